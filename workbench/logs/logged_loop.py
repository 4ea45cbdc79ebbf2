"""The loops whose signals a log has."""

from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.flight import Flight


@dataclass(frozen=True)
class LoggedLoop:
    """A loop that may have a response in a log, with its setpoint and response.

    Attributes:
        setpoints: signals; the first one in the log is used.
        responses: signals; the first one in the log is used.
        length: of its step response [s].
    """

    setpoints: tuple[str, ...]
    responses: tuple[str, ...]
    length: float


def _make_logged_loops() -> dict[str, LoggedLoop]:
    found = {}
    for axis, angle in zip("xyz", ("roll", "pitch", "yaw"), strict=True):
        found[f"{angle}_rate"] = LoggedLoop(
            (f"rate_setpoint.w_{axis}",),
            (f"imu.angular_velocity.{axis}", f"estimate.w_{axis}", f"attitude.w_{axis}"),
            0.6,
        )
        found[angle] = LoggedLoop(
            (f"attitude_setpoint.{angle}",),
            (f"estimate.{angle}", f"position_data.{angle}"),
            1.6,
        )
        found[f"v_{axis}"] = LoggedLoop(
            (f"setpoint.v_{axis}", f"command_velocity.v_{axis}"),
            (f"velocity_data.v_{axis}", f"estimate.v_{axis}"),
            3.0,
        )
        found[axis] = LoggedLoop(
            (f"setpoint.{axis}",), (f"position_data.{axis}", f"estimate.{axis}"), 5.0
        )
    found["yaw_rate"] = LoggedLoop(
        (*found["yaw_rate"].setpoints, "command_velocity.yaw_rate"),
        (*found["yaw_rate"].responses, "velocity_data.w_z"),
        0.6,
    )
    return found


LOGGED_LOOPS: Mapping[str, LoggedLoop] = _make_logged_loops()
"""Loops by name."""


def find_logged_loop(flight: Flight, name: str) -> tuple[str, str, float]:
    """Return setpoint, response and length [s] of a loop in a log.

    Args:
        flight: the log.
        name: one of `LOGGED_LOOPS`, or SETPOINT:RESPONSE of any two signals.

    Raises:
        WorkbenchError: if the log lacks one of the signals.
    """
    if ":" in name:
        setpoint, _, response = name.partition(":")
        return flight[setpoint].name, flight[response].name, 1.6
    if name not in LOGGED_LOOPS:
        raise unknown_name("loop", name, LOGGED_LOOPS)
    loop = LOGGED_LOOPS[name]
    setpoint = next((each for each in loop.setpoints if each in flight), "")
    response = next((each for each in loop.responses if each in flight), "")
    for found, wanted in ((setpoint, loop.setpoints), (response, loop.responses)):
        if not found:
            raise WorkbenchError(
                f"{flight.source}: has no {' or '.join(wanted)}, so {name} has no step response"
            )
    return setpoint, response, loop.length

"""Rows of a law's tables with one entry for each axis: states, loop points and loops."""

from collections.abc import Mapping, Sequence

from workbench.common.parameter import State
from workbench.control.loop import Loop

Names = tuple[str, ...]


def states(name: str, unit: str, axes: str = "xyz", initial: float = 0.0) -> tuple[State, ...]:
    """Return a state for each axis: `states("i_rate", "1")` has i_rate_x, i_rate_y and i_rate_z."""
    return tuple(State(f"{name}_{axis}", unit, initial) for axis in axes)


def points(units: Mapping[str, str], axes: Sequence[str] = "xyz") -> dict[str, str]:
    """Return loop points for each axis, with their units; {} in a name stands for the axis."""
    return {name.format(axis): unit for name, unit in units.items() for axis in axes}


def loops_along(
    error: str, output: str, gains: Sequence[Names], hold: bool = False
) -> tuple[Loop, ...]:
    """Return the loops along x, y and z: velocity_x, velocity_y and velocity_z for "velocity".

    Args:
        error: stage of their errors: "velocity" stands for the loop point velocity_x_error.
        output: stage of their outputs: "acceleration" stands for acceleration_x; "" for the errors.
        gains: names of the gains of each loop.
        hold: whether the loops are closed only while a position is held.
    """
    return tuple(
        Loop(f"{error}_{k}", f"{error}_{k}_error", output and f"{output}_{k}", hold, k, own)
        for k, own in zip("xyz", gains, strict=True)
    )


def loops_about(
    names: Sequence[str], error: str, output: str, gains: Sequence[Names]
) -> tuple[Loop, ...]:
    """Return the loops about x, y and z of T, or about x and y.

    A step along y goes through the loop about x (roll), a step along x through that about y
    (pitch).

    Args:
        names: of the loops.
        error: see `loops_along`.
        output: see `loops_along`.
        gains: names of the gains of each loop.
    """
    return tuple(
        Loop(name, f"{error}_{k}_error", output and f"{output}_{k}", axis=step, gains=own)
        for name, k, step, own in zip(names, "xyz", ("y", "x", "yaw"), gains, strict=False)
    )


CASCADE_POINTS = points(
    {
        "position_{}_error": "m",
        "velocity_{}_error": "m/s",
        "acceleration_{}": "m/s^2",
        "attitude_{}_error": "1",
        "angular_acceleration_{}": "rad/s^2",
    }
) | {"roll_setpoint": "1", "pitch_setpoint": "1"}
"""Loop points of a cascade to accelerations, with the specific force in W without gravity."""
POSITION_POINT = 0
VELOCITY_POINT = 3
ACCELERATION_POINT = 6
ATTITUDE_POINT = 9
TURN_POINT = 12
SETPOINT_POINT = 15
"""Index of the first of its three points of each stage, or of its two setpoints."""

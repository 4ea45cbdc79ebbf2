"""The loop points and loops of the autopilots whose cascade ends with torques, stage by stage."""

from collections.abc import Sequence

from workbench.control.cascade import Names
from workbench.control.loop import Loop
from workbench.controllers import loops_about, loops_along, points

ATTITUDE_STAGE_POINT = 6
RATE_STAGE_POINT = 9
TORQUE_STAGE_POINT = 12
TILT_SETPOINT_POINT = 15
RATE_SETPOINT_POINT = 17
"""Index of the first of the three points of each stage, or of the two setpoints."""
_STAGE_TURNS = ("roll", "pitch", "yaw")


def stage_points(angle: str, tilt: str) -> dict[str, str]:
    """Return loop points with their units, for a unit of angles and one of the tilt setpoint."""
    stages = {
        "position_{}_error": "m",
        "velocity_{}_error": "m/s",
        "attitude_{}_error": angle,
        "rate_{}_error": f"{angle}/s",
        "torque_{}": "1",
    }
    setpoints = {"{}_setpoint": tilt, "{}_rate_setpoint": f"{angle}/s"}
    return points(stages) | points(setpoints, _STAGE_TURNS[:2])


def stage_loops(
    position: Sequence[Names],
    velocity: Sequence[Names],
    attitude: Sequence[Names],
    rate: Sequence[Names],
    angle: str = "attitude",
) -> tuple[Loop, ...]:
    """Return the loops of a cascade; the gains of each stage are those of x, y and z.

    Args:
        position: names of the gains.
        velocity: likewise.
        attitude: likewise; of roll and pitch alone, if there is no loop of yaw.
        rate: likewise.
        angle: stage of the errors of attitude.
    """
    return (
        *loops_along("velocity", "", velocity),
        *loops_about(_STAGE_TURNS[: len(attitude)], angle, "", attitude),
        *loops_about([f"{name}_rate" for name in _STAGE_TURNS], "rate", "torque", rate),
        *loops_along("position", "", position, hold=True),
    )

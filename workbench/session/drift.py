"""The rule where a step of a command begins in wind: at the steady drift of its law."""

import math
from collections.abc import Mapping

from workbench.scenario.axes import AXIS_NAMES

MAX_HOVER_S, HOVER_LOOK_S = 60.0, 0.25
"""Longest flight before a step until the drone is steady, and time after which it is looked at
again [s]."""
STEERED_SPEED_M_S = 2e-6
"""Speed at which a law no longer holds a point, and that is none in any number [m/s]."""
WIND_SPEEDS = ("wind_x", "wind_y", "wind_z", "turbulence", "gust_x", "gust_y", "gust_z")
"""Parameters of the air that moves; all 0 in still air."""
NEVER_STEADY = (
    "the air is turbulent, so the drone does not come to rest before the step: set turbulence to 0"
)
"""Why the numbers of a step are withheld in turbulence."""
NOT_STEADY = (
    f"in this wind the drone does not drift steadily within {MAX_HOVER_S:g} s; change the gains"
)
"""Why they are withheld of a drone that has not become steady."""


def air_moves(values: Mapping[str, float]) -> bool:
    """Return whether the air of a flight moves, by the values of its parameters."""
    return any(values[name] for name in WIND_SPEEDS)


def moving_speed(amplitude: float, *, is_estimated: bool) -> float:
    """Return the speed above which a drone moves at the edge of its step [m/s or rad/s].

    On an estimate it trembles by some cm/s, which is no motion.

    Args:
        amplitude: of the step [m/s or rad/s].
        is_estimated: whether the law flies on an estimate.
    """
    from workbench.session.hover_attitude import AT_REST_SPEED, LEVEL_SHARE  # loads Drake

    trembles = AT_REST_SPEED if is_estimated else 0.0
    return max(LEVEL_SHARE * abs(amplitude), trembles)


def drift_commands(axis: str, amplitude: float) -> tuple[list[float], list[float]]:
    """Return velocity in W and yaw rate (4) before a step from a drift, and from its edge on.

    No point is held before a step of velocity.
    """
    place, drift = AXIS_NAMES.index(axis), [0.0] * len(AXIS_NAMES)
    if axis != "yaw":
        drift[place] = math.copysign(STEERED_SPEED_M_S, amplitude)
    command = list(drift)
    command[place] += amplitude
    return drift, command


def steady_window(duration: float) -> float:
    """Return the time for which a drone has to drift steadily before a step [s].

    Args:
        duration: flown after the edge [s].
    """
    return min(duration, 0.5 * MAX_HOVER_S)

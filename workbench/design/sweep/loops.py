"""The loop that a step along an axis commands, and the axis whose step shows a parameter."""

from collections.abc import Iterable

from workbench.common.errors import unknown_name

_AXIS_LOOPS = {"x": "velocity_x", "y": "velocity_y", "z": "velocity_z", "yaw": "yaw_rate"}


def axis_loop(axis: str) -> str:
    """Return the name of an axis's loop, see `linear.loops`.

    Raises:
        WorkbenchError: if there is no such axis.
    """
    if axis not in _AXIS_LOOPS:
        raise unknown_name("axis", axis, _AXIS_LOOPS)
    return _AXIS_LOOPS[axis]


_AXIS_OF = {
    "pitch": "x",
    "roll": "y",
    "velocity_x": "x",
    "velocity_y": "y",
    "velocity_z": "z",
    "yaw_rate": "yaw",
}
"""The axis that answers through a loop, by what its gains are named for."""
_OTHERS = {
    "max_tilt": "x",
    "max_speed": "x",
    "max_climb_rate": "z",
    "max_yaw_rate": "yaw",
    "wind_x": "x",
    "wind_y": "y",
    "wind_z": "z",
}
DEFAULT_AXIS = "z"


def axis_of(parameter: str) -> str:
    """Return the axis whose step a parameter acts in, "" if it is of none or of all."""
    return _OTHERS.get(parameter) or _AXIS_OF.get(parameter.partition("_")[2], "")


def default_axis(parameters: Iterable[str]) -> str:
    """Return the axis to step along: that of the first parameter that has one, else z."""
    return next(filter(None, map(axis_of, parameters)), DEFAULT_AXIS)

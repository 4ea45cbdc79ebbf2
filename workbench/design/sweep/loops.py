"""The loop that a step along an axis commands, and the axis whose step shows a parameter."""

from collections.abc import Iterable

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller, load_controller
from workbench.scenario.axes import AXES


def axis_loop(axis: str, controller: Controller | None = None) -> str:
    """Return the name of an axis's outermost loop that steers.

    Args:
        axis: x, y, z or yaw.
        controller: whose loops; the default one where none is given.

    Raises:
        WorkbenchError: if there is no such axis, or the controller states no loop for it.
    """
    if axis not in AXES:
        raise unknown_name("axis", axis, AXES)
    law = controller or load_controller()
    for loop in law.loops:
        if loop.axis == axis and not loop.hold:
            return loop.name
    raise WorkbenchError(
        f"{law.name} states no loop that steers {axis}: give a loop in its file axis={axis!r}"
    )


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


def axis_of(parameter: str, controller: Controller | None = None) -> str:
    """Return the axis whose step a parameter acts in, "" if it is of none or of all.

    Of a gain it is that of the first loop which names it.
    """
    if parameter in _OTHERS:
        return _OTHERS[parameter]
    loops = (controller or load_controller()).loops
    return next((each.axis for each in loops if parameter in each.gains and not each.hold), "")


def default_axis(parameters: Iterable[str], controller: Controller | None = None) -> str:
    """Return the axis to step along: that of the first parameter that has one, else z."""
    axes = (axis_of(each, controller) for each in parameters)
    return next(filter(None, axes), DEFAULT_AXIS)

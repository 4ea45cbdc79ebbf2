"""The loop that a step along an axis commands."""

from workbench.errors import unknown_name

_AXIS_LOOPS = {"x": "velocity_x", "y": "velocity_y", "z": "velocity_z", "yaw": "yaw_rate"}


def axis_loop(axis: str) -> str:
    """Return the name of an axis's loop, see `linear.loops`.

    Raises:
        WorkbenchError: if there is no such axis.
    """
    if axis not in _AXIS_LOOPS:
        raise unknown_name("axis", axis, _AXIS_LOOPS)
    return _AXIS_LOOPS[axis]

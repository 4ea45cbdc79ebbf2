"""Drag of a body in moving air."""

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3

SPEED_SQUARED_OFFSET = 1e-12
"""Added to squared speeds, so that their roots have derivatives in still air [m²/s²]."""


@register_jitable(forceinline=True)
def drag_force(half_drag: float, v: Numbers) -> Vector3:
    """Return the force of the air on a body [N], -half_drag |v| v, in the frame of v.

    Args:
        half_drag: half the air's density times the body's drag area [kg/m].
        v: velocity of the centre of mass in the air (3) [m/s].
    """
    v_x, v_y, v_z = v
    drag = -half_drag * (v_x * v_x + v_y * v_y + v_z * v_z + SPEED_SQUARED_OFFSET) ** 0.5
    return drag * v_x, drag * v_y, drag * v_z

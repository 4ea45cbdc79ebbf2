"""Attitude, velocity of the centre of mass, and drag from the plant's state, for a law."""

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Matrix3, Numbers, Quaternion, Vector3
from workbench.dynamics.air.drag import SPEED_SQUARED_OFFSET


@register_jitable
def thrust_attitude(q_WB: Numbers, q_BT: Numbers) -> Quaternion:
    """Return the orientation q_WT of the frame in which the rotors lift along z."""
    w, x, y, z = q_WB
    t_w, t_x, t_y, t_z = q_BT
    return (
        w * t_w - x * t_x - y * t_y - z * t_z,
        w * t_x + x * t_w + y * t_z - z * t_y,
        w * t_y - x * t_z + y * t_w + z * t_x,
        w * t_z + x * t_y - y * t_x + z * t_w,
    )


VERTICAL_LENGTH_SQUARED = 1e-24
"""Squared level length of an axis below which it is vertical."""


@register_jitable(forceinline=True)
def attitude_matrix(q_WB: Numbers) -> Matrix3:
    """Return R_WB row by row (9) of a quaternion, which need not have unit length."""
    w, x, y, z = q_WB
    s = 2.0 / (w * w + x * x + y * y + z * z)
    return (
        1.0 - s * (y * y + z * z),
        s * (x * y - w * z),
        s * (x * z + w * y),
        s * (x * y + w * z),
        1.0 - s * (x * x + z * z),
        s * (y * z - w * x),
        s * (x * z - w * y),
        s * (y * z + w * x),
        1.0 - s * (x * x + y * y),
    )


@register_jitable
def mass_velocity(state: Numbers, p_BoBcm_B: Numbers) -> Vector3:
    """Return the velocity of the centre of mass in W [m/s].

    The rotors accelerate this point. An origin far from it first moves the wrong way when the drone
    tilts, so feeding back its velocity would disturb the attitude loop.
    """
    w, x, y, z = state[0:4]
    p_x, p_y, p_z = p_BoBcm_B
    s = 2.0 / (w * w + x * x + y * y + z * z)
    t_x = s * (y * p_z - z * p_y)
    t_y = s * (z * p_x - x * p_z)
    t_z = s * (x * p_y - y * p_x)
    l_x = p_x + w * t_x + y * t_z - z * t_y
    l_y = p_y + w * t_y + z * t_x - x * t_z
    l_z = p_z + w * t_z + x * t_y - y * t_x
    w_x, w_y, w_z = state[7:10]
    return (
        state[10] + w_y * l_z - w_z * l_y,
        state[11] + w_z * l_x - w_x * l_z,
        state[12] + w_x * l_y - w_y * l_x,
    )


@register_jitable
def still_air_drag(q_WT: Numbers, v_WB: Numbers, drag: Numbers) -> Vector3:
    """Return the deceleration by drag in still air, with the sign that compensates it, in W [m/s²].

    Rotors at hover speed have drag across their axis, the body has drag against its velocity. The
    law does not know the wind.

    Args:
        q_WT: orientation of the frame in which the rotors lift along z.
        v_WB: velocity [m/s].
        drag: see `plant.drag.DragRates`.
    """
    w, x, y, z = q_WT
    s = 2.0 / (w * w + x * x + y * y + z * z)
    n_x = s * (x * z + w * y)
    n_y = s * (y * z - w * x)
    n_z = 1.0 - s * (x * x + y * y)
    v_x, v_y, v_z = v_WB
    across, squared, _ = drag
    pull = across + squared * (v_x * v_x + v_y * v_y + v_z * v_z + SPEED_SQUARED_OFFSET) ** 0.5
    along = across * (v_x * n_x + v_y * n_y + v_z * n_z)
    return pull * v_x - along * n_x, pull * v_y - along * n_y, pull * v_z - along * n_z


@register_jitable(forceinline=True)
def level_heading(R: Numbers) -> tuple[float, float, float]:
    """Return cosine and sine of the yaw of R row by row, and the level length of its x axis.

    Where x is vertical, yaw is 0, as firmware has it by atan2(0, 0).
    """
    squared = R[0] * R[0] + R[3] * R[3]
    if squared < VERTICAL_LENGTH_SQUARED:
        return 1.0 + 0.0 * squared, 0.0 * squared, 0.0 * squared
    level = squared**0.5
    return R[0] / level, R[3] / level, level

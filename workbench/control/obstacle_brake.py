"""The obstacle brake: it limits the speed towards obstacles, as a pure function of scalars."""

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3

MAX_WALLS = 3
"""Number of walls considered: two and a ceiling meet in the corner of a room."""
MAX_BACK_OFF_SPEED = 0.5
"""Largest speed away from a wall that is too near [m/s]."""


@register_jitable
def braked(
    v_x: float,
    v_y: float,
    v_z: float,
    p_WB: Numbers,
    brake: float,
    walls: Numbers,
    slowing: float,
) -> Vector3:
    """Return a velocity in W whose part towards each wall is limited; parts along walls stay.

    With the distance s left to the stopping point, the limit on the speed towards a wall is

        brake s                            near the wall
        sqrt(2 slowing s - (slowing / brake)²)   farther away, so that `slowing` suffices to stop

    A wall is the plane through the obstacle's nearest point. Between updates of that point, the
    limit is exact for flat obstacles and conservative for round ones.

    Args:
        v_x: wanted velocity in W [m/s]; so `v_y`, `v_z`.
        v_y: see `v_x`.
        v_z: see `v_x`.
        p_WB: position [m].
        brake: allowed speed per distance left, not 0 [1/s].
        walls: (4 `MAX_WALLS`) for each, nearest first, the unit vector n in W towards it, and its
            offset n · p with the stopping point p [m]; all zero for none.
        slowing: largest deceleration [m/s²].
    """
    x, y, z = p_WB
    turn = slowing / brake
    for wall in range(MAX_WALLS - 1, -1, -1):  # the nearest last, so that its limit always holds
        at = 4 * wall
        n_x, n_y, n_z, offset = walls[at], walls[at + 1], walls[at + 2], walls[at + 3]
        left = offset - n_x * x - n_y * y - n_z * z
        limit = brake * left
        if limit > turn:
            limit = (2.0 * slowing * left - turn * turn) ** 0.5
        if limit < -MAX_BACK_OFF_SPEED:
            limit = -MAX_BACK_OFF_SPEED
        excess = n_x * v_x + n_y * v_y + n_z * v_z - limit
        if excess > 0.0:
            v_x = v_x - excess * n_x
            v_y = v_y - excess * n_y
            v_z = v_z - excess * n_z
    return v_x, v_y, v_z

"""The brake near obstacles: how fast a drone may go towards walls, as a pure function of scalars.

Part of the law and written like it: see `pd`.
"""

from typing import Any

from workbench.common.jitable import register_jitable

Scalar = Any
Vector = Any

WALLS = 3
"""How many walls are heeded: two and a ceiling meet in the corner of a room."""
BACK_OFF = 0.5
"""What is nearer than it may be is left no faster than this [m/s]."""


@register_jitable
def braked(
    v_x: Scalar,
    v_y: Scalar,
    v_z: Scalar,
    p_WB: Vector,
    brake: Scalar,
    walls: Vector,
    slowing: Scalar,
) -> tuple[Scalar, Scalar, Scalar]:
    """Return a velocity in W that goes towards no wall faster than it may; along them it stays.

    The speed allowed is `brake` times the way left; farther off, where slowing down at that rate
    would take more than `slowing`, it is the speed from which `slowing` stops in time.

    A wall is the plane in the obstacle's nearest point, so that the limit is exact between its
    updates for what is flat, and cautious for what is round.

    Args:
        v_x: wanted velocity in W [m/s]; so `v_y`, `v_z`.
        v_y: see `v_x`.
        v_z: see `v_x`.
        p_WB: position [m].
        brake: speed allowed per way left, not 0 [1/s].
        walls: (4 `WALLS`) the unit vector n in W towards each, and the place n · p along it at
            which to stop [m], nearest first; all zero where there is none.
        slowing: largest deceleration [m/s²].
    """
    x, y, z = p_WB
    turn = slowing / brake
    for wall in range(WALLS - 1, -1, -1):  # the nearest last: its limit holds whatever the others
        at = 4 * wall
        n_x, n_y, n_z, place = walls[at], walls[at + 1], walls[at + 2], walls[at + 3]
        way = place - n_x * x - n_y * y - n_z * z
        most = brake * way
        if most > turn:
            most = (2.0 * slowing * way - turn * turn) ** 0.5
        if most < -BACK_OFF:
            most = -BACK_OFF
        excess = n_x * v_x + n_y * v_y + n_z * v_z - most
        if excess > 0.0:
            v_x = v_x - excess * n_x
            v_y = v_y - excess * n_y
            v_z = v_z - excess * n_z
    return v_x, v_y, v_z

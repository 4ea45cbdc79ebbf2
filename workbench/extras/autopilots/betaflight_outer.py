"""The outer loop for Betaflight: from velocity errors to angles and throttle, like stick inputs.

Betaflight has no position loop. This one belongs to the workbench, for the law `betaflight` and for
the firmware itself; see `extras/autopilots/laws/betaflight.py` for its equations.
"""

import math

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.control.guidance import Gains
from workbench.control.law_parts import arctan2, between, clipped, integrated, tilted
from workbench.plant.gravity import GRAVITY

RADIAN_DEG = 180.0 / math.pi


@register_jitable(forceinline=True)
def outer_loop(
    e: Vector3,
    integrals: Vector3,
    ahead: Numbers,
    heading: tuple[float, float],
    g: Gains,
    signals: tuple[float, float],
    period: float,
) -> tuple[float, float, float, float, float, float]:
    """Return angles of roll and pitch [deg], nose down, throttle 0 .. 1, and the next integrals.

    Args:
        e: errors of velocity in W (3) [m/s].
        integrals: before (3) [m/s²].
        ahead: acceleration of a path in W (3) [m/s²].
        heading: cosine and sine of the yaw.
        g: gains by name; `outer_` ones, `angle_limit` and `max_tilt` are used.
        signals: of motors at zero throttle and in hover, 0 .. 1.
        period: since the previous update [s].
    """
    e_x, e_y, e_z = e
    i_x, i_y, i_z = integrals
    cos, sin = heading
    idle, hover = signals
    f_x = g.outer_p_velocity * e_x + i_x + ahead[0]
    f_y = g.outer_p_velocity * e_y + i_y + ahead[1]
    f_z = g.outer_p_climb * e_z + i_z + ahead[2]
    a_x, a_y, _ = tilted(f_x, f_y, GRAVITY, g)
    fore, left = cos * a_x + sin * a_y, cos * a_y - sin * a_x
    pitch = clipped(RADIAN_DEG * arctan2(fore, GRAVITY), g.angle_limit)
    roll = RADIAN_DEG * arctan2(-left, (fore * fore + GRAVITY * GRAVITY) ** 0.5)
    roll = clipped(roll, g.angle_limit)
    lean = (a_x * a_x + a_y * a_y + GRAVITY * GRAVITY) ** 0.5 / GRAVITY
    lift = (1.0 + f_z / GRAVITY) * lean
    lift = lift if lift > 1e-3 else 1e-3 + 0.0 * lift
    wanted = (hover * lift**0.5 - idle) / (1.0 - idle)
    throttle = between(wanted, 0.0, 1.0)
    i_x = integrated(i_x, g.outer_i_velocity * e_x, f_x - a_x, 0.0, period)
    i_y = integrated(i_y, g.outer_i_velocity * e_y, f_y - a_y, 0.0, period)
    i_z = integrated(i_z, g.outer_i_climb * e_z, wanted - throttle, 0.0, period)
    return roll, pitch, throttle, i_x, i_y, i_z

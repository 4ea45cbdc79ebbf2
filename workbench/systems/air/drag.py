"""What moving air does to a vehicle: pure functions of scalars, as the control law is.

One source runs with floats, converts to AutoDiffXd, and compiles with numba.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numba.extending import register_jitable

from workbench.plant.rotors import Rotor

Scalar = Any
"""float, AutoDiffXd, or what numba makes of it."""
Signal = Any
"""A sequence of scalars: a list or tuple in Python, an array in compiled code."""

Wrench = tuple[Scalar, Scalar, Scalar, Scalar, Scalar, Scalar]
STILL = 1e-12
"""Added to squared speeds, so that their roots have derivatives in still air [m²/s²]."""


def rotor_rows(rotors: Sequence[Rotor]) -> np.ndarray:
    """Return a row of 8 for each rotor: p_BR, axis in B, drag and rolling-moment coefficients."""
    return np.array(
        [
            [
                *rotor.p_BR,
                *rotor.axis_B,
                rotor.rotor_drag_coefficient,
                rotor.rolling_moment_coefficient,
            ]
            for rotor in rotors
        ]
    )


@register_jitable
def cross(a: Signal, b: Signal) -> tuple[Scalar, Scalar, Scalar]:
    """Return the cross product."""
    a_x, a_y, a_z = a
    b_x, b_y, b_z = b
    return a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


@register_jitable
def into_body(q_WB: Signal, a_W: Signal) -> tuple[Scalar, Scalar, Scalar]:
    """Return a vector of W in B; the quaternion may have any length but zero."""
    w, x, y, z = q_WB
    s = 2.0 / (w * w + x * x + y * y + z * z)
    a_x, a_y, a_z = a_W
    t_x, t_y, t_z = cross((x, y, z), a_W)
    u_x, u_y, u_z = cross((x, y, z), (t_x, t_y, t_z))
    return (
        a_x + s * (u_x - w * t_x),
        a_y + s * (u_y - w * t_y),
        a_z + s * (u_z - w * t_z),
    )


@register_jitable
def drag_wrench(
    state: Signal,
    speeds: Signal,
    wind_W: Signal,
    pressure: Scalar,
    p_BoBcm_B: Signal,
    rotors: Signal,
) -> Wrench:
    """Return force [N] and moment about the body's origin [N·m] of all drag, in B.

    With v the velocity of the centre of mass relative to the air, the body's drag there is
    -pressure |v| v. With v the part across a rotor's axis of its hub's velocity relative to the
    air, the rotor's is the force -|w| rotor_drag_coefficient v at the hub and the moment -|w|
    rolling_moment_coefficient v: against the way, whichever way the rotor turns. These two are
    Gazebo's (MulticopterMotorModel.cc of gz-sim, gazebo_motor_model.cpp of RotorS), after
    Martin and Salaun, "The True Role of Accelerometer Feedback in Quadrotor Control", ICRA 2010.

    Args:
        state: of the plant (13): q_WB, p_WB [m], w_WB_W [rad/s], v_WB_W [m/s].
        speeds: of the rotors, n or more of which the first n count [rad/s].
        wind_W: velocity of the air (3) [m/s].
        pressure: half the air's density times the body's drag area [kg/m].
        p_BoBcm_B: the centre of mass (3) [m].
        rotors: n rows, see `rotor_rows`.
    """
    v_B, w_B = motion_in_air(state, wind_W)
    wrench = body_drag(v_B, w_B, pressure, p_BoBcm_B)
    for i in range(len(rotors)):
        wrench = with_rotor_drag(wrench, v_B, w_B, speeds[i], rotors[i])
    return wrench


@register_jitable
def motion_in_air(state: Signal, wind_W: Signal) -> tuple[Any, Any]:
    """Return the origin's velocity relative to the air [m/s], and the turning [rad/s], in B."""
    q_WB = state[0:4]
    way_W = (state[10] - wind_W[0], state[11] - wind_W[1], state[12] - wind_W[2])
    return into_body(q_WB, way_W), into_body(q_WB, state[7:10])


@register_jitable
def body_drag(v_B: Signal, w_B: Signal, pressure: Scalar, p_BoBcm_B: Signal) -> Wrench:
    """Return the part of `drag_wrench` that the body has."""
    v_x, v_y, v_z = v_B
    s_x, s_y, s_z = cross(w_B, p_BoBcm_B)
    s_x = s_x + v_x
    s_y = s_y + v_y
    s_z = s_z + v_z
    drag = -pressure * (s_x * s_x + s_y * s_y + s_z * s_z + STILL) ** 0.5
    f_x = drag * s_x
    f_y = drag * s_y
    f_z = drag * s_z
    m_x, m_y, m_z = cross(p_BoBcm_B, (f_x, f_y, f_z))
    return f_x, f_y, f_z, m_x, m_y, m_z


@register_jitable
def with_rotor_drag(
    wrench: Wrench, v_B: Signal, w_B: Signal, speed: Scalar, rotor: Signal
) -> Wrench:
    """Return a wrench with the part of `drag_wrench` that a rotor has; see `rotor_rows`."""
    f_x, f_y, f_z, m_x, m_y, m_z = wrench
    v_x, v_y, v_z = v_B
    p_BR = rotor[0:3]
    n_x, n_y, n_z = rotor[3:6]
    s_x, s_y, s_z = cross(w_B, p_BR)
    s_x = s_x + v_x
    s_y = s_y + v_y
    s_z = s_z + v_z
    along = s_x * n_x + s_y * n_y + s_z * n_z
    s_x = s_x - along * n_x
    s_y = s_y - along * n_y
    s_z = s_z - along * n_z
    drag = -abs(speed) * rotor[6]
    roll = -abs(speed) * rotor[7]
    t_x, t_y, t_z = cross(p_BR, (drag * s_x, drag * s_y, drag * s_z))
    return (
        f_x + drag * s_x,
        f_y + drag * s_y,
        f_z + drag * s_z,
        m_x + t_x + roll * s_x,
        m_y + t_y + roll * s_y,
        m_z + t_z + roll * s_z,
    )

"""Drag of body and rotors: pure functions of scalars.

The same source runs with floats and AutoDiffXd, and compiles with numba.
"""

from workbench.common.jitable import Scalar, Vector, register_jitable
from workbench.dynamics.rigid_body import cross

Wrench = tuple[Scalar, Scalar, Scalar, Scalar, Scalar, Scalar]
STILL = 1e-12
"""Added to squared speeds, so that their roots have derivatives in still air [m²/s²]."""


@register_jitable(forceinline=True)
def body_drag(v_B: Vector, w_B: Vector, pressure: Scalar, p_BoBcm_B: Vector) -> Wrench:
    """Return force [N] and moment about the body's origin [N·m] of the body's drag, in B.

    The force at the centre of mass is -pressure |v| v, with its velocity v relative to the air.

    Args:
        v_B: velocity of the origin relative to the air, in B (3) [m/s].
        w_B: angular velocity in B (3) [rad/s].
        pressure: half the air's density times the body's drag area [kg/m].
        p_BoBcm_B: the centre of mass (3) [m].
    """
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


@register_jitable(forceinline=True)
def with_rotor_drag(
    wrench: Wrench, v_B: Vector, w_B: Vector, speed: Scalar, rotor: Vector
) -> Wrench:
    """Return a wrench with a rotor's drag.

    With v the hub's air velocity across the rotor axis, the force at the hub is
    -|w| rotor_drag_coefficient v, and the moment -|w| rolling_moment_coefficient v: against the
    motion, for both turning directions. Both are Gazebo's
    (MulticopterMotorModel.cc of gz-sim, gazebo_motor_model.cpp of RotorS), after Martin and
    Salaun, "The True Role of Accelerometer Feedback in Quadrotor Control", ICRA 2010.

    Args:
        wrench: force [N] and moment about the origin [N·m], in B (6).
        v_B: see `body_drag`.
        w_B: see `body_drag`.
        speed: of the rotor [rad/s].
        rotor: its row, see `vehicle_step.rotor_rows`.
    """
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

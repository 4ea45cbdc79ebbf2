"""One rigid body in free flight, stepped as Drake's discrete plant steps it: pure functions.

`MultibodyPlant` with a time step takes forces and accelerations at the old state, and velocity
before position (semi-implicit Euler):

    v+ = v + step vdot(q, v),  q+ = q + step N(q) v+

N(q) takes the quaternion at the length that it has, so that length drifts here as it does there.
Contact is not known here.
"""

from typing import Any, NamedTuple

import numpy as np
from numba.extending import register_jitable

from workbench.plant.gravity import GRAVITY
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle

Signal = Any
"""A sequence of numbers: a list or tuple in Python, an array in compiled code."""
Six = tuple[float, float, float, float, float, float]
Matrix = tuple[float, ...]
State = tuple[float, ...]
"""Of a free body (13): q_WB (w, x, y, z), p_WB [m], w_WB_W [rad/s], v_WB_W [m/s] of its origin."""


class RigidBody(NamedTuple):
    """What moves.

    Mass [kg]; inertia about the centre of mass in B and its inverse as xx, xy, xz, yy, yz, zz
    [kg·m²]; place of the centre of mass in B [m].
    """

    mass: float
    inertia: Six
    inverse: Six
    p_BoBcm_B: tuple[float, float, float]

    def packed(self) -> np.ndarray:
        """Return all of it as an array (16), in this order."""
        return np.array([self.mass, *self.inertia, *self.inverse, *self.p_BoBcm_B])


def rigid_body(vehicle: Vehicle, variation: Variation) -> RigidBody:
    """Return the body of a vehicle that differs from its record by a variation."""
    inertia = variation.inertia * vehicle.inertia
    return RigidBody(
        mass=variation.mass * vehicle.mass,
        inertia=_six(inertia),
        inverse=_six(np.linalg.inv(inertia)),
        p_BoBcm_B=vehicle.p_BoBcm_B,
    )


@register_jitable(forceinline=True)
def held_load(wrench: Signal, mass: float, p_BoBcm_B: Signal, step: float) -> Six:
    """Return what a wrench that is held in the body gives in a step, for `velocity_changes`.

    Args:
        wrench: force [N] and moment about the body's origin [N·m], in B, without gravity (6).
        mass: of the body [kg].
        p_BoBcm_B: its centre of mass (3) [m].
        step: of physics [s].

    Returns:
        Step times specific force [m/s], and moment about the centre of mass [N·m], in B.
    """
    f_x, f_y, f_z, t_x, t_y, t_z = wrench
    c_x, c_y, c_z = p_BoBcm_B
    share = step / mass
    m_x = t_x - c_y * f_z + c_z * f_y
    m_y = t_y - c_z * f_x + c_x * f_z
    m_z = t_z - c_x * f_y + c_y * f_x
    return share * f_x, share * f_y, share * f_z, m_x, m_y, m_z


@register_jitable(forceinline=True)
def rotation(q_WB: Signal) -> Matrix:
    """Return R_WB row by row (9) of a quaternion of any length but zero."""
    q_w, q_x, q_y, q_z = q_WB
    s = 2.0 / (q_w * q_w + q_x * q_x + q_y * q_y + q_z * q_z)
    s_x = s * q_x
    s_y = s * q_y
    s_z = s * q_z
    t_x = s_x * q_w
    t_y = s_y * q_w
    t_z = s_z * q_w
    return (
        1.0 - s_y * q_y - s_z * q_z,
        s_x * q_y - t_z,
        s_x * q_z + t_y,
        s_x * q_y + t_z,
        1.0 - s_x * q_x - s_z * q_z,
        s_y * q_z - t_x,
        s_x * q_z - t_y,
        s_y * q_z + t_x,
        1.0 - s_x * q_x - s_y * q_y,
    )


@register_jitable(forceinline=True)
def velocity_changes(
    R_WB: Signal,
    w_WB_W: Signal,
    load: Signal,
    inertia: Signal,
    turning: Signal,
    p_BoBcm_B: Signal,
    step: float,
) -> Six:
    """Return by how much the velocities change in a step, in B: angular (3), of the origin (3).

    Gravity is left to `moved`.

    Args:
        R_WB: see `rotation`.
        w_WB_W: angular velocity in W (3) [rad/s].
        load: see `held_load` (6).
        inertia: see `RigidBody` (6).
        turning: step times the inverse of that (6).
        p_BoBcm_B: the centre of mass (3) [m].
        step: of physics [s].
    """
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = R_WB
    w_x, w_y, w_z = w_WB_W
    f_x, f_y, f_z, m_x, m_y, m_z = load
    c_x, c_y, c_z = p_BoBcm_B
    i_xx, i_xy, i_xz, i_yy, i_yz, i_zz = inertia
    j_xx, j_xy, j_xz, j_yy, j_yz, j_zz = turning
    b_x = r00 * w_x + r10 * w_y + r20 * w_z  # the angular velocity in B
    b_y = r01 * w_x + r11 * w_y + r21 * w_z
    b_z = r02 * w_x + r12 * w_y + r22 * w_z
    h_x = i_xx * b_x + i_xy * b_y + i_xz * b_z
    h_y = i_xy * b_x + i_yy * b_y + i_yz * b_z
    h_z = i_xz * b_x + i_yz * b_y + i_zz * b_z
    n_x = m_x - b_y * h_z + b_z * h_y
    n_y = m_y - b_z * h_x + b_x * h_z
    n_z = m_z - b_x * h_y + b_y * h_x
    e_x = j_xx * n_x + j_xy * n_y + j_xz * n_z
    e_y = j_xy * n_x + j_yy * n_y + j_yz * n_z
    e_z = j_xz * n_x + j_yz * n_y + j_zz * n_z
    # the origin's velocity changes as that of the centre of mass, less e x c + step b x b x c
    k_x = step * (b_y * c_z - b_z * c_y)
    k_y = step * (b_z * c_x - b_x * c_z)
    k_z = step * (b_x * c_y - b_y * c_x)
    return (
        e_x,
        e_y,
        e_z,
        f_x - e_y * c_z + e_z * c_y - b_y * k_z + b_z * k_y,
        f_y - e_z * c_x + e_x * c_z - b_z * k_x + b_x * k_z,
        f_z - e_x * c_y + e_y * c_x - b_x * k_y + b_y * k_x,
    )


@register_jitable(forceinline=True)
def moved(state: Signal, R_WB: Signal, changes: Signal, step: float) -> State:
    """Return the state a step of physics later.

    Args:
        state: see `State`.
        R_WB: its orientation, see `rotation`.
        changes: see `velocity_changes`.
        step: of physics [s].
    """
    q_w, q_x, q_y, q_z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = R_WB
    e_x, e_y, e_z, a_x, a_y, a_z = changes
    v_x = v_x + r00 * a_x + r01 * a_y + r02 * a_z
    v_y = v_y + r10 * a_x + r11 * a_y + r12 * a_z
    v_z = v_z - step * GRAVITY + r20 * a_x + r21 * a_y + r22 * a_z
    w_x = w_x + r00 * e_x + r01 * e_y + r02 * e_z
    w_y = w_y + r10 * e_x + r11 * e_y + r12 * e_z
    w_z = w_z + r20 * e_x + r21 * e_y + r22 * e_z
    half = 0.5 * step
    g_x = half * w_x
    g_y = half * w_y
    g_z = half * w_z
    return (
        q_w - g_x * q_x - g_y * q_y - g_z * q_z,
        q_x + g_x * q_w + g_y * q_z - g_z * q_y,
        q_y + g_y * q_w + g_z * q_x - g_x * q_z,
        q_z + g_z * q_w + g_x * q_y - g_y * q_x,
        p_x + step * v_x,
        p_y + step * v_y,
        p_z + step * v_z,
        w_x,
        w_y,
        w_z,
        v_x,
        v_y,
        v_z,
    )


def _six(matrix: np.ndarray) -> Six:
    """Return xx, xy, xz, yy, yz, zz of a symmetric matrix."""
    return (
        float(matrix[0, 0]),
        float(matrix[0, 1]),
        float(matrix[0, 2]),
        float(matrix[1, 1]),
        float(matrix[1, 2]),
        float(matrix[2, 2]),
    )

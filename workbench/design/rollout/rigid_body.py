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


def rigid_body(vehicle: Vehicle, variation: Variation) -> RigidBody:
    """Return the body of a vehicle that differs from its record by a variation."""
    inertia = variation.inertia * vehicle.inertia
    return RigidBody(
        mass=variation.mass * vehicle.mass,
        inertia=_six(inertia),
        inverse=_six(np.linalg.inv(inertia)),
        p_BoBcm_B=vehicle.p_BoBcm_B,
    )


@register_jitable
def fly_on(state: Signal, wrench: Signal, body: RigidBody, step: float, steps: int) -> State:
    """Return the state after some steps under a wrench that is held in the body.

    Args:
        state: see `State`.
        wrench: force [N] and moment about the body's origin [N·m], in B, without gravity (6).
        body: which moves.
        step: of physics [s].
        steps: how many.
    """
    q_w, q_x, q_y, q_z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    f_x, f_y, f_z, t_x, t_y, t_z = wrench
    c_x, c_y, c_z = body.p_BoBcm_B
    i_xx, i_xy, i_xz, i_yy, i_yz, i_zz = body.inertia
    j_xx, j_xy, j_xz, j_yy, j_yz, j_zz = body.inverse
    m_x = t_x - c_y * f_z + c_z * f_y  # the moment about the centre of mass
    m_y = t_y - c_z * f_x + c_x * f_z
    m_z = t_z - c_x * f_y + c_y * f_x
    f_x = f_x / body.mass
    f_y = f_y / body.mass
    f_z = f_z / body.mass
    for _ in range(steps):
        s = 2.0 / (q_w * q_w + q_x * q_x + q_y * q_y + q_z * q_z)
        r00 = 1.0 - s * (q_y * q_y + q_z * q_z)
        r01 = s * (q_x * q_y - q_w * q_z)
        r02 = s * (q_x * q_z + q_w * q_y)
        r10 = s * (q_x * q_y + q_w * q_z)
        r11 = 1.0 - s * (q_x * q_x + q_z * q_z)
        r12 = s * (q_y * q_z - q_w * q_x)
        r20 = s * (q_x * q_z - q_w * q_y)
        r21 = s * (q_y * q_z + q_w * q_x)
        r22 = 1.0 - s * (q_x * q_x + q_y * q_y)
        b_x = r00 * w_x + r10 * w_y + r20 * w_z  # the angular velocity in B
        b_y = r01 * w_x + r11 * w_y + r21 * w_z
        b_z = r02 * w_x + r12 * w_y + r22 * w_z
        h_x = i_xx * b_x + i_xy * b_y + i_xz * b_z
        h_y = i_xy * b_x + i_yy * b_y + i_yz * b_z
        h_z = i_xz * b_x + i_yz * b_y + i_zz * b_z
        n_x = m_x - b_y * h_z + b_z * h_y
        n_y = m_y - b_z * h_x + b_x * h_z
        n_z = m_z - b_x * h_y + b_y * h_x
        e_x = j_xx * n_x + j_xy * n_y + j_xz * n_z  # the angular acceleration in B
        e_y = j_xy * n_x + j_yy * n_y + j_yz * n_z
        e_z = j_xz * n_x + j_yz * n_y + j_zz * n_z
        u_x = b_y * c_z - b_z * c_y  # of the centre of mass, seen from the origin
        u_y = b_z * c_x - b_x * c_z
        u_z = b_x * c_y - b_y * c_x
        a_x = f_x - (e_y * c_z - e_z * c_y) - (b_y * u_z - b_z * u_y)
        a_y = f_y - (e_z * c_x - e_x * c_z) - (b_z * u_x - b_x * u_z)
        a_z = f_z - (e_x * c_y - e_y * c_x) - (b_x * u_y - b_y * u_x)
        v_x = v_x + step * (r00 * a_x + r01 * a_y + r02 * a_z)
        v_y = v_y + step * (r10 * a_x + r11 * a_y + r12 * a_z)
        v_z = v_z + step * (r20 * a_x + r21 * a_y + r22 * a_z - GRAVITY)
        w_x = w_x + step * (r00 * e_x + r01 * e_y + r02 * e_z)
        w_y = w_y + step * (r10 * e_x + r11 * e_y + r12 * e_z)
        w_z = w_z + step * (r20 * e_x + r21 * e_y + r22 * e_z)
        half = 0.5 * step
        d_w = -w_x * q_x - w_y * q_y - w_z * q_z
        d_x = w_x * q_w + w_y * q_z - w_z * q_y
        d_y = w_y * q_w + w_z * q_x - w_x * q_z
        d_z = w_z * q_w + w_x * q_y - w_y * q_x
        q_w = q_w + half * d_w
        q_x = q_x + half * d_x
        q_y = q_y + half * d_y
        q_z = q_z + half * d_z
        p_x = p_x + step * v_x
        p_y = p_y + step * v_y
        p_z = p_z + step * v_z
    return q_w, q_x, q_y, q_z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z


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

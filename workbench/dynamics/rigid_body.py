"""One rigid body in free flight: pure functions of scalars.

The same source runs with floats and AutoDiffXd, and compiles with numba. With the body's
origin Bo, the centre of mass C at c = p_BoBcm_B, and a force f and a moment t about Bo:

    I_C alpha = t - c x f - w x I_C w
    a_Bo      = f / m + g - alpha x c - w x (w x c)
"""

from typing import NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Matrix3, Numbers, Quaternion, Symmetric3, Vector3
from workbench.plant.gravity import GRAVITY


class RigidBody(NamedTuple):
    """Mass properties of a rigid body.

    Mass [kg]; inertia about the centre of mass in B and its inverse as xx, xy, xz, yy, yz, zz
    [kg·m²]; position of the centre of mass in B [m].
    """

    mass: float
    inertia: Symmetric3
    inverse: Symmetric3
    p_BoBcm_B: Vector3


def rigid_body(mass: float, inertia: np.ndarray, p_BoBcm_B: Vector3) -> RigidBody:
    """Return a body from its mass [kg], inertia matrix about its centre of mass, and that in B."""
    return RigidBody(mass, _six(inertia), _six(np.linalg.inv(inertia)), p_BoBcm_B)


@register_jitable(forceinline=True)
def rotation(q_WB: Numbers) -> Matrix3:
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
def into_world(R_WB: Numbers, a_B: Numbers) -> Vector3:
    """Return a vector of B in W."""
    x, y, z = a_B
    return (
        R_WB[0] * x + R_WB[1] * y + R_WB[2] * z,
        R_WB[3] * x + R_WB[4] * y + R_WB[5] * z,
        R_WB[6] * x + R_WB[7] * y + R_WB[8] * z,
    )


@register_jitable(forceinline=True)
def into_body(R_WB: Numbers, a_W: Numbers) -> Vector3:
    """Return a vector of W in B."""
    r00, r01, r02, r10, r11, r12, r20, r21, r22 = R_WB
    x, y, z = a_W
    return (
        r00 * x + r10 * y + r20 * z,
        r01 * x + r11 * y + r21 * z,
        r02 * x + r12 * y + r22 * z,
    )


@register_jitable(forceinline=True)
def cross(a: Numbers, b: Numbers) -> Vector3:
    """Return the cross product."""
    a_x, a_y, a_z = a
    b_x, b_y, b_z = b
    return a_y * b_z - a_z * b_y, a_z * b_x - a_x * b_z, a_x * b_y - a_y * b_x


@register_jitable(forceinline=True)
def quaternion_step(q_WB: Numbers, w_WB_W: Numbers, angle_share: float) -> Quaternion:
    """Return q + angle_share w q (4), with w as a quaternion without a real part."""
    q_w, q_x, q_y, q_z = q_WB
    w_x, w_y, w_z = w_WB_W
    g_x = angle_share * w_x
    g_y = angle_share * w_y
    g_z = angle_share * w_z
    return (
        q_w - g_x * q_x - g_y * q_y - g_z * q_z,
        q_x + g_x * q_w + g_y * q_z - g_z * q_y,
        q_y + g_y * q_w + g_z * q_x - g_x * q_z,
        q_z + g_z * q_w + g_x * q_y - g_y * q_x,
    )


@register_jitable(forceinline=True)
def quaternion_rate(q_WB: Numbers, w_WB_W: Numbers) -> Quaternion:
    """Return dq/dt = w q / 2 (4) [1/s], with w as a quaternion without a real part."""
    q_w, q_x, q_y, q_z = q_WB
    t_w, t_x, t_y, t_z = quaternion_step(q_WB, w_WB_W, 0.5)
    return t_w - q_w, t_x - q_x, t_y - q_y, t_z - q_z


@register_jitable(forceinline=True)
def body_acceleration(
    R_WB: Numbers,
    w_B: Numbers,
    force: Numbers,
    moment: Numbers,
    mass: float,
    inertia: Numbers,
    inverse: Numbers,
    p_BoBcm_B: Numbers,
) -> tuple[float, float, float, float, float, float]:
    """Return angular acceleration (3) and acceleration of the origin (3), in W.

    Args:
        R_WB: see `rotation`.
        w_B: angular velocity in B (3) [rad/s].
        force: in B, without gravity (3) [N].
        moment: about the origin, in B (3) [N·m].
        mass: see `RigidBody`, and so the next three.
        inertia: about the centre of mass.
        inverse: of the inertia.
        p_BoBcm_B: the centre of mass.
    """
    b_x, b_y, b_z = w_B
    f_x, f_y, f_z = force
    t_x, t_y, t_z = moment
    c_x, c_y, c_z = p_BoBcm_B
    about_center = (
        t_x - c_y * f_z + c_z * f_y,
        t_y - c_z * f_x + c_x * f_z,
        t_z - c_x * f_y + c_y * f_x,
    )
    e_x, e_y, e_z = _euler(w_B, about_center, inertia, inverse)
    k_x = b_y * c_z - b_z * c_y
    k_y = b_z * c_x - b_x * c_z
    k_z = b_x * c_y - b_y * c_x
    a_B = (
        f_x / mass - e_y * c_z + e_z * c_y - b_y * k_z + b_z * k_y,
        f_y / mass - e_z * c_x + e_x * c_z - b_z * k_x + b_x * k_z,
        f_z / mass - e_x * c_y + e_y * c_x - b_x * k_y + b_y * k_x,
    )
    a_x, a_y, a_z = into_world(R_WB, a_B)
    return into_world(R_WB, (e_x, e_y, e_z)) + (a_x, a_y, a_z - GRAVITY)


@register_jitable(forceinline=True)
def _euler(w_B: Numbers, moment: Numbers, inertia: Numbers, inverse: Numbers) -> Vector3:
    """Return angular acceleration in B under a moment about the centre of mass."""
    b_x, b_y, b_z = w_B
    m_x, m_y, m_z = moment
    i_xx, i_xy, i_xz, i_yy, i_yz, i_zz = inertia
    j_xx, j_xy, j_xz, j_yy, j_yz, j_zz = inverse
    h_x = i_xx * b_x + i_xy * b_y + i_xz * b_z
    h_y = i_xy * b_x + i_yy * b_y + i_yz * b_z
    h_z = i_xz * b_x + i_yz * b_y + i_zz * b_z
    n_x = m_x - b_y * h_z + b_z * h_y
    n_y = m_y - b_z * h_x + b_x * h_z
    n_z = m_z - b_x * h_y + b_y * h_x
    return (
        j_xx * n_x + j_xy * n_y + j_xz * n_z,
        j_xy * n_x + j_yy * n_y + j_yz * n_z,
        j_xz * n_x + j_yz * n_y + j_zz * n_z,
    )


def _six(matrix: np.ndarray) -> Symmetric3:
    """Return xx, xy, xz, yy, yz, zz of a symmetric matrix."""
    xx, xy, xz, yy, yz, zz = (float(matrix[i, j]) for i in range(3) for j in range(i, 3))
    return xx, xy, xz, yy, yz, zz

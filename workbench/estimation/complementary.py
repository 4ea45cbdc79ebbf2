"""Mahony's complementary filter for the attitude, and fixed gains for position and velocity.

The attitude follows the gyro, with a correction from accelerometer and magnetometer. With the unit
vectors u and m of the measured specific force and heading, and u_hat and m_hat as the attitude
predicts them, all in B,

    e = u x u_hat + (m x m_hat)         w = w_IMU - b_g + kp e         b_g+ = b_g - ki e dt

Only the heading of the field is used, so a wrong dip does not affect the tilt. Position and
velocity integrate the specific force, rotated by that attitude. GPS and barometer correct them with
the gains of a second-order filter with the time constant T:

    v+ = v + a dt + dt (p_y - p) / T²       p+ = p + v dt + 2 dt (p_y - p) / T

and the GPS's velocity with 1 / T_v. Between samples the last ones are used, propagated: positions
by the estimated velocity, the velocity by the specific force. A constant sample would hold the
estimate back in every acceleration. GPS samples are used for a second; after that only barometer
and specific force remain.

A constant gyro bias b first turns the attitude by b / kp; b_g takes it over with the time constant
kp / ki, 25 s with the defaults.

Source: R. Mahony, T. Hamel and J.-M. Pflimlin, Nonlinear complementary filters on the special
orthogonal group, IEEE Transactions on Automatic Control 53(5), 2008: explicit filter with bias
correction, equations 32 and 34.
"""

import math

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.dynamics.rigid_body import cross, into_world, rotation
from workbench.estimation.ekf import nominal
from workbench.estimation.ekf_propagation import turned_by
from workbench.estimation.ekf_state import NOMINAL
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER
from workbench.plant.gravity import GRAVITY

LAST_SAMPLES_INDEX = NOMINAL
COMPLEMENTARY_MEMORY_SIZE = LAST_SAMPLES_INDEX + 4 + 3 + 3 + 1
"""Layout of the memory, and its size: the nominal state as in the EKF, with a zero accelerometer
bias (16); whether GPS, barometer and magnetometer have had samples, and the age of the last GPS
sample (4); position (3) and velocity (3) of the last GPS sample, and height of the last barometer
sample (1)."""
GPS_HOLD_TIME_S = 1.0
"""The last GPS sample is used for this long [s]."""
_MIN_FORCE_RATIO, _MAX_FORCE_RATIO = 0.5, 1.5
"""Range of specific force over g in which it is used as the upward direction."""


@register_jitable
def turning(x: Numbers, imu: Numbers, field: Numbers, m_W: Numbers) -> Vector3:
    """Return the attitude error e (3).

    Args:
        x: attitude first (4).
        imu: angular velocity and specific force in B (6).
        field: magnetic field in B (3), zero without a sample.
        m_W: magnetic field (3).
    """
    R = rotation((x[0], x[1], x[2], x[3]))
    up = (R[6], R[7], R[8])
    f = (imu[3], imu[4], imu[5])
    size = (f[0] * f[0] + f[1] * f[1] + f[2] * f[2]) ** 0.5
    e_x, e_y, e_z = 0.0 * size, 0.0 * size, 0.0 * size
    if _MIN_FORCE_RATIO * GRAVITY < size < _MAX_FORCE_RATIO * GRAVITY:
        e_x, e_y, e_z = cross((f[0] / size, f[1] / size, f[2] / size), up)
    n_x, n_y, _ = into_world(R, (field[0], field[1], field[2]))
    level = ((n_x * n_x + n_y * n_y) * (m_W[0] * m_W[0] + m_W[1] * m_W[1])) ** 0.5
    if level > 0.0:
        turn = (n_x * m_W[1] - n_y * m_W[0]) / level
        e_x, e_y, e_z = e_x + turn * up[0], e_y + turn * up[1], e_z + turn * up[2]
    return e_x, e_y, e_z


@register_jitable
def update(
    memory: np.ndarray, z: np.ndarray, settings: Numbers, mounting: np.ndarray, dt: float
) -> None:
    """Do an update in place.

    Args:
        memory: see `COMPLEMENTARY_MEMORY_SIZE`.
        z: see `samples`.
        settings: see `settings.ComplementarySettings`.
        mounting: see `samples.Mounting.packed`.
        dt: since the previous update [s]; 0 at the first.
    """
    x = memory[:NOMINAL]
    seen = memory[LAST_SAMPLES_INDEX : LAST_SAMPLES_INDEX + 4]
    p_y, v_y = (
        memory[LAST_SAMPLES_INDEX + 4 : LAST_SAMPLES_INDEX + 7],
        memory[LAST_SAMPLES_INDEX + 7 : LAST_SAMPLES_INDEX + 10],
    )
    kp, ki = settings[0], settings[1]
    e = turning(x, z, z[MAGNETOMETER + 1 : MAGNETOMETER + 4] * z[MAGNETOMETER], mounting[15:18])
    w = (
        z[0] - x[10] + kp * e[0],
        z[1] - x[11] + kp * e[1],
        z[2] - x[12] + kp * e[2],
    )
    q = (x[0], x[1], x[2], x[3])
    R = rotation(turned_by(q, (0.5 * dt * w[0], 0.5 * dt * w[1], 0.5 * dt * w[2])))
    q = turned_by(q, (dt * w[0], dt * w[1], dt * w[2]))
    a = into_world(R, (z[3], z[4], z[5]))
    arm = into_world(
        R, (mounting[3] - mounting[0], mounting[4] - mounting[1], mounting[5] - mounting[2])
    )
    below = into_world(
        R, (mounting[6] - mounting[0], mounting[7] - mounting[1], mounting[8] - mounting[2])
    )
    seen[3] += dt
    if z[GPS] > 0.0:
        seen[0], seen[3] = 1.0, 0.0
        for i in range(3):
            v_y[i] = z[GPS + 5 + i]
            p_y[i] = z[GPS + 2 + i] - arm[i] + z[GPS + 1] * v_y[i]
    if z[BAROMETER] > 0.0:
        seen[1] = 1.0
        memory[LAST_SAMPLES_INDEX + 10] = z[BAROMETER + 1] - below[2]
    by_gps = seen[0] if seen[3] <= GPS_HOLD_TIME_S else 0.0
    for i in range(4):
        x[i] = q[i]
    for i in range(3):
        x[10 + i] -= ki * dt * e[i]
        pull = a[i] - (GRAVITY if i == 2 else 0.0)
        way = dt * (x[7 + i] + 0.5 * dt * pull)
        p, v = x[4 + i] + way, x[7 + i] + dt * pull
        if z[GPS] == 0.0:
            p_y[i] += way
            v_y[i] += dt * pull
        if i == 2 and z[BAROMETER] == 0.0:
            memory[LAST_SAMPLES_INDEX + 10] += way
        time, target, known = settings[2], p_y[i], by_gps
        if i == 2 and seen[1] > 0.0:
            time, target, known = settings[4], memory[LAST_SAMPLES_INDEX + 10], 1.0
        gap = known * (target - p)
        drawn = by_gps * (v_y[i] - v) / settings[3]
        x[4 + i] = p + dt * 2.0 / time * gap
        x[7 + i] = v + dt * (gap / (time * time) + drawn)


def initial_complementary(state: Numbers, p_BI: Numbers) -> np.ndarray:
    """Return the initial memory for a known motion.

    Args:
        state: q_WB, p_WB, w_WB_W, v_WB_W (13).
        p_BI: of the IMU (3) [m].
    """
    memory = np.zeros(COMPLEMENTARY_MEMORY_SIZE)
    memory[:NOMINAL] = nominal(state, p_BI)
    assert math.isfinite(memory.sum())
    return memory

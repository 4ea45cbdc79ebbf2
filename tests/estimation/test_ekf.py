"""The EKF beside a filter written from the textbook, and beside differences and Drake's numbers.

The textbook's is that of J. Solà, Quaternion kinematics for the error-state Kalman filter,
arXiv:1711.02508, in matrices: derivatives by differences of the models, which stand here once
more, and all numbers of an update at once in Joseph's form.
"""

import numpy as np
from scipy.spatial.transform import Rotation

from workbench.estimation import ekf
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER, Mounting

G = np.array([0.0, 0.0, 9.81])
MOUNTING = Mounting(
    p_BI=(0.03, -0.02, 0.05),
    p_BG=(-0.1, 0.06, 0.12),
    p_BP=(0.02, 0.04, -0.03),
    p_BR=(0.05, 0.01, -0.08),
    n_BR=(0.0998334166468282, 0.0, -0.995004165278026),
    m_W=(3e-6, 2.1e-5, -4.2e-5),
)
SETTINGS = ekf.EkfSettings()


class Textbook:
    """Rotation, then p, v, b_g and b_a (12), and the covariance of their errors (15, 15)."""

    def __init__(self, memory):
        self.R = Rotation.from_quat(memory[:4], scalar_first=True)
        self.x = memory[4:16].copy()
        self.P = memory[16:241].reshape(15, 15).copy()

    def update(self, z, settings, mounting, dt):
        F = derivative(lambda errors: self.after(errors, z, dt))
        gyro, accel = settings.ekf_gyro_noise**2, settings.ekf_accel_noise**2
        Q = np.zeros((15, 15))
        one = np.eye(3)
        Q[0:3, 0:3] = gyro * dt * one
        Q[3:9, 3:9] = accel * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], one)
        Q[9:12, 9:12] = settings.ekf_gyro_bias_walk**2 * dt * one
        Q[12:15, 12:15] = settings.ekf_accel_bias_walk**2 * dt * one
        self.R, self.x = moved(self.R, self.x, z, dt)
        self.P = F @ self.P @ F.T + Q
        y, expected, r = told(self.R, z, settings, mounting)
        if y.size == 0:
            return
        H = derivative(lambda errors: expected(*added(self.R, self.x, errors)))
        gap = y - expected(self.R, self.x)
        S = H @ self.P @ H.T + np.diag(r)
        K = self.P @ H.T @ np.linalg.inv(S)
        rest = np.eye(15) - K @ H
        self.P = rest @ self.P @ rest.T + K @ np.diag(r) @ K.T
        self.R, self.x = added(self.R, self.x, K @ gap)

    def after(self, errors, z, dt):
        """Return the errors after a period by those before it (N, 15)."""
        R, x = moved(*added(self.R, self.x, errors), z, dt)
        R_0, x_0 = moved(self.R, self.x, z, dt)
        return np.concatenate([(R_0.inv() * R).as_rotvec(), x - x_0], axis=-1)


def added(R, x, error):
    return R * Rotation.from_rotvec(error[..., :3]), x + error[..., 3:]


def moved(R, x, z, dt):
    """Return rotation and the rest after a period of the IMU; force as in its middle."""
    turn = dt * (z[0:3] - x[..., 6:9])
    a = (R * Rotation.from_rotvec(turn / 2)).apply(z[3:6] - x[..., 9:12]) - G
    p, v = x[..., 0:3], x[..., 3:6]
    p, v = p + dt * v + dt**2 / 2 * a, v + dt * a
    return R * Rotation.from_rotvec(turn), np.concatenate([p, v, x[..., 6:]], axis=-1)


def told(R_0, z, settings, mounting):
    """Return what was measured, the function that expects it, and the variances.

    Of the field the heading is measured: of what is read in B, turned by the attitude R_0.
    """
    arm_G, arm_P, arm_R = (np.array(p) - mounting.p_BI for p in mounting[1:4])
    m = np.array(mounting.m_W)
    y, r, parts = [], [], []
    if z[GPS]:
        y += [*z[GPS + 2 : GPS + 8]]
        r += [settings.ekf_gps_position**2] * 2 + [settings.ekf_gps_height**2]
        r += [settings.ekf_gps_velocity**2] * 3

        def antenna(R, x):
            R, x = moved(R, x, z, -z[GPS + 1])  # to when it was measured
            v = x[..., 3:6] + R.apply(np.cross(z[0:3] - x[..., 6:9], arm_G))
            return np.concatenate([x[..., 0:3] + R.apply(arm_G), v], axis=-1)

        parts.append(antenna)
    if z[BAROMETER]:
        y.append(z[BAROMETER + 1])
        r.append(settings.ekf_barometer**2)
        parts.append(lambda R, x: x[..., 2:3] + R.apply(arm_P)[..., 2:])
    if z[MAGNETOMETER]:
        true = np.arctan2(m[1], m[0])
        read = R_0.apply(z[MAGNETOMETER + 1 : MAGNETOMETER + 4])
        y.append((np.arctan2(read[1], read[0]) - true + np.pi) % (2 * np.pi) - np.pi)
        r.append(settings.ekf_magnetometer**2 / (m[0] ** 2 + m[1] ** 2))

        def heading(R, x):
            n = (R_0 * R.inv()).apply(m)
            return np.arctan2(n[..., 1:2], n[..., 0:1]) - true

        parts.append(heading)
    if z[RANGE_FINDER]:
        y.append(z[RANGE_FINDER + 1])
        r.append(settings.ekf_range_finder**2)
        parts.append(
            lambda R, x: (x[..., 2:3] + R.apply(arm_R)[..., 2:]) / -R.apply(mounting.n_BR)[..., 2:]
        )
    return np.array(y), lambda R, x: np.concatenate([part(R, x) for part in parts], axis=-1), r


STEP = 1e-4


def derivative(function):
    """Return the derivative at an error of zero, by differences of fourth order.

    Args:
        function: of errors (N, 15), a row of results each.
    """
    each = np.eye(15) * STEP
    found = function(np.concatenate([each, -each, 2 * each, -2 * each]))
    there, back, far, far_back = np.split(found, 4)
    return ((8 * (there - back) - (far - far_back)) / (12 * STEP)).T


def covariance(memory):
    return memory[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(ekf.ERRORS, ekf.ERRORS)


def test_the_textbooks_filter_gives_the_same_estimate_and_covariance(kit):
    rng = np.random.default_rng(7)
    flown = kit.flights["figure of eight"](20.0)
    memory, biases = kit.begin(flown, SETTINGS, rng)
    z = kit.samples(flown, MOUNTING, SETTINGS, rng, biases, age=3)
    settings, mounting = np.array(SETTINGS), MOUNTING.packed()
    book = Textbook(memory)
    worst, spread = 0.0, 0.0
    for row in z[1:]:
        kit.ekf(memory, row, settings, mounting, kit.period)
        book.update(row, SETTINGS, MOUNTING, kit.period)
        turn = (book.R.inv() * Rotation.from_quat(memory[:4], scalar_first=True)).as_rotvec()
        worst = max(worst, np.abs(turn).max(), np.abs(memory[4:16] - book.x).max())
        scale = np.sqrt(np.diag(book.P))
        spread = max(spread, np.abs((covariance(memory) - book.P) / np.outer(scale, scale)).max())
    assert np.degrees(np.arccos(flown.R.as_matrix()[:, 2, 2])).max() > 30.0
    assert worst < 1e-8
    assert spread < 1e-7

"""The EKF beside a filter written from the textbook, and beside differences and Drake's numbers.

The textbook's is that of J. Solà, Quaternion kinematics for the error-state Kalman filter,
arXiv:1711.02508, in matrices: derivatives by differences of the models, which stand here once
more, and all numbers of an update at once in Joseph's form.
"""

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractGradient, InitializeAutoDiff
from scipy import linalg
from scipy.spatial.transform import Rotation

from workbench.common.compiled import compile_cached
from workbench.estimation import ekf, ekf_measurements, ekf_propagation, ekf_state
from workbench.estimation.samples import (
    AGES,
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
    Mounting,
)
from workbench.estimation.settings import EkfSettings

G = np.array([0.0, 0.0, 9.81])
MOUNTING = Mounting(
    p_BI=(0.03, -0.02, 0.05),
    p_BG=(-0.1, 0.06, 0.12),
    p_BP=(0.02, 0.04, -0.03),
    p_BR=(0.05, 0.01, -0.08),
    n_BR=(0.0998334166468282, 0.0, -0.995004165278026),
    m_W=(3e-6, 2.1e-5, -4.2e-5),
)
SETTINGS = EkfSettings()
SOURCES = ("dynamics/rigid_body.py", "estimation", "plant/gravity.py")


class Textbook:
    """Rotation, then p, v, b_g and b_a (12), and the covariance of their errors (15, 15)."""

    def __init__(self, memory):
        self.R = Rotation.from_quat(memory[:4], scalar_first=True)
        self.x = memory[4:16].copy()
        self.P = memory[16:241].reshape(15, 15).copy()

    def update(self, z, settings, mounting, dt, without=None):
        F, Q = self.motion(z, settings, dt)
        self.R, self.x = moved(self.R, self.x, z, dt)
        self.P = F @ self.P @ F.T + Q
        gap, H, r = self.measurement(z, settings, mounting)
        if without is not None:
            r[without] = 1e12
        S = H @ self.P @ H.T + np.diag(r)
        K = self.P @ H.T @ np.linalg.inv(S)
        rest = np.eye(15) - K @ H
        self.P = rest @ self.P @ rest.T + K @ np.diag(r) @ K.T
        self.R, self.x = added(self.R, self.x, K @ gap)

    def motion(self, z, settings, dt):
        """Return F and Q of a period."""
        gyro, accel = settings.ekf_gyro_noise**2, settings.ekf_accel_noise**2
        Q = np.zeros((15, 15))
        one = np.eye(3)
        Q[0:3, 0:3] = gyro * dt * one
        Q[3:9, 3:9] = accel * np.kron([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]], one)
        Q[9:12, 9:12] = settings.ekf_gyro_bias_walk**2 * dt * one
        Q[12:15, 12:15] = settings.ekf_accel_bias_walk**2 * dt * one
        return derivative(lambda errors: self.after(errors, z, dt)), Q

    def measurement(self, z, settings, mounting):
        """Return y - h(x), H and the variances of what is measured."""
        y, expected, r = told(self.R, self.x, z, settings, mounting)
        H = derivative(lambda errors: expected(*added(self.R, self.x, errors)))
        return y - expected(self.R, self.x), H, r

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


def told(R_0, x_0, z, settings, mounting):
    """Return what was measured, the function that expects it, and the variances.

    Of the field the heading is measured, of what is read in B and turned by the attitude R_0: a
    vehicle that is turned farther to the left reads it farther to the right.
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

        def height(R, x):
            R, x = moved(R, x, z, -z[AGES])
            return x[..., 2:3] + R.apply(arm_P)[..., 2:]

        parts.append(height)
    if z[MAGNETOMETER]:
        true = np.arctan2(m[1], m[0])
        R_then, _ = moved(R_0, x_0, z, -z[AGES + 1])
        read = R_then.apply(z[MAGNETOMETER + 1 : MAGNETOMETER + 4])
        y.append((true - np.arctan2(read[1], read[0]) + np.pi) % (2 * np.pi) - np.pi)
        r.append(settings.ekf_magnetometer**2 / (m[0] ** 2 + m[1] ** 2))

        def heading(R, x):
            n = (R_then * moved(R, x, z, -z[AGES + 1])[0].inv()).apply(m)
            return true - np.arctan2(n[..., 1:2], n[..., 0:1])

        parts.append(heading)
    if z[RANGE_FINDER]:
        y.append(z[RANGE_FINDER + 1])
        r.append(settings.ekf_range_finder**2)

        def distance(R, x):
            R, x = moved(R, x, z, -z[AGES + 2])
            return (x[..., 2:3] + R.apply(arm_R)[..., 2:]) / -R.apply(mounting.n_BR)[..., 2:]

        parts.append(distance)

    def together(R, x):
        return np.concatenate([x[..., :0], *(part(R, x) for part in parts)], axis=-1)

    return np.array(y), together, r


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
    return memory[ekf_state.COVARIANCE_INDEX : ekf_state.INNOVATIONS_INDEX].reshape(
        ekf_state.ERRORS, ekf_state.ERRORS
    )


def test_the_textbooks_filter_gives_the_same_estimate_and_covariance(kit):
    rng = np.random.default_rng(7)
    flown = kit.flights["figure of eight"](10.0)
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


def anything(rng):
    """Return a nominal state (16), samples of all sensors, and a mounting, at random."""
    x = np.concatenate([rng.normal(size=4), rng.normal(size=6), 0.1 * rng.normal(size=6)])
    R = Rotation.from_rotvec(rng.uniform(-0.5, 0.5, 3)) * Rotation.from_euler("z", rng.normal())
    x[:4] = R.as_quat(scalar_first=True)
    x[6] += 8.0
    places = rng.uniform(-0.3, 0.3, (4, 3))
    mounting = Mounting(*places, MOUNTING.n_BR, MOUNTING.m_W)
    z = np.concatenate(
        [3 * rng.normal(size=3), 5 * rng.normal(size=3) + G, np.zeros(SAMPLE_ARRAY_SIZE - 6)]
    )
    z[GPS : GPS + 8] = [1.0, rng.uniform(0.0, 0.05), *rng.normal(size=6)]
    z[BAROMETER : BAROMETER + 2] = 1.0, rng.normal()
    z[MAGNETOMETER : MAGNETOMETER + 4] = [
        1.0,
        *(R.inv().apply(MOUNTING.m_W) + 5e-6 * rng.normal(size=3)),
    ]
    z[RANGE_FINDER : RANGE_FINDER + 2] = 1.0, rng.normal()
    z[AGES:] = rng.uniform(0.0, 0.02, 3)
    return x, z, mounting


def automatically(function):
    """Return the derivative of a tuple by errors (15) at zero, by Drake's AutoDiffXd."""
    found = function(InitializeAutoDiff(np.zeros(15)).ravel())
    return ExtractGradient(np.array([found]).T)


def error_between(q_0, q):
    """Return d_theta (3) by which q is off q_0, to first order; of any scalars."""
    w, x, y, z = q_0
    a, b, c, d = q
    return [
        2 * (w * b - x * a - y * d + z * c),
        2 * (w * c + x * d - y * a - z * b),
        2 * (w * d - x * c + y * b - z * a),
    ]


def test_transition_is_the_derivative_of_the_motion(case):
    rng = np.random.default_rng(1)
    for number in range(20):
        x, z, _ = anything(rng)
        dt = rng.uniform(0.001, 0.02)
        F = ekf_propagation.transition(x, z, dt)[:9]
        q_0 = ekf_propagation.propagated(x, z, dt)[:4]

        def after(error, x=x, z=z, dt=dt, q_0=q_0):
            found = ekf_propagation.propagated(ekf_propagation.corrected(x, error), z, dt)
            return [*error_between(q_0, found[:4]), *found[4:10]]

        book = Textbook(np.concatenate([x, np.zeros(225)]))
        with case(number, "AutoDiffXd"):
            np.testing.assert_allclose(F, automatically(after), atol=1e-11)
        with case(number, "differences of the textbook's"):
            expected = derivative(lambda e, z=z, dt=dt, book=book: book.after(e, z, dt))
            np.testing.assert_allclose(F, expected[:9], atol=1e-9)


def test_rows_are_the_derivatives_of_what_is_measured(case):
    rng = np.random.default_rng(2)
    kinds = [*["place of the antenna"] * 3, *["its velocity"] * 3, "height", "heading", "distance"]
    for number in range(20):
        x, z, mounting = anything(rng)
        rows, gaps = ekf_measurements.measurement_rows(x, z, mounting.packed(), SETTINGS)
        R = Rotation.from_quat(x[:4], scalar_first=True)
        y, expected, variances = told(R, x[4:], z, SETTINGS, mounting)
        H = derivative(lambda e, R=R, x=x, told=expected: told(*added(R, x[4:], e)))
        for row, kind in enumerate(kinds):
            with case(number, kind):
                np.testing.assert_allclose(rows[row], H[row], atol=1e-7)
                assert gaps[row].tolist() == pytest.approx(
                    [(y - expected(R, x[4:]))[row], variances[row]], abs=1e-8
                )
        assert np.isnan(gaps[9]).all()
        assert not rows[9].any()
        nothing = z * (np.arange(z.size) < GPS)
        rows, gaps = ekf_measurements.measurement_rows(x, nothing, mounting.packed(), SETTINGS)
        assert np.isnan(gaps).all()
        assert not rows.any()


@pytest.mark.slow  # it compiles for fifteen seconds
def test_compiled_it_gives_what_it_gives_in_python(kit):
    compiled_ekf = compile_cached(ekf.update, SOURCES, "the estimator ekf", error_model="numpy")
    rng = np.random.default_rng(3)
    flown = kit.flights["full speed"](2.0)
    compiled, biases = kit.begin(flown, SETTINGS, rng)
    z = kit.samples(flown, MOUNTING, SETTINGS, rng, biases, age=2)
    interpreted = compiled.copy()
    for row in z[1:]:
        compiled_ekf(compiled, row, np.array(SETTINGS), MOUNTING.packed(), kit.period)
        ekf.update(interpreted, row, np.array(SETTINGS), MOUNTING.packed(), kit.period)
    np.testing.assert_allclose(compiled, interpreted, rtol=1e-12, atol=1e-12)


def test_after_ten_thousand_violent_updates_the_covariance_is_one(kit):
    rng = np.random.default_rng(4)
    x, _, mounting = anything(rng)
    memory = np.full(ekf_state.EKF_MEMORY_SIZE, np.nan)
    memory[:16] = x
    memory[ekf_state.COVARIANCE_INDEX : ekf_state.INNOVATIONS_INDEX] = np.diag(
        10.0 ** rng.uniform(-6, 4, 15)
    ).ravel()
    gateless = SETTINGS._replace(ekf_gate=1e9, ekf_range_finder=1e-4, ekf_gps_height=100.0)
    settings, packed = np.array(gateless), mounting.packed()
    drawn = [anything(rng)[1] for _ in range(1000)]
    for number in range(10_000):
        z = drawn[number % len(drawn)].copy()
        z[:6] *= 5.0
        z[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = rng.random(4) < 0.3
        kit.ekf(memory, z, settings, packed, kit.period)
    P = covariance(memory)
    scale = np.sqrt(np.diag(P))
    assert np.isfinite(memory[:16]).all()
    assert (P == P.T).all()
    assert np.linalg.eigvalsh(P / np.outer(scale, scale)).min() > 0.0
    assert np.linalg.norm(memory[:4]) == pytest.approx(1.0, abs=1e-12)


def test_what_is_beyond_the_gate_or_not_new_changes_nothing(case, kit):
    flown = kit.flights["hover"](0.1)
    begun = ekf.initial_ekf(flown.state(0), (0.0, 0.0, 0.0), ekf.InitialDeviations())
    rng = np.random.default_rng(5)
    every = dict.fromkeys(("gps", "barometer", "magnetometer", "range_finder"), 1)
    z = kit.samples(flown, MOUNTING, SETTINGS, rng, np.zeros((len(flown.p), 6)), every)[1]
    none, outlier = z.copy(), z.copy()
    none[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = 0.0
    outlier[GPS + 2] += 50.0
    settings, mounting = np.array(SETTINGS), MOUNTING.packed()
    with case("no new sample"):
        memory, book = begun.copy(), Textbook(begun)
        kit.ekf(memory, none, settings, mounting, kit.period)
        book.update(none, SETTINGS, MOUNTING, kit.period)
        np.testing.assert_allclose(covariance(memory), book.P, atol=1e-12)
        assert np.isnan(memory[ekf_state.INNOVATIONS_INDEX :]).all()
    with case("an outlier"):
        # the one number is left out, as if its noise were boundless; its innovation is told
        memory, book = begun.copy(), Textbook(begun)
        kit.ekf(memory, outlier, settings, mounting, kit.period)
        book.update(outlier, SETTINGS, MOUNTING, kit.period, without=0)
        np.testing.assert_allclose(memory[4:16], book.x, atol=1e-9)
        np.testing.assert_allclose(covariance(memory), book.P, atol=1e-12)
        assert memory[ekf_state.INNOVATIONS_INDEX] == pytest.approx(50.0, abs=2.0)
    with case("all that is within the gate counts"):
        memory, book = begun.copy(), Textbook(begun)
        kit.ekf(memory, z, settings, mounting, kit.period)
        book.update(z, SETTINGS, MOUNTING, kit.period)
        np.testing.assert_allclose(covariance(memory), book.P, atol=1e-12)


def test_a_range_finder_counts_while_it_looks_down(case):
    """Along its beam a height of 3 m is 3 / cos farther; from 60 degrees on it says nothing."""
    z = np.zeros(SAMPLE_ARRAY_SIZE)
    z[0:6], z[RANGE_FINDER] = [0.0, 0.0, 0.0, *G], 1.0
    for degrees, counts in (
        (0, True),
        (59, True),
        (61, False),
        (90, False),
        (120, False),
        (180, False),
    ):
        with case(degrees):
            R = Rotation.from_euler("y", degrees, degrees=True)
            state = [*R.as_quat(scalar_first=True), 0.0, 0.0, 3.0, *[0.0] * 6]
            memory = ekf.initial_ekf(state, (0.0, 0.0, 0.0), ekf.InitialDeviations())
            begun = memory.copy()
            z[RANGE_FINDER + 1] = 3.0 / abs(np.cos(np.radians(degrees))) + 0.01
            ekf.update(memory, z, np.array(SETTINGS), Mounting().packed(), 0.0)
            told = memory[ekf_state.INNOVATIONS_INDEX + 2 * ekf_state.DISTANCE_CHANNEL]
            if counts:
                assert told == pytest.approx(0.01, abs=1e-9)
                assert memory[6] > 3.0
            else:
                assert np.isnan(told)
                np.testing.assert_array_equal(
                    memory[: ekf_state.INNOVATIONS_INDEX], begun[: ekf_state.INNOVATIONS_INDEX]
                )


def test_in_hover_the_covariance_settles_as_the_riccati_equation_says(kit):
    # in hover only levers tell a tilt from a bias of the accelerometer: long ones settle in seconds
    mounting = MOUNTING._replace(p_BG=(1.0, 0.5, 0.1), p_BP=(-0.5, 1.0, 0.0), p_BR=(0.0, -1.0, 0.2))
    settings = SETTINGS._replace(ekf_gyro_bias_walk=1e-2, ekf_accel_bias_walk=1e-1)
    flown = kit.flights["hover"](0.1)
    memory = ekf.initial_ekf(flown.state(0), (0.0, 0.0, 0.0), ekf.InitialDeviations())
    book, z = Textbook(memory), np.zeros(SAMPLE_ARRAY_SIZE)
    z[[GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER]] = 1.0
    z[0:6] = [*flown.w[0], *flown.f[0]]
    z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = flown.R[0].inv().apply(mounting.m_W)
    F, Q = book.motion(z, settings, kit.period)
    gap, H, r = book.measurement(z, settings, mounting)
    for places, rows in ((GPS + 2, slice(0, 6)), (BAROMETER + 1, 6), (RANGE_FINDER + 1, 8)):
        count = np.size(gap[rows])
        z[places : places + count] -= gap[rows]  # all is as expected, and the estimate stays
    predicted = linalg.solve_discrete_are(F.T, H.T, Q, np.diag(r))
    K = predicted @ H.T @ np.linalg.inv(H @ predicted @ H.T + np.diag(r))
    settled = predicted - K @ H @ predicted
    numbers, packed = np.array(settings), mounting.packed()
    for _ in range(20_000):
        kit.ekf(memory, z, numbers, packed, kit.period)
    scale = np.sqrt(np.diag(settled))
    off = (covariance(memory) - settled) / np.outer(scale, scale)
    assert np.abs(memory[4:16] - book.x).max() < 1e-9
    assert np.abs(off).max() < 1e-6

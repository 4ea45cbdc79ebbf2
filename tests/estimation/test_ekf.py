"""The EKF against a textbook's in whole matrices, against chi-square bounds, and in its limits."""

from functools import partial

import numpy as np
import pytest
from pydrake.autodiffutils import ExtractValue, InitializeAutoDiff
from scipy import stats
from scipy.spatial.transform import Rotation

from tests.estimation.made_flights import PERIOD, figure_eight, full_speed, hover, made
from tests.estimation.textbook import State, TextbookFilter
from workbench.estimation import ekf
from workbench.estimation.estimators import compiled_update
from workbench.estimation.samples import (
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLES,
    Mounting,
)
from workbench.estimation.settings import EkfSettings

FIELD = np.array([1e-6, 21e-6, -43e-6])
MOUNTING = Mounting(
    p_BI=(0.02, -0.01, 0.03),
    p_BG=(0.0, 0.1, 0.15),
    p_BP=(-0.05, 0.0, 0.02),
    p_BR=(0.04, 0.0, -0.05),
    n_BR=(0.1, 0.0, -np.sqrt(0.99)),
    m_W=FIELD,
)
PLACES = MOUNTING.packed()
SETTINGS = EkfSettings(ekf_gate=1e6)
START = ekf.InitialDeviations(0.02, 0.3, 0.1, 0.003, 0.05)
FLIGHTS = {"hover": hover, "figure of eight": figure_eight, "full speed": full_speed}
EVERY = {"gps": 13, "barometer": 3, "magnetometer": 3, "range_finder": 6}
"""Updates from one sample to the next."""


def nominal(turn, p, v, b_g=(0, 0, 0), b_a=(0, 0, 0)):
    x, y, z, w = turn.as_quat()
    return np.array([w, x, y, z, *p, *v, *b_g, *b_a])


def wanted(state, w, age):
    """Return what sensors should say of the textbook's state, a part a kind of sensor."""
    rate = w - state.b_g
    arm, low, look = (
        np.array(p) - MOUNTING.p_BI for p in (MOUNTING.p_BG, MOUNTING.p_BP, MOUNTING.p_BR)
    )
    speed = state.v + state.turn.apply(np.cross(rate, arm))
    place = state.p + state.turn.apply(arm) - age * speed
    beam = state.turn.apply(MOUNTING.n_BR)
    return {
        "gps": np.concatenate([place, speed]),
        "barometer": np.array([state.p[2] + state.turn.apply(low)[2]]),
        "range_finder": np.array([-(state.p[2] + state.turn.apply(look)[2]) / beam[2]]),
    }


def heading_gap(state, field):
    """Return by how much the horizontal field must be turned to be the known one."""
    east, north, _ = state.turn.apply(field)
    return np.arctan2(FIELD[1], FIELD[0]) - np.arctan2(north, east)


def variances(settings):
    s = settings
    level = np.hypot(*FIELD[:2])
    return {
        "gps": np.square([s[4], s[4], s[5], s[6], s[6], s[6]]),
        "barometer": np.array([s[7] ** 2]),
        "magnetometer": np.array([(s[8] / level) ** 2]),
        "range_finder": np.array([s[9] ** 2]),
    }


def samples(number, truth, w, f, rng, settings, age=0.0):
    """Return what sensors say at an update: of the truth, with the noise that the filter states."""
    z = np.zeros(SAMPLES)
    z[:3], z[3:6] = w, f
    said, noise = wanted(truth, w, age), variances(settings)
    said["magnetometer"] = truth.turn.inv().apply(FIELD)
    for kind, place in (
        ("gps", GPS),
        ("barometer", BAROMETER),
        ("range_finder", RANGE_FINDER),
        ("magnetometer", MAGNETOMETER),
    ):
        if number % EVERY[kind]:
            continue
        z[place] = 1.0
        spread = np.sqrt(noise[kind]) * rng.normal(size=len(noise[kind]))
        if kind == "gps":
            z[GPS + 1 : GPS + 8] = [age, *(said["gps"] + spread)]
        elif kind == "magnetometer":
            turned = Rotation.from_rotvec([0.0, 0.0, spread[0]]).apply(FIELD)
            z[MAGNETOMETER + 1 : MAGNETOMETER + 4] = truth.turn.inv().apply(turned)
        else:
            z[place + 1] = (said[kind] + spread)[0]
    return z


def flown(path, seconds, seed, run, settings=SETTINGS, age=0.0, textbook=None):
    """Fly a filter, and yield number, memory and the true state after each update."""
    rng = np.random.default_rng(seed)
    turns, p, v, w, f = made(path, seconds)
    spread = np.repeat(START, 3)
    errors = spread * rng.normal(size=15)
    b_g, b_a = errors[9:12], errors[12:15]
    truth = State(turns[0], p[0], v[0], b_g, b_a)
    guess = truth.plus(-np.concatenate([errors[:9], np.zeros(6)]))
    memory = np.full(ekf.SIZE, np.nan)
    memory[: ekf.NOMINAL] = nominal(guess.turn, guess.p, guess.v)
    memory[ekf.COVARIANCE : ekf.INNOVATIONS] = np.diag(spread**2).ravel()
    if textbook:
        textbook.state = State(guess.turn, guess.p, guess.v, np.zeros(3), np.zeros(3))
        textbook.P = np.diag(spread**2)
    root = 1.0 / np.sqrt(PERIOD)
    for number in range(1, len(w) + 1):
        measured_w = w[number - 1] + b_g + settings[0] * root * rng.normal(size=3)
        measured_f = f[number - 1] + b_a + settings[1] * root * rng.normal(size=3)
        b_g = b_g + settings[2] / root * rng.normal(size=3)
        b_a = b_a + settings[3] / root * rng.normal(size=3)
        truth = State(turns[number], p[number], v[number], b_g, b_a)
        # sensors that need the rate see the noisy one that the filter has, so that h is exact
        z = samples(number, truth, measured_w, measured_f, rng, settings, age)
        run(memory, z, np.array(settings), PLACES, PERIOD)
        if textbook:
            follow(textbook, z, number, settings)
        yield number, memory, truth


def follow(textbook, z, number, settings):
    """Let the textbook's filter do what the filter under test did."""
    w, f = z[:3], z[3:6]
    textbook.predict(w, f, PERIOD)
    kinds = [kind for kind in ("gps", "barometer", "magnetometer", "range_finder")]
    places = dict(zip(kinds, (GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER), strict=True))
    there = [kind for kind in kinds if z[places[kind]] > 0.0]
    if not there:
        return
    noise = variances(settings)

    def measure(state, field=z[MAGNETOMETER + 1 : MAGNETOMETER + 4]):
        parts = wanted(state, w, z[GPS + 1])
        parts["magnetometer"] = np.array([-heading_gap(state, field)])
        return np.concatenate([parts[kind] for kind in there])

    expected = partial(measure, field=textbook.state.turn.inv().apply(FIELD))

    said = {
        "gps": z[GPS + 2 : GPS + 8],
        "barometer": z[BAROMETER + 1 : BAROMETER + 2],
        "magnetometer": np.zeros(1),
        "range_finder": z[RANGE_FINDER + 1 : RANGE_FINDER + 2],
    }
    textbook.correct(
        measure,
        np.concatenate([said[kind] for kind in there]),
        np.concatenate([noise[kind] for kind in there]),
        expected,
    )


def test_it_is_the_textbooks_filter():
    """20 s of a figure of eight, all sensors, GPS samples 0.1 s old."""
    textbook = TextbookFilter(None, np.eye(15), SETTINGS[:4])
    for _, memory, _ in flown(
        figure_eight, 20.0, 7, compiled_update("ekf"), age=0.1, textbook=textbook
    ):
        x = memory[: ekf.NOMINAL]
        own = State(Rotation.from_quat(x[[1, 2, 3, 0]]), x[4:7], x[7:10], x[10:13], x[13:16])
        assert np.abs(own.minus(textbook.state)).max() < 1e-6
    P = memory[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(15, 15)
    scale = np.sqrt(np.outer(np.diag(P), np.diag(P)))
    assert (np.abs(P - textbook.P) / scale).max() < 1e-5
    assert (np.abs(P - P.T) / scale).max() < 1e-12
    assert np.linalg.eigvalsh(P).min() > 0.0


@pytest.mark.parametrize(
    "name",
    [
        "figure of eight",
        *(pytest.param(n, marks=pytest.mark.slow) for n in ("hover", "full speed")),
    ],
)
def test_its_errors_are_as_large_as_it_says(name):
    """NEES of attitude, place and velocity, the mean of 50 seeds, within the 95 % bounds.

    And of each of the three, at instants 2 s apart: of so many one in twenty may be outside.
    """
    seeds, wide = 50, 9
    nees: dict[tuple[int, slice], list[float]] = {}
    innovations = []
    for seed in range(seeds):
        for number, memory, truth in flown(FLIGHTS[name], 10.0, seed, compiled_update("ekf")):
            told = memory[ekf.INNOVATIONS : ekf.SIZE].reshape(-1, 2)
            innovations += [gap * gap / s for gap, s in told if not np.isnan(gap)]
            if number % 256:
                continue
            x = memory[: ekf.NOMINAL]
            own = State(Rotation.from_quat(x[[1, 2, 3, 0]]), x[4:7], x[7:10], x[10:13], x[13:16])
            error = truth.minus(own)
            P = memory[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(15, 15)
            for part in (slice(0, 9), slice(0, 3), slice(3, 6), slice(6, 9)):
                value = error[part] @ np.linalg.solve(P[part, part], error[part])
                nees.setdefault((number, part.start, part.stop), []).append(value)
    outside = 0
    for (_, first, last), values in nees.items():
        freedom = seeds * (last - first)
        low, high = stats.chi2.ppf([0.025, 0.975], freedom)
        outside += not low < sum(values) < high
    assert outside <= 3, f"{outside} of {len(nees)}"
    whole = [sum(values) for (_, *part), values in nees.items() if part == [0, wide]]
    low, high = stats.chi2.ppf([0.025, 0.975], seeds * wide)
    assert low < np.mean(whole) < high
    share = np.mean(np.array(innovations) < stats.chi2.ppf(0.95, 1))
    assert share == pytest.approx(0.95, abs=0.01)


def test_jacobians_are_those_of_autodiff():
    rng = np.random.default_rng(3)
    for _ in range(20):
        x = nominal(Rotation.random(random_state=rng), *rng.normal(size=(4, 3)))
        x[4:7] += [0.0, 0.0, 20.0]
        imu = np.concatenate([4.0 * rng.normal(size=3), [0, 0, 9.8] + 3.0 * rng.normal(size=3)])
        F = np.empty((9, 15))
        ekf.transition(x, imu, PERIOD, F)
        after = np.array(ekf.propagated(x, imu, PERIOD))

        def moved(error, x=x, imu=imu, after=after):
            found = ekf.propagated(ekf.corrected(x, error), imu, PERIOD)
            turn = Rotation.from_quat(after[[1, 2, 3, 0]]).inv() * Rotation.from_quat(
                [found[1], found[2], found[3], found[0]]
            )
            return np.concatenate([turn.as_rotvec(), np.array(found[4:10]) - after[4:10]])

        columns = [(moved(1e-6 * e) - moved(-1e-6 * e)) / 2e-6 for e in np.eye(15)]
        assert np.abs(F - np.array(columns).T).max() < 1e-8
        seeded = InitializeAutoDiff(np.zeros(15), np.eye(15)).ravel().tolist()
        whole = np.array(ekf.propagated(ekf.corrected(x.tolist(), seeded), imu.tolist(), PERIOD))
        by = np.array([each.derivatives() for each in whole[4:10]])
        assert np.abs(F[3:] - by).max() < 1e-9
        assert ExtractValue(whole[:, None]).ravel() == pytest.approx(after, abs=1e-12)


def test_compiled_is_interpreted():
    run = compiled_update("ekf")
    flights = zip(
        flown(figure_eight, 1.0, 5, run), flown(figure_eight, 1.0, 5, ekf.update), strict=True
    )
    for (_, one, _), (_, other, _) in flights:
        known = ~np.isnan(other)
        assert (known == ~np.isnan(one)).all()
        assert one[known] == pytest.approx(other[known], rel=1e-9, abs=1e-12)


def test_what_is_far_beyond_the_gate_is_left_out():
    settings = np.array(EkfSettings())
    memory = ekf.initial(
        np.array([1.0, *[0.0] * 5, 10.0, *[0.0] * 6]), MOUNTING.p_BI, ekf.InitialDeviations()
    )
    z = np.zeros(SAMPLES)
    z[5] = 9.81
    quiet, far = memory.copy(), memory.copy()
    ekf.update(quiet, z, settings, PLACES, PERIOD)
    z[GPS : GPS + 8] = 1.0, 0.0, 50.0, 0.1, 10.15, 0.0, 0.0, 0.0
    ekf.update(far, z, settings, PLACES, PERIOD)
    assert far[4] == pytest.approx(quiet[4], abs=0.01)
    assert far[ekf.INNOVATIONS] == pytest.approx(50.0, abs=0.1)
    P = far[ekf.COVARIANCE : ekf.INNOVATIONS].reshape(15, 15)
    assert P[4, 4] < P[3, 3]  # the other axis was taken in
    assert np.isnan(quiet[ekf.INNOVATIONS :]).all()

"""Expressions of signals against numpy, and what is wrong in one with its place."""

import numpy as np
import pytest
import scipy.signal

from workbench.common.errors import WorkbenchError
from workbench.logs.expressions import EXPRESSION_FUNCTIONS, parse_expression

RATE = 200.0
RNG = np.random.default_rng(7)
TIME = np.arange(2000) / RATE
SIGNALS = {
    "velocity_data.v_x": RNG.normal(size=2000),
    "velocity_data.v_y": RNG.normal(size=2000),
    "command_velocity.v_x": RNG.normal(size=2000),
    "position_data.roll": RNG.uniform(-0.9, 0.9, size=2000),
    "rotors.thrust.0": RNG.uniform(1.0, 5.0, size=2000),
    "rotors.thrust.1": RNG.uniform(1.0, 5.0, size=2000),
}
X, Y, C, ROLL, T0, T1 = SIGNALS.values()


def read(name, since):
    first = int(np.searchsorted(TIME, since))
    return TIME[first:], SIGNALS[name][first:]


def series(text, since=-np.inf, reads=read, known=SIGNALS):
    expression = parse_expression(text)
    return expression.series(reads, expression.find(known), since)


EQUAL = {
    "sqrt(v_x**2 + v_y**2)": np.sqrt(X**2 + Y**2),
    "hypot(v_x, v_y)": np.hypot(X, Y),
    "velocity_data.v_x - command_velocity.v_x": X - C,
    "deg(roll)": np.rad2deg(ROLL),
    "rad(deg(roll)) / pi": ROLL / np.pi,
    "rotors.thrust.0 + 2*rotors.thrust.1 - 1.5": T0 + 2 * T1 - 1.5,
    "-v_x*-2 % 1.5 // 0.25": -X * -2 % 1.5 // 0.25,
    "v_x > 0.5": (X > 0.5).astype(float),
    "clip(v_x, -1, max(v_y, 0))": np.clip(X, -1.0, np.maximum(Y, 0.0)),
    "min(abs(v_x), exp(v_y))": np.minimum(np.abs(X), np.exp(Y)),
    "atan2(sin(roll), cos(roll)) + tan(roll)": np.arctan2(np.sin(ROLL), np.cos(ROLL))
    + np.tan(ROLL),
    "asin(roll) + acos(roll) + atan(roll)": np.arcsin(ROLL) + np.arccos(ROLL) + np.arctan(ROLL),
    "log(abs(v_x)) + log10(abs(v_y))": np.log(np.abs(X)) + np.log10(np.abs(Y)),
    "sqrt(v_x - 99)": np.full(2000, np.nan),
    "sign(v_x)*unwrap(4*roll)": np.sign(X) * np.unwrap(4 * ROLL),
    "diff(v_x)": np.diff(X, prepend=np.nan),
    "derivative(v_x)": np.gradient(X, TIME),
    "lowpass(v_x, 20)": scipy.signal.sosfilt(
        (sos := scipy.signal.butter(2, 20.0, fs=RATE, output="sos")),
        X,
        zi=scipy.signal.sosfilt_zi(sos) * X[0],
    )[0],
    "0*v_x + 9**9**9": 0 * X + np.inf,
}


def test_they_are_numpy_s():
    with np.errstate(all="ignore"):
        for text, wanted in EQUAL.items():
            time, values = series(text)
            assert np.array_equal(time, TIME), text
            np.testing.assert_allclose(values, wanted, rtol=1e-12, atol=1e-12, err_msg=text)
    used = {name for name in EXPRESSION_FUNCTIONS for text in EQUAL if f"{name}(" in text}
    assert used == set(EXPRESSION_FUNCTIONS)


def test_a_part_is_the_same_as_in_the_whole():
    for text in EQUAL:
        _, whole = series(text)
        time, part = series(text, 5.0)
        assert time[0] == 5.0
        np.testing.assert_allclose(part, whole[1000:], rtol=1e-6, atol=1e-9, err_msg=text)


@pytest.mark.parametrize("drift", [0.0, 3.0])
def test_a_low_pass_of_a_ramp_is_late_at_the_times_of_the_samples(drift):
    """By sqrt(2) / (2 pi f) for a Butterworth filter of second order, also with a slow drift.

    The first value is unknown, as that of a difference is.
    """
    time = TIME + drift / RATE * np.sin(np.pi * TIME / TIME[-1])
    _, late = series(
        "lowpass(a.x, 5)",
        reads=lambda *_: (time, np.where(time > 0.0, time, np.nan)),
        known={"a.x": time},
    )
    assert np.isnan(late[0])
    settled = time > 1.0
    np.testing.assert_allclose(
        late[settled], time[settled] - np.sqrt(2.0) / (2.0 * np.pi * 5.0), atol=1e-4
    )


def test_a_slower_signal_is_interpolated_and_held_after_its_last_sample():
    slow = np.array([0.1, 0.3, 0.5])

    def mixed(name, since):
        return (slow, 10.0 * slow) if name == "gps.x" else read(name, since)

    made = series("0*v_x + gps.x", reads=mixed, known=[*SIGNALS, "gps.x"])[1]
    assert np.isnan(made[:20]).all()
    np.testing.assert_allclose(made[20:101], 10.0 * TIME[20:101])
    assert (made[101:] == 5.0).all()
    time, of_slow = series("gps.x + 0*v_x", reads=mixed, known=[*SIGNALS, "gps.x"])
    assert np.array_equal(time, slow) and np.allclose(of_slow, 10.0 * slow)


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("sqrt(v_x", "at character 5"),
        ("", "at its end: no expression"),
        ("v_x + + ", "at its end"),
        ("v_x + velocity_data.v_x.real.x()", "at character 7"),
        ("__import__('os').system('x')", "at character 1"),
        ("[v_x for v_x in v_y]", "at character 1"),
        ("v_x if v_y else 2", "at character 1"),
        ("v_x + 'text'", "at character 7, ''text''"),
        ("squrt(v_x)", "at character 1, 'squrt(v_x)': unknown function 'squrt': did you mean"),
        ("2*hypot(v_x)", "at character 3, 'hypot(v_x)': hypot takes 2 arguments, not 1"),
        ("lowpass(v_x, v_y)", "at character 14, 'v_y)': lowpass takes a number here"),
        ("sqrt + v_x", "write sqrt"),
        ("1 + 2", "names no signal"),
        ("v_x + " + "1 + " * 100 + "1", "at most 300 characters"),
        ("v_x @ v_y", "is not allowed"),
        ("v_x(1)", "unknown function 'v_x'"),
        ("True + v_x", "at character 1"),
        ("deg(v_x, unit=3)", "at character 1"),
    ],
)
def test_what_is_wrong_is_said_with_its_place(text, said):
    with pytest.raises(WorkbenchError) as refused:
        parse_expression(text)
    assert said in str(refused.value)


def test_names_are_found_and_doubt_is_said():
    known = ["command_velocity.v_x", "velocity_data.v_x", "a.z", "b.z", "c.only"]
    assert parse_expression("v_x + only").find(known) == {
        "v_x": "velocity_data.v_x",
        "only": "c.only",
    }
    for text, said in (("z", "may be a.z, b.z"), ("v_q", "unknown signal 'v_q'")):
        with pytest.raises(WorkbenchError, match=said):
            parse_expression(text).find(known)


def test_a_filter_that_the_samples_do_not_allow_is_refused():
    with pytest.raises(WorkbenchError, match="below 100 Hz"):
        series("lowpass(v_x, 100)")

"""Filters against scipy.signal's own."""

import numpy as np
from scipy import signal

from workbench.estimation.filters import (
    PASS_THROUGH,
    lowpass,
    notch,
    section_output,
    section_states,
)

PERIOD = 1 / 1024
FILTERS = (
    ("low-pass, first order", lowpass(40.0, 1.0, PERIOD), signal.butter(1, 40.0, fs=1024)),
    ("low-pass, second order", lowpass(80.0, 2.0, PERIOD), signal.butter(2, 80.0, fs=1024)),
    ("low-pass near the limit", lowpass(500.0, 2.0, PERIOD), signal.butter(2, 500.0, fs=1024)),
    ("notch", notch(180.0, 30.0, PERIOD), signal.iirnotch(180.0, 180.0 / 30.0, fs=1024)),
    ("wide notch", notch(50.0, 80.0, PERIOD), signal.iirnotch(50.0, 50.0 / 80.0, fs=1024)),
)


def run(section, inputs, x=(0.0, 0.0)):
    """Return what comes out of a section, and its states in the end."""
    found = []
    for u in inputs:
        found.append(section_output(section, *x, u))
        x = section_states(section, *x, u)
    return np.array(found), x


def test_coefficients_and_responses_are_scipys(case):
    inputs = np.random.default_rng(1).normal(size=400)
    for name, section, (b, a) in FILTERS:
        with case(name):
            A, B = np.array(section[:4]).reshape(2, 2), np.array(section[4:6])[:, None]
            found = signal.ss2tf(A, B, np.array(section[6:8])[None, :], [[section[8]]])
            order = len(a)
            # of first order one state is idle: its pole at 0 is in numerator and denominator
            np.testing.assert_allclose(found[0][0][:order], b, atol=1e-12)
            np.testing.assert_allclose(found[1][:order], a, atol=1e-12)
            np.testing.assert_allclose(
                run(section, inputs)[0], signal.lfilter(b, a, inputs), atol=1e-12
            )


def test_at_rest_any_filter_may_take_over_from_any_other(case):
    for name, section, _ in (*FILTERS, ("none", PASS_THROUGH, None)):
        with case(name):
            out, x = run(section, [2.5] * 20, (0.0, 2.5))
            np.testing.assert_allclose(out, 2.5, rtol=1e-13)
            np.testing.assert_allclose(x, (0.0, 2.5), atol=1e-12)


def test_what_lets_through_tracks_its_input():
    out, x = run(PASS_THROUGH, [1.0, -3.0, 7.0], (5.0, 5.0))
    assert out.tolist() == [1.0, -3.0, 7.0]
    assert x == (0.0, 7.0)


def test_beyond_half_the_sampling_rate_there_is_no_filter():
    for make in (lambda f: lowpass(f, 2.0, PERIOD), lambda f: notch(f, 9.0, PERIOD)):
        assert make(0.0) == make(510.0) == PASS_THROUGH
        assert make(500.0) != PASS_THROUGH

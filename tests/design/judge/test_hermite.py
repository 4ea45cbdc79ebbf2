"""Numbers read off a curve with their derivatives, against curves that are known."""

import numpy as np
import pytest
from pydrake.autodiffutils import AutoDiffXd

from workbench.design.judge.sensitivity import CubicCurve, carried_metrics

A, B = 1.3, 4.0


def carried(values, by_gain):
    """Return numbers (N) with their derivatives (N, 2)."""
    return np.array([AutoDiffXd(*each) for each in zip(values, by_gain, strict=True)])


def curve(a=A, b=B):
    """Return 1 - e^(-at) cos(bt) sampled, with its derivatives by a and b."""
    t = np.linspace(0.0, 3.0, 301)
    decay, c, s = np.exp(-a * t), np.cos(b * t), np.sin(b * t)
    return CubicCurve(
        time=t,
        value=carried(1.0 - decay * c, np.column_stack([t * decay * c, t * decay * s])),
        slope=carried(
            decay * (a * c + b * s),
            np.column_stack(
                [decay * (c - t * (a * c + b * s)), decay * (s - a * t * s + b * t * c)]
            ),
        ),
    )


def differences(read):
    """Return the derivatives of what is read off by a and b, by central differences."""
    h = 1e-6
    return [
        (read(curve(A + h, B)).value() - read(curve(A - h, B)).value()) / (2 * h),
        (read(curve(A, B + h)).value() - read(curve(A, B - h)).value()) / (2 * h),
    ]


LEVEL = AutoDiffXd(0.6, np.zeros(2))
READ = {
    "first crossing": lambda c: c.first_crossing(LEVEL),
    "last crossing": lambda c: c.last_crossing(AutoDiffXd(1.02, np.zeros(2))),
    "peak": lambda c: c.highest()[0],
    "peak time": lambda c: c.highest()[1],
    "crossing of its own end": lambda c: c.first_crossing(0.5 * c.end),
    "overshoot": lambda c: (c.highest()[0] - c.end) / c.end,
}


@pytest.mark.parametrize("name", READ)
def test_derivatives_are_those_of_central_differences(name):
    assert READ[name](curve()).derivatives() == pytest.approx(
        differences(READ[name]), rel=1e-5, abs=1e-9
    )


def test_a_crossing_and_a_peak_are_where_the_formula_has_them():
    at = curve().first_crossing(LEVEL).value()
    assert 1.0 - np.exp(-A * at) * np.cos(B * at) == pytest.approx(0.6, abs=1e-8)
    time = (np.pi - np.arctan(A / B)) / B  # tan(bt) = -a / b
    peak, when = curve().highest()
    assert when.value() == pytest.approx(time, abs=1e-5)
    assert peak.value() == pytest.approx(1.0 - np.exp(-A * time) * np.cos(B * time), abs=1e-8)


def test_a_level_that_is_never_reached_is_nan():
    assert np.isnan(curve().first_crossing(AutoDiffXd(9.0, np.zeros(2))).value())


def test_the_highest_of_a_curve_that_only_rises_is_its_end():
    t = np.linspace(0.0, 1.0, 11)
    rising = CubicCurve(
        t, carried(2.0 * t, t[:, None]), carried(np.full(11, 2.0), np.ones((11, 1)))
    )
    peak, when = rising.highest()
    assert (peak.value(), when.value()) == (2.0, 1.0)
    assert peak.derivatives() == pytest.approx([1.0])


def test_a_response_settles_where_it_leaves_either_side_of_the_band_for_the_last_time(case):
    """A sampled oscillation that ends above the steady state, and one that ends below it."""
    time = np.linspace(0.0, 6.0, 1201)
    for sign in (1.0, -1.0):
        for phase in (0.0, 0.7):
            wave = np.exp(-time) * np.cos(4.0 * time + phase)
            slope = -np.exp(-time) * (np.cos(4.0 * time + phase) + 4.0 * np.sin(4.0 * time + phase))
            curve = CubicCurve(
                time,
                np.array([AutoDiffXd(sign * (1.0 - each)) for each in wave]),
                np.array([AutoDiffXd(-sign * each) for each in slope]),
            )
            outside = np.abs((1.0 - wave) / (1.0 - wave[-1]) - 1.0) > 0.02
            with case(sign, phase):
                found = carried_metrics(curve, sign)["settling_time"].value()
                assert found == pytest.approx(time[np.flatnonzero(outside)[-1]], abs=0.006)

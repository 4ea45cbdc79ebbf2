"""Limits of a pinned spec by hand: three digits, rounded so that they leave more room, never less.

`tests/commands/test_pin.py` pins flights.
"""

import math

import pytest

from workbench.design.pin_limits import (
    limit_between,
    load_tolerances,
    margin_limits,
    step_limits,
    step_tolerances,
)
from workbench.design.regress.spec import SpecLimit

NONE = math.inf


def test_a_limit_is_rounded_away_from_what_was_measured(case):
    for low, high, wanted in (
        (0.43219, 0.54321, SpecLimit(0.432, 0.544)),
        (432.1, 543.2, SpecLimit(432.0, 544.0)),
        (0.001, 0.001, SpecLimit(0.001, 0.001)),
        (-0.2, 0.12345, SpecLimit(max=0.124)),
    ):
        with case(low, high):
            found = limit_between(low, high)
            assert (found.min, found.max) == pytest.approx((wanted.min, wanted.max), rel=1e-9)


def test_limits_of_a_step_are_shares_spans_and_factors_of_its_numbers(case):
    measured = {
        "rise_time": 0.4321,  # 12 %: 0.3802 .. 0.4840
        "peak": 2.0,  # 8 %
        "overshoot": 3.456,  # 2 % of the step
        "steady_state_error": 0.2,  # half a per cent: below 0 is no limit
        "settling_time": 1.2345,  # 1.4 times
        "coupling_z": 0.0123,  # 1.5 times and 1 cm
        "peak_rotor_use": math.nan,
    }
    wanted = {
        "rise_time": (0.380, 0.484),
        "peak": (1.84, 2.16),
        "overshoot": (1.45, 5.46),
        "steady_state_error": (-NONE, 0.7),
        "settling_time": (-NONE, 1.73),
        "coupling_z": (-NONE, 0.0285),
    }
    found = step_limits(measured)
    assert found.keys() == wanted.keys()
    for name, limits in wanted.items():
        with case(name):
            assert (found[name].min, found[name].max) == pytest.approx(limits, rel=1e-9)


def test_limits_of_margins_are_below_them_and_a_gain_margin_is_one_above_1(case):
    measured = {"phase_margin_deg": 50.222, "gain_margin": 6.0, "crossover": 10.0}
    found = margin_limits({**measured, "disk_margin": -0.1, "delay_margin": math.inf})
    for name, limits in (
        ("phase_margin_deg", (46.7, NONE)),
        ("gain_margin", (5.0, NONE)),
        ("crossover", (9.2, 10.8)),
    ):
        with case(name):
            assert (found[name].min, found[name].max) == pytest.approx(limits, rel=1e-9)
    assert found.keys() == measured.keys(), "nothing is held of a loop that is unstable"
    assert margin_limits({"gain_margin": 50.0})["gain_margin"].min == pytest.approx(16.2)


def test_tolerances_of_curves_are_shares_of_the_step_and_not_too_small():
    assert step_tolerances("x", 2.0)["v_x"].absolute == pytest.approx(0.03)
    assert step_tolerances("x", 0.1)["v_x"].absolute == pytest.approx(0.002)
    assert step_tolerances("yaw", -0.2)["yaw_rate"].absolute == pytest.approx(0.004)
    (tolerance,) = load_tolerances("force_y", 0.1234).values()
    assert tolerance.absolute == pytest.approx(0.00247)

"""Checks, comparisons and results, and the sentences that they make."""

import math
from pathlib import Path

import numpy as np
import pytest

from workbench.common.series import Series
from workbench.design.regress.baseline import changed_conditions
from workbench.design.regress.spec import SpecLimit, Tolerance
from workbench.design.regress.verdict import (
    CaseResult,
    CurveComparison,
    LimitCheck,
    band,
    results_summary,
    since_baseline,
)

TIME = np.array([0.0, 0.5, 1.0])
TIMES = np.linspace(0.0, 2.0, 9)
RAMP = Series("v_x", "m/s", TIMES, 3.0 * TIMES)


@pytest.mark.parametrize(
    ("value", "limit", "met", "excess"),
    [
        (0.35, SpecLimit(0.3, 0.4), True, 0.0),
        (0.30, SpecLimit(0.3, 0.4), True, 0.0),
        (0.25, SpecLimit(0.3, 0.4), False, 0.05),
        (0.50, SpecLimit(0.3, 0.4), False, 0.1),
        (9.0, SpecLimit(min=1.0), True, 0.0),
        (-9.0, SpecLimit(max=1.0), True, 0.0),
        (math.inf, SpecLimit(min=1.0), True, 0.0),
    ],
)
def test_a_check_says_by_how_much(value, limit, met, excess):
    check = LimitCheck("rise_time", "s", value, limit)
    assert check.met is met
    assert check.excess == pytest.approx(excess)


def test_what_is_no_number_meets_nothing():
    check = LimitCheck("t90", "s", math.nan, SpecLimit(max=1.0))
    assert not check.met
    assert math.isnan(check.excess)
    assert check.sentence == "t90 does not exist, and should be at most 1 s"


def test_the_sentence_names_value_limit_and_excess():
    said = LimitCheck("rise_time", "s", 0.5, SpecLimit(0.3, 0.42)).sentence
    assert said == "rise_time is 0.5 s, and should be 0.3 .. 0.42 s: 0.08 s above"
    said = LimitCheck("roll.gain_margin", "1", 1.5, SpecLimit(min=2.0)).sentence
    assert said == "roll.gain_margin is 1.5, and should be at least 2: 0.5 below"


def compared(*values: float) -> CurveComparison:
    baseline = Series("v_x", "m/s", TIME, np.array([0.0, 1.0, 2.0]))
    limits = baseline.values - 0.1, baseline.values + 0.1
    return CurveComparison(Series("v_x", "m/s", TIME, np.array(values)), baseline, limits)


def test_a_curve_inside_its_band_is_as_demanded():
    curve = compared(0.0, 1.05, 1.95)
    assert curve.met
    assert curve.use == pytest.approx(0.5)


def test_a_curve_is_judged_by_its_worst_sample():
    curve = compared(0.0, 1.3, 1.8)
    assert not curve.met
    assert curve.use == pytest.approx(3.0)
    assert curve.sentence == (
        "v_x leaves its band: 1.3 m/s at 0.500 s, and should be 0.9 .. 1.1 m/s: 0.2 m/s beyond"
    )


def test_a_curve_with_what_is_no_number_leaves_its_band():
    assert not compared(0.0, math.nan, 2.0).met


def test_a_baseline_that_is_not_there_is_a_failure():
    curve = CurveComparison(Series("v_x", "m/s", TIME, TIME), missing="record it")
    assert (curve.met, curve.sentence) == (False, "record it")


def test_differences_are_those_beyond_rounding():
    found = changed_conditions(
        {"kp": 4.0, "kd": 0.1, "mass": 1.9, "gone": 1.0, "nought": 0.0},
        {"kp": 5.0, "kd": 0.1 * (1 + 1e-9), "mass": 1.9, "new": 2.0, "nought": 1e-17},
    )
    assert [each.name for each in found] == ["kp", "new", "gone"]
    assert found[0].sentence == "kp 4 -> 5"
    assert math.isnan(found[1].baseline)


def test_a_parameter_that_a_baseline_is_too_old_to_have_was_at_its_default():
    assert not changed_conditions({}, {"payload_mass": 0.0, "rotor_1": 1.0})
    (found,) = changed_conditions({}, {"payload_mass": 0.2})
    assert (found.baseline, found.now) == (0.0, 0.2)


def test_a_result_tells_all_failures_and_what_differs():
    result = CaseResult(
        "steps",
        Path("steps.workbench.yaml"),
        "x",
        checks=(
            LimitCheck("peak", "m/s", 2.0, SpecLimit(max=1.0)),
            LimitCheck("mean", "m", 0.0, SpecLimit(max=1.0)),
        ),
        curves=(compared(0.0, 1.0, 2.0), compared(9.0, 1.0, 2.0)),
        differences=changed_conditions({"kp": 4.0}, {"kp": 5.0}),
    )
    assert not result.passed
    assert [text.split()[0] for text in result.failures] == ["peak", "v_x"]
    assert result.story[-1] == "since the baseline: kp 4 -> 5"
    assert CaseResult("s", Path("s"), "x", differences=result.differences).passed


def result(spec: str, *, good: bool = True, kp: float = 4.0) -> CaseResult:
    return CaseResult(
        spec,
        Path(spec),
        "x",
        trouble="" if good else "lost",
        differences=changed_conditions({"kp": 4.0}, {"kp": kp}),
    )


@pytest.mark.parametrize(
    ("good", "said"),
    [
        ([True], "the case passed"),
        ([False], "the case failed"),
        ([True, True], "all 2 cases passed"),
        ([True, False], "1 of 2 cases failed"),
        ([False, False], "all 2 cases failed"),
    ],
)
def test_how_many_passed_is_said_in_words(good, said):
    assert results_summary([result("a", good=each) for each in good]) == said


@pytest.mark.parametrize(
    ("results", "said"),
    [
        ([result("a"), result("b")], []),
        ([result("a", kp=5), result("a", kp=5)], ["a: since the baseline: kp 4 -> 5"]),
        ([result("a", kp=5), result("b", kp=5)], ["since the baseline: kp 4 -> 5"]),
        (
            [result("a", kp=5), result("b"), result("c", kp=5)],
            ["a, c: since the baseline: kp 4 -> 5"],
        ),
        (
            [result("a", kp=5), result("b", kp=6)],
            ["a: since the baseline: kp 4 -> 5", "b: since the baseline: kp 4 -> 6"],
        ),
    ],
)
def test_what_differs_is_said_once(results, said):
    assert since_baseline(results) == said


def test_a_tolerance_widens_the_baseline_both_ways():
    low, high = band(RAMP, Tolerance(absolute=0.5), TIMES)
    assert low == pytest.approx(3.0 * TIMES - 0.5)
    assert high == pytest.approx(3.0 * TIMES + 0.5)


def test_a_relative_tolerance_is_a_share_of_the_largest_distance_from_the_start():
    curve = Series("v_x", "m/s", TIMES, 10.0 - 4.0 * TIMES)  # from 10 to 2: an amplitude of 8
    _, high = band(curve, Tolerance(relative=0.05, absolute=0.1), TIMES)
    assert high - curve.values == pytest.approx(np.full(9, 0.4))


def test_the_larger_of_both_tolerances_counts():
    _, high = band(RAMP, Tolerance(relative=0.05, absolute=0.9), TIMES)
    assert high - RAMP.values == pytest.approx(np.full(9, 0.9))


def test_a_ramp_shifted_to_and_fro_sweeps_slope_times_shift():
    low, high = band(RAMP, Tolerance(time_shift=0.1), TIMES)
    assert low[1:-1] == pytest.approx(3.0 * TIMES[1:-1] - 0.3)
    assert high[1:-1] == pytest.approx(3.0 * TIMES[1:-1] + 0.3)
    assert (low[0], high[-1]) == (0.0, 6.0)  # nothing is known beyond the ends


def test_a_peak_within_the_shift_belongs_to_the_band():
    tent = Series("v_x", "m/s", TIMES, 1.0 - np.abs(TIMES - 1.0))
    low, high = band(tent, Tolerance(time_shift=0.3), np.array([0.8, 1.0, 1.2]))
    assert high == pytest.approx([1.0, 1.0, 1.0])
    assert low == pytest.approx([0.5, 0.7, 0.5])


def test_the_band_is_what_many_shifted_copies_cover():
    random = np.random.default_rng(1)
    time = np.sort(random.uniform(0.0, 5.0, 40))
    curve = Series("v_x", "m/s", time, random.normal(size=40))
    wanted = np.linspace(0.5, 4.5, 57)
    shift = 0.23
    low, high = band(curve, Tolerance(time_shift=shift), wanted)
    copies = np.stack(
        [np.interp(wanted + by, time, curve.values) for by in np.linspace(-shift, shift, 4001)]
    )
    assert low == pytest.approx(copies.min(axis=0), abs=5e-3)
    assert high == pytest.approx(copies.max(axis=0), abs=5e-3)
    assert (low <= copies.min(axis=0) + 1e-12).all()
    assert (high >= copies.max(axis=0) - 1e-12).all()

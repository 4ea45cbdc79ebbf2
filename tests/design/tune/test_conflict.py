"""Which wish stands against which, on a problem in closed form."""

import numpy as np
import pytest

from workbench.design.tune.conflict import conflicts
from workbench.design.tune.evaluation import Budget, SearchEndedError

START = np.log([1.0, 0.5])


def explain(problem):
    return conflicts(problem, [START], Budget(100), {})


def test_a_wish_stands_against_another(second_order):
    """An effort of 0.25 is w of 5; the fastest rise there is that of the least damping."""
    problem = second_order(
        "x.rise_time<=0.1", "x.peak_rotor_use<=0.25", "x.overshoot<=90", "x.rise_time>=0.01"
    )
    (found,) = explain(problem).conflicts
    assert found.wish.name == "x.rise_time"
    assert [wish.name for wish in found.against] == ["x.peak_rotor_use"]
    z = np.linspace(0.05, 1.0, 2000)
    fastest = ((1.0 - 0.4167 * z + 2.917 * z * z) / 5.0).min()
    assert found.nearest == pytest.approx(fastest, rel=0.03)
    assert str(found) == (
        "x.rise_time <= 0.1 s cannot be met together with x.peak_rotor_use <= 0.25: the nearest "
        f"has {found.nearest:.3g} s; without x.peak_rotor_use it is met"
    )


def test_a_wish_that_cannot_be_met_at_all_stands_alone(second_order):
    (found,) = explain(second_order("x.rise_time<=0.001", "x.overshoot<=10")).conflicts
    assert found.against == ()
    assert str(found).startswith("x.rise_time <= 0.001 s cannot be met, even alone: the nearest")
    z = 0.5912  # an overshoot of 10 %, which is kept; w = 100 is the most
    assert found.nearest == pytest.approx((1.0 - 0.4167 * z + 2.917 * z * z) / 100.0, rel=0.03)


def test_three_wishes_stand_against_each_other(second_order):
    """Any two can be met: little overshoot needs damping, which needs speed, which needs effort."""
    problem = second_order("x.rise_time<=0.3", "x.overshoot<=1", "x.peak_rotor_use<=0.4")
    (found,) = explain(problem).conflicts
    assert {found.wish, *found.against} == {required.wish for required in problem.requirements}


def test_what_can_be_met_has_no_conflict(second_order):
    assert explain(second_order("x.rise_time<=1", "x.overshoot<=10")).conflicts == ()


def test_it_can_be_stopped(second_order):
    budget = Budget(100)
    budget.told = True
    with pytest.raises(SearchEndedError):
        conflicts(second_order("x.rise_time<=0.001"), [START], budget, {})


def test_what_is_told_is_about_one_candidate(second_order):
    """The candidate that is reported has the value of the sentence, and meets all other wishes."""
    problem = second_order("x.rise_time<=0.1", "x.peak_rotor_use<=0.25", "x.overshoot<=30")
    unmet = explain(problem)
    names = [each.wish.name for each in problem.requirements]
    values = dict(zip(names, unmet.nearest.values, strict=True))
    for conflict in unmet.conflicts:
        assert conflict.nearest == values[conflict.wish.name]
    yielding = {conflict.wish for conflict in unmet.conflicts}
    for each, value in zip(problem.requirements, unmet.nearest.values, strict=True):
        assert each.wish in yielding or each.met(value), each
    told = unmet.measured(problem.requirements, [9.0, 0.1, 1.0])
    assert told[0].nearest == 9.0

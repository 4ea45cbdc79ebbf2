"""What a search is told of gains that do not fly: never a number that looks good."""

import math

import numpy as np
import pytest

from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import REST_VELOCITY_M_S
from workbench.design.tune.case import NOMINAL_CASE
from workbench.design.tune.evaluation import Problem
from workbench.design.tune.measure import Instruments, TuneStep
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import variables_for
from workbench.design.tune.wish import parse_wish
from workbench.setup import make_setup

WORSE, WORST = {"kp_roll": 900.0, "kd_roll": 1.0}, {"kp_roll": 2000.0, "kd_roll": 0.0}


@pytest.fixture(scope="module")
def tools():
    found = Instruments(make_setup(), REST_VELOCITY_M_S)
    found.steps = {"y": TuneStep(1.0, 3.0)}
    return found


def required(*names: str) -> list[Requirement]:
    """Return requirements on numbers by their names, with any bound."""
    wishes = (wish for name in names for wish in parse_wish(f"{name}<=1"))
    return [Requirement(wish, NOMINAL_CASE, wish.bound) for wish in wishes]


def growth(gains) -> float:
    """Return the rate at which the fastest growing mode of the sampled loop grows [1/s]."""
    model = LinearStudy().sampled(gains=gains)
    return math.log(np.abs(np.linalg.eigvals(model.A)).max()) / model.period


def test_an_unstable_loop_has_a_margin_below_0_that_falls_with_its_growth(tools):
    """By a tenth of the growth rate; its peak sensitivity and its noise have no bound."""
    loop = [f"roll.{name}" for name in ("phase_margin", "disk_margin", "peak_sensitivity")]
    asked = required(*loop, "rotors.noise_amplification")
    many = [tools.base, {**tools.base, **WORSE}, {**tools.base, **WORST}]
    good, *bad = tools.measure(many, asked)
    assert good[0] > 0.6 and good[1] > 0.6 and good[2] < 2.0 and good[3] < 10.0
    rates = [growth(gains) for gains in many[1:]]
    assert 0.0 < rates[0] < rates[1]
    for values, rate in zip(bad, rates, strict=True):
        assert values == pytest.approx([-0.1 * rate, -0.1 * rate, math.inf, math.inf], rel=1e-3)


def test_a_flight_that_diverges_has_infinite_numbers(tools):
    names = ("rise_time", "overshoot", "steady_state_error", "peak_rotor_use")
    asked = required(*(f"y.{name}" for name in names))
    good, bad = tools.measure([tools.base, {**tools.base, **WORST}], asked)
    assert np.isfinite(good).all()
    assert bad.tolist() == [math.inf] * 4


def test_what_the_full_diagram_adds_is_added(tools):
    (one,) = required("y.rise_time")
    variables = variables_for(tools.controller, ["y"], tied=False)
    problem = Problem(tools, variables, tools.base, (one,))
    ((plain,),) = problem.measured([tools.base])
    corrected = problem.corrected([(one, plain + 0.25)], np.array([plain]))
    for proved, measured in ((math.inf, plain), (plain, math.inf), (math.nan, math.nan)):
        corrected = corrected.corrected([(one, proved)], np.array([measured]))
    ((value,),) = corrected.measured([tools.base])
    assert value == pytest.approx(plain + 0.25)
    twice = corrected.corrected([(one, value + 0.5)], np.array([value]))
    assert twice.measured([tools.base])[0, 0] == pytest.approx(plain + 0.75)

"""What a search is told of gains that do not fly: never a number that looks good."""

import dataclasses
import math

import numpy as np
import pytest

from workbench.design.linear.study import LinearStudy
from workbench.design.metrics import LOOP, ROTORS, STEP
from workbench.design.step_response import HOVER
from workbench.design.tune.case import NOMINAL
from workbench.design.tune.evaluation import Problem
from workbench.design.tune.measure import Instruments, Quantity, Step
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import variables_for
from workbench.design.tune.wish import parse_wish
from workbench.scenario.scenario import Scenario

WORSE, WORST = {"kp_roll": 900.0, "kd_roll": 1.0}, {"kp_roll": 2000.0, "kd_roll": 0.0}


@pytest.fixture(scope="module")
def tools():
    found = Instruments(Scenario(), {}, HOVER)
    found.steps = {"y": Step(1.0, 3.0)}
    return found


def growth(gains) -> float:
    """Return the rate at which the fastest growing mode of the sampled loop grows [1/s]."""
    model = LinearStudy().sampled(gains=gains)
    return math.log(np.abs(np.linalg.eigvals(model.A)).max()) / model.period


def test_an_unstable_loop_has_a_margin_below_0_that_falls_with_its_growth(tools):
    """By a tenth of the growth rate; its peak sensitivity and its noise have no bound."""
    asked = [
        *(Quantity(NOMINAL, LOOP, "roll", name) for name in ("phase_margin", "disk_margin")),
        Quantity(NOMINAL, LOOP, "roll", "peak_sensitivity"),
        Quantity(NOMINAL, ROTORS, "rotors", "noise_amplification"),
    ]
    many = [tools.base, {**tools.base, **WORSE}, {**tools.base, **WORST}]
    good, *bad = tools.measure(many, asked)
    assert good[0] > 0.6 and good[1] > 0.6 and good[2] < 2.0 and good[3] < 10.0
    rates = [growth(gains) for gains in many[1:]]
    assert 0.0 < rates[0] < rates[1]
    for values, rate in zip(bad, rates, strict=True):
        assert values == pytest.approx([-0.1 * rate, -0.1 * rate, math.inf, math.inf], rel=1e-3)


def test_a_flight_that_diverges_has_infinite_numbers(tools):
    names = ("rise_time", "overshoot", "steady_state_error", "peak_rotor_use")
    asked = [Quantity(NOMINAL, STEP, "y", name) for name in names]
    good, bad = tools.measure([tools.base, {**tools.base, **WORST}], asked)
    assert np.isfinite(good).all()
    assert bad.tolist() == [math.inf] * 4


def test_what_the_full_diagram_adds_is_added(tools):
    (wish,) = parse_wish("y.rise_time<=1")
    required = Requirement(wish, NOMINAL, 1.0)
    variables = variables_for(tools.controller, ["y"], tied=False)
    problem = Problem(tools, variables, tools.base, (required,))
    corrected = dataclasses.replace(problem, corrections={required: 0.25})
    ((plain,),), ((found,),) = problem.measured([tools.base]), corrected.measured([tools.base])
    assert found == pytest.approx(plain + 0.25)

"""Which flights prove the gains, and the numbers of steps in corners and in steady flight."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.design.flier import DIAGRAM
from workbench.design.step_response import fly_step
from workbench.design.tune import proof
from workbench.design.tune.case import NOMINAL_CASE, Robustness, VehicleCase
from workbench.design.tune.measure import Instruments, TuneStep
from workbench.design.tune.proof import case_metrics, flights_to_fly
from workbench.design.tune.requirement import Requirement, requirements
from workbench.design.tune.wish import parse_wish
from workbench.setup import make_setup

HEAVY, SLOW = VehicleCase(mass=1.2), VehicleCase(rotor_lag=1.5)


def test_each_wished_axis_is_flown_as_described_and_in_its_worst_corner():
    """The worst corner is that of the smallest reserve; a margin is no flight."""
    texts = (
        "x.overshoot<=5",
        "z.steady_state_error<=5",
        "pitch.disk_margin>=0.6",
        "y.rise_time<=1",
    )
    wishes = [wish for text in texts for wish in parse_wish(text)]
    required = requirements(wishes, [NOMINAL_CASE, HEAVY, SLOW], Robustness())
    worst = {("x", HEAVY): -0.5, ("x", SLOW): 0.2, ("z", HEAVY): 0.1, ("z", SLOW): 0.05}
    reserves = {each: worst.get((each.wish.subject, each.case), 9.0) for each in required}
    assert flights_to_fly(required, reserves) == [
        (NOMINAL_CASE, "x"),
        (NOMINAL_CASE, "z"),
        (NOMINAL_CASE, "y"),
        (HEAVY, "x"),
        (SLOW, "z"),
    ]


def test_a_step_in_a_corner_is_measured_from_where_its_hover_was():
    """1 - exp(-t / 0.2 s) on top of a hover that is off by 0.1 m/s: rise 0.2 s ln 9, error 10 %."""
    time = np.arange(0.0, 3.0, 1e-3)
    response = 0.1 - np.expm1(-time / 0.2)
    found = case_metrics(time, response, 1.0, 0.0, HEAVY)
    assert found.rise_time == pytest.approx(0.2 * math.log(9.0), rel=1e-2)
    assert found.settling_time == pytest.approx(0.2 * math.log(50.0), rel=1e-2)
    assert found.steady_state_error == pytest.approx(10.0, abs=0.1)
    assert math.isnan(case_metrics(time, response, 1.0, 0.0, NOMINAL_CASE).rise_time), "not at rest"


def test_a_flight_that_is_lost_proves_nothing_but_its_use_of_the_rotors(monkeypatch):
    """However well it had risen before; a flight that goes on has its numbers."""
    time = np.arange(0.0, 3.0, 1e-3)
    flown = SimpleNamespace(
        time=time,
        response=-np.expm1(-time / 0.2),
        amplitude=1.0,
        decay=0.0,
        peak_rotor_use=0.7,
        loss="it has come down to the ground",
    )
    flies = []

    def fly(*of, fly_on, **more):
        flies.append(fly_on)
        return flown

    monkeypatch.setattr(proof, "fly_step", fly)
    wishes = [*parse_wish("x.rise_time<=1"), *parse_wish("x.peak_rotor_use<=0.9")]
    required = requirements(wishes, [NOMINAL_CASE], Robustness())

    def found():
        steps, flights = {"x": TuneStep(1.0, 3.0)}, [(NOMINAL_CASE, "x")]
        return proof.prove_gains(make_setup(), {}, steps, required, flights, lambda *said: None)

    (rise, _), (use, value) = found().missed[0], found().values[1]
    assert {*flies} == {DIAGRAM}
    assert (rise.wish.name, use.wish.name, value) == ("x.rise_time", "x.peak_rotor_use", 0.7)
    flown.loss = None
    assert found().missed == []
    assert found().values[0][1] == pytest.approx(0.2 * math.log(9.0), rel=1e-2)


def test_a_step_from_steady_flight_is_measured_from_that_flight():
    """At 3 m/s forwards, one more is wished for: the response begins at 0, and ends at 1."""
    velocity = (3.0, 0.0, 0.0)
    tools = Instruments(make_setup(), velocity)
    tools.steps = {"x": TuneStep(1.0, 3.0)}
    response = tools.responses([tools.base], "x", NOMINAL_CASE).response[0]
    assert response[0] == 0.0
    assert response[-1] == pytest.approx(1.0, abs=0.05)
    wishes = [*parse_wish("x.rise_time<=1"), *parse_wish("x.steady_state_error<=1")]
    asked = [Requirement(wish, NOMINAL_CASE, wish.bound) for wish in wishes]
    flown = fly_step("x", 1.0, duration=3.0, velocity=velocity).metrics
    rise, error = tools.measure([tools.base], asked)[0]
    assert rise == pytest.approx(flown.rise_time, abs=2 / 128)  # one for each way to count samples
    assert error == pytest.approx(flown.steady_state_error, abs=0.1)

"""Where the phase went, beside hand calculations and scipy's filters."""

import math

import numpy as np
import pytest
from scipy import signal

from workbench.control.installed_laws import installed_laws
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.phase_budget import PHASE_BUDGET_PARTS, PhaseStudy, phase_budgets
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Rates, Scenario, VehicleConfig

HOLD = OperatingPoint(hold=True)


def budgets(study, gains=None):
    steering, holding = study.sampled(gains=gains), study.sampled(HOLD, gains)
    loops = judge_loops(steering, holding)
    found = phase_budgets(study, steering, holding, loops, gains)
    return {each.loop: each for each in found}, {each.loop: each.actuator for each in loops}


@pytest.mark.parametrize("law", installed_laws())
def test_parts_add_up_to_the_phase_of_the_loop(law):
    found, margins = budgets(LinearStudy(Scenario(controller=law)), {"gyro_lowpass": 80.0})
    assert found.keys() == margins.keys()
    for name, budget in found.items():
        turn = (budget.phase + math.pi + math.pi) % (2.0 * math.pi) - math.pi
        assert abs(turn) == pytest.approx(margins[name].phase_margin, abs=1e-6)
        assert budget.phase == pytest.approx(
            sum(getattr(budget, part) for part in PHASE_BUDGET_PARTS)
        )


def test_closed_forms_of_delay_hold_and_rotors():
    """All late by hand: 3 ms of sensing, 2 ms of commands."""
    variation = Variation(sensing_delay=3 / 1024, command_delay=2 / 1024)
    study = LinearStudy(Scenario(vehicle=VehicleConfig(variation=variation)))
    found, _ = budgets(study)
    for budget in found.values():
        w = budget.crossover
        assert budget.delay == pytest.approx(-w * 5 / 1024)
        assert budget.hold == pytest.approx(-w / 256)
        tau = study.vehicle.rotor_lag
        assert math.degrees(budget.rotors) == pytest.approx(
            -math.degrees(math.atan(w * tau)), abs=2.0
        )
        assert (budget.filters, budget.estimator) == pytest.approx((0.0, 0.0), abs=1e-12)
    # what is late costs what the delays say, at the same frequency, but for what sampling folds
    w = found["pitch"].crossover
    plain = LinearStudy(Scenario())
    (other,) = [
        each
        for each in PhaseStudy(plain).budgets(plain.sampled(), {"pitch": w})
        if each.loop == "pitch"
    ]
    assert math.degrees(found["pitch"].law - other.law) == pytest.approx(0.0, abs=0.5)


def test_filters_take_the_phase_of_scipys():
    """The yaw loop feeds back the rate alone; with updates as fast as samples nothing folds."""
    rates = Rates(control_period=1 / 1024, record_period=1 / 1024)
    settings = {"gyro_lowpass": 50.0, "gyro_notch": 90.0, "gyro_notch_width": 30.0}
    found, _ = budgets(LinearStudy(Scenario(rates=rates)), settings)
    at = found["yaw_rate"].crossover / 1024
    filters = (signal.butter(2, 50.0, fs=1024), signal.iirnotch(90.0, 3.0, fs=1024))
    wanted = sum(np.angle(signal.freqz(b, a, [at])[1][0]) for b, a in filters)
    assert math.degrees(found["yaw_rate"].filters) == pytest.approx(math.degrees(wanted), abs=1e-4)
    assert math.degrees(found["pitch"].filters) < -3.0
    assert abs(found["pitch"].estimator) < 1e-12


def test_an_estimator_has_a_part_of_its_own():
    found, _ = budgets(LinearStudy(Scenario(estimator="complementary")), {"gyro_lowpass": 50.0})
    alone, _ = budgets(LinearStudy(Scenario(estimator="complementary")))
    for budgets_of in (found, alone):
        assert abs(math.degrees(budgets_of["velocity_x"].estimator)) > 1.0
        assert abs(math.degrees(budgets_of["yaw_rate"].estimator)) < 0.1
    assert abs(alone["pitch"].filters) < 1e-12 and found["pitch"].filters < -0.05

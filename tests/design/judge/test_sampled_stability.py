"""The slowest rate, against a flight with the law at it, and slower."""

import copy
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.controllers import pd
from workbench.design.judge import sampled_stability
from workbench.design.judge.sampled_stability import HOVER_POINT, rate_sample, slowest_rate
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.step_response import fly_step
from workbench.scenario.scenario import Scenario

FAST = {"kp_velocity_x": 20.5}
"""With this the border lies at a rate that steps are flown at in a moment."""


def growth(steps) -> float:
    """Return how much more a small flown step swings at its end than before, law so slow."""
    scenario = Scenario()
    scenario.rates = copy.deepcopy(scenario.rates)
    scenario.rates.control_period = steps / 1024
    flown = fly_step("x", 0.01, duration=6.0, scenario=scenario, settings=FAST).response
    quarter = len(flown) // 4
    return float(np.ptp(flown[-quarter:]) / np.ptp(flown[quarter : 2 * quarter]))


@pytest.mark.slow
def test_the_border_is_where_a_flown_step_stops_settling():
    found = slowest_rate(settings=FAST)
    border = round(found.stable_period * 1024)
    assert rate_sample(LinearStudy(), border, settings=FAST).stable
    assert not rate_sample(LinearStudy(), border + 1, settings=FAST).stable
    assert growth(border - 12) < 0.7 < 1.4 < growth(border + 8)


def test_a_law_that_is_unstable_at_any_rate_has_no_slowest():
    found = slowest_rate(settings={"kd_pitch": 0.0, "kd_velocity_x": 0.0, "kp_velocity_x": 30.0})
    assert np.isnan(found.stable_period)
    assert np.isnan(found.safe_period)
    assert len(found.samples) == 1


def test_a_heading_that_the_wind_straightens_out_says_nothing_of_the_rate():
    point = OperatingPoint(velocity=(5.0, 0.0, 0.0))
    for steps in (8, 40):
        hover, forward = (rate_sample(LinearStudy(), steps, at) for at in (HOVER_POINT, point))
        assert forward.growth == pytest.approx(hover.growth, rel=0.05)
        assert hover.growth < -1.0


def test_growth_is_that_of_the_spectral_radius_where_a_mode_grows():
    found = rate_sample(LinearStudy(), 8, settings={"kp_velocity_x": 30.0})
    assert found.growth == pytest.approx(np.log(found.spectral_radius) * 128)
    assert found.growth > 1.0


@pytest.mark.parametrize("steps", [4, 8])
def test_the_period_is_the_one_asked_for(steps):
    assert rate_sample(LinearStudy(), steps).period == steps / 1024


def test_a_law_with_a_period_of_its_own_is_judged_at_the_one_asked_for(tmp_path):
    law = tmp_path / "quick.py"
    law.write_text(Path(pd.__file__).read_text() + "\n\nPERIOD = 1 / 512\n")
    study = LinearStudy(Scenario(controller=str(law)))
    assert study.setup.rates.control_period == 1 / 512
    assert [rate_sample(study, steps).period for steps in (2, 8)] == [2 / 1024, 8 / 1024]


def test_the_phase_margin_of_a_rate_is_that_of_the_weakest_loop_wherever_it_is_cut(monkeypatch):
    study = LinearStudy()

    def judged(*margins):
        loops = [
            SimpleNamespace(
                actuator=SimpleNamespace(phase_margin=one),
                error=SimpleNamespace(phase_margin=other),
            )
            for one, other in margins
        ]
        monkeypatch.setattr(sampled_stability, "judge_loops", lambda model: loops)
        return rate_sample(study, 8).phase_margin

    assert judged((0.6, 0.7), (0.9, 0.8)) == 0.6
    assert judged((1.0, 0.9), (0.9, 0.5)) == 0.5

"""The margins of the loops that a controller states."""

import numpy as np
import pytest

from tests.jointed import drone, joint, link
from workbench.common.resources import controllers_dir
from workbench.design.judge.loop_judgement import judge_loops
from workbench.design.judge.loop_response import closed_poles, growing_poles, growth_rate
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.scenario.scenario import Scenario, VehicleConfig

TEXT = (controllers_dir() / "pd.py").read_text(encoding="utf-8")


@pytest.mark.parametrize("kept", [4, 0])
def test_a_controller_without_loops_that_hold_is_judged(tmp_path, kept):
    path = tmp_path / "law.py"
    path.write_text(f"{TEXT}\nLOOPS = LOOPS[3 : 3 + {kept}]\n", encoding="utf-8")
    study = LinearStudy(Scenario(controller=str(path)))
    holding = study.sampled(OperatingPoint(hold=True))
    found = judge_loops(study.sampled(), holding)
    names = ("roll", "pitch", "yaw_rate", "position_x")[:kept]
    assert tuple(each.loop for each in found) == names


@pytest.mark.parametrize("period", [0.0, 1 / 128])
def test_what_drifts_over_minutes_does_not_grow(period):
    poles = np.array([4e-4, 0.0, -2.0, 0.02, 1e-3 + 3.0j, 1e-3 - 3.0j, -1e-3 + 3.0j])
    seen = np.exp(poles * period) if period else poles
    assert growing_poles(seen, period).tolist() == [False, False, False, True, True, True, False]
    assert not growing_poles(np.zeros(2), 1 / 128).any()
    assert growth_rate(seen, period) == pytest.approx(0.02)
    slower = np.array([8e-3, 2e-3 + 1.0j])  # what drifts grows faster than what swings
    assert growth_rate(np.exp(slower * period) if period else slower, period) == pytest.approx(2e-3)


def test_loops_have_margins_with_a_payload_beside_the_middle_that_the_law_does_not_know():
    """While a pilot steers, the heading drifts in an hour, and the place with it.

    It has the margins of the loops with the payload in the middle, but for its moment of inertia.
    """
    study = LinearStudy()
    middle = study.sampled(gains={"payload_mass": 0.1})
    model = study.sampled(gains={"payload_mass": 0.1, "payload_x": 0.1})
    assert 1e-4 < growth_rate(closed_poles(model), model.period) < 1e-3
    for beside, other in zip(judge_loops(model), judge_loops(middle), strict=True):
        assert beside.actuator.stable
        expected = other.actuator.phase_margin_deg
        assert beside.actuator.phase_margin_deg == pytest.approx(expected, abs=2.0)


def test_a_heading_that_drifts_for_an_hour_is_not_unstable(tmp_path):
    """A boom hangs beside the middle, so a law without integrators holds still at a commanded
    velocity of 17 mm/s, which does not turn with the heading; the rotors' drag turns that slowly.
    """
    damping = '<dynamics damping="1e-3"/>'
    boom = link("boom", 0.05, (0.05, 0.0, -0.1)) + joint(
        "swing", "continuous", "base", "boom", (0.05, 0.0, -0.05), more=damping
    )
    path = drone(tmp_path, boom)
    sidecar = tmp_path / "jointed.rotors.yaml"
    text = sidecar.read_text().replace("max_rot", "rotor_drag_coefficient: 1e-3, max_rot")
    sidecar.write_text(text)
    model = LinearStudy(Scenario(vehicle=VehicleConfig(model=path))).sampled()
    assert 1e-4 < growth_rate(closed_poles(model), model.period) < 1e-3
    margins = [each.actuator.phase_margin for each in judge_loops(model)]
    assert min(margins) > 0.5

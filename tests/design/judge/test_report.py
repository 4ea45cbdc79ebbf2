"""The judgement of the shipped drone: what it says of loops, steps, rates, and of bad gains."""

import math

import numpy as np
import pytest

from tests.jointed import drone, joint, link
from workbench.control.controller_file import load_controller
from workbench.design.judge.loop_judgement import growing_loops, judge_loops
from workbench.design.judge.report import judge
from workbench.design.judge.step_pair import step_pair
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear_step import linear_step
from workbench.scenario.scenario import Scenario, VehicleConfig

LOOPS = load_controller().loops


SHARES: list[float] = []
"""Of the judgement, in the order in which they were reported."""


@pytest.fixture(scope="module")
def found():
    SHARES.clear()
    return judge(progress=SHARES.append)


@pytest.mark.slow
def test_the_share_done_grows_within_each_step(found):
    """The flown steps take most of the time, with joints minutes."""
    assert sorted(SHARES) == SHARES
    for step in range(len(found.steps)):
        inside = [each for each in SHARES if step / 5 < each < (step + 1) / 5]
        assert len(inside) > 3


@pytest.mark.slow
def test_every_loop_is_judged(found):
    assert [loop.loop for loop in found.loops] == [loop.name for loop in LOOPS]
    assert found.unstable == ()
    assert found.period == 1 / 128
    for loop in found.loops:
        assert loop.actuator.stable
        assert loop.error.gain_margin > 1.5
        assert loop.error.phase_margin > 0.3


@pytest.mark.slow
def test_inner_loops_are_faster_than_outer_ones(found):
    crossover = {loop.loop: loop.error.crossover for loop in found.loops}
    assert crossover["position_x"] < crossover["velocity_x"] < crossover["pitch"]
    assert crossover["position_z"] < crossover["velocity_z"]


@pytest.mark.slow
def test_linear_and_flown_steps_stand_side_by_side(found):
    assert [step.axis for step in found.steps] == ["x", "y", "z", "yaw"]
    for step in found.steps:
        assert step.flown is not None
        assert step.linear.rise_time == pytest.approx(step.flown.rise_time, rel=0.15)
        assert step.difference < 0.1
        assert len(step.time) == len(step.linear_response) == len(step.flown_response)


def test_a_drone_with_an_imu_on_its_gimbal_alone_is_judged(tmp_path, monkeypatch):
    """Its noise is not; margins need no IMU."""
    monkeypatch.setattr("workbench.design.judge.report.PAPER_STEPS", ())
    monkeypatch.setattr("workbench.design.judge.report.slowest_rate", lambda **_: None)
    hung = link("camera", 0.05, (0.0, 0.0, -0.05)) + joint(
        "tilt", "continuous", "base", "camera", more='<dynamics damping="0.01"/>'
    )
    imu = '<gazebo reference="camera"><sensor type="imu" name="imu"/></gazebo>'
    found = judge(Scenario(vehicle=VehicleConfig(model=drone(tmp_path, hung + imu))))
    assert len(found.loops) > 4
    assert (found.unstable, found.noise) == ((), ())


def test_a_small_flown_step_is_the_linear_one(steering):
    pair = step_pair(steering, "x", 0.02, scenario=Scenario())
    assert pair.difference < 0.005


def test_the_linear_step_is_python_controls(steering):
    import control

    system = steering.state_space(["reference_v_z"], ["v_z"])
    time = steering.period * np.arange(200)
    expected = control.step_response(system, time).outputs.ravel()
    assert linear_step(steering, "reference_v_z", "v_z", 200) == pytest.approx(expected, abs=1e-9)


@pytest.mark.slow
def test_the_law_may_run_slower_but_not_any_slower(found):
    slowest = found.slowest
    by_steps = {round(sample.period * 1024): sample for sample in slowest.samples}
    assert slowest.stable_period == slowest.samples[-1].period == 51 / 1024  # a scenario's slowest
    assert slowest.at_limit
    safe = round(slowest.safe_period * 1024)
    assert by_steps[safe].phase_margin >= math.radians(30.0) > by_steps[safe + 1].phase_margin
    assert 8 < safe < 51


def test_away_from_hover_there_are_margins_and_no_steps(study):
    loops = judge_loops(study.sampled(OperatingPoint(velocity=(5.0, 0.0, 0.0))))
    assert [loop.loop for loop in loops] == [loop.name for loop in LOOPS if not loop.hold]


@pytest.mark.parametrize(
    ("settings", "guilty"),
    [
        ({"kp_pitch": 2000.0}, {"pitch"}),
        ({"kd_roll": 0.0}, {"roll"}),
        ({"kp_velocity_x": 30.0}, {"velocity_x", "pitch"}),
    ],
)
def test_the_loop_through_which_a_mode_grows_is_named(study, settings, guilty):
    model = study.sampled(gains=settings)
    assert set(growing_loops(model)) == guilty
    assert not any(loop.error.stable for loop in judge_loops(model))


@pytest.mark.slow
def test_a_set_that_cannot_fly_is_judged_all_the_same():
    found = judge(settings={"kp_velocity_y": 30.0})
    assert "velocity_y" in found.unstable
    assert math.isnan(found.slowest.stable_period)
    assert len(found.steps) == 4
    assert {step.linear for step in found.steps} == {None}
    assert all(math.isnan(step.difference) for step in found.steps)

"""The shipped arm takes a crate, carries it, and sets it down; weights by hand."""

import numpy as np
import pytest

from workbench.common.resources import find_scenario
from workbench.design.judge.loop_judgement import live_margins
from workbench.design.linear.study import LinearStudy
from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Action, Scenario, ScenarioStart, VehicleConfig
from workbench.scenario.scenario_file import load_scenario
from workbench.session.session import Session

CRATE, HEIGHT, REACH = 0.3, 0.08, 0.06
"""Of the crate [kg, m], and of the gripper [m]."""
HAND = np.array([-0.18, -0.015, 0.0])
"""Middle of the hand in the frame of the forearm [m]."""


def hand_to_handle(session: Session) -> np.ndarray:
    """Return the way from the hand to the crate's handle in W (3) [m]."""
    hand = session.pose("world", "forearm").multiply(HAND)
    return session.pose("world", "crate").translation() - hand


def test_the_arm_takes_a_crate_from_the_ground(tmp_path):
    """Thrust rises by the crate's weight, which the ground bears before and the fingers after."""
    script = [Action(1.0, set={"open_hooks": 0.0}, go_to=[0.0, 0.0, 0.6])]
    start = ScenarioStart(position=[0.0, 0.0, 0.48])
    arm = VehicleConfig(model="manipulator")
    stretched = {"open_hooks": 1.0, "servo_shoulder": 0.9, "servo_elbow": -1.8}
    session = Session(Scenario(vehicle=arm, start=start, script=script, duration=3.5), stretched)
    session.tick(1.0)
    assert 0.0 < -hand_to_handle(session)[2] < REACH
    bare = session.recording()
    weight = (session.vehicle.mass - CRATE) * GRAVITY
    assert bare.force_W[-1, 2] == pytest.approx(weight, rel=2e-3)
    assert session.vehicle.contact_links == ("base_link", "forearm", "crate")
    forces = bare.contact_forces[-1].reshape(3, 3)
    assert not forces[:2].any()
    assert forces[2] == pytest.approx([0.0, 0.0, CRATE * GRAVITY], abs=0.02)
    session.run()
    held = session.recording()
    assert held.force_W[-1, 2] == pytest.approx(weight + CRATE * GRAVITY, rel=2e-3)
    assert held.tensions[-1].sum() == pytest.approx(CRATE * GRAVITY, rel=0.01)
    assert not held.contact_forces[-1].any()
    assert session.pose("world", "crate").translation()[2] > HEIGHT + 0.05
    assert np.linalg.norm(hand_to_handle(session)) == pytest.approx(REACH, abs=5e-3)


def test_every_loop_has_margins_though_the_arm_sags():
    """Its law has no integrator, so it holds a place beside the setpoint, see `find_trim`.

    The crossover of a position loop is its gain, as its inner loop is much faster.
    """
    study = LinearStudy(Scenario(vehicle=VehicleConfig(model="manipulator")))
    found = {each.loop: each.margins for each in live_margins(study)}
    assert list(found) == [loop.name for loop in study.controller.loops]
    for axis, gain in (("x", "kp_position_xy"), ("y", "kp_position_xy"), ("z", "kp_position_z")):
        margins = found[f"position_{axis}"]
        assert margins.stable
        assert margins.crossover == pytest.approx(study.gains[gain], rel=0.06)
        assert margins.phase_margin_deg > 60.0


@pytest.mark.slow
def test_the_shipped_flight_carries_the_crate_a_metre_and_lands_beside_it():
    session = Session(load_scenario(find_scenario("take-crate")))
    session.run()
    recording = session.recording()
    crate = session.pose("world", "crate")
    assert crate.translation() == pytest.approx([1.0, 0.0, HEIGHT], abs=0.02)
    assert crate.rotation().matrix()[2, 2] > 0.999
    assert recording.mode[-1] == 0.0
    assert recording.p_WB[-1] == pytest.approx([1.0, 1.0, 0.271], abs=0.03)
    carried = recording.between(14.0, 15.0)
    assert carried.force_W[:, 2].mean() == pytest.approx(session.vehicle.mass * GRAVITY, rel=2e-3)
    after = recording.between(21.5, 22.5)
    lighter = (session.vehicle.mass - CRATE) * GRAVITY
    assert after.force_W[:, 2].mean() == pytest.approx(lighter, rel=2e-3)
    assert not after.tensions.any()

"""What integral and incremental laws are for, flown on the full diagram: wind, ground, weak rotors.

And a law of a reader's own, from its file through diagram and linear models.
"""

from pathlib import Path

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.design.judge.margins import loop_margins
from workbench.design.linear.study import LinearStudy
from workbench.design.rollout.agreement import agreement, random_trials
from workbench.gains.gain_choice import flight_gains
from workbench.plant.variation import Variation
from workbench.scenario.scenario import Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

OWN = str(Path(__file__).with_name("cascade.py"))
TAKE_OFF, WAIT = 2.0, 4.0
"""Height [m], and time before it [s]."""


def in_the_air(controller: str, variation: Variation | None = None) -> Session:
    config = VehicleConfig(variation=variation or Variation())
    start = ScenarioStart(position=[0.0, 0.0, 40.0])
    return Session(Scenario(controller=controller, vehicle=config, start=start, duration=1000.0))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("law", "within", "duration"),
    [("pid", 1e-3, 30.0), ("lqi", 1e-3, 30.0), ("indi", 1e-3, 8.0)],
)
def test_a_place_is_held_in_8_m_s_of_wind(law, within, duration):
    """The wind begins while a hover holds its position, and keeps on."""
    session = in_the_air(law)
    session.tick(1.0)
    held = session.recording().p_WB[-1].copy()
    session.set("wind_x", 8.0)
    session.tick(duration)
    flown = session.recording()
    assert np.linalg.norm(flown.p_WB - held, axis=1).max() > within, "the wind has moved it"
    last = flown.p_WB[flown.time > duration]
    assert np.linalg.norm(last - held, axis=1).max() < within


def take_off(law: str, wait: float, wish: float) -> np.ndarray:
    """Return height and climb rate (N, 2) from a take-off on, after a wait with a command."""
    session = Session(Scenario(controller=law, start=ScenarioStart(mode="off"), duration=1000.0))
    session.request("arm")
    session.command([0.0, 0.0, wish])
    session.tick(wait)
    session.request("take_off", TAKE_OFF)
    session.command([0.0, 0.0, 0.0])
    session.tick(6.0)
    flown = session.recording()
    which = flown.time > wait
    return np.column_stack([flown.p_WB[which, 2], flown.v_WB[which, 2]])


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pid", "lqi"])
def test_nothing_winds_up_on_the_ground(law):
    """Armed for 4 s with a command up: the take-off is the one without that."""
    flown = take_off(law, WAIT, 1.0)
    height, speed = flown.max(axis=0)
    begin = flown[0, 0]
    assert height - TAKE_OFF < 0.1 * (TAKE_OFF - begin)
    assert speed < 1.1  # the mode takes off at 1 m/s
    assert flown[-1] == pytest.approx([TAKE_OFF, 0.0], abs=0.02)
    assert flown == pytest.approx(take_off(law, 0.5, 0.0), abs=1e-4)


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pid", "lqi"])
def test_rotors_that_do_all_they_can_stop_the_integral_in_climb(law):
    """A payload too heavy to lift holds it down: after 6 s it is let go as after 3 s.

    What it has gathered by then, the weight that rotors can lift, goes off in a jump.
    """
    peaks = []
    for held in (3.0, 6.0):
        session = Session(
            Scenario(controller=law, start=ScenarioStart(mode="off"), duration=1000.0)
        )
        session.set("payload_mass", 4.0)
        session.request("take_off", TAKE_OFF)
        session.tick(4.0)
        session.command([0.0, 0.0, 1.0])
        session.tick(held)
        assert session.recording().p_WB[-1, 2] < 0.2, "it stands"
        session.set("payload_mass", 0.0)
        session.tick(2.0)
        peaks.append(session.recording().v_WB[:, 2].max())
    assert peaks[1] == pytest.approx(peaks[0], rel=0.05)


@pytest.mark.slow
def test_indi_steps_alike_with_another_inertia_and_weak_rotors(case):
    """Within 5 % of the step at any time, inertia ± 30 % and thrust - 20 %, unknown to the law."""
    steps = {"x": 1.0, "z": 1.0, "yaw": 0.3}
    others = {
        "inertia 0.7": (Variation(inertia=0.7), 1.0),
        "inertia 1.3": (Variation(inertia=1.3), 1.0),
        "thrust 0.8": (Variation(), 0.8),
    }
    for axis, size in steps.items():
        nominal = stepped(Variation(), 1.0, axis, size)
        assert nominal[-1] == pytest.approx(1.0, abs=0.01)
        for name, (variation, thrust) in others.items():
            with case(axis, name):
                found = stepped(variation, thrust, axis, size)
                assert np.abs(found - nominal).max() < 0.05


def stepped(variation: Variation, thrust: float, axis: str, size: float) -> np.ndarray:
    """Return INDI's response to a step, over its size."""
    session = in_the_air("indi", variation)
    for rotor in range(1, 5):
        session.set(f"rotor_{rotor}", thrust)
    session.tick(1.0)
    session.command([size * (axis == each) for each in "xyz"], size * (axis == "yaw"))
    session.tick(3.0)
    flown = session.recording()
    which = flown.time >= 1.0
    motion = flown.w_WB[:, 2] if axis == "yaw" else flown.v_WB[:, "xyz".index(axis)]
    return motion[which] / size


def test_a_law_of_ones_own_flies_and_has_margins():
    session = in_the_air(OWN)
    session.command([1.0, 0.0, 0.0])
    session.tick(4.0)
    assert session.recording().v_WB[-1] == pytest.approx([1.0, 0.0, 0.0], abs=0.1)
    study = LinearStudy(Scenario(controller=OWN))
    margins = loop_margins(study.sampled(), "pitch")
    assert margins.gain_margin > 2.0
    assert margins.phase_margin > 0.5


@pytest.mark.slow
def test_compiled_flights_of_a_law_of_ones_own_are_those_of_the_diagram(vehicle):
    """With random gains, saturated, thrown and lost; of ours see `design/rollout`."""
    law = load_controller(OWN)
    trials = random_trials(vehicle, flight_gains(vehicle, controller=law), 5, 5, law)
    found = agreement(Scenario(controller=OWN), trials)
    assert found.saturated.any()
    assert np.median(found.velocity) < 2e-3  # two integrators
    assert found.velocity.max() < 0.05 and found.angular_velocity.max() < 0.5

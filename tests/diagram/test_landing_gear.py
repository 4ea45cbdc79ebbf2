"""The shipped landing gear: its springs and dampers against the oscillator's closed form."""

import math

import numpy as np
import pytest

from workbench.plant.gravity import GRAVITY
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart, VehicleConfig
from workbench.session.session import Session

LEG_MASS, STIFFNESS, CLEARANCE = 0.06, 250.0, 0.184
"""Of one leg [kg, N/m], and the height of the origin where its feet touch the ground [m]."""
SPRUNG_MASS = 1.903 - 4.0 * LEG_MASS
PHYSICS_STEP_S = Rates().physics_step


@pytest.mark.parametrize(("damping", "sink_rate"), [(7.0, 0.8), (0.5, 0.5)])
def test_legs_give_way_as_a_damped_oscillator_and_bear_the_weight_at_rest(damping, sink_rate):
    """Feet stop at once and the sprung mass m moves on: m z'' + 4 c z' + 4 k z = m g.

    With w² = 4 k / m, d = 2 c / m, w_d² = w² - d² and the deflection at rest z_s = m g / (4 k):
    z = z_s - exp(-d t) (z_s cos(w_d t) - (v - d z_s) / w_d sin(w_d t)). Little of the energy is in
    the legs, whose centres hardly move.
    """
    gear = VehicleConfig(model="landing_gear", args={"damping": str(damping)})
    start = ScenarioStart(mode="off", position=[0, 0, CLEARANCE], velocity=[0, 0, -sink_rate])
    rates = Rates(record_period=PHYSICS_STEP_S)
    session = Session(Scenario(vehicle=gear, start=start, rates=rates), {"drag_area": 0.0})
    mass = session.vehicle.mass
    assert mass == pytest.approx(SPRUNG_MASS + 4.0 * LEG_MASS, abs=1e-9)
    session.tick(0.25)
    at_rest = SPRUNG_MASS * GRAVITY / (4.0 * STIFFNESS)
    decay = 2.0 * damping / SPRUNG_MASS
    damped = math.sqrt(4.0 * STIFFNESS / SPRUNG_MASS - decay**2)
    recording = session.recording()
    t, legs = recording.time, recording.joints[:, :4]
    swing = (sink_rate - decay * at_rest) / damped * np.sin(damped * t)
    deflection = at_rest - np.exp(-decay * t) * (at_rest * np.cos(damped * t) - swing)
    first = slice(0, int(deflection.argmax()) + 1)
    peak = float(deflection.max())
    assert legs.max(axis=0) == pytest.approx([peak] * 4, rel=5e-3)
    assert np.abs(legs[first] - deflection[first, None]).max() < 0.01 * peak
    if damping > 1.0:
        session.tick(1.25)
        recording = session.recording()
        assert recording.joints[-1, :4] == pytest.approx([at_rest] * 4, rel=1e-3)
        names = session.vehicle.contact_links
        assert names == ("base_link", *(f"leg{number}_link" for number in (1, 2, 3, 4)))
        forces = recording.contact_forces[-1].reshape(5, 3)
        assert forces[0].tolist() == [0.0, 0.0, 0.0]
        assert forces[1:, 2] == pytest.approx([mass * GRAVITY / 4.0] * 4, rel=1e-3)
        assert np.abs(forces[:, :2]).max() < 1e-3


def test_it_lands_and_stands_on_its_springs(tmp_path):
    """The rotors stop, the legs take the weight, and the file of the flight has the forces."""
    start = ScenarioStart(position=[0.0, 0.0, 0.3])
    gear = VehicleConfig(model="landing_gear")
    script = [Action(0.0, request="land")]
    session = Session(Scenario(vehicle=gear, start=start, script=script, duration=3.0))
    session.run()
    recording = session.recording()
    at_rest = SPRUNG_MASS * GRAVITY / (4.0 * STIFFNESS)
    assert recording.mode[-1] == 0.0
    assert recording.total_thrust[-1] < 0.1
    assert recording.p_WB[-1, 2] == pytest.approx(CLEARANCE - at_rest, abs=1e-4)
    assert at_rest < recording.joints[:, 0].max() < 0.03
    recording.write_csv(tmp_path / "landing.csv")
    header = (tmp_path / "landing.csv").read_text().splitlines()[0].split(",")
    assert "contact.leg3_link.z [N]" in header

"""Every shipped law at every attitude: no exception, finite commands, and upright again.

`benchmarks/attitudes.py` flies 1,000 random attitudes of each.
"""

import itertools
import math

import numpy as np
import pytest

from workbench.control.controller_file import load_controller
from workbench.control.flight_law import flight_law
from workbench.control.guidance import Guidance, LawSetpoint, Reference
from workbench.control.installed_laws import installed_laws
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.gains.gain_choice import flight_gains
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.session import Session

FREE = Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0)
ROOT = math.sqrt(0.5)
QUATERNIONS = [
    np.array(q)
    for q in itertools.product((0.0, 0.5, -0.5, ROOT, -ROOT, 1.0), repeat=4)
    if abs(np.dot(q, q) - 1.0) < 1e-12 and next(x for x in q if x) > 0.0
]
"""Of all turns by multiples of 90° about each axis, with entries that are exactly 0 and alike."""
MOTIONS = (
    ([0.0] * 3, [0.0] * 3),
    ([0.0, 0.0, -50.0], [0.0, 0.0, 9.0]),
    ([30.0] * 3, [9.0] * 3),
)
"""Velocity [m/s] and angular velocity [rad/s] in W."""
UPSIDE_DOWN = ([math.pi, 0.0, 0.0], [0.0, math.pi, 1.0])
ON_ITS_SIDE = ([math.pi / 2, 0.0, 0.0], [0.0, -math.pi / 2, 2.0])
FALLS = {"mellinger"}
"""Laws that do not turn a vehicle on its back, as their docstrings say."""
HEIGHT = 100.0


@pytest.mark.parametrize("name", installed_laws())
def test_a_law_commands_finite_wrenches_at_exact_attitudes(name, vehicle):
    law = load_controller(name)
    values = flight_gains(vehicle, controller=law)
    constants = law_constants(vehicle)
    dt = law.period or 1 / 128
    g = flight_law(law).gains(law.gains(values, known_vehicle(constants), dt))
    read_memory, wrench = flight_law(law).memory, flight_law(law).wrench
    setpoint = LawSetpoint(Reference(*[0.0] * 7, 1.0), FREE, [0.0] * 3)
    for q in QUATERNIONS:
        for v, w in MOTIONS:
            memory = law.initial_memory
            state = [*q, 0.0, 0.0, 0.0, *w, *v]
            for count in range(3):
                wanted, memory = wrench(
                    state,
                    [0.0] * 3,
                    1.0,
                    setpoint,
                    g,
                    read_memory(memory),
                    [vehicle.mass * 9.81, 0.0, 0.0, 0.0],
                    dt,
                    constants,
                    None,
                    count,
                )
                assert np.isfinite([*wanted, *memory]).all(), (q, v, w)


def tilts(name: str, starts, duration: float) -> list[float]:
    """Return the largest tilt in the last tenth of flights from rest [rad]."""
    start = ScenarioStart(position=[0.0, 0.0, HEIGHT])
    session = Session(Scenario(controller=name, start=start, duration=1000.0))
    found = []
    for angles in starts:
        session.scenario.start = ScenarioStart(
            position=[0.0, 0.0, HEIGHT], roll_pitch_yaw=list(angles)
        )
        session.reset()
        session.set("max_height", 2.0 * HEIGHT)
        session.tick(duration)
        flown = session.recording()
        q = flown.q_WB[flown.time > 0.9 * duration]
        found.append(float(np.arccos(1.0 - 2.0 * (q[:, 1:3] ** 2).sum(axis=1)).max()))
    return found


@pytest.mark.slow
@pytest.mark.parametrize("name", installed_laws())
def test_a_law_turns_a_vehicle_upright_from_all_sides(name):
    """Also from exactly upside down, where a law may find no way that is shorter."""
    starts = ON_ITS_SIDE if name in FALLS else (ON_ITS_SIDE[-1], *UPSIDE_DOWN)
    assert max(tilts(name, starts, 8.0)) < math.radians(10.0)  # after 5 s px4 still flies back

"""A law that does not turn a vehicle upright."""

import math

import numpy as np

from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.session.session import Session

UPSIDE_DOWN = ([math.pi, 0.0, 0.0], [0.0, math.pi, 0.0], [math.pi, 0.0, 1.0])
HEIGHT = 100.0


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


def test_mellinger_gives_up_a_vehicle_on_its_back_as_its_firmware_does():
    """bitcraze/crazyflie-firmware, controller_mellinger.c: no torque without thrust."""
    assert min(tilts("mellinger", UPSIDE_DOWN[:1], 0.5)) > math.radians(179.0)

"""A push gives its impulse whatever the control period is."""

import numpy as np
import pytest
from pydrake.systems.analysis import Simulator

from workbench.dynamics.air.settings import AirSettings, push_settings
from workbench.systems.push import PushSystem

FORCE, POINT, TORQUE = (3.0, -1.0, 2.0), (0.1, 0.2, -0.3), (0.5, 0.25, -0.125)


def sampled(start, duration, period):
    """Return the pushes of the periods of a second (N, 9)."""
    settings = AirSettings(**push_settings(FORCE, POINT, start, duration, TORQUE))
    push = PushSystem(settings=settings, period=period)
    simulator = Simulator(push)
    found = []
    for number in range(round(1.0 / period)):
        simulator.AdvanceTo((number + 0.5) * period)
        found.append(push.get_output_port().Eval(simulator.get_context()).copy())
    return np.array(found)


@pytest.mark.parametrize(
    ("start", "duration", "period"),
    [(0.1, 0.1, 1 / 128), (0.2003, 0.0001, 1 / 128), (0.3, 0.25, 1 / 32), (0.0, 0.004, 1 / 128)],
)
def test_its_impulse_is_force_times_duration(start, duration, period):
    pushes = sampled(start, duration, period)
    assert period * pushes[:, :3].sum(axis=0) == pytest.approx(duration * np.array(FORCE))
    assert period * pushes[:, 6:].sum(axis=0) == pytest.approx(duration * np.array(TORQUE))
    time = period * np.arange(len(pushes))
    inside = (time + period > start) & (time < start + duration)
    assert pushes[inside][:, 3:6] == pytest.approx(np.tile(POINT, (inside.sum(), 1)))
    assert not pushes[~inside].any()

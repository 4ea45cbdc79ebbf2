"""When a drone is steady, from motions that are known."""

from types import SimpleNamespace

import numpy as np

from workbench.control.mode import FlightMode
from workbench.design.steady_drift import HOVER_LOOK_S, steady_time
from workbench.design.step_response import STEP_EDGE_S
from workbench.scenario.axes import AXIS_NAMES
from workbench.scenario.scenario import Action, Scenario


class KnownFlight:
    """A flight whose velocity or rate along each axis is a function of time."""

    scenario = Scenario()

    def __init__(self, motions, height=1.0):
        self.time, self.motions, self.height = 0.0, motions, height

    def follow(self, script, duration):
        self.script = script

    def tick(self, duration):
        self.time += duration

    def snapshot(self):
        x, y, z, yaw = (self.motions.get(name, lambda t: 0.0)(self.time) for name in AXIS_NAMES)
        return SimpleNamespace(v_WB=(x, y, z), w_WB=(np.nan, np.nan, yaw))

    def recording(self):
        return SimpleNamespace(
            time=np.array([self.time]),
            p_WB=np.array([[0.0, 0.0, self.height]]),
            q_WB=np.array([[1.0, 0.0, 0.0, 0.0]]),
            v_WB=np.zeros((1, 3)),
            w_WB=np.zeros((1, 3)),
            mode=np.array([FlightMode.CRUISING]),
            vehicle=SimpleNamespace(ground_clearance=0.1),
        )


def test_it_is_steady_once_its_own_axis_no_longer_changes(case):
    script = [Action(at=12.0)]
    for axis in AXIS_NAMES:
        for other in AXIS_NAMES:
            motions = {axis: lambda t: 0.7, other: lambda t: 5.0 * max(0.0, 4.0 - t)}
            found = steady_time(KnownFlight(motions), script, axis, 0.01, 1.0)
            with case(axis, other):
                begun = 4.0 if other == axis else STEP_EDGE_S
                assert begun + 0.9 < found < begun + 1.0 + 2.0 * HOVER_LOOK_S
    never = KnownFlight({"y": lambda t: 0.1 * t})
    assert steady_time(never, script, "y", 0.01, 1.0) == 0.0


def test_a_drone_that_stands_on_the_ground_is_not_steady():
    script = [Action(at=12.0)]
    assert steady_time(KnownFlight({}, height=0.11), script, "z", 0.01, 1.0) > 0.0
    assert steady_time(KnownFlight({}, height=0.09), script, "z", 0.01, 1.0) == 0.0

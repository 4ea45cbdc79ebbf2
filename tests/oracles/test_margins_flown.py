"""Margins are true of what flies: just inside of them disturbances die out, just outside they grow.

The full diagram is flown with the gain of one loop scaled, or with its signal late. A delay that is
no whole number of control periods is interpolated between samples, which at the frequencies where
these loops cross turns the phase as the delay does, and changes the size by less than a percent.
"""

import numpy as np
import pytest

from workbench.design.judge.margins import loop_margins
from workbench.design.linear.loops import LOOPS
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.scenario import Scenario, Start
from workbench.session import Session
from workbench.systems.flight_computer import PROBES
from workbench.systems.loop_points import COUNT, INJECTIONS, POINTS

PERIOD = 1 / 128
SMALL = 1e-5
"""Of the disturbance, so that rotors answer linearly [m/s, rad/s, N]."""
GROWN = 8.0
LONGEST = 40.0
"""Flown before growth or decay by this factor must have shown [s]."""


@pytest.fixture(scope="module")
def margins():
    study = LinearStudy()
    models = {hold: study.sampled(OperatingPoint(hold=hold)) for hold in (False, True)}
    return {loop.name: loop_margins(models[loop.hold], loop.actuator) for loop in LOOPS}


@pytest.fixture(scope="module")
def session():
    """Far from ground and ceiling."""
    return Session(Scenario(start=Start(position=[0.0, 0.0, 60.0]), duration=1000.0))


class FlownLoop:
    """A flight in which one loop's signal goes on scaled and late."""

    def __init__(self, session, loop, gain, delay):
        self.session, self.place = session, POINTS.index(loop.actuator)
        self.gain, self.delay = gain, delay / PERIOD
        session.reset()
        self.computer = session._bench.computer
        self.context = self.computer.GetMyMutableContextFromRoot(
            session._live.simulator.get_mutable_context()
        )
        self.past = [self.signal()]
        self._disturb(loop)

    def _disturb(self, loop):
        if loop.hold:
            force = [SMALL * (loop.name[-1] == axis) for axis in "xyz"]
            self.session.push(force, duration=0.1)
        elif loop.name == "yaw_rate":
            self.session.command(yaw_rate=SMALL)
        else:
            axis = {"pitch": "x", "roll": "y"}.get(loop.name, loop.name[-1])
            self.session.command([SMALL * (axis == each) for each in "xyz"])

    def signal(self) -> float:
        return self.computer.update(self.context)[2][self.place]

    def tick(self) -> float:
        """Fly a control period and return the signal that it began with."""
        self.past.append(self.signal())
        probes = self.context.get_mutable_numeric_parameter(PROBES)
        if self.delay:
            whole = int(self.delay)
            share = self.delay - whole
            early, late = (self.past[max(-len(self.past), -1 - whole - i)] for i in (0, 1))
            probes.SetAtIndex(self.place, 0.0)
            passed = (1.0 - share) * early + share * late
            probes.SetAtIndex(INJECTIONS + self.place, passed)
        else:
            probes.SetAtIndex(self.place, self.gain)
        self.session.tick(PERIOD)
        return self.past[-1]


def grows(flown: FlownLoop) -> bool:
    """Fly until the swing of the signal has grown or shrunk, and return which."""
    window = 64
    first = None
    swings = []
    for _ in range(int(LONGEST * 128 / window)):
        signals = np.array([flown.tick() for _ in range(window)])
        swing = np.abs(np.diff(signals)).max()
        swings.append(swing)
        first = swings[2] if len(swings) > 3 else None  # the disturbance itself has gone by
        if first and swing > GROWN * first:
            return True
        if first and swing < first / GROWN:
            return False
    return swings[-1] > swings[len(swings) // 2]


def check(session, loop, gain, delay) -> bool:
    return grows(FlownLoop(session, loop, gain, delay))


@pytest.mark.parametrize("loop", LOOPS, ids=lambda loop: loop.name)
def test_the_gain_margin_is_where_the_flight_begins_to_diverge(session, margins, loop):
    margin = margins[loop.name].gain_margin
    assert not check(session, loop, 0.98 * margin, 0.0)
    assert check(session, loop, 1.02 * margin, 0.0)


@pytest.mark.parametrize("loop", LOOPS, ids=lambda loop: loop.name)
def test_the_delay_margin_is_where_the_flight_begins_to_diverge(session, margins, loop):
    margin = margins[loop.name].delay_margin
    assert not check(session, loop, 1.0, 0.95 * margin)
    assert check(session, loop, 1.0, 1.05 * margin)


@pytest.mark.parametrize("name", ["roll", "pitch"])
def test_a_weaker_tilt_loop_diverges_under_its_velocity_loop(session, margins, name):
    loop = next(loop for loop in LOOPS if loop.name == name)
    margin = margins[name].gain_reduction_margin
    assert margin > 0.0
    assert not check(session, loop, 1.02 * margin, 0.0)
    assert check(session, loop, 0.98 * margin, 0.0)


def test_a_normal_flight_has_all_gates_open_and_nothing_injected(session):
    session.reset()
    context = session._bench.computer.GetMyContextFromRoot(session._live.root)
    probes = context.get_numeric_parameter(PROBES).CopyToVector()
    assert probes == pytest.approx([1.0] * COUNT + [0.0] * COUNT)

"""Alarms of a flight whose motion and thrusts are made up, told by what they name."""

import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from workbench.control.flight_mode import FlightMode, Reason
from workbench.live.alarms import Alarms
from workbench.live.messages import Pace
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session

PERIOD_S = 1 / 128


class MadeFlight:
    """A flight in place whose heading is 45°, with a swing about one axis of the body.

    Attributes:
        swing: amplitudes of roll and pitch [rad]; their loops give twice what they are asked for.
        speed: amplitude along x [m/s]; its loop gives twice what it is asked for.
        thrusts: of the rotors [N].
    """

    def __init__(self, swing=(0.0, 0.0), frequency=3.0, speed=0.0, law="pd"):
        flown = Session(Scenario(controller=law))
        self.controller, self.vehicle, self.scenario = (
            flown.controller,
            flown.vehicle,
            flown.scenario,
        )
        self.asked = (0.0, 0.0, 0.0, 0.0)
        self.swing, self.turn, self.time = swing, 2.0 * math.pi * frequency, 0.0
        self.speed = speed
        self.thrusts = [0.5 * rotor.max_thrust for rotor in self.vehicle.rotors]

    @property
    def angles(self):
        return [each * math.sin(self.turn * self.time) for each in self.swing]

    @property
    def v_x(self):
        return self.speed * math.sin(self.turn * self.time)

    def state(self):
        """Angular velocity in W: body axes at 45° between x and y of the world."""
        roll, pitch = (each * self.turn * math.cos(self.turn * self.time) for each in self.swing)
        rates = [(roll - pitch) / math.sqrt(2.0), (roll + pitch) / math.sqrt(2.0), 0.0]
        half = math.radians(22.5)
        return np.array(
            [math.cos(half), 0.0, 0.0, math.sin(half), 0.0, 0.0, 10.0, *rates, self.v_x, 0.0, 0.0]
        )

    def snapshot(self):
        return SimpleNamespace(
            v_WB=(self.v_x, 0.0, 0.0),
            roll_pitch_yaw=(*self.angles, math.radians(45.0)),
            thrusts=self.thrusts,
            mode=FlightMode.HOVERING,
            reason=Reason.NONE,
            time=self.time,
        )

    def loop_signals(self):
        """Errors of the loops: the command, half of what moves, less what moves."""
        law, (roll, pitch) = self.controller, self.angles
        signals = np.zeros(len(law.point_names))
        for name, value in (("roll", roll), ("pitch", pitch), ("velocity_x", self.v_x)):
            signals[law.point_names.index(law.loop(name).error)] = -0.5 * value
        return signals

    def told(self, seconds):
        told = []
        watch = Alarms(self, told.append)
        for number in range(round(seconds / PERIOD_S)):
            self.time = number * PERIOD_S
            watch.look(excited=False)
        return told


@pytest.mark.parametrize(("swing", "loop"), [((0.2, 0.0), "roll"), ((0.0, 0.2), "pitch")])
def test_a_swing_is_told_by_the_axis_of_the_body_in_hertz_and_radians_a_second(swing, loop):
    (said,) = MadeFlight(swing).told(4.0)
    assert f"oscillates in the loop {loop}, at 3.0 Hz (19 rad/s)" in said  # 2 pi 3 = 18.8


def test_a_swing_along_x_is_told_by_its_loop_of_a_law_in_parts():
    (said,) = MadeFlight(frequency=0.5, speed=1.0, law="px4").told(9.0)
    assert "oscillates in the loop velocity x, at 0.50 Hz" in said


def test_rotors_at_their_largest_thrust_are_told_by_their_numbers_from_one():
    for full, wanted in (((2,), "rotor 3 is"), ((1, 3), "rotors 2 and 4 are")):
        flight = MadeFlight()
        for index in full:
            flight.thrusts[index] = flight.vehicle.rotors[index].max_thrust
        (said,) = flight.told(1.5)
        assert said.startswith(f"{wanted} at")


def test_lost_real_time_lasts_only_while_it_is_lost():
    """It is told again if it lasts beyond ten seconds of the flight, and ends with a pause, too."""
    flight, told = MadeFlight(), []
    alarms = Alarms(flight, told.append)
    slow = Pace(asked=1.0, achieved=0.6, lag=0.3, given_up=1.0, slow=True)
    kept = replace(slow, achieved=1.0, slow=False)

    def seen(*paces):
        """Seconds of wall and flight with a pace: how often it was told, and whether it lasts."""
        found = []
        for pace in paces:
            flight.time += 1.0
            alarms.look_at_pace(pace, flight.time)
            found.append((len(told), bool(alarms.lasting)))
        return found

    assert seen(slow, slow, slow, slow) == [(0, False), (0, False), (1, True), (1, True)]
    assert seen(kept) == [(1, False)]
    assert seen(*[slow] * 4) == [(1, False)] * 4
    assert seen(*[slow] * 6)[-1] == (2, True)


@pytest.mark.parametrize(
    ("updraft", "speed", "why"),
    [
        (20.0, 0.0, "the air rises at 20 m/s"),
        (0.01, 0.0, "it may stand on something"),
        (20.0, 0.5, "it has to brake first, and still moves at 0.5 m/s"),
        (0.0, 0.5, "it has to brake first, and still moves at 0.5 m/s"),
        (0.0, 0.0, "it may stand on something"),
    ],
)
def test_a_landing_that_does_not_sink_is_told_with_the_reason_until_it_sinks(updraft, speed, why):
    flight, told = MadeFlight(), []
    now, height = flight.snapshot(), 3.0
    flight.get = {"wind_z": updraft, "landing_speed": 0.5}.__getitem__
    flight.snapshot = lambda: SimpleNamespace(
        **{**vars(now), "mode": mode, "time": flight.time, "p_WB": (0.0, 0.0, height)}
        | {"v_WB": (speed, 0.0, 0.0)}
    )
    alarms = Alarms(flight, told.append)

    def fly(seconds, sinks=0.0):
        nonlocal height
        for _ in range(round(4.0 * seconds)):
            flight.time += 0.25
            height -= 0.25 * sinks
            alarms.look(excited=False)

    mode = FlightMode.HOVERING
    fly(20.0)
    mode = FlightMode.LANDING
    fly(12.0, sinks=0.05)
    assert told == []
    fly(11.0)
    (said,) = told
    clearance = flight.vehicle.ground_clearance
    assert said.startswith("the drone does not sink")
    assert f"at {2.4 - clearance:.1f} m: {why}. Its rotors go on" in said
    assert len(alarms.lasting) == 1
    fly(3.0, sinks=0.5)
    assert alarms.lasting == ()
    fly(11.0)
    assert len(told) == 2
    mode = FlightMode.HOVERING
    fly(1.0)
    assert alarms.lasting == ()

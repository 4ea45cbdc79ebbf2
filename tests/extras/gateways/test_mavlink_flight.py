"""A mission as it is flown: ways, limits, stops and waits of a drone that does as it is told."""

import asyncio
import math
from functools import partial
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("pymavlink", reason="install the extra `mavlink` to try it")

from pymavlink.dialects.v20 import common as mavlink

from workbench.extras.gateways import mavlink_flight
from workbench.extras.gateways.mavlink_effect import NoEffectError, wait_for_effect
from workbench.extras.gateways.mavlink_flight import MISSION_SPEED_SHARE, REACHED_M, MissionFlight
from workbench.extras.gateways.mavlink_messages import HOLD_MODE, LANDING_MODE
from workbench.extras.gateways.mavlink_mission import MissionPlace, MissionStep

LEVEL_SPEED, CLIMB_RATE = 5.0, 0.8
PERIOD = 0.05
"""Of the drone's steps [s]."""
LONGEST_S = 200.0
"""Longer than any of these missions [s]."""


class ObedientDrone:
    """Client and control of a drone that flies the newest velocity in steps of `PERIOD`.

    Attributes:
        flown: (time, position, velocity) of each step.
    """

    hello = SimpleNamespace(limits=SimpleNamespace(level_speed=LEVEL_SPEED, climb_rate=CLIMB_RATE))

    def __init__(self):
        self.time, self.mode = 0.0, 0
        self.place, self.told = np.zeros(3), np.zeros(3)
        self.flown = []

    def latest(self, topic):
        if topic == "drone_state":
            return {"mode": self.mode}

        class Sample(dict):
            time = self.time

        return Sample(zip("xyz", self.place.tolist(), strict=True))

    def velocity(self, x, y, z, hold=math.inf):
        assert hold >= 2 * PERIOD  # the drone must not stop between two commands
        self.told = np.array([x, y, z])

    def check(self):
        pass

    async def step(self, _):
        """Fly on, in place of waiting."""
        assert self.time < LONGEST_S, f"it is on its way for ever, at {self.place}"
        self.flown.append((self.time, self.place.copy(), self.told.copy()))
        self.place = self.place + PERIOD * self.told
        self.time += PERIOD

    async def operate(self, what, height):
        self.mode = {"take_off": HOLD_MODE, "land": 0}[what]
        if what == "take_off":
            self.place[2] = height


def fly(steps, monkeypatch):
    """Return the drone that flew the steps of a mission, and the numbers of those reached."""
    drone, reached = ObedientDrone(), []
    mission = SimpleNamespace(steps=steps, current=0, complete=False)
    flight = MissionFlight(drone, drone, mission, drone.operate, reached.append)
    monkeypatch.setattr(mavlink_flight, "asyncio", SimpleNamespace(sleep=drone.step))
    asyncio.run(flight.fly())
    assert mission.complete
    return drone, reached


def to(x, y, z, **about):
    return MissionStep(mavlink.MAV_CMD_NAV_WAYPOINT, MissionPlace(x, y, z), **about)


def test_it_goes_straight_to_each_place_within_the_limits_and_stops_there(monkeypatch, case):
    """From the origin; along the level part of the way the direction is that of the place."""
    for place, speed, most in (
        ((12.0, 5.0, 0.0), 0.0, MISSION_SPEED_SHARE * LEVEL_SPEED),
        ((-3.0, 20.0, 0.0), 1.2, 1.2),
        ((30.0, -4.0, 1.0), 9.0, LEVEL_SPEED),
        ((0.0, 0.0, 6.0), 0.0, CLIMB_RATE),
        ((0.6, 0.0, -6.0), 0.0, CLIMB_RATE),
    ):
        with case(place, speed):
            drone, reached = fly([to(*place, speed=speed)], monkeypatch)
            told = np.array([velocity for _, _, velocity in drone.flown])
            level = np.hypot(told[:, 0], told[:, 1])
            assert max(level.max(), np.abs(told[:, 2]).max()) == pytest.approx(most)
            assert level.max() <= LEVEL_SPEED + 1e-9
            assert np.abs(told[:, 2]).max() <= CLIMB_RATE + 1e-9
            off_course = told[:, 0] * place[1] - told[:, 1] * place[0]
            assert np.abs(off_course).max() < 1e-9
            assert math.dist(drone.place, place) <= REACHED_M
            assert drone.told.tolist() == [0.0, 0.0, 0.0] and reached == [0]


def test_a_place_has_the_radius_that_it_is_given_and_is_held_for_its_wait(monkeypatch):
    steps = [to(4.0, 0.0, 0.0, radius=0.1, wait=1.5), to(None, 3.0, 0.0)]
    drone, reached = fly(steps, monkeypatch)
    held = [place for _, place, velocity in drone.flown if not velocity.any()]
    assert len(held) == pytest.approx(1.5 / PERIOD, abs=1)
    assert all(math.dist(place, (4.0, 0.0, 0.0)) <= 0.1 for place in held)
    assert drone.place[0] == pytest.approx(held[-1][0])  # of a place without x, x stays
    assert drone.place[1] == pytest.approx(3.0, abs=REACHED_M) and reached == [0, 1]


def test_it_takes_off_returns_at_its_height_and_lands(monkeypatch):
    steps = [
        MissionStep(mavlink.MAV_CMD_NAV_TAKEOFF, MissionPlace(None, None, 2.0)),
        to(3.0, 2.0, 2.0),
        MissionStep(mavlink.MAV_CMD_NAV_RETURN_TO_LAUNCH),
    ]
    drone, reached = fly(steps, monkeypatch)
    assert all(place[2] == 2.0 for _, place, _ in drone.flown)
    assert math.hypot(*drone.place[:2]) <= REACHED_M
    assert drone.mode == 0 and reached == [0, 1, 2]


def test_an_effect_is_one_that_the_drone_shows_after_the_order(case):
    """What it did before, or does only after more than two seconds, is none of it."""

    class Shown(dict):
        def __init__(self, time, mode):
            super().__init__(mode=mode, condition=f"mode {mode}")
            self.time = time

    def next_of(coming, _):
        return next(coming)

    for states, works in (
        ([Shown(1.0, HOLD_MODE), Shown(1.1, LANDING_MODE)], True),
        ([Shown(0.9, LANDING_MODE), Shown(1.0, LANDING_MODE), Shown(3.1, HOLD_MODE)], False),
        ([Shown(1.1, HOLD_MODE), Shown(3.1, HOLD_MODE), Shown(3.2, LANDING_MODE)], False),
    ):
        client = SimpleNamespace(latest=partial(next_of, iter(states)))
        waiting = wait_for_effect(client, "land", 1.0)
        with case([each.time for each in states]):
            if works:
                asyncio.run(waiting)
            else:
                with pytest.raises(NoEffectError, match="land had no effect: .* is mode"):
                    asyncio.run(waiting)

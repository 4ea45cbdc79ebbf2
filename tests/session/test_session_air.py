"""Gusts and pushes of a session: sums by hand, and the same flight from a script."""

import math

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.scenario.scenario import Action, Gust, Push, Rates, Scenario
from workbench.session.session import Session

PERIOD = Rates().control_period


def test_a_gust_rises_and_falls_within_its_time():
    """From the next control update on: 1 - cos, as MIL-F-8785C has it, but rising and falling."""
    session = Session()
    session.tick(0.1003)
    start = math.floor(0.1003 * 128) / 128
    assert session.time == start
    session.gust([6.0, 0.0, 0.0], 0.25)
    session.tick(0.5 - session.time)
    flight = session.recording()
    wind = flight.wind_W[:, 0]
    assert np.flatnonzero(wind)[0] > start * 128
    assert wind.max() == pytest.approx(6.0, rel=0.01)
    assert np.flatnonzero(wind)[-1] <= (start + 0.25) * 128 + 1
    assert np.abs(flight.wind_W[:, 1:]).max() == 0.0
    assert session.get("gust_start") == start


def test_a_push_changes_the_momentum_by_force_times_time():
    """Level, through the centre of mass, and too short for the law to answer much."""
    session = Session(settings={"drag_area": 0.0})
    session.tick(0.25)
    session.push([9.5, 0.0, 0.0], session.vehicle.p_BoBcm_B, 0.03125)
    assert session.get("push_start") == 0.25
    session.tick(0.03125 + 1 / 128)
    gained = 9.5 * 0.03125 / session.vehicle.mass
    assert session.snapshot().v_WB[0] == pytest.approx(gained, rel=0.1)
    assert session.recording().v_WB[32, 0] == pytest.approx(0.0, abs=1e-9)  # at 0.25 s


def test_gusts_and_pushes_of_a_script_are_those_of_a_pilot():
    gust, push = Gust([0.0, 4.0, 0.0], 0.5), Push([3.0, 0.0, -2.0], [0.1, 0.0, 0.0], 0.2)
    script = [Action(at=0.2, gust=gust), Action(at=0.33, push=push)]
    pilot = Session(Scenario(duration=1.0, script=script))
    pilot.tick(1.0)
    scripted = pilot.recording()
    session = Session(Scenario(duration=1.0))
    session.tick(math.ceil(0.2 / PERIOD) * PERIOD)
    session.gust(gust.velocity, gust.duration)
    session.tick(math.ceil(0.33 / PERIOD) * PERIOD - session.time)
    session.push(push.force, push.point, push.duration)
    session.tick(1.0 - session.time)
    for name in ("p_WB", "q_WB", "v_WB", "w_WB", "thrusts", "wind_W"):
        one, other = getattr(session.recording(), name), getattr(scripted, name)
        assert one.tobytes() == other.tobytes(), name
    assert np.abs(scripted.v_WB).max() > 0.05


def test_of_a_gust_or_push_that_is_refused_nothing_is_set():
    session = Session()
    before = [session.get(name) for name in ("gust_x", "gust_start", "push_x", "push_at_x")]
    for act in (
        lambda: session.gust([1.0, 99.0, 0.0], 1.0),
        lambda: session.push([1.0, 2e3, 0.0], [1.0, 0.0, 0.0], 1.0),
    ):
        with pytest.raises(WorkbenchError):
            act()
    names = ("gust_x", "gust_start", "push_x", "push_at_x")
    assert [session.get(name) for name in names] == before

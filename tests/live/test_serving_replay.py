"""What clients, the operator and the ladder did live is flown again to the bit, each time."""

import dataclasses
import random
import time

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import Client
from workbench.link.authority import HOLD_AFTER_S
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Action, Rates, Scenario, ScenarioStart
from workbench.session.recording import Recording
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""
TOPIC = "/dh_drone/velocity_data"
STEP = Rates().physics_step


def time_of(flight: LiveFlight) -> float:
    return flight.latest().snapshot.time


def fly(flight: LiveFlight, client: Client, until: float, dice: random.Random) -> None:
    """Command at random; on a machine that is busy control may be lost, and is asked for again."""
    deadline = time.monotonic() + ENOUGH
    while time_of(flight) < until:
        assert time.monotonic() < deadline
        try:
            with client.control() as control:
                if flight.latest().snapshot.p_WB[2] < 0.5:
                    control.take_off(1.0)
                control.set(kp_velocity_x=dice.uniform(3.0, 6.0))
                while time_of(flight) < until:
                    assert time.monotonic() < deadline
                    level, climb = dice.uniform(-2.0, 2.0), dice.uniform(-0.3, 0.5)
                    control.velocity(level, -0.0, climb, dice.uniform(-0.3, 0.3))
                    time.sleep(0.01)
        except WorkbenchError:
            time.sleep(0.05)


def stop_and_be_interrupted(flight: LiveFlight, client: Client) -> None:
    """Command a stop, and lose control to the operator; a script may have taken it before."""
    deadline = time.monotonic() + ENOUGH
    while time.monotonic() < deadline:
        try:
            with client.control() as control:
                control.velocity(0.0, 0.0, 0.0)
                flight.command([0.0, 0.5, 0.0]).result(ENOUGH)
                return
        except WorkbenchError:
            time.sleep(0.05)
    raise AssertionError("the client had no control long enough for one command")


def served_and_flown(scenario: Scenario, seconds: float, speed: float):
    """Return what came of a flight with all kinds of hands in it."""
    dice = random.Random(3)
    with LiveFlight(scenario, {"kp_roll": 60.0}) as flight:
        flight.wait(ENOUGH)
        flight.set_speed(speed)
        address = flight.serve(ServerConfig(port=0)).result(ENOUGH)
        with Client(address, name="Ada", topics=[TOPIC], rate=50) as client:
            flight.reset().result(ENOUGH)
            fly(flight, client, 0.4 * seconds, dice)
            flight.gust([2.0, 1.0, 0.0], 0.5).result(ENOUGH)
            stop_and_be_interrupted(flight, client)
            flight.give_back().result(ENOUGH)
            fly(flight, client, 0.8 * seconds, dice)
        while time_of(flight) < seconds:
            time.sleep(0.01)
        return flight.flown().result(ENOUGH)


CASES = {
    "usual rates": (Scenario(start=ScenarioStart(mode="off")), 10.0, 5.0),
    "control at every step": (Scenario(rates=Rates(control_period=STEP)), 3.0, 1.0),
    "a script beside": (
        Scenario(script=[Action(at=0.1 * k, velocity=[0.0, 0.0, 0.1]) for k in range(1, 40)]),
        4.0,
        2.0,
    ),
}


@pytest.mark.parametrize(
    "case",
    [
        pytest.param("usual rates", marks=pytest.mark.slow),
        pytest.param("control at every step", marks=pytest.mark.slow),
        "a script beside",
    ],
)
def test_a_served_flight_is_flown_again_to_the_bit(case):
    scenario, seconds, speed = CASES[case]
    flown = served_and_flown(scenario, seconds, speed)
    script = flown.scenario.script
    assert len([each for each in script if each.velocity is not None and any(each.velocity)]) > 10
    assert [each for each in script if each.gust]
    assert [each for each in script if "kp_velocity_x" in each.set]
    assert [each for each in script if each.velocity == [0.0, 0.0, 0.0]]
    if case == "usual rates":
        assert [each for each in script if each.request == "take_off"]
    assert all((each.at / STEP).is_integer() for each in script)
    assert np.ptp(flown.recording.p_WB, axis=0).max() > 0.25  # it is no equality of nothing
    for bridge, replays in ((None, 2), (Bridge(), 1)):
        session = Session(flown.scenario, bridge=bridge)
        for _ in range(replays):
            session.reset()
            session.run()
            assert_equal_to_the_bit(session.recording(), flown.recording, case)


def assert_equal_to_the_bit(one: Recording, other: Recording, case: str) -> None:
    for field in dataclasses.fields(Recording):
        if field.name == "vehicle":
            continue
        a, b = getattr(one, field.name), getattr(other, field.name)
        assert a.shape == b.shape, field.name
        assert a.tobytes() == b.tobytes(), field.name


@pytest.mark.slow
def test_the_ladder_is_flown_again_to_the_bit():
    """A client falls silent in a pause that does not end for it: HOLD, and LAND 5 s later."""
    with LiveFlight(Scenario(start=ScenarioStart(position=[0.0, 0.0, 3.0]))) as flight:
        flight.wait(ENOUGH)
        address = flight.serve(ServerConfig(port=0)).result(ENOUGH)
        with Client(address, name="Ada", topics=[TOPIC]) as client:
            flight.pause().result(ENOUGH)
            flight.reset().result(ENOUGH)
            with client.control() as control:
                control.velocity(1.0, 0.0, 0.0)
                client.ping()
                flight.fly_on(0.25).result(ENOUGH)
                client.parameters("kp_roll")  # what was sent before has come
                flight.fly_on(8.0).result(ENOUGH)
            flown = flight.flown().result(ENOUGH)
    moves = [each for each in flown.scenario.script if each.velocity and any(each.velocity)]
    holds = [each.at for each in flown.scenario.script if each.velocity == [0.0, 0.0, 0.0]]
    (land,) = [each for each in flown.scenario.script if each.request not in (None, "hold")]
    assert moves
    assert (
        min(at for at in holds if at > moves[-1].at) <= 0.25 + HOLD_AFTER_S + Rates().control_period
    )
    assert land.request == "land"
    again = Session(flown.scenario)
    again.run()
    assert_equal_to_the_bit(again.recording(), flown.recording, "ladder")

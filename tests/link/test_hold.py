"""Whatever happens to who flies, the drone holds: real processes, sockets and signals.

The same a hundred times each: benchmarks/link_hold.py. Times are exact in test_hold_ladder.py.
"""

import importlib
from pathlib import Path

import pytest

from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Rates

BENCHMARKS = Path(__file__).resolve().parents[2] / "benchmarks"
ALLOWED = 0.5 + Rates().control_period
"""From the last command that came into force to HOLD, in simulated time [s]."""
SPEED = 5.0


@pytest.fixture(scope="module")
def faults():
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(BENCHMARKS)
        yield importlib.import_module("link_faults")


@pytest.fixture(scope="module")
def flight(faults):
    with LiveFlight() as flight:
        flight.wait(faults.ENOUGH)
        flight.set_speed(SPEED).result(faults.ENOUGH)
        yield flight


CLIENTS = ["kill -9", "SIGSTOP", "reset", "close", "half-open", "silence", "only NaN", "release"]
SERVERS = ["server stopped", "server killed", "server SIGSTOP"]


def one_of_a_kind(faults, quick):
    """Return faults of which all but some are slow tests: the flight goes on in real time."""
    return [
        each if each in quick else pytest.param(each, marks=pytest.mark.slow) for each in faults
    ]


def test_all_faults_are_tried(faults):
    assert {*CLIENTS, *SERVERS} == set(faults.FAULTS)


@pytest.mark.parametrize(
    "fault", one_of_a_kind(CLIENTS, ("kill -9", "SIGSTOP", "half-open", "only NaN"))
)
def test_the_drone_holds_when_a_client_comes_to_harm(faults, flight, fault):
    address = faults.serve(flight)
    assert_held(faults.harmed(flight, address, fault, 0.02))
    flight.stop_serving().result(faults.ENOUGH)


@pytest.mark.parametrize("fault", one_of_a_kind(SERVERS, ("server SIGSTOP",)))
def test_the_drone_holds_when_the_server_comes_to_harm(faults, flight, fault):
    address = faults.serve(flight)
    assert_held(faults.harmed(flight, address, fault, 0.0))


def assert_held(held) -> None:
    assert held.commands > 0
    assert 0.0 < held.gap <= ALLOWED
    assert held.revived == 0


@pytest.mark.parametrize("fault", one_of_a_kind(("silence", "kill -9"), ("silence",)))
def test_nobody_comes_and_the_drone_lands(faults, flight, fault):
    address = faults.serve(flight)
    with faults.flown(flight, address) as scene:
        faults.FAULTS[fault](scene)
        faults.wait_for(
            lambda: flight.latest().snapshot.mode.name == "LANDING", "the drone does not land"
        )
        script = faults.script(flight)
        last = max(each.at for each in script if faults.is_move(each))
        (land,) = [each for each in script if each.request not in (None, "hold")]
        assert land.request == "land"
        assert 5.0 <= land.at - last <= 5.0 + Rates().control_period
    flight.stop_serving().result(faults.ENOUGH)


def test_a_client_that_let_go_is_not_landed(faults, flight):
    address = faults.serve(flight)
    with faults.flown(flight, address) as scene:
        faults.FAULTS["release"](scene)
        faults.fly_on(flight, 6.0)
        assert not [each for each in faults.script(flight) if each.request not in (None, "hold")]
    flight.stop_serving().result(faults.ENOUGH)

"""Eight clients race for control: one gets it each time, and only what it commands is flown.

Each commands a velocity of its own, so that the flight's script shows whose commands came into
force.
"""

import contextlib
import importlib.util
import itertools
import json
import random
import socket
import struct
import time
from pathlib import Path

import pytest

from workbench.link.drone_topics import COMMAND_SIGNAL
from workbench.link.server.config import ServerConfig
from workbench.link.wire import FRAME_HEADER, FrameKind
from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Rates

CLIENTS = 8
ROUNDS_OVER_SOCKETS = 15
CONTROL = Rates().control_period
ENOUGH = 300.0
"""No test waits so long unless it fails [s]."""


def _load():
    spec = importlib.util.spec_from_file_location("served", Path(__file__).with_name("served.py"))
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.load()


rig = _load()


def signature(number: int) -> tuple[float, float, float]:
    """Return the velocity that only this client commands; exact as a float of 32 bits."""
    return (0.125 * (number + 1), 0.0, 0.0)


def owner(velocity) -> int | None:
    """Return whose velocity it is, None for a HOLD."""
    return round(8.0 * velocity[0]) - 1 if any(velocity) else None


@pytest.mark.parametrize("rounds", [50, pytest.param(300, marks=pytest.mark.slow)])
def test_races_have_one_winner_each(monkeypatch, rounds):
    """Losers command all the same: with no lease, old ones, guesses, and the winner's."""
    served = rig.Served(monkeypatch, rig.build())
    clients = [rig.Client(served, f"client {number}") for number in range(CLIENTS)]
    dice = random.Random(11)
    wins = [0] * CLIENTS
    old = [1] * CLIENTS
    for _ in range(rounds):
        done = len(served.script)
        racers = dice.sample(range(CLIENTS), CLIENTS)
        for number in racers:
            clients[number].said.clear()
            clients[number].say(id=1, op="request_control")
        served.hear()
        leases = [_answer(client, 1).get("lease", 0) for client in clients]
        (winner,) = [number for number, lease in enumerate(leases) if lease]
        assert winner == racers[0]
        wins[winner] += 1
        held = [_answer(client, 1).get("code") for client in clients]
        assert held.count("held") == CLIENTS - 1
        clients[winner].command(0.0, 0.0, 0.0, lease=leases[winner])
        for number in dice.sample(range(CLIENTS), CLIENTS):
            stolen = (0, old[number], dice.getrandbits(32), leases[winner])
            lease = leases[winner] if number == winner else dice.choice(stolen)
            clients[number].command(*signature(number), lease=lease)
        served.fly(CONTROL)
        velocities = [each.velocity for each in served.script[done:] if each.velocity is not None]
        flown = [owner(each) for each in velocities]
        assert flown[0] is None  # HOLD
        assert [each for each in flown if each is not None] == [winner]
        old[winner] = leases[winner]
        clients[winner].say(id=2, op="release_control", lease=leases[winner])
    assert min(wins) > 0
    assert sum(wins) == rounds
    served.flying._network.close()


def _answer(client, id: int) -> dict:
    (found,) = [each for each in client.said if each.get("id") == id]
    return found


@pytest.mark.parametrize("how", ["release", "gone"])
def test_a_request_in_the_same_breath_as_the_end_of_the_last_one_is_granted(monkeypatch, how):
    served = rig.Served(monkeypatch, rig.build())
    first, second = rig.Client(served, "Ada"), rig.Client(served, "Bob")
    first.begin()
    first.command(1.0, 0.0, 0.0)
    served.fly(CONTROL)
    done = len(served.script)
    if how == "gone":
        first.go()
    else:
        first.say(op="release_control", lease=first.lease)
    second.say(id=1, op="request_control")
    served.hear()
    second.lease = _answer(second, 1)["lease"]
    second.command(0.0, 0.0, 0.0)
    second.command(0.0, 1.0, 0.0)
    served.fly(CONTROL)
    *holds, last = [each.velocity for each in served.script[done:]]
    assert last == [0.0, 1.0, 0.0]
    assert holds and all(each == [0.0] * 3 for each in holds)
    served.flying._network.close()


class Racer:
    """A client by sockets alone."""

    def __init__(self, address: str) -> None:
        host, _, port = address.rpartition(":")
        self._socket = socket.create_connection((host, int(port)), timeout=ENOUGH)
        self._file = self._socket.makefile("rb")
        self._seq = itertools.count(1)
        self._ids = itertools.count(1)
        self._nacks: set[int] = set()

    def close(self) -> None:
        self._file.close()
        self._socket.close()

    def say(self, **operation) -> int:
        """Send an operation, and return its number."""
        number = next(self._ids)
        self._send(FrameKind.CONTROL, 0, json.dumps({"id": number} | operation).encode(), 0)
        return number

    def answer(self, number: int) -> dict:
        """Wait for the answer to an operation."""
        while (said := self._read()).get("id") != number:
            pass
        return said

    def is_refused(self, seq: int) -> bool:
        """Wait until the server has dealt with a command, by a round trip to the flight."""
        self.answer(self.say(op="parameters", get=["kp_roll"]))
        return seq in self._nacks

    def command(self, velocity, lease: int) -> int:
        """Send a command that acts on the state of now."""
        t_ns = self.answer(self.say(op="ping"))["t_ns"]
        payload = struct.pack("<IIffff", lease, 15, *velocity, 0.0)
        return self._send(FrameKind.DATA, COMMAND_SIGNAL.id, payload, t_ns)

    def fly_on(self) -> None:
        """Wait until an update has dealt with what was sent before."""
        end = self.answer(self.say(op="ping"))["t_ns"] + 40_000_000
        while self.answer(self.say(op="ping"))["t_ns"] < end:
            time.sleep(0.002)

    def _send(self, kind: FrameKind, topic: int, payload: bytes, t_ns: int) -> int:
        seq = next(self._seq)
        head = FRAME_HEADER.pack(b"DH", 1, kind, topic, 0, seq, len(payload), t_ns)
        self._socket.sendall(head + payload)
        return seq

    def _read(self) -> dict:
        _, _, kind, _, _, _, length, _ = FRAME_HEADER.unpack(self._file.read(FRAME_HEADER.size))
        said = json.loads(self._file.read(length)) if kind == FrameKind.CONTROL else {}
        if said.get("op") == "nack" and said.get("seq"):
            self._nacks.add(said["seq"])
        return said


@pytest.mark.slow
def test_races_over_real_sockets_have_one_winner_each():
    dice = random.Random(12)
    with LiveFlight() as flight, contextlib.ExitStack() as stack:
        flight.wait(ENOUGH)
        address = flight.serve(ServerConfig(port=0)).result(ENOUGH)
        racers = [stack.enter_context(contextlib.closing(Racer(address))) for _ in range(CLIENTS)]
        winners = []
        for _ in range(ROUNDS_OVER_SOCKETS):
            order = dice.sample(range(CLIENTS), CLIENTS)
            asked = {number: racers[number].say(op="request_control") for number in order}
            answers = {number: racers[number].answer(id) for number, id in asked.items()}
            (winner,) = [number for number, said in answers.items() if said.get("lease")]
            lease = answers[winner]["lease"]
            racers[winner].command((0.0, 0.0, 0.0), lease)
            racers[winner].fly_on()
            for number in order:
                seq = racers[number].command(signature(number), lease)
                if number == winner:
                    racers[number].fly_on()
                else:
                    assert racers[number].is_refused(seq)
            racers[winner].answer(racers[winner].say(op="release_control", lease=lease))
            winners.append(winner)
        script = flight.flown().result(ENOUGH).scenario.script
    flown = [owner(each.velocity) for each in script if each.velocity is not None]
    turns = [number for number, _ in itertools.groupby(flown) if number is not None]
    expected = [number for number, _ in itertools.groupby(winners)]
    assert [number for number, _ in itertools.groupby(turns)] == expected
    assert len(set(winners)) > 1

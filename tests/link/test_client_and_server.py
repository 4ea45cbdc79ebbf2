"""The client and the server's own process, with a flight that is made up between them."""

import contextlib
import os
import subprocess
import sys
import threading
import time
from multiprocessing import Pipe
from pathlib import Path

import pytest

from workbench.common.errors import WorkbenchError
from workbench.link import Client
from workbench.link.authentication import write_tokens
from workbench.link.backplane import (
    ClientRequest,
    CommandRefusal,
    Disconnect,
    Published,
    Reply,
    ServedFlight,
    StopServer,
    VelocityCommand,
)
from workbench.link.drone_topics import drone_topics
from workbench.link.hello import ParameterRow
from workbench.link.messages import (
    ControlOwner,
    ControlState,
    FlightDone,
    FlightOperation,
    GetParameters,
    LinkLossStage,
    ParameterValues,
    ReleaseControl,
    RequestControl,
    SetParameters,
)
from workbench.link.page_address import lan_address
from workbench.link.server.config import ServerConfig
from workbench.link.signal import TopicOptions
from workbench.link.topics import Delivery

ROOT = Path(__file__).resolve().parents[2]
OLD_CLIENT = ROOT / "tests" / "outside" / "given" / "old_client.py"
TOPICS = drone_topics(TopicOptions(rotors=4, fast=204.8, slow=10.24))
STATES = [topic for topic in TOPICS if topic.delivery is Delivery.STATE]
PERIOD_NS = 1_000_000_000 / 204.8


class ScriptedFlight:
    """Starts a server, answers what clients ask, and keeps it."""

    def __init__(self, **config):
        self.pipe, other = Pipe()
        with other:
            self.process = subprocess.Popen(
                [sys.executable, "-P", "-m", "workbench.link.server.process", str(other.fileno())],
                pass_fds=[other.fileno()],
                env=os.environ | {"PYTHONPATH": str(ROOT)},
            )
        rows = (ParameterRow("kp_x", "1/s", 0.0, 10.0, 2.0, "gain of v_x"),)
        self.pipe.send(ServerConfig(port=0, **config))
        self.pipe.send(ServedFlight("x500", TOPICS, rows, (8.0, 8.0, 0.4)))
        assert self.pipe.poll(20.0)
        self.address = self.pipe.recv().address
        self.asked = []
        self.step = 0
        self.lock = threading.Lock()
        self.thread = threading.Thread(target=self.hear)
        self.thread.start()

    def send(self, record):
        with self.lock:
            self.pipe.send(record)

    def publish(self, steps):
        for _ in range(steps):
            self.step += 1
            payloads = tuple((topic.id, bytes(topic.packer.size)) for topic in STATES)
            self.send(Published(round(self.step * PERIOD_NS), 0, payloads))

    def of(self, kind):
        """Return records, or operations, of a kind that were asked for."""
        asked = [getattr(each, "operation", each) for each in self.asked]
        return [each for each in asked if isinstance(each, kind)]

    def hear(self):
        while True:
            try:
                record = self.pipe.recv()
            except (OSError, EOFError):
                return
            self.asked.append(record)
            self.answer(record)

    def answer(self, record):
        match record:
            case ClientRequest(peer, RequestControl(id, name)):
                self.send(Reply(peer, RequestControl(id, lease=7, expires=0.5)))
                self.send(
                    ControlState(
                        ControlOwner.CLIENT, peer, name, LinkLossStage.LIVE, 0.0, "granted"
                    )
                )
            case ClientRequest(peer, ReleaseControl(id)):
                self.send(Reply(peer, ReleaseControl(id)))
                self.send(
                    ControlState(ControlOwner.NOBODY, 0, "", LinkLossStage.LIVE, 0.0, "released")
                )
            case ClientRequest(peer, FlightOperation(id, what)):
                self.send(Reply(peer, FlightDone(id, what, 3)))
            case ClientRequest(peer, GetParameters(id)):
                self.send(Reply(peer, ParameterValues(id, {"kp_x": 2.0})))
            case ClientRequest(peer, SetParameters(id, values)):
                self.send(Reply(peer, ParameterValues(id, values)))
            case VelocityCommand(peer, seq, velocity=(speed, _, _)) if speed > 50.0:
                self.send(CommandRefusal(peer, seq, "too_fast", f"{speed:g} m/s is too fast"))

    def close(self):
        with contextlib.suppress(OSError):  # it may have ended already
            self.send(StopServer.STOP)
        assert self.process.wait(20.0) == 0
        self.thread.join(20.0)
        assert not self.thread.is_alive()
        self.pipe.close()


@pytest.fixture
def serve(fakes):
    flights = []

    def start(**config):
        flights.append(ScriptedFlight(**config))
        return flights[-1]

    yield start
    for each in flights:
        each.close()


def test_a_client_that_reads_gets_every_sample(serve, fakes):
    flight = serve()
    with Client(flight.address, name="reader") as client:
        got = {}
        for steps in [1] + 100 * [2]:  # as a flight does, which never sends much at once
            flight.publish(steps)
            count = flight.step * len(STATES)
            fakes.wait_until(lambda count=count: client.received == count)
            for _ in range(steps * len(STATES)):
                sample = next(client)
                got.setdefault(sample.topic, []).append(sample.t_ns)
        assert client.dropped == 0
    expected = [round(step * PERIOD_NS) for step in range(1, 202)]
    assert len(got) == len(STATES)
    assert all(stamps == expected for stamps in got.values())


@pytest.mark.parametrize("beyond", [False, True], ids=["this machine", "beyond"])
def test_control_with_tokens_reaches_the_flight(serve, fakes, tmp_path, certificate, beyond):
    """Beyond this machine, by its address in its network, all goes over TLS."""
    tokens = write_tokens(tmp_path / "tokens")
    tls = {"host": "0.0.0.0", "tls_cert": certificate[0], "tls_key": certificate[1]}
    flight = serve(token_file=str(tmp_path / "tokens"), **(tls if beyond else {}))
    address, trusted = flight.address, None
    if beyond:
        own = lan_address() or pytest.skip("this machine has no network")
        address, trusted = f"{own}:{address.rpartition(':')[2]}", certificate[0]
    with Client(address, name="ada", token=tokens.command, tls=trusted) as client:
        flight.publish(1)
        next(client)
        assert client.parameters() == {"kp_x": 2.0}
        with client.control() as c:
            c.velocity(1.0, 2.0, 0.5, 0.1)
            fakes.wait_until(lambda: len(flight.of(VelocityCommand)) > 3)
            assert c.take_off(2.0) == 3e-9
            assert c.set(kp_x=3.0) == {"kp_x": 3.0}
            c.velocity(99.0, 0.0, 0.0)
            fakes.wait_until(lambda: flight.of(VelocityCommand)[-1].velocity == (0.0, 0.0, 0.0))
            with pytest.raises(WorkbenchError, match="99 m/s is too fast"):
                c.velocity(1.0, 0.0, 0.0)
    (request,) = flight.of(RequestControl)
    first, second = flight.of(VelocityCommand)[:2]
    assert request.name == "ada"
    assert (first.lease, first.axes, first.velocity, first.yaw_rate) == (7, 15, (0, 0, 0), 0)
    assert second.velocity == (1.0, 2.0, 0.5)
    assert second.t_ns == round(PERIOD_NS)
    assert len(flight.of(ReleaseControl)) == 1


def test_a_client_of_0_1_0_logs_in_by_its_proof_and_flies(serve, tmp_path):
    """It also signs its commands, which nobody looks at any more."""
    tokens = write_tokens(tmp_path / "tokens")
    flight = serve(token_file=str(tmp_path / "tokens"))
    words = [str(OLD_CLIENT), flight.address, "fly", "1.5", "0", "0", "0", "0.5"]
    with subprocess.Popen(
        [sys.executable, "-I", *words],
        env=os.environ | {"LINK_TOKEN": tokens.command},
        stdout=subprocess.PIPE,
        stderr=subprocess.STDOUT,
        text=True,
    ) as process:
        try:
            end = time.monotonic() + 60.0
            while process.poll() is None and time.monotonic() < end:
                flight.publish(4)
                time.sleep(0.005)
        finally:
            process.kill()
        assert process.returncode == 0, process.stdout.read()
    assert {each.velocity[0] for each in flight.of(VelocityCommand)} == {0.0, 1.5}
    assert len(flight.of(RequestControl)) == len(flight.of(ReleaseControl)) == 1


def test_the_token_to_view_lets_nobody_fly(serve, tmp_path):
    tokens = write_tokens(tmp_path / "tokens")
    flight = serve(token_file=str(tmp_path / "tokens"))
    with Client(flight.address, token=tokens.view, role="view") as client:
        with pytest.raises(WorkbenchError, match="refused: "):
            client.control().__enter__()
        assert client.ping() >= 0.0
    with pytest.raises(WorkbenchError, match="take it from the line 'command:'"):
        Client(flight.address, token=tokens.view).__enter__()
    with pytest.raises(WorkbenchError, match="wants a token"):
        Client(flight.address).__enter__()
    assert flight.of(RequestControl) == []


def test_an_unknown_topic_is_a_sentence(serve):
    flight = serve()
    with pytest.raises(WorkbenchError, match="the server refused: .*velocity"):
        Client(flight.address, topics=["velocity"]).__enter__()


def test_whom_the_operator_sends_away_stays_away(serve):
    flight = serve()
    with Client(flight.address) as client:
        flight.send(Disconnect(client.hello.peer, "enough"))
        with pytest.raises(WorkbenchError, match="enough"):
            next(client)


def test_control_that_another_takes_is_lost(serve, fakes):
    flight = serve()
    with Client(flight.address) as client, client.control() as c:
        fakes.wait_until(lambda: client.control_state)
        flight.send(
            ControlState(
                ControlOwner.OPERATOR, 0, "", LinkLossStage.LIVE, 0.0, "the operator took over"
            )
        )
        fakes.wait_until(lambda: c.lost == "the operator took over")


def test_a_server_that_stops_says_so(serve, fakes):
    flight = serve()
    with Client(flight.address, reconnect=False) as client:
        flight.send(StopServer.STOP)
        with pytest.raises(WorkbenchError, match="said goodbye: the server stops"):
            next(client)

"""A flight with its server in one process, both with clocks that are made up: no sockets, no waits.

Clients send real frames into the real hub; the hub's records reach the real flight, whose answers
come back as frames.
"""

import importlib.util
import json
import math
import struct
import sys
from collections import deque
from multiprocessing import Pipe
from pathlib import Path
from typing import NamedTuple

from tests.live_orders import execute
from workbench.link.backplane import ServedFlight, ServerStatus
from workbench.link.drone_topics import COMMAND_SIGNAL, PARAMETERS_SIGNAL
from workbench.link.messages import ControlOwner, LinkLossStage
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.policy import Policy
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireFrame
from workbench.live.flight_clock import FLIGHT_SLICE_S
from workbench.live.flying import FlightLoop
from workbench.live.messages import FlightReport, FlownSoFar, NetworkView
from workbench.live.orders import FlightOrder
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session
from workbench.systems.bridge import Bridge

COMMAND_FIELDS = struct.Struct("<IIffff")


def load():
    """Return this module, which stands beside the tests and is no test."""
    name = "served_flight"
    if name not in sys.modules:
        spec = importlib.util.spec_from_file_location(name, Path(__file__))
        sys.modules[name] = importlib.util.module_from_spec(spec)
        spec.loader.exec_module(sys.modules[name])
    return sys.modules[name]


class Built(NamedTuple):
    """What takes a second to build, and may be flown again and again."""

    session: Session
    bridge: Bridge


def build(scenario: Scenario | None = None) -> Built:
    """Build a session with a bridge."""
    bridge = Bridge()
    return Built(Session(scenario, bridge=bridge), bridge)


class Served:
    """A live flight whose server is here.

    Args:
        monkeypatch: of pytest.
        built: what is flown, from its start.
    """

    def __init__(self, monkeypatch, built: Built) -> None:
        monkeypatch.setattr("workbench.live.server_supervisor.ServerProcess", self._make)
        self.wall = self.waited = 0.0
        self.sent: list[object] = []
        self.lost = False
        self.connection, self._far = Pipe()
        self._records: deque[object] = deque()
        self.session, self.bridge = built
        self.session.reset()
        self.flying = FlightLoop(self.session, self.bridge, {}, self, lambda: self.wall)
        self.order(ServerConfig(port=0))

    def _make(self, config: ServerConfig, flight: ServedFlight) -> "Served":
        """Stand for the server's process."""
        self.hub = Hub(
            Policy(flight),
            Admission(64, 64),
            self._records.append,
            lambda: self.wall + self.waited,
        )
        self._records.append(ServerStatus("here:1", "", (), {}, ()))
        return self

    # What the flight has of its server.

    wait_time = math.inf

    def tell(self, record: object) -> None:
        if not self.lost:
            self.hub.hear([record])

    publish = tell

    def flush(self) -> None:
        """Send nothing: all is told at once."""

    def received(self, most: int):
        if self.lost:
            raise EOFError
        while self._records:
            yield self._records.popleft()

    def cause(self) -> str:
        return "the server was killed"

    def close(self) -> None:
        self.connection.close()
        self._far.close()

    # What the flight has of its caller.

    def post(self, message: object) -> None:
        self.sent.append(message)

    show = post

    # What a test does.

    def order(self, wanted) -> object:
        """Do what the operator wants, and return the last thing that was said then."""
        answer = execute(self.flying, wanted)
        self.hear()
        return answer

    def hear(self) -> None:
        """Let the flight hear what clients have sent."""
        self.flying._network.hear()
        while self._records and not self.lost and self.flying._network.connections:
            self.flying._network.hear()  # the flight hears for a few milliseconds at a time

    def fly(self, seconds: float) -> None:
        """Fly on, by a wall clock at speed 1."""
        end = self.wall + seconds
        while self.wall < end:
            self.hear()
            self.wall += min(FLIGHT_SLICE_S, end - self.wall)
            self.flying.fly()

    def age(self) -> float:
        """Return how long the holder has been silent [s]."""
        return self.bridge.authority.state(self.time).age

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.session.time

    @property
    def view(self) -> NetworkView:
        """How the network does."""
        return self.flying._network.view

    @property
    def stage(self) -> tuple[ControlOwner, LinkLossStage]:
        """Who flies, and how far the ladder has gone."""
        return self.view.control.hand, self.view.control.stage

    def flown(self) -> FlownSoFar:
        """Return all that was flown."""
        return execute(self.flying, FlightOrder.GET_FLOWN).value

    @property
    def script(self) -> list[Action]:
        """Return all that came into force."""
        return self.flying._network.done

    @property
    def velocities(self) -> list[tuple[float, list[float]]]:
        """Return times and velocities that came into force; HOLD is three zeros."""
        return [(each.at, each.velocity) for each in self.script if each.velocity is not None]

    @property
    def reports(self) -> list[FlightReport]:
        """Return what was shown."""
        return [each for each in self.sent if isinstance(each, FlightReport)]


class Client:
    """A client, byte by byte.

    Args:
        served: the flight that it connects to.
        name: its own name.
    """

    def __init__(self, served: Served, name: str = "") -> None:
        self._served = served
        self._decoder = Decoder()
        self._kept = Decoder()
        self._seq = 0
        self.name = name
        self.unsent = 0
        self.lease = 0
        self.said: list[dict] = []
        self.parameters: list[tuple[bytes, float]] = []
        self.session = served.hub.open(self, f"127.0.0.1:{id(self) % 65536}", "tcp", self._kept)
        self.peer = self.said[0]["peer"]

    # What the hub has of its connection.

    def write(self, data: bytes) -> None:
        for frame in self._decoder.feed(data):
            if frame.kind == FrameKind.CONTROL:
                self.said.append(json.loads(frame.payload))
            if frame.kind == FrameKind.DATA and frame.topic == PARAMETERS_SIGNAL.id:
                self.parameters.append(struct.unpack("<48sd", frame.payload))
            if frame.flags & FrameFlag.ACKNOWLEDGE:
                self.said.append({"op": "batch", "seq": frame.seq})

    def close(self) -> None:
        """Be told that the connection ends."""

    abort = close

    # What a client does.

    def say(self, **operation) -> None:
        """Send an operation."""
        self._send(FrameKind.CONTROL, 0, json.dumps(operation).encode(), 0)

    def ask(self, id: int = 7, **operation) -> dict:
        """Send an operation and return its answer."""
        self.say(id=id, **operation)
        self._served.hear()
        return [each for each in self.said if each.get("id") == id][-1]

    def request(self) -> int:
        """Ask for control, and return the lease; 0 if it was refused."""
        answer = self.ask(op="request_control", name=self.name)
        self.lease = answer.get("lease", 0)
        return self.lease

    def command(self, *velocity, yaw_rate=0.0, lease=None, axes=15, t_ns=None) -> int:
        """Send a command, and return its number."""
        lease = self.lease if lease is None else lease
        t_ns = round(self._served.time * 1e9) if t_ns is None else t_ns
        payload = COMMAND_FIELDS.pack(lease, axes, *velocity, yaw_rate)
        self._send(FrameKind.DATA, COMMAND_SIGNAL.id, payload, t_ns)
        return self._seq

    def begin(self) -> None:
        """Take control, and begin from neutral."""
        assert self.request(), self.said[-1]
        self.command(0.0, 0.0, 0.0)

    def nacks(self, seq: int | None = None) -> list[str]:
        """Return the codes of refusals of commands; of one, if its number is given."""
        found = [each for each in self.said if each["op"] == "nack" and each.get("seq")]
        return [each["code"] for each in found if seq in (None, each["seq"])]

    def go(self) -> None:
        """Let the connection end."""
        self._served.hub.lost(self.session)

    def _send(self, kind: FrameKind, topic: int, payload: bytes, t_ns: int) -> None:
        self._seq += 1
        data = WireFrame(kind, topic, 0, self._seq, t_ns, payload).to_bytes()
        self._kept.received += data
        size: int | None = len(data)
        while pause := self._served.hub.receive(self.session, size):  # a flood is read later
            self._served.waited += pause
            size = None

"""A hub with connections that are made up, and a server's process with a flight that is."""

import functools
import hashlib
import hmac
import json
import os
import socket
import struct
import subprocess
import sys
import tempfile
import time
from dataclasses import replace
from multiprocessing import Pipe
from pathlib import Path

import pytest

from workbench.link.backplane import Published, ServedFlight, ServerStatus, StopServer
from workbench.link.drone_topics import COMMAND_SIGNAL, EVENTS_SIGNAL, drone_topics
from workbench.link.hello import ParameterRow
from workbench.link.server.admission import Admission
from workbench.link.server.hub import Hub
from workbench.link.server.policy import Policy
from workbench.link.signal import TopicOptions
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireFrame

OUTFIT = TopicOptions(rotors=4, fast=204.8, slow=10.24)
ROOT = Path(__file__).resolve().parents[3]
LIMIT = 300.0
"""Generous: nothing here is a matter of time [s]."""


@functools.cache
def make_flight():
    rows = (ParameterRow("kp_x", "1/s", 0.0, 10.0, 2.0, "gain of v_x"),)
    return ServedFlight("x500", drone_topics(OUTFIT), rows, (8.0, 8.0, 0.4))


SIZES = {topic.id: topic.packer.size for topic in drone_topics(OUTFIT)}
STATES = tuple(number for number in SIZES if number not in (16, EVENTS_SIGNAL.id))


def published(step, topics=STATES, wall_ns=None):
    """Return a sample of a step of 1/204.8 s."""
    wall_ns = time.time_ns() if wall_ns is None else wall_ns
    t_ns = round(step * 1e9 / 204.8)
    return Published(
        t_ns, wall_ns, tuple((number, bytes(SIZES.get(number, 8))) for number in topics)
    )


def operation(op, seq=1, **values):
    return saying({"op": op, **values}, seq)


def saying(values, seq):
    payload = json.dumps(values).encode()
    return WireFrame(FrameKind.CONTROL, 0, 0, seq, 0, payload)


def command(seq=1, lease=7, velocity=(0.0, 0.0, 0.0), yaw_rate=0.0, axes=15, t_ns=0):
    payload = struct.pack("<II4f", lease, axes, *velocity, yaw_rate)
    return WireFrame(FrameKind.DATA, COMMAND_SIGNAL.id, 0, seq, t_ns, payload)


def acknowledgement(seq):
    return WireFrame(FrameKind.ACKNOWLEDGEMENT, 0, 0, seq, 0, b"")


def older_proof(token, role, server_nonce, client_nonce="ab" * 16):
    """Return how a client of before tokens were sent logs in, by the words of the protocol."""
    nonces = bytes.fromhex(server_nonce + client_nonce)
    text = b"DH1 login" + role.encode() + nonces
    proof = hmac.new(token.encode(), text, hashlib.sha256).hexdigest()
    return {"role": role, "nonce": client_nonce, "proof": proof}


def with_proof(frame, proof=b"p" * 16):
    """Return the bytes of a frame as such a client sends it, with a proof at its end."""
    return replace(frame, flags=frame.flags | 1, payload=frame.payload + proof).to_bytes()


class FakeTransport:
    """Keeps what is written; `stuck` plays a connection whose other side reads nothing."""

    def __init__(self):
        self.data = bytearray()
        self.stuck = False
        self.closed = False

    @property
    def unsent(self):
        return len(self.data) if self.stuck else 0

    def write(self, data):
        assert not self.closed
        self.data += data

    def close(self):
        self.closed = True

    abort = close


class FakeClient:
    """The other side of a made-up connection."""

    def __init__(self, room, address):
        self.room = room
        self.transport = FakeTransport()
        self.kept = Decoder()
        self.session = room.hub.open(self.transport, address, "tcp", self.kept)
        self._decoder = Decoder()

    def send(self, *frames):
        data = b"".join(f if isinstance(f, bytes) else f.to_bytes() for f in frames)
        self.kept.received += data
        return self.room.hub.receive(self.session, len(data))

    def go_on(self):
        return self.room.hub.receive(self.session)

    def frames(self):
        """Return the frames that have come since the last call."""
        data = bytes(self.transport.data)
        self.transport.data.clear()
        frames = list(self._decoder.feed(data))
        assert self._decoder.waiting == 0, "a frame that was begun is not finished"
        return frames

    def said(self):
        """Return the operations that have come."""
        return [json.loads(f.payload) for f in self.frames() if f.kind == FrameKind.CONTROL]

    def answer(self, op):
        """Return the last operation of a name that has come."""
        return [each for each in self.said() if each["op"] == op][-1]

    def acknowledge(self):
        """Read all there is and acknowledge as a good client does; return the frames."""
        frames = self.frames()
        for frame in frames:
            if frame.flags & FrameFlag.ACKNOWLEDGE:
                self.send(acknowledgement(frame.seq))
        return frames

    @property
    def is_in(self):
        return not self.session.gone


class Room:
    """A hub whose clock is told, and what it has told the flight."""

    def __init__(self, clients=16, an_address=4, call_soon=lambda call: call(), **policy):
        self.now = 100.0
        self.told = []
        self.policy = Policy(make_flight(), clients=clients, **policy)
        admission = Admission(clients, an_address)
        self.hub = Hub(self.policy, admission, self.told.append, lambda: self.now, call_soon)

    def connect(self, address="10.0.0.1:5000"):
        return FakeClient(self, address)

    def wait(self, seconds):
        """Let time pass, with the hub looking ten times a second."""
        for _ in range(round(10 * seconds)):
            self.now += 0.1
            self.hub.tick()

    def asked(self, kind):
        return [each for each in self.told if isinstance(each, kind)]


class Raw:
    """A client of sockets alone."""

    def __init__(self, port, host="127.0.0.1", context=None, source=None):
        self.socket = socket.create_connection(
            (host, port), LIMIT, source_address=(source, 0) if source else None
        )
        if context is not None:
            self.socket = context.wrap_socket(self.socket, server_hostname=host)
        self._decoder = Decoder()
        self._frames = []

    __enter__ = lambda self: self  # noqa: E731

    def __exit__(self, *_):
        self.socket.close()

    def send(self, *frames):
        data = b"".join(f if isinstance(f, bytes) else f.to_bytes() for f in frames)
        self.socket.sendall(data)

    def frame(self):
        """Wait for a frame; None at the end of the connection."""
        while not self._frames:
            data = self.socket.recv(65536)
            if not data:
                return None
            self._frames += self._decoder.feed(data)
        return self._frames.pop(0)

    def answer(self, op):
        """Wait for an operation, and let others pass."""
        while (frame := self.frame()) is not None:
            if frame.kind == FrameKind.CONTROL:
                said = json.loads(frame.payload)
                if said["op"] == op:
                    return said
        raise AssertionError(f"the connection ended without {op}")

    def rest(self):
        """Wait for the end; return the operations until then."""
        frames = list(iter(self.frame, None))
        return [json.loads(frame.payload) for frame in frames if frame.kind == FrameKind.CONTROL]


class Process:
    """A server's process, and the flight's end of its connection."""

    def __init__(self, config):
        self.flight, other = Pipe()
        fd = other.fileno()
        self._noise = tempfile.TemporaryFile()  # noqa: SIM115
        self.process = subprocess.Popen(
            [sys.executable, "-P", "-m", "workbench.link.server.process", str(fd)],
            pass_fds=[fd],
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stderr=self._noise,
        )
        other.close()
        self.flight.send(config)
        self.flight.send(make_flight.__wrapped__())  # a packer that was used is no record
        self.begun = self.hear()
        if isinstance(self.begun, ServerStatus):
            self.port = int(self.begun.address.rpartition(":")[2])

    def hear(self):
        """Wait for a record."""
        assert self.flight.poll(LIMIT), "the server says nothing"
        return self.flight.recv()

    def hear_of(self, kind, fits=lambda record: True):
        """Wait for a record of a kind."""
        end = time.monotonic() + LIMIT
        while not isinstance(record := self.hear(), kind) or not fits(record):
            assert time.monotonic() < end, f"no {kind.__name__}"
        return record

    def client(self, **how):
        return Raw(self.port, **how)

    def stop(self):
        """Stop it; return what it has printed."""
        try:
            self.flight.send(StopServer.STOP)
            while self.flight.poll(LIMIT):
                self.flight.recv()
        except (OSError, EOFError):  # it has ended
            self.flight.close()
        try:
            self.process.wait(LIMIT)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
            raise
        finally:
            self.flight.close()
        if not self._noise.closed:
            self._noise.seek(0)
            self.printed = self._noise.read().decode()
            self._noise.close()
        return self.printed


@pytest.fixture
def parts():
    """Return what these tests are made of."""
    return sys.modules[__name__]


@pytest.fixture
def room():
    """Return a hub without tokens."""
    return Room()


@pytest.fixture
def serve():
    """Return a function that starts a server; all end with the test, and have nothing to tell."""
    servers = []

    def start(config):
        servers.append(Process(config))
        return servers[-1]

    yield start
    for each in servers:
        assert each.stop() == ""

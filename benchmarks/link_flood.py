"""Does the pilot keep control while ten viewers send the worst that the protocol allows?

A flight in real time with its server and its page. A pilot flies it, a program of its own: 20
commands a second, and 50 pings, whose way there and back is measured. Ten viewers beside it send
one kind of frames each run, as much as the server takes: operations of the largest size and of the
worst shape, pings, subscriptions, requests that the flight has to answer, commands without a lease,
frames of one byte after the other, and the same in a WebSocket; or they come and go: with a login
and without, with what is no frame, with TLS's first words, as HTTP. All of it runs on this
machine's cores, the viewers too, so it wants a quiet machine. It ends with 1 where the 99th
percentile of the pilot's pings is 20 ms or more, or the pilot lost control.

`python benchmarks/link_flood.py --seconds 5 --only objects` is a short one.
"""

import argparse
import base64
import json
import os
import selectors
import socket
import struct
import subprocess
import sys
import time
from dataclasses import dataclass

from host import Host
from link_age import FLOWN

from workbench.link.server.config import ServerConfig
from workbench.link.wire import MAX_OPERATION_BYTES, Decoder, FrameKind
from workbench.live.flight import LiveFlight

SECONDS = 30.0
VIEWERS = 10
ENOUGH = 120.0
"""Nothing takes so long unless it fails [s]."""
LONGEST_TRIP = 20.0
"""Of the pilot's pings, 99th percentile [ms]."""
PING_PERIOD = 0.02
COMMAND_PERIOD = 0.05
HEADER = struct.Struct("<2sBBHHIIq")
COMMAND = struct.Struct("<II4f")
PIECE = 256 * 1024
COMES_AND_GOES = 0.002
"""Between two connections of one viewer [s]."""


@dataclass(frozen=True)
class LinkFloodRow:
    """How a pilot does beside ten viewers.

    Attributes:
        viewers: what they send.
        pings: of the pilot, that were answered.
        trip_50: of a ping there and back, median [ms].
        trip_99: the 99th percentile [ms].
        trip_worst: the longest [ms].
        lost: how often the pilot lost control.
        sent: by all viewers [kB/s].
        connections: that they made.
        stolen: by the machine's host, of all processor time meanwhile [%].
    """

    viewers: str
    pings: int
    trip_50: float
    trip_99: float
    trip_worst: float
    lost: int
    sent: float
    connections: int
    stolen: float


@dataclass(frozen=True)
class Habit:
    """What a viewer does.

    Attributes:
        begin: sent once.
        again: sent without end; nothing where it comes and goes.
        web: whether it is a WebSocket, or asks for one.
        goes: whether it leaves after `begin`, and comes again.
        piece: bytes that are sent at once, all that go if 0.
    """

    begin: bytes = b""
    again: bytes = b""
    web: bool = False
    goes: bool = False
    piece: int = 0


def frame(kind: int, payload: bytes, topic: int = 0) -> bytes:
    """Return a frame; its number does not matter where nobody has logged in."""
    return HEADER.pack(b"DH", 1, kind, topic, 0, 1, len(payload), 0) + payload


def filled(begin: bytes, part: bytes, end: bytes) -> bytes:
    """Return the largest operation of so many equal parts."""
    room = MAX_OPERATION_BYTES - len(begin) - len(end)
    return frame(FrameKind.CONTROL, begin + part * (room // len(part)) + end)


def numbered(begin: bytes, part: bytes, end: bytes) -> bytes:
    """Return the largest operation of parts that differ by a number."""
    parts, left, index = [], MAX_OPERATION_BYTES - len(begin) - len(end), 0
    while (more := part % index) and (left := left - len(more)) >= 0:
        parts.append(more)
        index += 1
    return frame(FrameKind.CONTROL, begin + b"".join(parts) + end)


def masked(payload: bytes, opcode: int = 2) -> bytes:
    """Return a WebSocket's frame of a client, whose mask changes nothing."""
    size = len(payload)
    length = bytes([0x80 | size]) if size < 126 else b"\xfe" + size.to_bytes(2, "big")
    return bytes([0x80 | opcode]) + length + bytes(4) + payload


PING = frame(FrameKind.CONTROL, b'{"op":"ping"}')
OBJECTS = filled(b'{"op":"ping","a":[', b"{},", b"{}]}")
KEYS = numbered(b'{"op":"ping"', b',"%x":{}', b"}")
KINDS: dict[str, Habit] = {
    "nothing": Habit(),
    "objects": Habit(again=OBJECTS),
    "keys": Habit(again=KEYS),
    "pings": Habit(again=PING * 500),
    "subscriptions": Habit(
        again=(
            frame(FrameKind.CONTROL, b'{"op":"subscribe","topics":["*"],"rate":10000}')
            + frame(FrameKind.CONTROL, b'{"op":"subscribe","topics":["/dh_drone/position_dat"]}')
        )
        * 100
    ),
    "all parameters": Habit(again=frame(FrameKind.CONTROL, b'{"op":"parameters","get":[]}') * 100),
    "requests": Habit(
        again=frame(FrameKind.CONTROL, b'{"op":"flight","what":"stop","lease":1}') * 100
        + frame(FrameKind.CONTROL, b'{"op":"request_control"}') * 100
    ),
    "commands without a lease": Habit(
        again=frame(FrameKind.DATA, COMMAND.pack(1, 15, 0, 0, 0, 0), 8) * 500
    ),
    "pieces of a byte": Habit(again=PING, piece=1),
    "largest frames to be skipped": Habit(again=frame(0x80, bytes(65536))),
    "pings of a WebSocket": Habit(again=masked(b"", 9) * 1000, web=True),
    "objects in a WebSocket": Habit(again=masked(OBJECTS), web=True),
    "come and go": Habit(goes=True),
    "come, log in and go": Habit(
        begin=frame(FrameKind.CONTROL, b'{"op":"login","name":"viewer"}'), goes=True
    ),
    "come with what is no frame": Habit(begin=b"GET / HTTP/1.1\r\n\r\n", goes=True),
    "come with bad JSON": Habit(
        begin=filled(b'{"op":"ping","a":[', b"{},", b"{}}"), goes=True
    ),
    "fetch the page": Habit(begin=b"GET /app.js HTTP/1.1\r\nHost: %s\r\n\r\n", web=True, goes=True),
}  # fmt: skip


def measure(seconds: float = SECONDS, only: list[str] | None = None) -> list[LinkFloodRow]:
    """Fly once beside each kind of viewers, begun anew each time."""
    rows = []
    with LiveFlight(FLOWN) as flight:
        flight.wait(ENOUGH)
        address = flight.serve(ServerConfig(port=0, web=True)).result(ENOUGH)
        server = flight.latest().network.server
        assert server
        page = server.page.removeprefix("http://").rstrip("/")
        for name in only or KINDS:
            flight.reset().result(ENOUGH)
            rows.append(_beside(name, seconds, address, page))
            print(rows[-1], file=sys.stderr, flush=True)
    return rows


def holds(row: LinkFloodRow) -> bool:
    """Return whether the pilot kept control and heard back in time."""
    return row.trip_99 < LONGEST_TRIP and not row.lost


def show(rows: list[LinkFloodRow]) -> None:
    """Print a table."""
    print("  50 %    99 %   worst ms   lost  stolen  viewers")
    for row in rows:
        print(
            f"{row.trip_50:6.2f} {row.trip_99:7.2f} {row.trip_worst:7.2f} {row.lost:9d} "
            f"{row.stolen:5.1f} %  "
            f"{row.viewers} ({row.sent:.0f} kB/s, {row.connections} connections)"
        )


def _beside(name: str, seconds: float, address: str, page: str) -> LinkFloodRow:
    """Let a pilot fly beside viewers, each side in a process of its own."""

    def begun(*words: str) -> "subprocess.Popen[str]":
        words = (sys.executable, __file__, *words)
        return subprocess.Popen(words, stdout=subprocess.PIPE, text=True)

    pilot = begun("--pilot", address, "--seconds", str(seconds))
    assert pilot.stdout and pilot.stdout.readline().strip() == "flies"
    host = Host()
    viewers = begun("--viewers", name, address, page, "--seconds", str(seconds))
    heard, sent = (
        json.loads(each.communicate(timeout=seconds + ENOUGH)[0]) for each in (pilot, viewers)
    )
    trips = sorted(heard["trips"])
    assert trips, f"{name}: no ping was answered"
    return LinkFloodRow(
        name,
        len(trips),
        *(1e3 * trips[int(share * (len(trips) - 1))] for share in (0.5, 0.99, 1.0)),
        heard["lost"],
        sent["bytes"] / seconds / 1e3,
        sent["connections"],
        host.stolen,
    )


def pilot(address: str, seconds: float) -> None:
    """Fly, ping, and print how long pings took and how often control was lost."""
    host, _, port = address.rpartition(":")
    link = socket.create_connection((host, int(port)))
    link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
    decoder, seq, lease, newest, lost = Decoder(), 0, 0, 0, 0
    asked: dict[int, float] = {}
    trips: list[float] = []

    def send(kind: int, payload: bytes, topic: int = 0, number: int | None = None) -> None:
        nonlocal seq
        seq += number is None
        head = (b"DH", 1, kind, topic, 0, seq if number is None else number, len(payload), newest)
        link.sendall(HEADER.pack(*head) + payload)

    def say(**operation: object) -> None:
        send(FrameKind.CONTROL, json.dumps(operation).encode())

    say(op="subscribe", topics=["/dh_drone/position_data"], rate=50, id=1)
    say(op="ping", id=2)
    end, begun = 0.0, False
    ping_due = command_due = 0.0
    count = 10
    while not end or time.perf_counter() < end:
        now = time.perf_counter()
        if end and now >= ping_due:
            ping_due = now + PING_PERIOD
            asked[count] = now
            say(op="ping", id=count)
            count += 1
        if lease and now >= command_due:
            command_due = now + COMMAND_PERIOD
            speed, begun = 0.2 * begun, True  # the first command of a lease is neutral
            send(FrameKind.DATA, COMMAND.pack(lease, 15, speed, 0.0, 0.0, 0.0), 8)
        link.settimeout(0.001)
        try:
            data = link.recv(65536)
        except TimeoutError:
            continue
        assert data, "the server has ended the connection"
        now = time.perf_counter()
        for each in decoder.feed(data):
            if each.kind == FrameKind.DATA:
                newest = each.t_ns
            if each.flags & 2:
                send(FrameKind.ACKNOWLEDGEMENT, b"", number=each.seq)
            if each.kind != FrameKind.CONTROL:
                continue
            said = json.loads(each.payload)
            if said["op"] == "pong" and said["id"] in asked:
                trips.append(now - asked.pop(said["id"]))
            elif said["op"] == "pong":
                newest = said["t_ns"]
                say(op="request_control", id=3, name="pilot")
            elif said["op"] == "request_control":
                lease, begun, command_due = said["lease"], False, 0.0
                if not end:
                    end = now + seconds
                    print("flies", flush=True)
            elif said["op"] == "control_state" and lease and said["stage"] != "live":
                lost, lease = lost + 1, 0
                say(op="request_control", id=3, name="pilot")
    print(json.dumps({"trips": trips, "lost": lost}))


class Viewer:
    """A viewer that sends as much as goes, and reads what comes.

    Args:
        kind: what it does.
        address: of the server, "HOST:PORT".
        page: of the page.
        selector: that waits for all viewers.
    """

    def __init__(
        self, kind: Habit, address: str, page: str, selector: selectors.BaseSelector
    ) -> None:
        self.kind, self.page, self.selector = kind, page, selector
        host, _, port = (page if kind.web else address).rpartition(":")
        self.where = host, int(port)
        self.sent = self.connections = 0
        self.come()

    def come(self) -> None:
        """Connect."""
        self.link = socket.create_connection(self.where)
        self.link.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.connections += 1
        begin = self.kind.begin.replace(b"%s", self.page.encode())
        if self.kind.web and not begin:
            key = base64.b64encode(os.urandom(16)).decode()
            begin = (
                f"GET /ws HTTP/1.1\r\nHost: {self.page}\r\nOrigin: http://{self.page}\r\n"
                "Connection: Upgrade\r\nUpgrade: websocket\r\nSec-WebSocket-Version: 13\r\n"
                f"Sec-WebSocket-Key: {key}\r\n\r\n"
            ).encode()
            self.link.sendall(begin)
            self.link.recv(4096)  # the answer, before anything else is sent
            begin = b""
        self.left = begin
        self.link.setblocking(False)
        self.watch()

    def watch(self) -> None:
        """Wait for what is to be waited for."""
        events = selectors.EVENT_READ
        if self.left or self.kind.again:
            events |= selectors.EVENT_WRITE
        self.selector.register(self.link, events, self)

    def go_on(self, mask: int) -> None:
        """Read and send what goes."""
        try:
            ended = mask & selectors.EVENT_READ and not self.link.recv(PIECE)
            if ended or (mask & selectors.EVENT_READ and self.kind.goes and not self.left):
                self.go()
                return
            if mask & selectors.EVENT_WRITE:
                self.left = self.left or self.kind.again
                count = self.link.send(self.left[: self.kind.piece or PIECE])
                self.sent += count
                self.left = self.left[count:]
                if not self.left and not self.kind.again:
                    self.selector.modify(self.link, selectors.EVENT_READ, self)
        except BlockingIOError:
            pass
        except OSError:
            self.go()

    def go(self) -> None:
        """Leave, and come again."""
        self.selector.unregister(self.link)
        self.link.close()
        time.sleep(COMES_AND_GOES)
        self.come()


def view(name: str, address: str, page: str, seconds: float) -> None:
    """Let all viewers do their worst, and print how much it was."""
    with selectors.DefaultSelector() as selector:
        viewers = [Viewer(KINDS[name], address, page, selector) for _ in range(VIEWERS)]
        end = time.perf_counter() + seconds
        while time.perf_counter() < end:
            for key, mask in selector.select(0.1):
                key.data.go_on(mask)
    sent, made = sum(each.sent for each in viewers), sum(each.connections for each in viewers)
    print(json.dumps({"bytes": sent, "connections": made}))


def main() -> int:
    """Measure, or be one of the programs that are measured; 1 if the pilot came to harm."""
    parser = argparse.ArgumentParser(description=__doc__.partition("\n")[0])
    parser.add_argument("--seconds", type=float, default=SECONDS, help="of each run")
    parser.add_argument("--only", nargs="+", choices=KINDS, metavar="KIND", help=", ".join(KINDS))
    parser.add_argument("--pilot", nargs=1, help=argparse.SUPPRESS)
    parser.add_argument("--viewers", nargs=3, help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if arguments.pilot:
        pilot(*arguments.pilot, arguments.seconds)
    elif arguments.viewers:
        view(*arguments.viewers, arguments.seconds)
    else:
        rows = measure(arguments.seconds, arguments.only)
        show(rows)
        return 0 if all(map(holds, rows)) else 1
    return 0


if __name__ == "__main__":
    sys.exit(main())

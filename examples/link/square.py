"""Fly a square of 2 m over the link (protocol version 1), with Python's standard library only.

    workbench serve --port 7733
    python3 square.py 127.0.0.1:7733
    python3 square.py 127.0.0.1:7733 --token "$(sed -n 's/^command: *//p' tokens.txt)"

It takes control, takes off, flies from corner to corner with velocity commands, holds, lands, and
returns control. Ctrl-C returns control at once; the drone then holds its position in the air.
"""

import argparse
import hashlib
import hmac
import json
import math
import os
import signal
import socket
import struct
import sys
from collections.abc import Iterator

HEIGHT = 1.5  # [m] above the start
SIDE = 2.0  # [m]
REACHED = 0.1  # [m] distance from a corner
SPEED = 1.0  # [m/s] maximum along each axis
GAIN = 1.0  # [1/s] speed per distance: small enough not to overshoot
PATIENCE = 60.0  # [s], simulated, for each part of the flight

HEADER = struct.Struct("<2sBBHHIIq")
CONTROL, DATA, ACKNOWLEDGEMENT = 0, 1, 2  # kinds of frames
PROOF, ACKNOWLEDGE = 1, 2  # flags
ALL_AXES = 0b1111

Position = tuple[float, float, float]


class RefusedError(Exception):
    """The server or the flight refuses a request."""

    def __init__(self, said: str, code: str = "") -> None:
        super().__init__(said)
        self.code = code


class Link:
    """A connection; its attributes have the latest received values."""

    def __init__(self, host: str, port: int, token: str | None) -> None:
        # A server that is silent for 30 s is gone. Small frames must not wait for more (Nagle).
        self.socket = socket.create_connection((host, port), timeout=30.0)
        self.socket.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.incoming = self.socket.makefile("rb")
        self.seq = self.last_id = self.lease = 0
        self.key = b""  # for proofs, if the server needs them
        self.newest_ns = 0
        self.position: Position | None = None
        self.motors_on: bool | None = None  # not known yet
        self.interrupted = False

        hello = self.receive()
        if not hello or hello["op"] != "hello" or hello["protocol"][0] > 1:
            raise RefusedError("the server does not speak version 1 of the protocol")
        self.peer = hello["peer"]
        topics = {topic["name"]: topic for topic in hello["topics"]}
        prefix = "/dh_drone/"
        self.command = topics[prefix + "command_velocity"]
        self.position_data = topics[prefix + "position_data"]
        self.on_off_state = topics[prefix + "on_off_state"]
        if hello["login"]:
            self.login(hello["nonce"], token)
        wanted = [self.position_data["name"], self.on_off_state["name"]]
        self.ask("subscribe", topics=wanted, rate=20)

    def login(self, server_nonce: str, token: str | None) -> None:
        if not token:
            raise RefusedError("the server needs a login: give --token")
        nonce = os.urandom(16)
        nonces = bytes.fromhex(server_nonce) + nonce
        secret = token.encode()
        proof = hmac.digest(secret, b"DH1 login" + b"command" + nonces, hashlib.sha256).hex()
        self.ask("login", name="square", role="command", nonce=nonce.hex(), proof=proof)
        self.key = hmac.digest(secret, b"DH1 session" + nonces, hashlib.sha256)

    def interrupt(self, *_: object) -> None:
        """Note Ctrl-C for the end of the present frame; a second Ctrl-C ends the program."""
        self.interrupted = True
        signal.signal(signal.SIGINT, signal.SIG_DFL)

    # Sending

    def send(self, kind: int, topic: int, payload: bytes, commands: bool, t_ns: int = 0) -> None:
        self.seq += 1
        proven = commands and self.key
        flags, length = (PROOF, len(payload) + 16) if proven else (0, len(payload))
        frame = HEADER.pack(b"DH", 1, kind, topic, flags, self.seq, length, t_ns) + payload
        if proven:
            frame += hmac.digest(self.key, frame, hashlib.sha256)[:16]
        self.socket.sendall(frame)

    def say(self, op: str, commands: bool = False, **keys: object) -> int:
        self.last_id += 1
        said = {"op": op, "id": self.last_id} | keys
        self.send(CONTROL, 0, json.dumps(said).encode(), commands)
        return self.last_id

    def ask(self, op: str, commands: bool = False, **keys: object) -> None:
        """Send an operation and wait for its answer; process all frames until then."""
        wanted = self.say(op, commands, **keys)
        while True:
            said = self.receive()
            if said and said.get("id") == wanted:
                if said["op"] == "nack":
                    raise RefusedError(f"{op}: {said['code']}: {said['said']}", said["code"])
                return

    # Receiving

    def read(self, size: int) -> bytes:
        got = self.incoming.read(size)
        if len(got) < size:
            raise ConnectionError("the server closed the connection")
        return got

    def receive(self) -> dict | None:
        """Process one frame; return it if it is an operation."""
        head = self.read(HEADER.size)
        magic, version, kind, topic, flags, seq, length, t_ns = HEADER.unpack(head)
        payload = self.read(length)
        if magic != b"DH" or version != 1 or ACKNOWLEDGEMENT < kind < 128:
            raise ConnectionError("the server does not send version 1 of the protocol")
        said = None
        if kind == CONTROL:
            said = json.loads(payload)
            self.hear(said)
        elif kind == DATA:
            self.newest_ns = max(self.newest_ns, t_ns)  # topics of a batch are in any order
            if topic == self.position_data["id"]:
                self.position = struct.unpack(self.position_data["struct"], payload)[:3]
            elif topic == self.on_off_state["id"]:
                self.motors_on = struct.unpack(self.on_off_state["struct"], payload) == (1,)
        if flags & ACKNOWLEDGE:  # at the end, so that the server knows our speed
            self.socket.sendall(HEADER.pack(b"DH", 1, ACKNOWLEDGEMENT, 0, 0, seq, 0, 0))
        return said

    def hear(self, said: dict) -> None:
        """Process an operation that matters even if we do not wait for it."""
        op = said["op"]
        if op in ("error", "bye"):
            raise ConnectionError(f"{said.get('code', 'bye')}: {said['said']}")
        if op == "request_control":
            self.lease = said["lease"]
        elif op == "control_state" and self.lease:
            flies = said["hand"], said["peer"], said["stage"]
            if flies != ("client", self.peer, "live"):
                self.lease = 0
                print(f"control is lost: {said['reason']}", file=sys.stderr)
        elif op == "nack" and "seq" in said and said["code"] != "not_holder":
            # A nack of a command. Commands that were on their way when control was lost get
            # not_holder, but control_state reports that already.
            print(f"command: {said['code']}: {said['said']}", file=sys.stderr)

    def next_position(self) -> Position:
        self.position = None
        while self.position is None:
            self.receive()
        if self.interrupted:
            raise KeyboardInterrupt
        return self.position

    # Flying

    def fly(self, v_x: float = 0.0, v_y: float = 0.0, v_z: float = 0.0) -> None:
        """Command a velocity. Without control, request it first, and start from zero.

        So if a busy machine makes us silent for too long, the drone only stops for a moment. If
        somebody else has control by then, this raises RefusedError.
        """
        while not self.lease:
            self.ask("request_control", commands=True, name="square")
            self.next_position()  # the last known state could be stale
            v_x = v_y = v_z = 0.0
        values = self.lease, ALL_AXES, v_x, v_y, v_z, 0.0
        payload = struct.pack(self.command["struct"], *values)
        self.send(DATA, self.command["id"], payload, commands=True, t_ns=self.newest_ns)

    def flight(self, what: str, **keys: object) -> None:
        while True:
            self.fly()
            try:
                return self.ask("flight", commands=True, what=what, lease=self.lease, **keys)
            except RefusedError as refusal:
                if refusal.code != "not_holder":
                    raise
                self.lease = 0  # we were silent for too long: try again

    def release(self) -> None:
        lease, self.lease = self.lease, 0  # set first: the control_state that follows is not a loss
        if lease:
            self.ask("release_control", commands=True, lease=lease)

    def leave(self) -> None:
        """Return control, say bye, and read to the end, so that everything arrives."""
        try:
            self.release()  # wait for the answer: bye could overtake it
            self.say("bye")
            self.socket.shutdown(socket.SHUT_WR)
            while self.socket.recv(65536):  # not by receive(): nothing can be acknowledged now
                pass
        except (OSError, RefusedError):
            pass  # the server or the lease is already gone
        self.socket.close()


def positions(link: Link, what: str) -> Iterator[Position]:
    """Yield new positions until the time limit."""
    deadline = link.newest_ns + int(PATIENCE * 1e9)
    while link.newest_ns < deadline:
        yield link.next_position()
    raise RefusedError(f"{what}: not done after {PATIENCE:g} s")


def fly_to(link: Link, goal: Position, what: str) -> Position:
    """Answer each position with a velocity: this needs no clock, and renews the lease."""
    for position in positions(link, what):
        if math.dist(position, goal) < REACHED:
            break
        link.fly(
            *(max(-SPEED, min(SPEED, GAIN * (g - p))) for g, p in zip(goal, position, strict=True))
        )
    link.fly()
    return position


def fly_square(link: Link) -> None:
    """Take off, fly from corner to corner, and land."""
    while link.motors_on is None:
        x, y, z = link.next_position()
    if link.motors_on:
        raise RefusedError("the drone's motors are on already: start with the drone on the ground")
    link.flight("take_off", height=HEIGHT)
    # The answer comes at the start of the take-off. Until its end, zeros renew the lease.
    for position in positions(link, "take-off"):
        link.fly()
        if position[2] - z > 0.8 * HEIGHT:
            break

    corners = [(0.0, 0.0), (SIDE, 0.0), (SIDE, SIDE), (0.0, SIDE), (0.0, 0.0)]
    for number, (east, north) in enumerate(corners):
        goal = (x + east, y + north, z + HEIGHT)
        at = fly_to(link, goal, f"corner {number}")
        where = f"x {at[0]:.2f} y {at[1]:.2f} z {at[2]:.2f} m"
        print(f"corner {number}: {where}, {math.dist(at, goal):.2f} m off", flush=True)

    until = link.newest_ns + 2_000_000_000
    while link.newest_ns < until:
        link.next_position()
        link.fly()

    link.flight("land")
    for _ in positions(link, "landing"):
        if not link.motors_on:
            break
        link.fly()
    link.release()
    print("landed, control is returned")


def main() -> int:
    """Read the command line, fly, and return the exit code."""
    parser = argparse.ArgumentParser(description="Fly a square of 2 m.")
    parser.add_argument("address", metavar="HOST:PORT")
    parser.add_argument("--token", help="token for commands, if the server needs a login")
    arguments = parser.parse_args()
    host, _, port = arguments.address.rpartition(":")
    link = None
    try:
        link = Link(host, int(port), arguments.token)
        signal.signal(signal.SIGINT, link.interrupt)
        fly_square(link)
        return 0
    except (RefusedError, OSError, ValueError) as problem:
        print(f"square: {problem}", file=sys.stderr)
        return 1
    except KeyboardInterrupt:
        print("square: interrupted", file=sys.stderr)
        return 130
    finally:
        if link:
            link.leave()


if __name__ == "__main__":
    sys.exit(main())

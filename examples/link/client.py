"""Watch and fly a drone over the link, with Python's standard library only.

python client.py [HOST:PORT] watch [FRAMES]
python client.py [HOST:PORT] fly V_X V_Y V_Z YAW_RATE [SECONDS [TAKE_OFF_HEIGHT]]

Speeds are in m/s and rad/s in the world's axes, z up. If the server needs a token, put it into
the environment: LINK_TOKEN=... python client.py watch. See docs/protocol.md.
"""

import hashlib
import hmac
import json
import os
import secrets
import socket
import struct
import sys

HEADER = struct.Struct("<2sBBHHIIq")  # magic, version, kind, topic, flags, seq, length, t_ns
CONTROL, DATA, ACKNOWLEDGEMENT = 0, 1, 2
HMAC, ACKNOWLEDGE = 1, 2
ALL_AXES = 15
VELOCITY, COMMAND = "/dh_drone/velocity_data", "/dh_drone/command_velocity"
TAKE_OFF_TIME = 4.0  # simulated seconds until the first command to move
DONE = {"release_control", "bye"}


class Link:
    """A connection: it sends operations and data, and receives frames."""

    def __init__(self, host, port, role):
        self.stream = socket.create_connection((host, port), timeout=10)
        self.stream.setsockopt(socket.IPPROTO_TCP, socket.TCP_NODELAY, 1)
        self.seq, self.key = 0, None
        self.hello = self.hear_one("hello")
        self.topics = {topic["id"]: topic for topic in self.hello["topics"]}
        self.numbers = {topic["name"]: topic["id"] for topic in self.hello["topics"]}
        if self.hello["login"]:
            self.log_in(os.environ.get("LINK_TOKEN", ""), role)

    def log_in(self, token, role):
        """Prove that we know the token, without sending it."""
        mine = secrets.token_bytes(16)
        nonces = bytes.fromhex(self.hello["nonce"]) + mine
        proof = hmac.digest(token.encode(), b"DH1 login" + role.encode() + nonces, "sha256").hex()
        self.say("login", name="example", role=role, nonce=mine.hex(), proof=proof)
        self.hear_one("login")
        self.key = hmac.digest(token.encode(), b"DH1 session" + nonces, "sha256")

    def hear_one(self, op):
        """Return the next operation of a kind; others may come before it."""
        while (said := json.loads(self.receive()[3]))["op"] != op:
            hear(said)
        return said

    def say(self, op, commands=False, **values):
        """Send an operation; `commands` if it needs a proof."""
        self.send(CONTROL, 0, json.dumps({"op": op} | values).encode(), 0, commands)

    def send(self, kind, topic, payload, t_ns=0, commands=False):
        """Send a frame."""
        self.seq += 1
        proven = commands and self.key is not None
        flags, length = (HMAC, len(payload) + 16) if proven else (0, len(payload))
        frame = HEADER.pack(b"DH", 1, kind, topic, flags, self.seq, length, t_ns) + payload
        if proven:
            frame += hmac.new(self.key, frame, hashlib.sha256).digest()[:16]
        self.stream.sendall(frame)

    def receive(self):
        """Return kind, topic, t_ns and payload of the next frame; acknowledge if requested."""
        magic, version, kind, topic, flags, seq, length, t_ns = HEADER.unpack(self.read(24))
        if magic != b"DH" or version != 1:
            sys.exit("this is not a link of version 1")
        payload = self.read(length)
        if flags & ACKNOWLEDGE:  # with the `seq` of the frame just received
            self.stream.sendall(HEADER.pack(b"DH", 1, ACKNOWLEDGEMENT, 0, 0, seq, 0, 0))
        return kind, topic, t_ns, payload

    def read(self, size):
        """Return a number of bytes."""
        data = b""
        while len(data) < size:
            piece = self.stream.recv(size - len(data))
            if not piece:
                sys.exit("the server has gone")
            data += piece
        return data

    def leave(self):
        """Say bye, and read to the end: closing the socket earlier could lose what we sent."""
        self.say("bye")
        self.stream.shutdown(socket.SHUT_WR)
        while self.stream.recv(65536):
            pass
        self.stream.close()

    def values(self, topic, payload):
        """Return a data frame's single numbers by name; all of it is in hello."""
        fields = self.topics[topic]["fields"]
        numbers = struct.unpack(self.topics[topic]["struct"], payload)
        return dict(zip((field["name"] for field in fields), numbers, strict=True))


def watch(link, frames):
    """Print velocities."""
    link.say("subscribe", topics=[VELOCITY], rate=20)
    while frames:
        kind, topic, t_ns, payload = link.receive()
        if kind == DATA and topic == link.numbers[VELOCITY]:
            v = link.values(topic, payload)
            print(f"{t_ns * 1e-9:9.3f} s  {v['v_x']:7.3f} {v['v_y']:7.3f} {v['v_z']:7.3f} m/s")
            frames -= 1
        elif kind == CONTROL:
            hear(json.loads(payload))
    link.leave()


def fly(link, wanted, seconds, height):
    """Take control, answer each state with a command, and return control."""
    link.say("subscribe", topics=[VELOCITY], rate=20)
    link.say("request_control", id=1, name="example", commands=True)
    lease, begin = None, None
    wait = TAKE_OFF_TIME if height else 0.25
    while True:
        kind, topic, t_ns, payload = link.receive()
        if kind == CONTROL:
            said = json.loads(payload)
            hear(said)
            if said["op"] == "request_control":
                lease = said["lease"]
            elif said["op"] in DONE:
                return link.leave()
        elif lease and kind == DATA and topic == link.numbers[VELOCITY]:
            begin = t_ns if begin is None else begin
            age = (t_ns - begin) * 1e-9
            if age >= wait + seconds + 0.5:
                link.say("release_control", id=3, lease=lease, commands=True)
                lease = None
                continue
            moving = wait <= age < wait + seconds
            velocity = wanted if moving else (0.0, 0.0, 0.0, 0.0)  # the first command must be zero
            command = struct.pack("<IIffff", lease, ALL_AXES, *velocity)
            link.send(DATA, link.numbers[COMMAND], command, t_ns, commands=True)
            if height and t_ns == begin:
                link.say("flight", id=2, what="take_off", height=height, lease=lease, commands=True)


def hear(said):
    """Print an operation; some end the program."""
    print(" ".join(f"{name}={value}" for name, value in said.items()))
    refused = said["op"] == "nack" and ("id" in said or said["code"] == "not_holder")
    if said["op"] == "error" or refused:
        sys.exit(1)


def main(words):
    """Run the command line."""
    host, port = "127.0.0.1", "7733"
    if words and words[0] not in ("watch", "fly"):
        host, _, port = words.pop(0).rpartition(":")
    match words:
        case ["watch", *frames]:
            watch(Link(host, int(port), "view"), int(frames[0]) if frames else -1)
        case ["fly", v_x, v_y, v_z, yaw_rate, *rest]:
            wanted = [float(each) for each in (v_x, v_y, v_z, yaw_rate)]
            seconds = float(rest[0]) if rest else 2.0
            height = float(rest[1]) if len(rest) > 1 else 0.0
            fly(Link(host, int(port), "command"), wanted, seconds, height)
        case _:
            sys.exit(__doc__)


if __name__ == "__main__":
    main(sys.argv[1:])

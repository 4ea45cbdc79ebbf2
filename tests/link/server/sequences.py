"""Sequences of what clients do, good and bad, at random from a seed, in pieces of any size."""

import random
import struct

from workbench.link.authentication import Tokens
from workbench.link.backplane import CommandRefusal, Disconnect, Reply
from workbench.link.messages import Nack, ParameterValues
from workbench.link.wire import MAX_PAYLOAD_BYTES, FrameKind

STEPS = 8
OPERATIONS = (
    {"op": "subscribe", "topics": ["*"]},
    {"op": "subscribe", "topics": ["/dh_drone/time_data"], "rate": 20},
    {"op": "subscribe", "topics": ["nowhere"]},
    {"op": "subscribe", "topics": []},
    {"op": "request_control", "name": "me"},
    {"op": "release_control", "lease": 5},
    {"op": "flight", "what": "land", "lease": 5},
    {"op": "flight", "what": "take_off", "height": -1, "lease": 5},
    {"op": "parameters", "get": []},
    {"op": "parameters", "set": {"kp_x": 1e300}, "lease": 5},
    {"op": "parameters"},
    {"op": "ping", "id": 2**32 - 1},
    {"op": "ping", "id": -1},
    {"op": "login", "name": "me"},
    {"op": "login", "role": "command", "nonce": "00" * 16, "proof": "00" * 32},
    {"op": "login", "role": "command", "token": "00" * 16},
    {"op": "dance"},
    {"op": 3},
    {},
    {"op": "bye"},
)
NUMBERS = (0.0, 1.0, -1e38, float("nan"), float("inf"), -float("inf"), 1e-45)


def play(parts, seed):
    """Play one sequence beside a good client; return what went wrong."""
    draw = random.Random(seed)
    tokens = Tokens("v" * 16, "c" * 16) if draw.random() < 0.5 else None
    room = parts.Room(tokens=tokens, allow_commands=draw.random() < 0.9)
    good = enter(parts, room, "10.0.0.1:1")
    good.send(parts.operation("subscribe", 2, topics=["/dh_drone/time_data"]))
    good.frames()
    bad = [None, None, None]
    step = 0
    got = []
    for _ in range(STEPS):
        at = draw.randrange(3)
        if bad[at] is None or bad[at].session is None or not bad[at].is_in:
            host = f"10.0.1.{at}:1"
            bad[at] = enter(parts, room, host) if draw.random() < 0.5 else room.connect(host)
        else:
            act(parts, draw, room, bad[at])
        step += 1
        room.hub.hear([parts.published(step)])
        got += [frame.t_ns for frame in good.acknowledge() if frame.kind == FrameKind.DATA]
        if draw.random() < 0.3:
            room.now += draw.choice((0.01, 0.5, 3.5))
            room.hub.tick()
    return wrong(parts, room, good, got, step)


def enter(parts, room, address):
    """Return a client that has logged in where that is needed."""
    client = room.connect(address)
    if room.policy.tokens is not None and client.session is not None:
        client.send(parts.operation("login", 1, role="command", token="c" * 16))
    return client


def act(parts, draw, room, client):
    """Do one thing as a client, or to it."""
    what = draw.randrange(8)
    if what == 0:
        client.transport.stuck = not client.transport.stuck
    elif what == 1:
        room.hub.lost(client.session)
    elif what == 2:
        client.frames()
    elif what == 3:
        number = client.session.number
        room.hub.hear(
            [
                draw.choice(
                    (
                        Reply(number, ParameterValues(draw.randrange(9), {})),
                        Reply(number, Nack("held", "x" * 500, 1)),
                        CommandRefusal(number, draw.randrange(9), "too_fast", "slower"),
                        Disconnect(number, "go"),
                    )
                )
            ]
        )
    else:
        data = b"".join(words(parts, draw) for _ in range(draw.choice((1, 3, 20))))
        while data:
            size = draw.choice((1, 7, 24, 100, 5000, len(data)))
            pause = client.send(data[:size])
            while pause > 0.0:  # as a transport does
                room.now += pause
                pause = client.go_on()
            data = data[size:]
            if draw.random() < 0.1:
                room.now += 0.02


def words(parts, draw):
    """Return the bytes of one frame, perhaps of none."""
    seq = draw.choice((0, 1, 2, 5, 9, 2**32 - 1))
    kind = draw.randrange(7)
    if kind < 3:
        data = parts.saying({"id": draw.randrange(5)} | draw.choice(OPERATIONS), seq)
    elif kind == 3:
        velocity = tuple(draw.choice(NUMBERS) for _ in "xyz")
        data = parts.command(seq, draw.choice((0, 5, 2**32 - 1)), velocity, axes=seq)
    elif kind == 4:
        data = parts.acknowledgement(seq)
    elif kind == 5:
        data = parts.WireFrame(1, draw.choice((0, 1, 8, 65535)), 0, seq, -1, draw.randbytes(24))
    else:
        length = draw.choice((0, 16, 4097, MAX_PAYLOAD_BYTES + 1, 2**32 - 1))
        head = (draw.choice((b"DH", b"dh")), draw.choice((1, 1, 2)), draw.randrange(256))
        return struct.pack("<2sBBHHIIq", *head, 0, draw.randrange(4), seq, length, 0)
    found = bytearray(data.to_bytes())
    if draw.random() < 0.1:
        found[draw.randrange(len(found))] ^= 1 << draw.randrange(8)
    return bytes(found)


def wrong(parts, room, good, got, step):
    """Return what went wrong, in words."""
    said = []
    if "internal" in room.hub.refusals.counts:
        said.append(f"it failed: {room.hub.refusals.log}")
    if not good.is_in:
        said.append("the good client is out")
    elif got != [round(n * 1e9 / 204.8) for n in range(1, step + 1)]:
        said.append("the good client has missed something")
    else:
        good.send(parts.operation("ping", 99))
        if good.said()[-1]["op"] != "pong":
            said.append("the good client is not answered")
    for session in room.hub._sessions.values():
        out = session.out
        if (
            out.overflowed
            or len(out._batches) > 2
            or session._decoder.waiting > 2 * MAX_PAYLOAD_BYTES
        ):
            said.append("too much is kept")
        if len(session.transport.data) > 400_000:
            said.append("too much is written to who does not read")
    inside = sum(session.role is not None for session in room.hub._sessions.values())
    if len(room.hub._sessions) > 4 or room.hub._admission._inside.total() != inside:
        said.append("places are lost")
    return said

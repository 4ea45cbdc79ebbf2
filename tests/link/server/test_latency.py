"""Clients that are far away keep control: told time, the real hub and authority, a slow line."""

import json
import struct
from collections import deque
from itertools import pairwise

import pytest

from workbench.link.authority import Authority, CommandLimits, DeniedError, SilenceEffect
from workbench.link.backplane import ClientRequest, CommandRefusal, Reply, VelocityCommand
from workbench.link.drone_topics import COMMAND_SIGNAL
from workbench.link.messages import Nack, RequestControl
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireFrame

STEP = 1 / 204.8
VELOCITY = 3
SETTLED = 3.0
"""Time of a client to find out how far away it is [s]."""


class FarFlight:
    """A flight with its server, and one client behind a line of a given delay.

    Args:
        parts: what the tests of the server are made of.
        client: makes what answers frames; see `LockStep`.
        delay: of the line, each way [s].
        topics: that the client subscribes to.

    Attributes:
        now: simulated time, which is also that of clocks [s].
        effects: of silence, and when [s].
        refused: codes of refusals.
        flown: times at which commands came into force [s].
    """

    def __init__(self, parts, client, delay, topics):
        self.room = parts.Room()
        self.parts, self.delay, self.now = parts, delay, 0.0
        self.begun = self.room.now
        self.authority = Authority(CommandLimits(8.0, 8.0, 0.4))
        self.effects, self.refused, self.flown = [], [], []
        self.end = self.room.connect()
        self.up, self.down = deque(), deque()  # what is on its way, and when it arrives
        self.seq = 0
        self.client = client(self)
        self.say("subscribe", topics=topics, rate=20)

    def send(self, frame):
        self.up.append((self.now + self.delay, frame.to_bytes()))

    def say(self, op, **values):
        self.seq += 1
        self.send(self.parts.operation(op, self.seq, **values))

    def command(self, lease, v_x, t_ns):
        self.seq += 1
        payload = struct.pack("<II4f", lease, 15, v_x, 0.0, 0.0, 0.0)
        self.send(WireFrame(FrameKind.DATA, COMMAND_SIGNAL.id, 0, self.seq, t_ns, payload))

    def fly(self, seconds):
        """Let time pass."""
        for _ in range(round(seconds / STEP)):
            self.now += STEP
            self.room.now = self.begun + self.now
            while self.up and self.up[0][0] <= self.now:
                self.end.send(self.up.popleft()[1])
            self._decide()
            step = round(self.now / STEP)
            self.room.hub.hear([self.parts.published(step, wall_ns=1)])
            if step % 20 == 0:
                self.room.hub.tick()
            if self.end.transport.data:
                self.down.append((self.now + self.delay, bytes(self.end.transport.data)))
                self.end.transport.data.clear()
            while self.down and self.down[0][0] <= self.now:
                self.client.receive(self.down.popleft()[1])
            self.client.pass_time()

    def _decide(self):
        told, self.room.told[:] = list(self.room.told), []
        while (effect := self.authority.effect_due(self.now)) is not None:
            self.effects.append((effect, self.now))
        for each in told:
            try:
                if isinstance(each, VelocityCommand):
                    self.authority.command(each, self.now)
                    self.flown.append(self.now)
                elif isinstance(each, ClientRequest):
                    assert isinstance(each.operation, RequestControl)
                    lease = self.authority.request(each.peer, "far", self.now)
                    answer = RequestControl(each.operation.id, lease=lease, expires=0.5)
                    self.room.hub.hear([Reply(each.peer, answer)])
            except DeniedError as error:
                self.refused.append(error.code)
                if isinstance(each, VelocityCommand):
                    record = CommandRefusal(each.peer, each.seq, error.code, str(error))
                else:
                    record = Reply(each.peer, Nack(error.code, str(error), each.operation.id))
                self.room.hub.hear([record])


class LockStep:
    """A client that commands whenever a velocity comes, as the protocol advises; it has no clock.

    Args:
        flight: at the other end.
    """

    def __init__(self, flight):
        self.flight = flight
        self.lease = 0
        self.newest = 0
        self._decoder = Decoder()

    def receive(self, data):
        for frame in self._decoder.feed(data):
            if frame.flags & FrameFlag.ACKNOWLEDGE:
                self.flight.send(self.flight.parts.acknowledgement(frame.seq))
            if frame.kind == FrameKind.CONTROL:
                self.heard(json.loads(frame.payload))
            else:
                self.newest = max(self.newest, frame.t_ns)
                self.sampled(frame.topic)

    def heard(self, said):
        if said["op"] == "request_control":
            self.lease = said["lease"]
            self.flight.command(self.lease, 0.0, self.newest)

    def sampled(self, topic):
        if self.lease and topic == VELOCITY:
            self.flight.command(self.lease, 1.0, self.newest)

    def pass_time(self):
        pass


class Repeating(LockStep):
    """A client that repeats its command 20 times a second, and pings as often for the time."""

    PERIOD = 0.05
    due = 0.0

    def heard(self, said):
        if said["op"] == "pong":
            self.newest = max(self.newest, said["t_ns"])
        super().heard(said)

    def sampled(self, topic):
        pass

    def pass_time(self):
        if self.flight.now >= self.due:
            self.due = self.flight.now + self.PERIOD
            self.flight.say("ping")
            if self.lease:
                self.flight.command(self.lease, 1.0, self.newest)


ONE, ALL = ["/dh_drone/velocity_data"], ["*"]


@pytest.mark.parametrize("client", [LockStep, Repeating])
@pytest.mark.parametrize("topics", [ONE, ALL], ids=["one", "all"])
@pytest.mark.parametrize("delay", [0.0, 0.05, 0.15, 0.3])
def test_who_is_far_away_keeps_control(parts, client, topics, delay):
    """With 300 ms each way commands still come all the time, and act on a state that is not old."""
    flight = FarFlight(parts, client, delay, topics)
    flight.fly(SETTLED)
    flight.say("request_control", id=1)
    flight.fly(10.0)
    assert [effect for effect, _ in flight.effects] == [SilenceEffect.HOLD], (
        "that of the grant alone"
    )
    assert flight.refused == []
    steps = [after - before for before, after in pairwise([*flight.flown, flight.now])]
    assert max(steps) <= delay + 0.1, "the gap that silence may have is half a second"

"""A flight that is played: the real hub, page and authority, and a point that moves as told."""

import asyncio
import math
import threading
from dataclasses import replace

from workbench.link import drone_topics as topic
from workbench.link.authority import (
    HOLD_AFTER_S,
    Authority,
    CommandLimits,
    DeniedError,
    SilenceEffect,
)
from workbench.link.backplane import (
    ClientDisconnected,
    ClientRequest,
    CommandRefusal,
    Published,
    Reply,
    ServedFlight,
    VelocityCommand,
)
from workbench.link.drone_topics import drone_topics
from workbench.link.messages import (
    FlightDone,
    FlightOperation,
    Nack,
    ReleaseControl,
    RequestControl,
)
from workbench.link.server import web
from workbench.link.server.admission import Admission
from workbench.link.server.config import ServerConfig
from workbench.link.server.hub import Hub
from workbench.link.server.policy import Policy
from workbench.link.signal import TopicOptions

STEP = 0.02
CLIMB = 10.0
PACE = 0.25
"""Of simulated time: a page that a slow machine keeps waiting shall not lose control by it."""
COLUMNS = 180
LAYERS = (-0.2, 0.1, 5)
SCAN = {
    "R_BS": [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
    "azimuths": [-math.pi, 2 * math.pi / COLUMNS, COLUMNS],
    "elevations": list(LAYERS),
}
LIMITS = (8.0, 8.0, 0.4)
MODES = ("off", "armed", "taking off", "hovering", "ascending", "descending", "cruising", "landing")
WALLS = (7.0, 5.0, 4.0, 6.0)
"""Distance from the origin along x, y, -x and -y [m]."""


class PlayedFlight:
    """A server with a page, in a thread of its own, that ends with `close`.

    Args:
        config: of the server.
        outfit: what the drone has; a lidar, usually.

    Attributes:
        url: of the page.
        commands: applied velocities with yaw rate, and when [s].
        done: flight operations that were carried out.
        hub: the server's.
        authority: who flies.
        now: simulated time [s].
        pace: how fast it goes.
        tells_mode: whether it publishes its mode.
    """

    def __init__(self, config=None, *, lidar=True):
        self.config = config or ServerConfig(port=0, web=True)
        rays = COLUMNS * LAYERS[2] if lidar else 0
        self.outfit = TopicOptions(
            4, 200, 8, rates={"lidar": 10} if lidar else {}, rays=rays, scan=SCAN
        )
        self.topics = {each.id: each for each in drone_topics(self.outfit)}
        self.commands, self.done = [], []
        self.authority = Authority(CommandLimits(*LIMITS))
        self.now, self.pace = 0.0, PACE
        self.place = [0.0, 0.0, 0.1]
        self.yaw, self.velocity, self.yaw_rate = 0.6, (0.0, 0.0, 0.0), 0.0
        self.mode, self.charge = 0, 0.87
        self.tells_mode = True
        self.url, self.hub = "", None
        self._asked, self._said, self._control = [], [], None
        self._ready, self._stop = threading.Event(), threading.Event()
        self._failed = None
        self._thread = threading.Thread(target=self._run)
        self._thread.start()
        self._ready.wait(20)
        if self._failed is not None:
            self._thread.join()
            raise self._failed

    def close(self):
        self._stop.set()
        self._thread.join(20)
        assert not self._thread.is_alive()

    def say(self, severity, said):
        """Send an event to all."""
        self._said.append((severity, said))

    def _run(self):
        try:
            asyncio.run(self._serve())
        except Exception as error:
            self._failed = error
        self._ready.set()

    async def _serve(self):
        flight = ServedFlight("dh_drone", tuple(self.topics.values()), (), LIMITS)
        policy = Policy(flight, self.config.tokens(), self.config.allow_commands)
        # A lease lasts as long for the page, which goes by its own clock.
        policy.__dict__["_limits"] = replace(policy._limits, hold_after=HOLD_AFTER_S / PACE)
        self.hub = Hub(policy, Admission(16, 4), self._asked.append)
        page = web.Page(self.hub, self.config)
        await page.open()
        self.url = page.address
        self._ready.set()
        loop = asyncio.get_running_loop()
        due, count = loop.time(), 0
        while not self._stop.is_set():
            self._step(count)
            self.hub.tick()
            count += 1
            due = max(due + STEP / self.pace, loop.time())
            await asyncio.sleep(due - loop.time())
        self.hub.stop("the flight is over")
        await page.close()

    def _step(self, count):
        self.now = count * STEP
        asked, self._asked[:] = list(self._asked), []
        told = [said for each in asked if (said := self._do(each)) is not None]
        effect = self.authority.effect_due(self.now)
        if effect is not None:
            self.velocity, self.yaw_rate = (0.0, 0.0, 0.0), 0.0
        if effect is SilenceEffect.LAND and self.mode > 1:
            self.mode = 7
        self._move()
        told.append(self._published(count))
        control = self.authority.state(self.now)
        if count % 50 == 0 or replace(control, age=0.0) != self._control:
            self._control = replace(control, age=0.0)
            told.append(control)
        self.hub.hear(told)

    def _do(self, asked):
        """Do what a client asks for, and return the answer."""
        try:
            match asked:
                case VelocityCommand():
                    flown = self.authority.command(asked, self.now)
                    self.velocity, self.yaw_rate = flown.velocity, flown.yaw_rate
                    self.commands.append((self.now, *flown.velocity, flown.yaw_rate))
                    return None
                case ClientRequest(peer, operation):
                    return Reply(peer, self._answer(peer, operation))
                case ClientDisconnected(peer):
                    self.authority.gone(peer)
        except DeniedError as denied:
            if isinstance(asked, VelocityCommand):
                return CommandRefusal(asked.peer, asked.seq, denied.code, str(denied))
            return Reply(asked.peer, Nack(denied.code, str(denied), asked.operation.id))
        return None

    def _answer(self, peer, operation):
        match operation:
            case RequestControl(id, name):
                granted = self.authority.request(peer, name, self.now)
                return RequestControl(id, lease=granted, expires=0.5)
            case ReleaseControl(id, lease):
                self.authority.check(peer, lease, self.now)
                self.authority.release(self.now)
                return ReleaseControl(id)
            case FlightOperation(id, what, _, lease):
                self.authority.check(peer, lease, self.now)
                if what == "land" and self.mode < 2:
                    raise DeniedError("not_now", "the drone is on the ground")
                self.mode = {"arm": 1, "take_off": 2, "land": 7, "stop": 0}[what]
                self.done.append(what)
                return FlightDone(id, what, round(self.now * 1e9))
        raise TypeError(operation)

    def _move(self):
        if self.mode == 2:
            self.place[2] += CLIMB * STEP
            self.mode = 3 if self.place[2] >= 1.5 else 2
        elif self.mode == 7:
            self.place[2] = max(0.1, self.place[2] - CLIMB * STEP)
            self.mode = 0 if self.place[2] == 0.1 else 7
        elif self.mode > 2:
            self.mode = 6 if math.hypot(*self.velocity) > 0.05 else 3
            self.place = [p + v * STEP for p, v in zip(self.place, self.velocity, strict=True)]
            self.yaw += self.yaw_rate * STEP

    def _published(self, count):
        moving = self.velocity if self.mode > 2 else (0.0, 0.0, 0.0)
        ahead = math.cos(self.yaw) * moving[0] + math.sin(self.yaw) * moving[1]
        left = math.cos(self.yaw) * moving[1] - math.sin(self.yaw) * moving[0]
        angles = (-0.08 * left, 0.08 * ahead, self.yaw)
        values = {
            topic.POSITION_SIGNAL.id: (*self.place, *angles, *self.place),
            topic.VELOCITY_SIGNAL.id: (*moving, 0.0, 0.0, self.yaw_rate),
        }
        if count % 6 == 0 and self.tells_mode:
            values[topic.DRONE_STATE_SIGNAL.id] = (
                self.mode,
                MODES[self.mode],
                self.charge,
                math.inf,
            )
        if count % 5 == 0 and topic.LIDAR_CLOUD_SIGNAL.id in self.topics:
            values[topic.LIDAR_CLOUD_SIGNAL.id] = (round(self.now * 1e9), self._ranges(*angles))
        payloads = [(id, self.topics[id].pack(each)) for id, each in values.items()]
        payloads += [
            (topic.EVENTS_SIGNAL.id, self.topics[topic.EVENTS_SIGNAL.id].pack(said))
            for said in self._said
        ]
        self._said.clear()
        return Published(round(self.now * 1e9), 0, tuple(payloads))

    def _ranges(self, roll, pitch, yaw):
        """Return how far the walls and the ground are along the rays of a level drone."""
        first, step, layers = LAYERS
        found = []
        for layer in range(layers):
            elevation = first + layer * step
            for column in range(COLUMNS):
                angle = yaw - math.pi + column * 2 * math.pi / COLUMNS
                cos, sin = math.cos(angle), math.sin(angle)
                x = (
                    (WALLS[0] - self.place[0]) / cos
                    if cos > 0
                    else (-WALLS[2] - self.place[0]) / cos
                )
                y = (
                    (WALLS[1] - self.place[1]) / sin
                    if sin > 0
                    else (-WALLS[3] - self.place[1]) / sin
                    if sin
                    else math.inf
                )
                level = min(x, y) / math.cos(elevation)
                ground = self.place[2] / -math.sin(elevation) if elevation < -1e-6 else math.inf
                found.append(min(level, ground))
        return found

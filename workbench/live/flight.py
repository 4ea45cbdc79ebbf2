"""A live flight as its caller sees it: orders that never block, and the newest snapshot."""

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future
from pathlib import Path
from types import TracebackType
from typing import Any, Self

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerProcess
from workbench.link.backplane import Disconnect, Published
from workbench.link.server.config import ServerConfig
from workbench.live.choice import Choice
from workbench.live.messages import (
    CLOSE,
    Begin,
    Do,
    Failed,
    Flown,
    Order,
    Phase,
    Report,
    Streamed,
)
from workbench.live.view import LiveView
from workbench.scenario.excitation import Excitation
from workbench.scenario.scenario import FARTHEST, Action, Gust, Injection, Push, Scenario
from workbench.session.checkpoint import Checkpoint
from workbench.session.pilot_numbers import finite
from workbench.systems.sensors.readings import Reading

LOOK = 0.1
"""Period between checks of a starting flight [s]."""
QUIET = 2.0
"""A start that takes longer than this reports its progress [s]."""
CLOSING = 3.0
"""Time limit for the process to exit by itself [s]."""
MOST_WAITING = 1000
"""Limit of orders without an answer; further ones are refused."""
MOST_STREAMED = 4000
"""Number of kept samples for charts, about 20 s; then the oldest ones are dropped."""


class LiveFlight:
    """Flies a scenario in real time, in a process of its own.

    The flight begins at once, and continues past the scenario's duration until it is closed. Only
    `wait` and `close` block. An order returns a Future of the simulated time at which it took
    effect [s], between two steps, or of the requested value. Its exception is a WorkbenchError that
    says why it was refused. When it is done, `latest` shows its effect.

    Args:
        scenario: what to fly, as a scenario, or as a name with changes that the process reads; the
            default one hovers.
        settings: parameter values that override those of the scenario's gains.
        draw: whether the flight is drawn in Meshcat, at `latest().url`.
        stream: whether `streamed` is used; then `flown` has almost no recording.
        watch: whether the controller's file is loaded again, in flight, whenever it is saved.

    Raises:
        WorkbenchError: if no process can be started, or the scenario cannot be sent to it. `wait`
            reports errors in the scenario.
    """

    def __init__(
        self,
        scenario: Scenario | Choice | None = None,
        settings: Mapping[str, float] | None = None,
        *,
        draw: bool = False,
        stream: bool = False,
        watch: bool = False,
    ) -> None:
        self._view = LiveView()
        self._begun = threading.Event()  # set once the flight has begun, or has ended early
        self._streamed: deque[Published] = deque(maxlen=MOST_STREAMED)
        self._missed = 0
        self._failed = Failed("")
        self._process = WorkerProcess(
            "workbench.live.worker", "flight", self._hear, self._end, MOST_WAITING
        )
        self._order: Callable[[Callable[[], Action | Order]], Future[Any]] = self._process.ask
        try:
            self._process.send(
                Begin(scenario or Scenario(), dict(settings or {}), draw, stream, watch)
            )
        except Exception as error:  # a user's object may fail in any way
            self._process.close()
            raise WorkbenchError(f"the scenario cannot be sent to a process: {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self,
        kind: type[BaseException] | None,
        error: BaseException | None,
        trace: TracebackType | None,
    ) -> None:
        self.close()

    @property
    def pid(self) -> int:
        """Process ID."""
        return self._process.pid

    def latest(self) -> LiveView:
        """Return the newest view that arrived here."""
        return self._view

    def streamed(self) -> list[Published]:
        """Return what was published since the last call, at most the last 20 s or so.

        Each item has the topics of one time; `latest().topics` unpack their payloads.
        """
        return [self._streamed.popleft() for _ in range(len(self._streamed))]

    @property
    def missed(self) -> int:
        """Number of times that `streamed` has lost in all, as it was not called soon enough."""
        return self._missed

    def wait(self, limit: float = 120.0, progress: Callable[[str], None] | None = None) -> LiveView:
        """Wait until the flight has begun, and return its first view.

        Args:
            limit: longest time without news [s].
            progress: called with each sentence about the progress, from 2 s on.

        Raises:
            WorkbenchError: if the flight cannot begin, or there is no news for that time.
        """
        began = news = time.monotonic()
        said = told = ""
        while not self._begun.wait(LOOK):
            present = self.latest().said
            if present != said:
                said, news = present, time.monotonic()
            if time.monotonic() - news > limit:
                raise WorkbenchError(
                    f"the flight has not begun, and sent no message for {limit:g} s: {said}"
                )
            if progress and said != told and time.monotonic() - began > QUIET:
                told = said
                progress(said)
        view = self.latest()
        if view.phase is Phase.ENDED:
            raise WorkbenchError(view.said)
        return view

    def set(self, name: str, value: float) -> Future[float]:
        """Set a live parameter."""
        return self._order(lambda: Action(set={_text("parameter", name): _number(name, value)}))

    def set_all(self, values: Mapping[str, float]) -> Future[float]:
        """Set live parameters by name at one step; if one is refused, none is set."""
        return self._order(
            lambda: Action(
                set={
                    _text("parameter", name): _number(name, value) for name, value in values.items()
                }
            )
        )

    def command(
        self, velocity: Sequence[float] | None = None, yaw_rate: float | None = None
    ) -> Future[float]:
        """Command a velocity in W [m/s] and a yaw rate [rad/s]; None leaves a value unchanged."""
        return self._order(
            lambda: Action(
                velocity=None if velocity is None else _triple("velocity", velocity),
                yaw_rate=None if yaw_rate is None else _number("yaw rate", yaw_rate),
            )
        )

    def go_to(self, p_WB: Sequence[float]) -> Future[float]:
        """Fly to a position in W [m] and stay there."""
        return self._order(lambda: Action(go_to=_triple("position", p_WB)))

    def request(self, what: str, height: float = Action.height) -> Future[float]:
        """Request arm, take_off (to a height [m]), hold, land, or stop."""
        return self._order(lambda: Action(request=_text("request", what), height=_height(height)))

    def gust(self, velocity: Sequence[float], duration: float = 1.0) -> Future[float]:
        """Start a gust, rising to a velocity in W [m/s] and falling, within a duration [s]."""
        return self._order(
            lambda: Action(gust=Gust(_triple("gust", velocity), _number("gust_duration", duration)))
        )

    def push(
        self,
        force: Sequence[float],
        point: Sequence[float] = (0.0, 0.0, 0.0),
        duration: float = 0.1,
        torque: Sequence[float] = (0.0, 0.0, 0.0),
    ) -> Future[float]:
        """Push for a duration [s], see `Session.push`."""
        return self._order(
            lambda: Action(
                push=Push(
                    _triple("push", force),
                    _triple("point of the push", point),
                    _number("push_duration", duration),
                    _triple("torque of the push", torque),
                )
            )
        )

    def fly_controller(self, name_or_path: Path | str) -> Future[float]:
        """Switch to another controller in flight, see `Session.fly_controller`."""
        return self._order(lambda: Action(controller=_named(name_or_path)))

    def excite(self, excitation: Excitation) -> Future[float]:
        """Fly an excitation; the answer is its start time, with the next control update [s].

        It ends with any other flight command, as `command` or `request`, when someone else takes
        control, and when the drone no longer flies; then the drone hovers in place.
        """
        return self._order(lambda: Order(Do.EXCITE, _excitation(excitation)))

    def measure(self, injection: Injection, *, hold: bool) -> Future[float]:
        """Measure a loop by an injection; the answer is its start time [s].

        `LiveView.measured` has the measurement after each of its periods. It ends as an excitation
        does, and the drone returns to its start.

        Args:
            injection: see `design.judge.loop_measurement`.
            hold: whether the loop is one that holds a place.
        """
        return self._order(lambda: Order(Do.MEASURE, (injection, hold)))

    def stop_exciting(self) -> Future[float]:
        """End an excitation or a measurement, if one is flown, and hover in place."""
        return self._order(lambda: Order(Do.STOP_EXCITING))

    def reset(self) -> Future[float]:
        """Restart from the scenario's start, with its initial parameter values."""
        return self._order(lambda: Order(Do.RESET))

    def pause(self) -> Future[float]:
        """Pause simulated time."""
        return self._order(lambda: Order(Do.PAUSE))

    def resume(self) -> Future[float]:
        """Resume simulated time."""
        return self._order(lambda: Order(Do.RESUME))

    def set_speed(self, factor: float) -> Future[float]:
        """Set the number of simulated seconds per second, 0.01 to 20."""
        return self._order(lambda: Order(Do.SET_SPEED, _number("speed", factor)))

    def fly_on(self, duration: float) -> Future[float]:
        """Fly on for a time [s], up to 60, as fast as possible; only while paused."""
        return self._order(lambda: Order(Do.FLY_ON, _number("duration", duration)))

    def foresee(self, ends: float, p_WB: np.ndarray) -> Future[float]:
        """Draw a predicted path in Meshcat, until a simulated time [s]."""
        return self._order(lambda: Order(Do.FORESEE, (float(ends), np.asarray(p_WB, dtype=float))))

    def get(self, name: str) -> Future[float]:
        """Request the present value of a live parameter."""
        return self._order(lambda: Order(Do.GET, _text("parameter", name)))

    def reading(self, sensor: str) -> Future[Reading | None]:
        """Request the last delivered reading of a sensor, by name or kind; None if nothing yet."""
        return self._order(lambda: Order(Do.READ, _text("sensor", sensor)))

    def flown(self) -> Future[Flown]:
        """Request everything flown since the start, and the scenario that repeats it."""
        return self._order(lambda: Order(Do.GET_FLOWN))

    def checkpoint(self) -> Future[Checkpoint]:
        """Request the state that determines the rest of the flight, see `Session.begin_from`."""
        return self._order(lambda: Order(Do.GET_CHECKPOINT))

    instant = checkpoint
    """The name of `checkpoint` in earlier versions."""

    def serve(self, config: ServerConfig | None = None) -> Future[str]:
        """Let clients watch and fly; the answer is the server's address."""
        return self._order(lambda: Order(Do.SERVE, _checked(config or ServerConfig())))

    def stop_serving(self) -> Future[float]:
        """Disconnect all clients and end the server."""
        return self._order(lambda: Order(Do.STOP_SERVING))

    def take_over(self) -> Future[float]:
        """Take control for the operator; a command given here does that, too."""
        return self._order(lambda: Order(Do.TAKE_OVER))

    def give_back(self) -> Future[float]:
        """Allow clients to request control again."""
        return self._order(lambda: Order(Do.GIVE_BACK))

    def disconnect(self, peer: int, reason: str = "the operator ended it") -> Future[float]:
        """Disconnect a client, by its number in `latest().network.server.clients`."""
        return self._order(lambda: Order(Do.DISCONNECT, Disconnect(peer, reason)))

    def keep_log(self, path: Path | str) -> Future[str]:
        """Write a log (MCAP) from now on; after a reset it continues in the next file."""
        return self._order(lambda: Order(Do.KEEP_LOG, str(Path(path).absolute())))

    def stop_log(self) -> Future[str]:
        """End the log; the answer is its path."""
        return self._order(lambda: Order(Do.STOP_LOG))

    def close(self, limit: float = CLOSING) -> None:
        """End the flight; kill its process if that takes longer than a time [s].

        The process is killed at once if nothing was flown yet.
        """
        self._process.close(limit if self._begun.is_set() else 0.0, CLOSE)

    def _hear(self, message: object) -> None:
        match message:
            case Streamed(published, lost):
                full = len(self._streamed) + len(published) - MOST_STREAMED
                self._missed += lost + max(0, full)
                self._streamed.extend(published)
            case Failed():
                self._failed = message
            case _:
                self._view = self._view.after(message)
                if isinstance(message, Report):
                    self._begun.set()

    def _end(self, reason: str) -> str:
        """Mark the flight as ended, and return why."""
        said = self._failed.said or reason
        self._view = self._view.ended(said, self._failed.needed)
        self._begun.set()
        return said


def _checked(config: ServerConfig) -> ServerConfig:
    config.check()
    return config


def _excitation(excitation: Excitation) -> Excitation:
    excitation.check()
    return excitation


def _number(what: str, value: float) -> float:
    return finite(what, [value], 1)[0]


def _height(value: float) -> float:
    height = _number("height", value)
    if height <= 0.0:
        raise WorkbenchError(f"the height is {height:g} m: give it one above the ground")
    return height


def _triple(what: str, values: Sequence[float]) -> list[float]:
    """Return three numbers that a script can hold."""
    x, y, z = finite(what, values, 3)
    if max(abs(x), abs(y), abs(z)) > FARTHEST:
        raise WorkbenchError(f"{what} is {values!r:.60}: give it numbers within ±{FARTHEST:g}")
    return [x, y, z]


def _named(name_or_path: Path | str) -> str:
    """Return a controller's name, or the absolute path of its file."""
    name = str(name_or_path)
    return str(Path(name).absolute()) if name.endswith(".py") else name


def _text(what: str, value: object) -> str:
    """Return a name as text; the argument may be anything."""
    if not isinstance(value, str):
        raise WorkbenchError(f"the {what} is {value!r:.60}: give its name")
    return value

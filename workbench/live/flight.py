"""A live flight as its caller sees it: orders that never block, and the newest snapshot."""

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from concurrent.futures import Future
from pathlib import Path
from typing import Self

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.ipc.worker_process import WorkerProcess
from workbench.link.backplane import DISCONNECT_REASON, Disconnect, Published
from workbench.link.server.config import ServerConfig
from workbench.live.choice import Choice
from workbench.live.messages import (
    CLOSE_MESSAGE,
    FlightFailure,
    FlightReport,
    FlightStart,
    FlownSoFar,
    Phase,
    StreamedRecords,
)
from workbench.live.orders import (
    FlightOrder,
    FlyOn,
    GetParameter,
    GetReading,
    KeepLog,
    LiveOrder,
    MeasureLoop,
    NetworkOrder,
    SetSpeed,
    ShowPrediction,
)
from workbench.live.view import LiveView
from workbench.scenario.excitation import Excitation
from workbench.scenario.pilot_orders import PilotOrders
from workbench.scenario.scenario import Action, Injection, Scenario
from workbench.session.checkpoint import Checkpoint
from workbench.systems.sensors.readings import Reading

START_POLL_PERIOD_S = 0.1
"""Period between checks of a starting flight [s]."""
QUIET_START_S = 2.0
"""A start that takes longer than this reports its progress [s]."""
FLIGHT_EXIT_TIMEOUT_S = 3.0
"""Time limit for the process to exit by itself [s]."""
MAX_WAITING_ORDERS = 1000
"""Limit of orders without an answer; further ones are refused."""
MAX_STREAMED_SAMPLES = 4000
"""Number of kept samples for charts, about 20 s; then the oldest ones are dropped."""


class LiveFlight(WorkerProcess[LiveOrder], PilotOrders[Future[float]]):
    """Flies a scenario in real time, in a process of its own.

    The flight begins at once, and continues past the scenario's duration until it is closed. Only
    `wait` and `close` block. `do` takes an `Action`, or another record of `workbench.live.orders`,
    and returns a Future of the simulated time at which it took effect [s], between two steps, or of
    the requested value. Its exception is a WorkbenchError that says why it was refused. When it is
    done, `latest` shows its effect.

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
        self._streamed: deque[Published] = deque(maxlen=MAX_STREAMED_SAMPLES)
        self._missed = 0
        self._failed = FlightFailure("")
        super().__init__(
            "workbench.live.worker", "flight", self._take_news, self._note_end, MAX_WAITING_ORDERS
        )
        try:
            self.send(
                FlightStart(scenario or Scenario(), dict(settings or {}), draw, stream, watch)
            )
        except Exception as error:  # a user's object may fail in any way
            self.close()
            raise WorkbenchError(f"the scenario cannot be sent to a process: {error}") from error

    def __enter__(self) -> Self:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

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
        while not self._begun.wait(START_POLL_PERIOD_S):
            present = self.latest().said
            if present != said:
                said, news = present, time.monotonic()
            if time.monotonic() - news > limit:
                raise WorkbenchError(
                    f"the flight has not begun, and sent no message for {limit:g} s: {said}"
                )
            if progress and said != told and time.monotonic() - began > QUIET_START_S:
                told = said
                progress(said)
        view = self.latest()
        if view.phase is Phase.ENDED:
            raise WorkbenchError(view.said)
        return view

    def fly_controller(self, name_or_path: Path | str) -> Future[float]:
        """Switch to another controller in flight, see `Session.fly_controller`."""
        name = str(name_or_path)
        path = str(Path(name).absolute()) if name.endswith(".py") else name
        return self.do(Action(controller=path))

    def excite(self, excitation: Excitation) -> Future[float]:
        """Fly an excitation; the answer is its start time, with the next control update [s].

        It ends with any other flight command, as `command` or `request`, when someone else takes
        control, and when the drone no longer flies; then the drone hovers in place.
        """
        return self.do(excitation)

    def measure(self, injection: Injection, *, hold: bool) -> Future[float]:
        """Measure a loop, see `MeasureLoop`."""
        return self.do(MeasureLoop(injection, hold))

    def stop_exciting(self) -> Future[float]:
        """End an excitation or a measurement, if one is flown, and hover in place."""
        return self.do(FlightOrder.STOP_EXCITING)

    def reset(self) -> Future[float]:
        """Restart from the scenario's start, with its initial parameter values."""
        return self.do(FlightOrder.RESET)

    def pause(self) -> Future[float]:
        """Pause simulated time."""
        return self.do(FlightOrder.PAUSE)

    def resume(self) -> Future[float]:
        """Resume simulated time."""
        return self.do(FlightOrder.RESUME)

    def set_speed(self, factor: float) -> Future[float]:
        """Set the number of simulated seconds per second, 0.01 to 20."""
        return self.do(SetSpeed(factor))

    def fly_on(self, duration: float) -> Future[float]:
        """Fly on for a time [s], up to 60, as fast as possible; only while paused."""
        return self.do(FlyOn(duration))

    def foresee(self, ends: float, p_WB: np.ndarray) -> Future[float]:
        """Draw a predicted path in Meshcat, until a simulated time [s]."""
        return self.do(ShowPrediction(float(ends), np.asarray(p_WB, dtype=float)))

    def get(self, name: str) -> Future[float]:
        """Request the present value of a live parameter."""
        return self.do(GetParameter(str(name)))

    def reading(self, sensor: str) -> "Future[Reading | None]":
        """Request the last delivered reading of a sensor, by name or kind; None if nothing yet."""
        return self.do(GetReading(str(sensor)))

    def flown(self) -> Future[FlownSoFar]:
        """Request everything flown since the start, and the scenario that repeats it."""
        return self.do(FlightOrder.GET_FLOWN)

    def checkpoint(self) -> "Future[Checkpoint]":
        """Request the state that determines the rest of the flight, see `Session.begin_from`."""
        return self.do(FlightOrder.GET_CHECKPOINT)

    instant = checkpoint
    """The name of `checkpoint` in earlier versions."""

    def serve(self, config: ServerConfig | None = None) -> Future[str]:
        """Let clients watch and fly; the answer is the server's address."""
        return self.do(config or ServerConfig())

    def stop_serving(self) -> Future[float]:
        """Disconnect all clients and end the server."""
        return self.do(NetworkOrder.STOP_SERVING)

    def take_over(self) -> Future[float]:
        """Take control for the operator; a command given here does that, too."""
        return self.do(NetworkOrder.TAKE_OVER)

    def give_back(self) -> Future[float]:
        """Allow clients to request control again."""
        return self.do(NetworkOrder.GIVE_BACK)

    def disconnect(self, peer: int, reason: str = DISCONNECT_REASON) -> Future[float]:
        """Disconnect a client, by its number in `latest().network.server.clients`."""
        return self.do(Disconnect(peer, reason))

    def keep_log(self, path: Path | str) -> Future[str]:
        """Write a log (MCAP) from now on; after a reset it continues in the next file."""
        return self.do(KeepLog(str(Path(path).absolute())))

    def stop_log(self) -> Future[str]:
        """End the log; the answer is its path."""
        return self.do(NetworkOrder.STOP_LOG)

    def close(self, limit: float = FLIGHT_EXIT_TIMEOUT_S, last: object = CLOSE_MESSAGE) -> None:
        """End the flight; kill its process if that takes longer than a time [s].

        The process is killed at once if nothing was flown yet.
        """
        super().close(limit if self._begun.is_set() else 0.0, last)

    def _take_news(self, message: object) -> None:
        match message:
            case StreamedRecords(published, lost):
                full = len(self._streamed) + len(published) - MAX_STREAMED_SAMPLES
                self._missed += lost + max(0, full)
                self._streamed.extend(published)
            case FlightFailure():
                self._failed = message
            case _:
                self._view = self._view.after(message)
                if isinstance(message, FlightReport):
                    self._begun.set()

    def _note_end(self, reason: str) -> str:
        """Mark the flight as ended, and return why."""
        said = self._failed.said or reason
        self._view = self._view.ended(said, self._failed.needed)
        self._begun.set()
        return said

"""Three shapes of a live flight: by a timer of the window, in a thread, in a process."""

import os
import queue
import threading
import time
from abc import ABC, abstractmethod
from pathlib import Path

from PyQt6.QtCore import Qt, QTimer

from workbench.live.flight import LiveFlight
from workbench.scenario.scenario import Scenario
from workbench.session.session import Session
from workbench.session.snapshot import Snapshot

TICK = 1 / 60


class Shape(ABC):
    """A flight beside a screen."""

    lags: list[float]

    @abstractmethod
    def latest(self) -> Snapshot | None:
        """Return the newest snapshot."""

    @abstractmethod
    def command(self, velocity: float) -> None:
        """Ask for a velocity along x."""

    @abstractmethod
    def close(self) -> None:
        """End it."""

    def busy(self) -> float:
        """Return the time of processor of a process of its own [s]."""
        return 0.0


class InThisProcess(Shape):
    """Flies what is due whenever `tick` is called."""

    def __init__(self, scenario: Scenario) -> None:
        self._session = Session(scenario)
        self._session.tick(0.5)  # compiled code is slow the first time
        self._session.reset()
        self._commands: queue.SimpleQueue[float] = queue.SimpleQueue()
        self._snapshot = self._session.snapshot()
        self.lags = []
        self._begun = time.perf_counter()

    def tick(self) -> None:
        while not self._commands.empty():
            self._session.command([self._commands.get(), 0.0, 0.0])
        lag = time.perf_counter() - self._begun - self._session.time
        self.lags.append(lag)
        self._session.tick(max(0.0, lag))
        self._snapshot = self._session.snapshot()

    def latest(self) -> Snapshot | None:
        return self._snapshot

    def command(self, velocity: float) -> None:
        self._commands.put(velocity)


class ByTimer(InThisProcess):
    """In the window's thread."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        self._timer = QTimer()
        self._timer.setTimerType(Qt.TimerType.PreciseTimer)
        self._timer.timeout.connect(self.tick)
        self._timer.start(round(1000 * TICK))

    def close(self) -> None:
        self._timer.stop()


class InThread(InThisProcess):
    """In a thread beside the window's."""

    def __init__(self, scenario: Scenario) -> None:
        super().__init__(scenario)
        self._ended = threading.Event()
        self._thread = threading.Thread(target=self._run)
        self._thread.start()

    def close(self) -> None:
        self._ended.set()
        self._thread.join()

    def _run(self) -> None:
        due = time.perf_counter()
        while not self._ended.is_set():
            self.tick()
            due = max(due + TICK, time.perf_counter())
            self._ended.wait(due - time.perf_counter())


class InProcess(Shape):
    """In a process of its own."""

    def __init__(self, scenario: Scenario) -> None:
        self._flight = LiveFlight(scenario)
        self._flight.wait()
        self.lags = []

    def latest(self) -> Snapshot | None:
        view = self._flight.latest()
        if view.pace:
            self.lags.append(view.pace.lag)  # the worst since the report before
        return view.snapshot

    def command(self, velocity: float) -> None:
        self._flight.command([velocity, 0.0, 0.0])

    def close(self) -> None:
        self._flight.close()

    def busy(self) -> float:
        stat = Path(f"/proc/{self._flight.pid}/stat").read_text(encoding="utf-8")
        user, system = stat.rpartition(")")[2].split()[11:13]
        return (int(user) + int(system)) / os.sysconf("SC_CLK_TCK")


SHAPES: dict[str, type[ByTimer | InThread | InProcess]] = {
    "timer": ByTimer,
    "thread": InThread,
    "process": InProcess,
}

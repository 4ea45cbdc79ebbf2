"""Tasks for tests; processes of pools and clusters import them by this file's name."""

import logging
import os
import signal
import time
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from workbench.common.errors import WorkbenchError


@dataclass(frozen=True)
class Square:
    """Gives the square of a number after some seconds; the number 13 is refused."""

    number: int
    seconds: float = 0.0

    @property
    def scenario(self) -> Any:
        from workbench.scenario.scenario import Scenario

        return Scenario()

    def with_scenario(self, scenario: Any) -> "Square":
        return self

    def run(self) -> int:
        if self.number == 13:
            raise WorkbenchError("13 has no square: take another number")
        time.sleep(self.seconds)
        return self.number**2


@dataclass(frozen=True)
class Remarking(Square):
    """The same, with a remark."""

    def run(self) -> int:
        logging.getLogger("workbench.progress").warning("squaring %d", self.number)
        return super().run()


@dataclass(frozen=True)
class Deadly:
    """A task during which the process that begins it first is killed, as one without memory is."""

    task: Any
    marker: Path

    @property
    def scenario(self) -> Any:
        return self.task.scenario

    def with_scenario(self, scenario: Any) -> "Deadly":
        return Deadly(self.task.with_scenario(scenario), self.marker)

    def run(self) -> Any:
        try:
            self.marker.touch(exist_ok=False)
        except FileExistsError:
            return self.task.run()
        return os.kill(os.getpid(), signal.SIGKILL)


@dataclass(frozen=True)
class Losing:
    """An executor that loses a process on the way: once for all tasks."""

    executor: Any
    marker: Path

    def run(self, tasks: Sequence[Any], stop: Any = None) -> Iterator[tuple[int, Any]]:
        return self.executor.run([Deadly(task, self.marker) for task in tasks], stop)


@dataclass(frozen=True)
class Reading:
    """Gives the path and the text of a scenario's gain file; an empty one is refused."""

    scenario: Any

    def with_scenario(self, scenario: Any) -> "Reading":
        return Reading(scenario)

    def run(self) -> tuple[str, str]:
        path = Path(self.scenario.vehicle.gains)
        text = path.read_text()
        if "mute" in text:
            raise WorkbenchError(f"{path}:1: it is mute: write something else")
        return str(path), text


@dataclass(frozen=True)
class Signalled(Square):
    """The same, in a process that a terminal or a batch system asks to end meanwhile."""

    def run(self) -> int:
        for number in (signal.SIGINT, signal.SIGTERM, signal.SIGHUP):
            os.kill(os.getpid(), number)
        return super().run()

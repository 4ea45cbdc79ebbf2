"""The log of a live flight, begun and ended at any time, and the history of what was done."""

import math
from array import array
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.link.backplane import Published, Sampled
from workbench.scenario.scenario import Action
from workbench.session.session import Session

if TYPE_CHECKING:
    from workbench.logs.flight_log import FlightLog

WIDTH = 5
"""Numbers of a command: time, velocity, yaw rate."""


class LogKeeper:
    """Keeps what was done since the start, and writes a log where one is wanted.

    Args:
        session: that is flown.
        settings: values that it was built with, which no scenario has.
        values: all live parameters at the start.

    Attributes:
        done: actions since the start, and who wanted them.
        said: why a log ended by itself, "" else.
    """

    def __init__(
        self, session: Session, settings: Mapping[str, float], values: Mapping[str, float]
    ) -> None:
        self._session, self._settings, self._values = session, settings, values
        self._laws = [session.controller]  # of the start, and those that took over
        self._log: FlightLog | None = None
        self._flights = 1
        self._first: Path | None = None
        self.done = History()
        self.said = ""

    @property
    def path(self) -> str:
        """Where it writes, "" if nowhere."""
        return str(self._log.path) if self._log else ""

    def start(self, path: str) -> str:
        """Write a log from now on, with all that was done before; return its path.

        Raises:
            WorkbenchError: if there is one already, or it cannot be written.
        """
        if self._log:
            raise WorkbenchError(f"the log {self._log.path} is being written: stop it first")
        self._first, self._flights = Path(path), 1
        self._open(self._first)
        return self.path

    def stop(self) -> str:
        """End the log, if there is one, and return its path; "" where it is not whole."""
        if self._log:
            path = self.path
            self._log.close()
            self._take_end()
            if self._log:
                self._log = None
                return path
        return ""

    def look(self) -> None:
        """Notice that a log's file was moved or deleted, in a pause, too."""
        if self._log:
            self._log.look()
            self._take_end()

    def act(self, action: Action, by: str) -> None:
        """Keep what came into force."""
        self.done.append(action, by)
        if action.controller is not None:
            self._laws.append(self._session.controller)
        if self._log:
            self._log.act(action.at, action, by, self._laws[-1])

    def write(self, sampled: Sampled) -> None:
        """Keep a sample."""
        if self._log:
            self._log.write(sampled)
            self._take_end()

    def publish(self, published: Published) -> None:
        """Keep what was published besides samples."""
        if self._log:
            self._log.publish(published)
            self._take_end()

    def begin_anew(self) -> None:
        """Begin with a new flight: a log goes on in the next file, as `flight-2.mcap`."""
        self.done.clear()
        self._laws = [self._session.controller]
        self._values = self._session.parameters()
        if self._log and self._first and self.stop():
            try:
                self._open(self._next_path(self._first))
            except WorkbenchError as error:
                self.said = str(error)

    def _next_path(self, first: Path) -> Path:
        """Return the next name that no file has: what was logged yesterday stays."""
        while True:
            self._flights += 1
            path = first.with_name(f"{first.stem}-{self._flights}{first.suffix}")
            if not path.exists():
                return path

    def _open(self, path: Path) -> None:
        from workbench.logs.flight_log import FlightLog  # most flights have no log

        session = self._session
        self.said = ""
        self._log = FlightLog(
            path,
            session.topics,
            session.scenario,
            self._settings,
            self._values,
            session.vehicle.name,
            self._laws[0],
        )
        laws = iter(self._laws)
        law = next(laws)
        for action, by in self.done:
            law = law if action.controller is None else next(laws)
            self._log.act(action.at, action, by, law)

    def _take_end(self) -> None:
        """Notice that a log ended by itself: a disk that is full does not end the flight."""
        if self._log and self._log.said:
            self.said = self._log.said
            self._log = None


class History:
    """Actions since the flight's start, and who wanted them, in little memory.

    A pilot may steer for hours: a command, of which there may be a hundred a second, is kept as
    five numbers; anything else as it is.
    """

    def __init__(self) -> None:
        self._numbers = array("d")
        self._others: dict[int, Action] = {}
        self._who = array("I")
        self._names: list[str] = []

    def __len__(self) -> int:
        return len(self._who)

    def __iter__(self) -> Iterator[tuple[Action, str]]:
        for index, who in enumerate(self._who):
            yield self._action(index), self._names[who]

    @property
    def actions(self) -> list[Action]:
        """The actions alone."""
        return [action for action, _ in self]

    def append(self, action: Action, by: str) -> None:
        """Keep an action that came into force at its time."""
        if by not in self._names:
            self._names.append(by)
        if _is_command(action):
            assert action.velocity is not None and action.yaw_rate is not None
            self._numbers.extend((action.at, *action.velocity, action.yaw_rate))
        else:
            self._others[len(self._who)] = action
            self._numbers.extend([math.nan] * WIDTH)
        self._who.append(self._names.index(by))

    def clear(self) -> None:
        """Forget all."""
        del self._numbers[:]
        del self._who[:]
        self._others.clear()
        self._names.clear()

    def _action(self, index: int) -> Action:
        if index in self._others:
            return self._others[index]
        at, x, y, z, yaw_rate = self._numbers[WIDTH * index : WIDTH * (index + 1)]
        return Action(at, velocity=[x, y, z], yaw_rate=yaw_rate)


def _is_command(action: Action) -> bool:
    """Return whether a velocity and a yaw rate are all that an action has."""
    if action.velocity is None or action.yaw_rate is None:
        return False
    return action == Action(action.at, velocity=action.velocity, yaw_rate=action.yaw_rate)

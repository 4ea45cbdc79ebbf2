"""The log of a live flight, started and ended at any time, and the history of actions."""

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

NUMBERS_PER_COMMAND = 5
"""Numbers per command: time, velocity, yaw rate."""


class LogKeeper:
    """Keeps the actions since the start, and writes a log on request.

    Args:
        session: the flown session.
        settings: parameter values that the session was built with beside the scenario's.
        values: all live parameters at the start.

    Attributes:
        done: actions since the start, and who requested them.
        said: why a log ended by itself, else "".
    """

    def __init__(
        self, session: Session, settings: Mapping[str, float], values: Mapping[str, float]
    ) -> None:
        self._session, self._settings, self._values = session, settings, values
        self._laws = [session.controller]  # of the start, and of the laws that followed
        self._log: FlightLog | None = None
        self._flights = 1
        self._first: Path | None = None
        self.done = ActionHistory()
        self.said = ""

    @property
    def path(self) -> str:
        """Path of the log, "" without one."""
        return str(self._log.path) if self._log else ""

    def start(self, path: str) -> str:
        """Start a log now, with all earlier actions; return its path.

        Raises:
            WorkbenchError: if there is one already, or the file cannot be written.
        """
        if self._log:
            raise WorkbenchError(f"the log {self._log.path} is being written: stop it first")
        self._first, self._flights = Path(path), 1
        self._open(self._first)
        return self.path

    def stop(self) -> str:
        """End the log, if there is one, and return its path; "" if it is incomplete."""
        if self._log:
            path = self.path
            self._log.close()
            self._take_end()
            if self._log:
                self._log = None
                return path
        return ""

    def look(self) -> None:
        """Notice that a log's file was moved or deleted, also while paused."""
        if self._log:
            self._log.look()
            self._take_end()

    def act(self, action: Action, by: str) -> None:
        """Keep an action that took effect."""
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
        """Keep published data other than samples."""
        if self._log:
            self._log.publish(published)
            self._take_end()

    def begin_anew(self) -> None:
        """Start again with a new flight: the log continues in the next file, as `flight-2.mcap`."""
        self.done.clear()
        self._laws = [self._session.controller]
        self._values = self._session.parameters()
        if self._log and self._first and self.stop():
            try:
                self._open(self._next_path(self._first))
            except WorkbenchError as error:
                self.said = str(error)

    def _next_path(self, first: Path) -> Path:
        """Return the next free name: existing logs stay."""
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
            session.vehicle.published_joint_units,
        )
        laws = iter(self._laws)
        law = next(laws)
        for action, by in self.done:
            law = law if action.controller is None else next(laws)
            self._log.act(action.at, action, by, law)

    def _take_end(self) -> None:
        """Notice that a log ended by itself: a full disk does not end the flight."""
        if self._log and self._log.said:
            self.said = self._log.said
            self._log = None


class ActionHistory:
    """Actions since the flight's start, and who requested them, in little memory.

    A pilot may steer for hours with a hundred commands a second, so a command is kept as five
    numbers; any other action is kept as it is.
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
        """Append an action that took effect at its time."""
        if by not in self._names:
            self._names.append(by)
        if _is_command(action):
            assert action.velocity is not None and action.yaw_rate is not None
            self._numbers.extend((action.at, *action.velocity, action.yaw_rate))
        else:
            self._others[len(self._who)] = action
            self._numbers.extend([math.nan] * NUMBERS_PER_COMMAND)
        self._who.append(self._names.index(by))

    def clear(self) -> None:
        """Forget all actions."""
        del self._numbers[:]
        del self._who[:]
        self._others.clear()
        self._names.clear()

    def _action(self, index: int) -> Action:
        if index in self._others:
            return self._others[index]
        at, x, y, z, yaw_rate = self._numbers[
            NUMBERS_PER_COMMAND * index : NUMBERS_PER_COMMAND * (index + 1)
        ]
        return Action(at, velocity=[x, y, z], yaw_rate=yaw_rate)


def _is_command(action: Action) -> bool:
    """Return whether an action has nothing but a velocity and a yaw rate."""
    if action.velocity is None or action.yaw_rate is None:
        return False
    return action == Action(action.at, velocity=action.velocity, yaw_rate=action.yaw_rate)

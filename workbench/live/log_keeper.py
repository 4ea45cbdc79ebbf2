"""The log of a live flight: begun and ended at any time, one file a flight."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError
from workbench.link.backplane import Published, Sampled
from workbench.live.history import History
from workbench.scenario.scenario import Action
from workbench.session.session import Session

if TYPE_CHECKING:
    from workbench.logs.flight_log import FlightLog


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
        if self._log:
            self._log.act(action.at, action, by)

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
        )
        for action, by in self.done:
            self._log.act(action.at, action, by)

    def _take_end(self) -> None:
        """Notice that a log ended by itself: a disk that is full does not end the flight."""
        if self._log and self._log.said:
            self.said = self._log.said
            self._log = None

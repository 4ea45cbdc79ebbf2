"""Starts and stops the server of whatever flies, and knows what came of it."""

from dataclasses import dataclass
from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.flight_model import FlightModel
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.live.messages import Phase
from workbench.live.view import LiveView

ENDED_WITH_FLIGHT = "the server has ended with its flight: start it again"


class Running(Enum):
    """How a server is; the word is shown."""

    NO_FLIGHT = "No flight"
    STOPPED = "Stopped"
    STARTING = "Starting"
    LISTENING = "Listening"
    STOPPING = "Stopping"
    FAILED = "Failed"


class Wanted(Enum):
    """What was asked for and is not answered yet."""

    NOTHING = "nothing"
    START = "start"
    STOP = "stop"


@dataclass(frozen=True)
class ServerState:
    """A server in words.

    Attributes:
        running: how it is.
        said: the same as a sentence, and what to do.
    """

    running: Running
    said: str


def server_state(view: LiveView, flies: bool, wanted: Wanted, failure: str) -> ServerState:
    """Return how the server is.

    Args:
        view: of the flight.
        flies: whether there is a flight at all.
        wanted: what was asked for and is not answered.
        failure: why the last start failed, or the server ended; "" else.
    """
    if not flies or view.phase is Phase.ENDED:
        return ServerState(Running.NO_FLIGHT, "A server serves a flight: open a scenario first.")
    if wanted is Wanted.STOP:
        return ServerState(Running.STOPPING, "Clients are told goodbye.")
    if view.network.server is not None:
        count = len(view.network.server.clients)
        clients = "nobody is connected" if not count else f"{count} connected"
        return ServerState(Running.LISTENING, f"at {view.network.server.address}; {clients}.")
    if view.network.starts_again:
        return ServerState(Running.STARTING, f"{failure[:1].upper()}{failure[1:]}.")
    if wanted is Wanted.START:
        return ServerState(Running.STARTING, "It takes a moment.")
    if failure:
        return ServerState(Running.FAILED, f"{failure[:1].upper()}{failure[1:]}.")
    return ServerState(Running.STOPPED, "Nobody else can watch or fly until it is started.")


class ServerControl(QObject):
    """One server, of the present flight.

    Args:
        flight: that is served.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        config: with which the server was started last.
    """

    changed = pyqtSignal()
    """The state may be another."""

    def __init__(self, flight: FlightModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight = flight
        self.config = ServerConfig()
        self._wanted, self._failure = Wanted.NOTHING, ""
        self._served: LiveFlight | None = None
        self._listened = False
        flight.viewed.connect(self._look)

    @property
    def state(self) -> ServerState:
        """How the server is."""
        flies = self._flight.live is not None
        return server_state(self._flight.view, flies, self._wanted, self._failure)

    def start(self, config: ServerConfig) -> None:
        """Start a server; what is wrong with it comes as its state."""
        if self._flight.live is None or self._wanted is not Wanted.NOTHING:
            return
        self.config, self._served = config, self._flight.live
        self._wanted, self._failure = Wanted.START, ""
        served = self._served
        self._flight.order(
            lambda live: live.serve(config),
            done=lambda _: self._answered(served, ""),
            refused=lambda said: self._answered(served, said),
        )
        self.changed.emit()

    def stop(self) -> None:
        """Send all clients away."""
        served = self._flight.live
        if served is None or self._wanted is Wanted.STOP:
            return
        self._wanted, self._failure, self._listened = Wanted.STOP, "", False
        self._flight.order(
            lambda live: live.stop_serving(),
            done=lambda _: self._answered(served, ""),
            refused=lambda said: self._answered(served, said),
        )
        self.changed.emit()

    def _answered(self, served: LiveFlight, failure: str) -> None:
        if served is not self._flight.live:
            return  # that flight is over, and so is its server
        self._wanted, self._failure = Wanted.NOTHING, failure
        self.changed.emit()

    def _look(self, view: LiveView) -> None:
        """Notice a server that has ended by itself, or with its flight."""
        if self._flight.live is not self._served:
            self._served = self._flight.live
            self._failure = ENDED_WITH_FLIGHT if self._listened else ""
            self._wanted, self._listened = Wanted.NOTHING, False
            self.changed.emit()
        listens = view.network.server is not None
        ended = (self._listened or self._failure) and not listens
        if ended and self._wanted is Wanted.NOTHING:
            failure = view.network.said or self._failure or "the server has ended: start it again"
            if self._listened or failure != self._failure:
                self._failure = failure
                self.changed.emit()
        self._listened = listens and self._wanted is not Wanted.STOP

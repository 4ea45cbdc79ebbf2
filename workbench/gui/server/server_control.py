"""The server of the present flight: its state, and how it is started and stopped."""

from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.gui.flight_model import FlightModel
from workbench.gui.instruments.instrument import Sign
from workbench.link.server.config import ServerConfig
from workbench.live.flight import LiveFlight
from workbench.live.messages import Phase
from workbench.live.orders import NetworkOrder
from workbench.live.view import LiveView

SERVER_ENDED_REASON = "the server has ended with its flight: start it again"


class ListeningState(Enum):
    """State of a server; the word is shown."""

    NO_FLIGHT = "No flight"
    STOPPED = "Stopped"
    STARTING = "Starting"
    LISTENING = "Listening"
    STOPPING = "Stopping"
    FAILED = "Failed"


LISTENING_STATE_SIGNS = {ListeningState.LISTENING: Sign.GOOD, ListeningState.FAILED: Sign.BAD}


def server_state(
    view: LiveView, flies: bool, wanted: ListeningState | None, failure: str
) -> tuple[ListeningState, str]:
    """Return the server's state, and the same as a sentence with what to do.

    Args:
        view: view of the flight.
        flies: whether there is a flight.
        wanted: STARTING or STOPPING while such an order has no answer, else None.
        failure: why the last start failed, or the server ended; else "".
    """
    if not flies or view.phase is Phase.ENDED:
        return ListeningState.NO_FLIGHT, "A server serves a flight: open a scenario first."
    if wanted is ListeningState.STOPPING:
        return ListeningState.STOPPING, "Clients get a goodbye."
    if view.network.server is not None:
        count = len(view.network.server.clients)
        clients = "nobody is connected" if not count else f"{count} connected"
        return ListeningState.LISTENING, f"at {view.network.server.address}; {clients}."
    if view.network.starts_again:
        return ListeningState.STARTING, f"{failure[:1].upper()}{failure[1:]}."
    if wanted is ListeningState.STARTING:
        return ListeningState.STARTING, "It takes a moment."
    if failure:
        return ListeningState.FAILED, f"{failure[:1].upper()}{failure[1:]}."
    return ListeningState.STOPPED, "Nobody else can watch or fly until you start it."


class ServerControl(QObject):
    """The server of the present flight.

    Args:
        flight: the flight.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        config: last configuration of the server.
    """

    changed = pyqtSignal()
    """The state may have changed."""

    def __init__(self, flight: FlightModel, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._flight = flight
        self.config = ServerConfig()
        self._wanted: ListeningState | None = None
        self._failure = ""
        self._served: LiveFlight | None = None
        self._listened = False
        flight.viewed.connect(self._look)

    @property
    def state(self) -> tuple[ListeningState, str]:
        """The state, and the same as a sentence with what to do."""
        flies = self._flight.live is not None
        return server_state(self._flight.view, flies, self._wanted, self._failure)

    def start(self, config: ServerConfig) -> None:
        """Start a server; an error appears as its state."""
        if self._flight.live is None or self._wanted is not None:
            return
        self.config, self._served = config, self._flight.live
        self._wanted, self._failure = ListeningState.STARTING, ""
        self._order(config)

    def stop(self) -> None:
        """Disconnect all clients and end the server."""
        if self._flight.live is None or self._wanted is ListeningState.STOPPING:
            return
        self._wanted, self._failure, self._listened = ListeningState.STOPPING, "", False
        self._order(NetworkOrder.STOP_SERVING)

    def _order(self, order: ServerConfig | NetworkOrder) -> None:
        served = self._flight.live
        self._flight.do(
            order,
            done=lambda _: self._answered(served, ""),
            refused=lambda said: self._answered(served, said),
        )
        self.changed.emit()

    def _answered(self, served: LiveFlight | None, failure: str) -> None:
        if served is not self._flight.live:
            return  # that flight is over, and so is its server
        self._wanted, self._failure = None, failure
        self.changed.emit()

    def _look(self, view: LiveView) -> None:
        """Notice a server that has ended by itself, or with its flight."""
        if self._flight.live is not self._served:
            self._served = self._flight.live
            self._failure = SERVER_ENDED_REASON if self._listened else ""
            self._wanted, self._listened = None, False
            self.changed.emit()
        listens = view.network.server is not None
        ended = (self._listened or self._failure) and not listens
        if ended and self._wanted is None:
            failure = view.network.said or self._failure or "the server has ended: start it again"
            if self._listened or failure != self._failure:
                self._failure = failure
                self.changed.emit()
        self._listened = listens and self._wanted is not ListeningState.STOPPING

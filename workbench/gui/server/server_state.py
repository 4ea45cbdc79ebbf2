"""Whether a flight's server runs, in words."""

from dataclasses import dataclass
from enum import Enum

from workbench.live.messages import Phase
from workbench.live.view import LiveView


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

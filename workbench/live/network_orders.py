"""What is asked of a live flight about its network and its log, and how these do."""

from dataclasses import dataclass
from enum import Enum

from workbench.link.backplane import ControlState, Disconnect, ServerStatus
from workbench.link.server.config import ServerConfig


@dataclass(frozen=True)
class Serve:
    """Start a server; the answer is its address."""

    config: ServerConfig


@dataclass(frozen=True)
class KeepLog:
    """Write all that happens from the flight's start on to a file; the answer is its path."""

    path: str


class Network(Enum):
    """What needs no numbers."""

    STOP_SERVING = "stop serving"
    STOP_LOG = "stop the log"
    """The answer is the log's path."""
    TAKE_OVER = "take over"
    """Let the operator fly, whoever does."""
    GIVE_BACK = "give back"
    """Let clients ask for control again."""


NetworkOrder = Serve | KeepLog | Network | Disconnect


@dataclass(frozen=True)
class NetworkView:
    """How the network and the log do.

    Attributes:
        server: as it said last, None where none runs.
        control: who flies, None until it was said.
        said: why there is no server any more; "" else.
        starts_again: whether the server has ended by itself and is being started again.
        log: path of the log that is being written, "" without.
        log_said: why the last log is not whole; "" else.
    """

    server: ServerStatus | None = None
    control: ControlState | None = None
    said: str = ""
    log: str = ""
    starts_again: bool = False
    log_said: str = ""

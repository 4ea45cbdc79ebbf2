"""Messages between the flight and its server process, as frozen records.

Samples are named tuples: to write and read one takes 8 us, and a dataclass 12.

The server requests, the flight decides: the flight checks and applies everything that reaches the
drone, at a recorded step, even if the server crashes.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

from workbench.link.hello import ParameterRow
from workbench.link.message_json import FlightRequest, ServerMessage
from workbench.link.messages import Role
from workbench.link.topics import Topic

DISCONNECT_REASON = "the operator ended it"
"""Why the operator disconnects a client, unless stated otherwise."""

# From the server to the flight. `peer` is the number of a connection, never reused.


@dataclass(frozen=True, slots=True)
class VelocityCommand:
    """A velocity command of a client, as received or as flown.

    Attributes:
        peer: the client.
        seq: number of the frame.
        t_ns: time of the state the command acts on [ns].
        lease: the one it uses.
        axes: bits of the axes in use.
        velocity: in W [m/s].
        yaw_rate: [rad/s].
        scaled: why a smaller velocity is flown, else "".
    """

    peer: int
    seq: int
    t_ns: int
    lease: int
    axes: int
    velocity: tuple[float, float, float]
    yaw_rate: float
    scaled: str = ""


@dataclass(frozen=True, slots=True)
class ClientRequest:
    """A request of a client to the flight, which answers with a `Reply`."""

    peer: int
    operation: FlightRequest


@dataclass(frozen=True, slots=True)
class ClientDisconnected:
    """The connection of a client has ended."""

    peer: int


FromClient = VelocityCommand | ClientRequest | ClientDisconnected


@dataclass(frozen=True, slots=True)
class ClientStatus:
    """The status of a connected client, for the Server screen.

    Attributes:
        peer: its number.
        address: host and port.
        name: chosen by the client.
        transport: tcp, tls or websocket.
        role: its role, None before login.
        rate: frames per second sent to it [1/s].
        age: of the newest data it has acknowledged [s].
        dropped: number of frames dropped as it was too slow.
        refused: number of rejected commands and operations.
    """

    peer: int
    address: str
    name: str
    transport: str
    role: Role | None
    rate: float
    age: float
    dropped: int
    refused: int


@dataclass(frozen=True, slots=True)
class ServerStatus:
    """The status of the server, about twice a second and on change.

    Attributes:
        address: that it listens at, "HOST:PORT".
        page: address of the page for phones, "" without.
        clients: the connected ones.
        refusals: number of rejections since the start, by code.
        log: the last rejections in words, newest last.
    """

    address: str
    page: str
    clients: tuple[ClientStatus, ...]
    refusals: Mapping[str, int]
    log: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ServerFailed:
    """The server cannot start, or has ended; the reason is a sentence."""

    said: str


FromServer = FromClient | ServerStatus | ServerFailed
ToFlight = Callable[[FromServer], None]
"""Sends a record to the flight without waiting."""


# From the flight to the server.


@dataclass(frozen=True, slots=True)
class ServedFlight:
    """The flight: the first message, sent again when the set of parameters changes.

    Attributes:
        vehicle: name of the vehicle.
        topics: their definitions.
        parameters: the live parameters.
        limits: largest level speed, climb rate [m/s] and yaw rate [rad/s].
    """

    vehicle: str
    topics: tuple[Topic, ...]
    parameters: tuple[ParameterRow, ...]
    limits: tuple[float, float, float]


class Published(NamedTuple):
    """Published topics at one time.

    Attributes:
        t_ns: simulated time [ns].
        wall_ns: when it was sampled, by `time.time_ns`.
        payloads: topic number and payload of each.
    """

    t_ns: int
    wall_ns: int
    payloads: tuple[tuple[int, bytes], ...]


class Sampled(NamedTuple):
    """The topics published at one time, and the exact state.

    Attributes:
        published: the topics.
        state: of the plant: q_WB, p_WB, w_WB, v_WB, 13 numbers.
    """

    published: Published
    state: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Reply:
    """The answer to the request of a client."""

    peer: int
    answer: ServerMessage


@dataclass(frozen=True, slots=True)
class CommandRefusal:
    """A command that was not, or only partly, applied; `seq` is the number of its frame."""

    peer: int
    seq: int
    code: str
    said: str


@dataclass(frozen=True, slots=True)
class Disconnect:
    """The operator disconnects a client."""

    peer: int
    reason: str = DISCONNECT_REASON


class StopServer(Enum):
    """The last message: take leave of all clients, and end."""

    STOP = "stop"

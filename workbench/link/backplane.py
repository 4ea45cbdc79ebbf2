"""What goes between the flight and its server, which is a process of its own: frozen records.

The server asks, the flight decides: whatever reaches the drone was checked and applied there, at
a step that is on record, even if the server dies.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum

from workbench.link.hello import ParameterRow
from workbench.link.messages import FlightRequest, Role, ServerMessage
from workbench.link.topics import Topic

# From the server to the flight. `peer` is the number of a connection, never used twice.


@dataclass(frozen=True, slots=True)
class Command:
    """A velocity that a client asks for, as it stood in its frame; or as it is flown of that.

    Attributes:
        peer: the client.
        seq: number of the frame.
        t_ns: time of the state that the command acts on [ns].
        lease: that it is given under.
        axes: bits of those that count.
        velocity: in W [m/s].
        yaw_rate: [rad/s].
        scaled: why less is flown than was asked for, "" else.
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
class Request:
    """What a client asks of the flight, which answers with a `Reply`."""

    peer: int
    operation: FlightRequest


@dataclass(frozen=True, slots=True)
class Gone:
    """A client's connection has ended."""

    peer: int


FromClient = Command | Request | Gone


@dataclass(frozen=True, slots=True)
class ClientStatus:
    """A connected client, as the Server screen shows it.

    Attributes:
        peer: its number.
        address: host and port.
        name: what it calls itself.
        transport: tcp, tls or websocket.
        role: what it may do, None before login.
        rate: frames a second that it gets [1/s].
        age: of the newest data that it has acknowledged [s].
        dropped: frames that it was too slow for.
        refused: commands and operations that were refused.
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
    """How the server does, about twice a second and on change.

    Attributes:
        address: where it listens, "HOST:PORT".
        page: address of the page for phones, "" without.
        clients: who is connected.
        refusals: how often something was refused since the start, by its code.
        log: the last refusals in words, newest last.
    """

    address: str
    page: str
    clients: tuple[ClientStatus, ...]
    refusals: Mapping[str, int]
    log: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ServerFailed:
    """The server cannot start, or has ended; a sentence."""

    said: str


FromServer = FromClient | ServerStatus | ServerFailed
ToFlight = Callable[[FromServer], None]
"""Sends a record to the flight without waiting."""


# From the flight to the server.


@dataclass(frozen=True, slots=True)
class Flight:
    """What is flown: the first message, and again where other parameters are.

    Attributes:
        vehicle: its name.
        topics: their definitions.
        parameters: the live parameters.
        limits: largest level speed, climb rate [m/s] and yaw rate [rad/s].
    """

    vehicle: str
    topics: tuple[Topic, ...]
    parameters: tuple[ParameterRow, ...]
    limits: tuple[float, float, float]


@dataclass(frozen=True, slots=True)
class Published:
    """Topics at one time.

    Attributes:
        t_ns: simulated time [ns].
        wall_ns: when it was sampled, by `time.time_ns`.
        payloads: number of a topic and its payload.
    """

    t_ns: int
    wall_ns: int
    payloads: tuple[tuple[int, bytes], ...]


@dataclass(frozen=True, slots=True)
class Sampled:
    """What is published at one time, and the exact state then.

    Attributes:
        published: the topics.
        state: of the plant: q_WB, p_WB, w_WB, v_WB, 13 numbers.
    """

    published: Published
    state: tuple[float, ...]


@dataclass(frozen=True, slots=True)
class Reply:
    """What a client's request came to."""

    peer: int
    answer: ServerMessage


@dataclass(frozen=True, slots=True)
class Refused:
    """A command that was not applied, or only in part; `seq` is that of its frame."""

    peer: int
    seq: int
    code: str
    said: str


@dataclass(frozen=True, slots=True)
class Disconnect:
    """The operator wants a client gone."""

    peer: int
    reason: str


class Stop(Enum):
    """The last message: say goodbye to all and end."""

    STOP = "stop"

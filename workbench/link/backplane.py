"""What goes between the flight and its server, which is a process of its own: frozen records.

The server asks, the flight decides: whatever reaches the drone was checked and applied there, at
a step that is on record, even if the server dies.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum

from workbench.link.topics import Topic

# From the server to the flight. `peer` is the number of a connection, never used twice.


@dataclass(frozen=True, slots=True)
class Command:
    """A velocity that a client asks for, as it stood in its frame."""

    peer: int
    seq: int
    t_ns: int
    lease: int
    axes: int
    velocity: tuple[float, float, float]
    yaw_rate: float


@dataclass(frozen=True, slots=True)
class RequestControl:
    """A client wants to command; `name` is what it calls itself."""

    peer: int
    id: int
    name: str


@dataclass(frozen=True, slots=True)
class ReleaseControl:
    """A client wants to command no longer."""

    peer: int
    id: int
    lease: int


@dataclass(frozen=True, slots=True)
class FlightOperation:
    """A client wants to arm, take_off (to a height [m]), land, stop or hold."""

    peer: int
    id: int
    lease: int
    what: str
    height: float


@dataclass(frozen=True, slots=True)
class SetParameters:
    """A client wants to set live parameters: all, or none where one is refused."""

    peer: int
    id: int
    lease: int
    values: Mapping[str, float]


@dataclass(frozen=True, slots=True)
class GetParameters:
    """A client wants to know live parameters; of all if no names are given."""

    peer: int
    id: int
    names: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Gone:
    """A client's connection has ended."""

    peer: int


Asked = (
    Command
    | RequestControl
    | ReleaseControl
    | FlightOperation
    | SetParameters
    | GetParameters
    | Gone
)


class Role(Enum):
    """What a client may do."""

    VIEW = "view"
    COMMAND = "command"


@dataclass(frozen=True, slots=True)
class PeerStatus:
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
        peers: who is connected.
        refusals: how often something was refused since the start, by its code.
        log: the last refusals in words, newest last.
    """

    address: str
    page: str
    peers: tuple[PeerStatus, ...]
    refusals: Mapping[str, int]
    log: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class ServerFailed:
    """The server cannot start, or has ended; a sentence."""

    said: str


# From the flight to the server.


@dataclass(frozen=True, slots=True)
class Flight:
    """What is flown: the first message.

    Attributes:
        vehicle: its name.
        topics: their definitions.
        parameters: rows of the live parameters for HELLO: name, unit, low, high, default, help.
        limits: largest level speed, climb rate [m/s] and yaw rate [rad/s].
    """

    vehicle: str
    topics: tuple[Topic, ...]
    parameters: tuple[tuple[str, str, float, float, float, str], ...]
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
    """What a client's request came to: an operation of the protocol, without its `id`."""

    peer: int
    id: int
    operation: Mapping[str, object]


@dataclass(frozen=True, slots=True)
class Refused:
    """A command that was not applied, or only in part; `seq` is that of its frame."""

    peer: int
    seq: int
    code: str
    said: str


class Hand(Enum):
    """Who flies."""

    NOBODY = "nobody"
    CLIENT = "client"
    OPERATOR = "operator"


class Stage(Enum):
    """How far the ladder of a silent holder has gone."""

    LIVE = "live"
    HOLD = "hold"
    LOST = "lost"
    LAND = "land"


@dataclass(frozen=True, slots=True)
class ControlState:
    """Who commands, broadcast at 1 Hz of simulated time and on change.

    Attributes:
        hand: who.
        peer: the holder's connection, 0 if it is no client.
        name: what the holder calls itself.
        stage: how far its silence has led.
        age: of the last command that was applied [s], infinite where nobody flies.
        reason: why it came to this, in words.
    """

    hand: Hand
    peer: int
    name: str
    stage: Stage
    age: float
    reason: str


@dataclass(frozen=True, slots=True)
class Disconnect:
    """The operator wants a client gone."""

    peer: int
    reason: str


class Stop(Enum):
    """The last message: say goodbye to all and end."""

    STOP = "stop"

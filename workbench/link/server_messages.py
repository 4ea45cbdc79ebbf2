"""What the server says: messages as records, for it to write and for a client to read.

The flight answers with the same records, see `backplane.Reply`.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import Enum
from typing import ClassVar

from workbench.link.drone_topics import LONGEST_NAME
from workbench.link.hello import LARGEST_PEER, Hello, read_hello
from workbench.link.json_fields import LARGEST_ID, LONGEST_TOPIC, JsonFields
from workbench.link.operations import FLIGHT_OPERATIONS, Role
from workbench.link.strict_json import read_json, write_json


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
class LoggedIn:
    """The client is who it says; `role` is what it may do."""

    op: ClassVar[str] = "login"
    id: int
    role: Role


@dataclass(frozen=True, slots=True)
class Subscribed:
    """These topics come from now on."""

    op: ClassVar[str] = "subscribe"
    id: int
    topics: tuple[str, ...]


@dataclass(frozen=True, slots=True)
class Granted:
    """The client flies: its commands carry `lease`, which a silence of `expires` ends [s]."""

    op: ClassVar[str] = "request_control"
    id: int
    lease: int
    expires: float


@dataclass(frozen=True, slots=True)
class Released:
    """The client flies no longer."""

    op: ClassVar[str] = "release_control"
    id: int


@dataclass(frozen=True, slots=True)
class ParameterValues:
    """Live parameters as they now are; `applied_ns` is when they were set, simulated [ns]."""

    op: ClassVar[str] = "parameters"
    id: int
    values: Mapping[str, float]
    applied_ns: int | None = None


@dataclass(frozen=True, slots=True)
class FlightDone:
    """A flight operation was done at a simulated time [ns]."""

    op: ClassVar[str] = "flight"
    id: int
    what: str
    applied_ns: int


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

    op: ClassVar[str] = "control_state"
    hand: Hand
    peer: int
    name: str
    stage: Stage
    age: float
    reason: str


@dataclass(frozen=True, slots=True)
class Pong:
    """The server is there, at this simulated time [ns]."""

    op: ClassVar[str] = "pong"
    id: int
    t_ns: int


@dataclass(frozen=True, slots=True)
class Nack:
    """Something was not done, or not wholly; the connection goes on.

    Attributes:
        code: see `NackCode`.
        said: a sentence.
        id: of the operation, or None.
        seq: of the frame of data, or None.
    """

    op: ClassVar[str] = "nack"
    code: str
    said: str
    id: int | None = None
    seq: int | None = None


@dataclass(frozen=True, slots=True)
class Error:
    """The connection ends, see `ErrorCode`."""

    op: ClassVar[str] = "error"
    code: str
    said: str


@dataclass(frozen=True, slots=True)
class Goodbye:
    """The server stops, or the client has said goodbye."""

    op: ClassVar[str] = "bye"
    said: str


@dataclass(frozen=True, slots=True)
class Unknown:
    """Something that this version does not know: to be ignored."""

    op: str


ServerMessage = (
    Hello
    | LoggedIn
    | Subscribed
    | Granted
    | Released
    | ParameterValues
    | FlightDone
    | ControlState
    | Pong
    | Nack
    | Error
    | Goodbye
    | Unknown
)


def write_message(message: ServerMessage) -> bytes:
    """Return the payload of a control frame that says it."""
    if isinstance(message, Hello):
        return write_json({"op": "hello"} | message.values())
    found: dict[str, object] = {"op": message.op}
    for each in fields(message):
        value = getattr(message, each.name)
        if value is not None:
            found[each.name] = _plain(value)
    return write_json(found)


def read_message(payload: bytes) -> ServerMessage:
    """Return what the server says.

    Args:
        payload: of a control frame.

    Raises:
        WireError: if it is no strict JSON.
        BadOperation: if an operation that is known has wrong values.
    """
    found = JsonFields(read_json(payload))
    if found.op not in _READERS:
        return Unknown(found.op)
    return _READERS[found.op](found)


def _plain(value: object) -> object:
    """Return a field's value as it stands in JSON."""
    match value:
        case Enum():
            return value.value
        case Mapping():
            return dict(value)
        case float() if not math.isfinite(value):
            return None
    return value


def _control_state(found: JsonFields) -> ControlState:
    return ControlState(
        hand=found.member("hand", Hand),
        peer=found.integer("peer", 0, LARGEST_PEER),
        name=found.text("name", LONGEST_NAME),
        stage=found.member("stage", Stage),
        age=found.number("age") if "age" in found else math.inf,
        reason=found.sentence("reason"),
    )


def _nack(found: JsonFields) -> Nack:
    return Nack(
        code=found.text("code", LONGEST_NAME),
        said=found.sentence("said"),
        id=found.id if "id" in found else None,
        seq=found.integer("seq", 0, LARGEST_ID) if "seq" in found else None,
    )


_READERS: dict[str, Callable[[JsonFields], ServerMessage]] = {
    "hello": read_hello,
    "login": lambda f: LoggedIn(f.id, f.member("role", Role)),
    "subscribe": lambda f: Subscribed(f.id, f.names("topics", LONGEST_TOPIC)),
    "request_control": lambda f: Granted(
        f.id, f.integer("lease", 1, LARGEST_ID), f.number("expires", 0.0)
    ),
    "release_control": lambda f: Released(f.id),
    "parameters": lambda f: ParameterValues(
        f.id,
        f.numbers("values"),
        f.integer("applied_ns", 0, LARGEST_PEER) if "applied_ns" in f else None,
    ),
    "flight": lambda f: FlightDone(
        f.id, f.choice("what", FLIGHT_OPERATIONS), f.integer("applied_ns", 0, LARGEST_PEER)
    ),
    "control_state": _control_state,
    "pong": lambda f: Pong(f.id, f.integer("t_ns", 0, LARGEST_PEER)),
    "nack": _nack,
    "error": lambda f: Error(f.text("code", LONGEST_NAME), f.sentence("said")),
    "bye": lambda f: Goodbye(f.sentence("said") if "said" in f else ""),
}

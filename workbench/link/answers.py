"""What the server says: operations as records, for it to write and for a client to read."""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from typing import ClassVar

from workbench.link.backplane import ControlState, Hand, Role, Stage
from workbench.link.drone_topics import LONGEST_NAME
from workbench.link.hello import Hello, read_hello
from workbench.link.json_fields import (
    LARGEST_ID,
    LONGEST_TOPIC,
    JsonFields,
)
from workbench.link.operations import FLIGHT_OPERATIONS
from workbench.link.strict_json import read_json, write_json

LARGEST_PEER = 2**63 - 1


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
class ParametersSaid:
    """Live parameters as they now are; `applied_ns` is when they were set, simulated [ns]."""

    op: ClassVar[str] = "parameters"
    id: int
    values: Mapping[str, float]
    applied_ns: int | None = None


@dataclass(frozen=True, slots=True)
class Flown:
    """A flight operation was done at a simulated time [ns]."""

    op: ClassVar[str] = "flight"
    id: int
    what: str
    applied_ns: int


@dataclass(frozen=True, slots=True)
class ControlStateSaid:
    """Who commands, see `backplane.ControlState`; `age` is infinite where nobody ever did [s]."""

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
class ByeSaid:
    """The server stops, or the client has said goodbye."""

    op: ClassVar[str] = "bye"
    said: str


@dataclass(frozen=True, slots=True)
class Unknown:
    """Something that this version does not know: to be ignored."""

    op: str


Said = (
    Hello
    | LoggedIn
    | Subscribed
    | Granted
    | Released
    | ParametersSaid
    | Flown
    | ControlStateSaid
    | Pong
    | Nack
    | Error
    | ByeSaid
    | Unknown
)


def control_state_said(state: ControlState) -> ControlStateSaid:
    """Return what all clients are told of who commands."""
    return ControlStateSaid(
        state.hand, state.peer, state.name, state.stage, state.age, state.reason
    )


def write_said(said: Said) -> bytes:
    """Return the payload of a control frame that says it."""
    if isinstance(said, Hello):
        return write_json({"op": "hello"} | said.values())
    found: dict[str, object] = {"op": said.op}
    for each in fields(said):
        value = getattr(said, each.name)
        if value is not None:
            found[each.name] = _plain(value)
    return write_json(found)


def read_said(payload: bytes) -> Said:
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
        case Role() | Hand() | Stage():
            return value.value
        case tuple():
            return list(value)
        case Mapping():
            return dict(value)
        case float() if not math.isfinite(value):
            return None
    return value


def _control_state(found: JsonFields) -> ControlStateSaid:
    return ControlStateSaid(
        hand=Hand(found.choice("hand", tuple(each.value for each in Hand))),
        peer=found.integer("peer", 0, LARGEST_PEER),
        name=found.text("name", LONGEST_NAME),
        stage=Stage(found.choice("stage", tuple(each.value for each in Stage))),
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


_READERS: dict[str, Callable[[JsonFields], Said]] = {
    "hello": read_hello,
    "login": lambda f: LoggedIn(f.id, Role(f.choice("role", tuple(r.value for r in Role)))),
    "subscribe": lambda f: Subscribed(f.id, f.names("topics", LONGEST_TOPIC)),
    "request_control": lambda f: Granted(
        f.id, f.integer("lease", 1, LARGEST_ID), f.number("expires", 0.0)
    ),
    "release_control": lambda f: Released(f.id),
    "parameters": lambda f: ParametersSaid(
        f.id,
        f.numbers("values"),
        f.integer("applied_ns", 0, LARGEST_PEER) if "applied_ns" in f else None,
    ),
    "flight": lambda f: Flown(
        f.id, f.choice("what", FLIGHT_OPERATIONS), f.integer("applied_ns", 0, LARGEST_PEER)
    ),
    "control_state": _control_state,
    "pong": lambda f: Pong(f.id, f.integer("t_ns", 0, LARGEST_PEER)),
    "nack": _nack,
    "error": lambda f: Error(f.text("code", LONGEST_NAME), f.sentence("said")),
    "bye": lambda f: ByeSaid(f.sentence("said") if "said" in f else ""),
}

"""What clients and the server say to each other: messages as records, written and read.

What a client asks of the flight goes on to it with the client's number, and the flight answers with
such records, see `backplane`. Where an answer says the same of an operation as the request for it,
both are one record.
"""

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields
from enum import Enum
from typing import ClassVar

from workbench.link.codes import DeniedError, NackCode
from workbench.link.drone_topics import LONGEST_NAME
from workbench.link.hello import LARGEST_PEER, Hello, read_hello
from workbench.link.json_fields import LARGEST_ID, LONGEST_TOPIC, JsonFields, read_json, write_json

FLIGHT_OPERATIONS = ("arm", "take_off", "land", "stop", "hold")
TAKE_OFF_HEIGHT = 1.5
"""Of a take-off that names none [m]."""
HIGHEST_TAKE_OFF = 1000.0
SLOWEST = 0.1
FASTEST = 10_000.0
"""Bounds of the frames a second that a client may ask for [1/s]."""
NONCE_DIGITS = 32
PROOF_DIGITS = 64


class Role(Enum):
    """What a client may do."""

    VIEW = "view"
    COMMAND = "command"


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
class Login:
    """Who a client is; nonce and proof are empty where no token is asked for.

    The answer has id and role alone: what the client may do.
    """

    op: ClassVar[str] = "login"
    id: int = 0
    name: str = ""
    role: Role | None = None
    nonce: str = ""
    proof: str = ""


@dataclass(frozen=True, slots=True)
class Subscribe:
    """Which topics come from now on; this replaces what was subscribed before.

    Attributes:
        id: echoed in the answer; so in the others.
        topics: their names; of a client also "*" for all.
        rate: largest frames a second of each topic, None for all there are [1/s].
    """

    op: ClassVar[str] = "subscribe"
    id: int = 0
    topics: tuple[str, ...] = ("*",)
    rate: float | None = None


@dataclass(frozen=True, slots=True)
class RequestControl:
    """A client wants to fly; `name` replaces that of login, if it is not empty.

    In the answer the client flies: its commands carry `lease`, which a silence of `expires` ends
    [s].
    """

    op: ClassVar[str] = "request_control"
    id: int = 0
    name: str = ""
    lease: int = 0
    expires: float = 0.0


@dataclass(frozen=True, slots=True)
class ReleaseControl:
    """A client wants to fly no longer; in the answer, which has no lease, it does not."""

    op: ClassVar[str] = "release_control"
    id: int
    lease: int = 0


@dataclass(frozen=True, slots=True)
class FlightOperation:
    """A client wants to arm, take_off to a height above the ground [m], land, stop or hold."""

    op: ClassVar[str] = "flight"
    id: int
    what: str
    height: float
    lease: int


@dataclass(frozen=True, slots=True)
class FlightDone:
    """A flight operation was done at a simulated time [ns]."""

    op: ClassVar[str] = "flight"
    id: int
    what: str
    applied_ns: int


@dataclass(frozen=True, slots=True)
class GetParameters:
    """A client wants to know the live parameters of these names; all, if it names none."""

    op: ClassVar[str] = "parameters"
    id: int = 0
    get: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SetParameters:
    """A client wants to set live parameters: all, or none where one is refused."""

    op: ClassVar[str] = "parameters"
    id: int
    set: Mapping[str, float]
    lease: int


@dataclass(frozen=True, slots=True)
class ParameterValues:
    """Live parameters as they now are; `applied_ns` is when they were set, simulated [ns]."""

    op: ClassVar[str] = "parameters"
    id: int
    values: Mapping[str, float]
    applied_ns: int | None = None


@dataclass(frozen=True, slots=True)
class Ping:
    """A client wants to know whether somebody is there."""

    op: ClassVar[str] = "ping"
    id: int = 0


@dataclass(frozen=True, slots=True)
class Pong:
    """The server is there, at this simulated time [ns]."""

    op: ClassVar[str] = "pong"
    id: int
    t_ns: int


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
    """The connection ends; of the code see `ErrorCode`, and of a client's own `connection`."""

    op: ClassVar[str] = "error"
    code: str
    said: str


@dataclass(frozen=True, slots=True)
class Bye:
    """The client goes, with an id; or the server ends the connection as it should, and says why."""

    op: ClassVar[str] = "bye"
    id: int | None = None
    said: str = ""


FlightRequest = RequestControl | ReleaseControl | FlightOperation | GetParameters | SetParameters
"""What the flight answers."""
Operation = Login | Subscribe | FlightRequest | Ping | Bye
"""What a client says."""
COMMANDING = (RequestControl, ReleaseControl, FlightOperation, SetParameters)
"""Operations that carry a proof where tokens are in use."""
ServerMessage = (
    Hello
    | Login
    | Subscribe
    | RequestControl
    | ReleaseControl
    | ParameterValues
    | FlightDone
    | ControlState
    | Pong
    | Nack
    | Error
    | Bye
)
"""What the server says."""


def read_operation(payload: bytes) -> Operation:
    """Return what a client says.

    Args:
        payload: of a control frame.

    Raises:
        WireError: if it is no strict JSON; the connection must end.
        DeniedError: if it is not one of the operations, or has wrong values.
    """
    found = JsonFields(read_json(payload))
    if found.op not in _OPERATIONS:
        known = ", ".join(_OPERATIONS)
        raise DeniedError(
            NackCode.UNKNOWN_OP, f"operation {found.op!r} is unknown: known are {known}", found.id
        )
    return _OPERATIONS[found.op](found)


def read_message(payload: bytes) -> ServerMessage | None:
    """Return what the server says; None of what this version does not know.

    Args:
        payload: of a control frame.

    Raises:
        WireError: if it is no strict JSON.
        DeniedError: if an operation that is known has wrong values.
    """
    found = JsonFields(read_json(payload))
    return _MESSAGES[found.op](found) if found.op in _MESSAGES else None


def write_operation(operation: Operation) -> bytes:
    """Return the payload of a control frame that says it; an id of 0 is left out, too."""
    found = _stated(operation)
    if not found.get("id"):
        found.pop("id", None)
    return write_json(found)


def write_message(message: ServerMessage) -> bytes:
    """Return the payload of a control frame that says it."""
    if isinstance(message, Hello):
        return write_json({"op": "hello"} | message.values())
    return write_json(_stated(message))


def _stated(message: Operation | ServerMessage) -> dict[str, object]:
    """Return a message as it stands in JSON: what is None, and what may be empty and is, is not."""
    found: dict[str, object] = {"op": message.op}
    for each in fields(message):
        value = getattr(message, each.name)
        empty = value in ("", 0) and value == each.default and each.name != "id"
        if value is not None and not empty:
            found[each.name] = _plain(value)
    return found


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


def _login(found: JsonFields) -> Login:
    role = found.member("role", Role) if "role" in found else None
    nonce = found.digits("nonce", NONCE_DIGITS) if "nonce" in found else ""
    proof = found.digits("proof", PROOF_DIGITS) if "proof" in found else ""
    return Login(found.id, _name(found), role, nonce, proof)


def _subscribe(found: JsonFields) -> Subscribe:
    rate = found.number("rate", SLOWEST, FASTEST) if "rate" in found else None
    return Subscribe(found.id, found.names("topics", LONGEST_TOPIC), rate)


def _flight(found: JsonFields) -> FlightOperation:
    what = found.choice("what", FLIGHT_OPERATIONS)
    height = TAKE_OFF_HEIGHT
    if "height" in found:
        height = found.number("height", 0.0, HIGHEST_TAKE_OFF)
        if height == 0.0:
            raise found.bad('"height" must be above the ground [m]')
    return FlightOperation(found.id, what, height, _lease(found))


def _parameters(found: JsonFields) -> GetParameters | SetParameters:
    if ("get" in found) == ("set" in found):
        raise found.bad('give either "get" or "set"')
    if "get" in found:
        return GetParameters(found.id, found.names("get", LONGEST_NAME))
    values = found.numbers("set")
    if not values:
        raise found.bad('"set" names no parameter')
    return SetParameters(found.id, values, _lease(found))


def _name(found: JsonFields) -> str:
    return found.text("name", LONGEST_NAME) if "name" in found else ""


def _lease(found: JsonFields) -> int:
    return found.integer("lease", 1, LARGEST_ID)


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


_OPERATIONS: dict[str, Callable[[JsonFields], Operation]] = {
    "login": _login,
    "subscribe": _subscribe,
    "request_control": lambda found: RequestControl(found.id, _name(found)),
    "release_control": lambda found: ReleaseControl(found.id, _lease(found)),
    "flight": _flight,
    "parameters": _parameters,
    "ping": lambda found: Ping(found.id),
    "bye": lambda found: Bye(found.id or None),
}
_MESSAGES: dict[str, Callable[[JsonFields], ServerMessage]] = {
    "hello": read_hello,
    "login": lambda found: Login(found.id, role=found.member("role", Role)),
    "subscribe": lambda found: Subscribe(found.id, found.names("topics", LONGEST_TOPIC)),
    "request_control": lambda found: RequestControl(
        found.id, lease=_lease(found), expires=found.number("expires", 0.0)
    ),
    "release_control": lambda found: ReleaseControl(found.id),
    "parameters": lambda found: ParameterValues(
        found.id,
        found.numbers("values"),
        found.integer("applied_ns", 0, LARGEST_PEER) if "applied_ns" in found else None,
    ),
    "flight": lambda found: FlightDone(
        found.id,
        found.choice("what", FLIGHT_OPERATIONS),
        found.integer("applied_ns", 0, LARGEST_PEER),
    ),
    "control_state": _control_state,
    "pong": lambda found: Pong(found.id, found.integer("t_ns", 0, LARGEST_PEER)),
    "nack": _nack,
    "error": lambda found: Error(found.text("code", LONGEST_NAME), found.sentence("said")),
    "bye": lambda found: Bye(said=found.sentence("said") if "said" in found else ""),
}

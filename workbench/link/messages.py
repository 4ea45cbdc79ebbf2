"""The messages between clients and server, as records to write and read.

Requests to the flight are passed on with the number of the client, and the flight answers with such
records, see `backplane`. A request and an answer with the same content share one record.
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
"""Default height of a take-off [m]."""
HIGHEST_TAKE_OFF = 1000.0
SLOWEST = 0.1
FASTEST = 10_000.0
"""Limits of the requested frames per second [1/s]."""
NONCE_DIGITS = 32
PROOF_DIGITS = 64


class Role(Enum):
    """The roles of clients."""

    VIEW = "view"
    COMMAND = "command"


class Hand(Enum):
    """Who is in control."""

    NOBODY = "nobody"
    CLIENT = "client"
    OPERATOR = "operator"


class Stage(Enum):
    """The stages of silence of a holder."""

    LIVE = "live"
    HOLD = "hold"
    LOST = "lost"
    LAND = "land"


@dataclass(frozen=True, slots=True)
class Login:
    """The login of a client; nonce and proof are empty if no token is required.

    The answer has only id and role.
    """

    op: ClassVar[str] = "login"
    id: int = 0
    name: str = ""
    role: Role | None = None
    nonce: str = ""
    proof: str = ""


@dataclass(frozen=True, slots=True)
class Subscribe:
    """The subscribed topics; this replaces earlier subscriptions.

    Attributes:
        id: repeated in the answer, here and in other operations.
        topics: their names, or "*" for all from a client.
        rate: largest number of frames per second for each topic [1/s], None for all.
    """

    op: ClassVar[str] = "subscribe"
    id: int = 0
    topics: tuple[str, ...] = ("*",)
    rate: float | None = None


@dataclass(frozen=True, slots=True)
class RequestControl:
    """A client requests control; a `name` that is not empty replaces that of login.

    The answer grants control. Commands carry `lease`, which expires after a silence of `expires`
    [s].
    """

    op: ClassVar[str] = "request_control"
    id: int = 0
    name: str = ""
    lease: int = 0
    expires: float = 0.0


@dataclass(frozen=True, slots=True)
class ReleaseControl:
    """A client gives control back; the answer has no lease."""

    op: ClassVar[str] = "release_control"
    id: int
    lease: int = 0


@dataclass(frozen=True, slots=True)
class FlightOperation:
    """A client requests arm, take_off to a height above the ground [m], land, stop or hold."""

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
    """A client requests the live parameters with these names, or all if there are none."""

    op: ClassVar[str] = "parameters"
    id: int = 0
    get: tuple[str, ...] = ()


@dataclass(frozen=True, slots=True)
class SetParameters:
    """A client sets live parameters: all, or none if one is rejected."""

    op: ClassVar[str] = "parameters"
    id: int
    set: Mapping[str, float]
    lease: int


@dataclass(frozen=True, slots=True)
class ParameterValues:
    """The present live parameters; `applied_ns` is the simulated time when they were set [ns]."""

    op: ClassVar[str] = "parameters"
    id: int
    values: Mapping[str, float]
    applied_ns: int | None = None


@dataclass(frozen=True, slots=True)
class Ping:
    """A client checks whether the server is there."""

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
    """Who is in control, broadcast at 1 Hz of simulated time and on change.

    Attributes:
        hand: who.
        peer: connection of the holder, 0 if it is not a client.
        name: of the holder.
        stage: of its silence.
        age: of the last applied command [s], infinite if nobody flies.
        reason: why, in words.
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
    """Something was not, or not completely, done; the connection continues.

    Attributes:
        code: see `NackCode`.
        said: the reason, a sentence.
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
    """The connection ends; for codes see `ErrorCode`, and `connection` for those of a client."""

    op: ClassVar[str] = "error"
    code: str
    said: str


@dataclass(frozen=True, slots=True)
class Bye:
    """The client leaves, with an id; or the server ends the connection in order, with a reason."""

    op: ClassVar[str] = "bye"
    id: int | None = None
    said: str = ""


FlightRequest = RequestControl | ReleaseControl | FlightOperation | GetParameters | SetParameters
"""Requests that the flight answers."""
Operation = Login | Subscribe | FlightRequest | Ping | Bye
"""Messages of a client."""
COMMANDING = (RequestControl, ReleaseControl, FlightOperation, SetParameters)
"""Operations that need a proof if tokens are in use."""
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
"""Messages of the server."""


def read_operation(payload: bytes) -> Operation:
    """Return the message of a client.

    Args:
        payload: of a control frame.

    Raises:
        WireError: if it is not strict JSON; the connection must end.
        DeniedError: if it is an unknown operation, or has invalid values.
    """
    found = JsonFields(read_json(payload))
    if found.op not in _OPERATIONS:
        known = ", ".join(_OPERATIONS)
        raise DeniedError(
            NackCode.UNKNOWN_OP, f"operation {found.op!r} is unknown: known are {known}", found.id
        )
    return _OPERATIONS[found.op](found)


def read_message(payload: bytes) -> ServerMessage | None:
    """Return the message of the server; None if this version does not know it.

    Args:
        payload: of a control frame.

    Raises:
        WireError: if it is not strict JSON.
        DeniedError: if a known operation has invalid values.
    """
    found = JsonFields(read_json(payload))
    return _MESSAGES[found.op](found) if found.op in _MESSAGES else None


def write_operation(operation: Operation) -> bytes:
    """Return the payload of a control frame for an operation; an id of 0 is left out, too."""
    found = _stated(operation)
    if not found.get("id"):
        found.pop("id", None)
    return write_json(found)


def write_message(message: ServerMessage) -> bytes:
    """Return the payload of a control frame for a message."""
    if isinstance(message, Hello):
        return write_json({"op": "hello"} | message.values())
    return write_json(_stated(message))


def _stated(message: Operation | ServerMessage) -> dict[str, object]:
    """Return a message in JSON types, without fields that are None, or optional and empty."""
    found: dict[str, object] = {"op": message.op}
    for each in fields(message):
        value = getattr(message, each.name)
        empty = value in ("", 0) and value == each.default and each.name != "id"
        if value is not None and not empty:
            found[each.name] = _plain(value)
    return found


def _plain(value: object) -> object:
    """Return the value of a field in JSON types."""
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

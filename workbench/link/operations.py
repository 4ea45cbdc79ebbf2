"""What a client may say: operations as records, and their reading.

The same records go on to the flight, with the client's number: see `backplane.Request`.
"""

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from enum import Enum
from typing import ClassVar

from workbench.link.codes import NackCode
from workbench.link.drone_topics import LONGEST_NAME
from workbench.link.json_fields import LARGEST_ID, LONGEST_TOPIC, BadOperation, JsonFields
from workbench.link.strict_json import read_json, write_json

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


@dataclass(frozen=True, slots=True)
class Login:
    """Who a client is; nonce and proof are empty where no token is asked for."""

    op: ClassVar[str] = "login"
    id: int = 0
    name: str = ""
    role: Role | None = None
    nonce: str = ""
    proof: str = ""


@dataclass(frozen=True, slots=True)
class Subscribe:
    """Which topics are to come, "*" for all; this replaces what was subscribed before.

    Attributes:
        id: echoed in the answer; so in the others.
        topics: their names.
        rate: largest frames a second of each topic, None for all there are [1/s].
    """

    op: ClassVar[str] = "subscribe"
    id: int = 0
    topics: tuple[str, ...] = ("*",)
    rate: float | None = None


@dataclass(frozen=True, slots=True)
class RequestControl:
    """A client wants to fly; `name` replaces that of login, if it is not empty."""

    op: ClassVar[str] = "request_control"
    id: int = 0
    name: str = ""


@dataclass(frozen=True, slots=True)
class ReleaseControl:
    """A client wants to fly no longer."""

    op: ClassVar[str] = "release_control"
    id: int
    lease: int


@dataclass(frozen=True, slots=True)
class FlightOperation:
    """A client wants to arm, take_off to a height above the ground [m], land, stop or hold."""

    op: ClassVar[str] = "flight"
    id: int
    what: str
    height: float
    lease: int


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
class Ping:
    """A client wants to know whether somebody is there."""

    op: ClassVar[str] = "ping"
    id: int = 0


@dataclass(frozen=True, slots=True)
class Bye:
    """A client goes."""

    op: ClassVar[str] = "bye"
    id: int = 0


FlightRequest = RequestControl | ReleaseControl | FlightOperation | GetParameters | SetParameters
"""Operations that the flight answers."""
Operation = Login | Subscribe | FlightRequest | Ping | Bye

COMMANDING = (RequestControl, ReleaseControl, FlightOperation, SetParameters)
"""Operations that carry a proof where tokens are in use."""


def read_operation(payload: bytes) -> Operation:
    """Return what a client says.

    Args:
        payload: of a control frame.

    Raises:
        WireError: if it is no strict JSON; the connection must end.
        BadOperation: if it is not one of the operations, or has wrong values.
    """
    fields = JsonFields(read_json(payload))
    if fields.op not in _READERS:
        known = ", ".join(_READERS)
        raise BadOperation(
            NackCode.UNKNOWN_OP, f"operation {fields.op!r} is unknown: known are {known}", fields.id
        )
    return _READERS[fields.op](fields)


def write_operation(operation: Operation) -> bytes:
    """Return the payload of a control frame that says it; what is empty is left out."""
    found: dict[str, object] = {"op": operation.op}
    for name in type(operation).__slots__:
        value = getattr(operation, name)
        if value not in (None, "") and (name, value) != ("id", 0):
            found[name] = value.value if isinstance(value, Enum) else value
    return write_json(found)


def _login(fields: JsonFields) -> Login:
    role = fields.member("role", Role) if "role" in fields else None
    nonce = fields.digits("nonce", NONCE_DIGITS) if "nonce" in fields else ""
    proof = fields.digits("proof", PROOF_DIGITS) if "proof" in fields else ""
    return Login(fields.id, _name(fields), role, nonce, proof)


def _subscribe(fields: JsonFields) -> Subscribe:
    rate = fields.number("rate", SLOWEST, FASTEST) if "rate" in fields else None
    return Subscribe(fields.id, fields.names("topics", LONGEST_TOPIC), rate)


def _flight(fields: JsonFields) -> FlightOperation:
    what = fields.choice("what", FLIGHT_OPERATIONS)
    height = TAKE_OFF_HEIGHT
    if "height" in fields:
        height = fields.number("height", 0.0, HIGHEST_TAKE_OFF)
        if height == 0.0:
            raise fields.bad('"height" must be above the ground [m]')
    return FlightOperation(fields.id, what, height, _lease(fields))


def _parameters(fields: JsonFields) -> GetParameters | SetParameters:
    if ("get" in fields) == ("set" in fields):
        raise fields.bad('give either "get" or "set"')
    if "get" in fields:
        return GetParameters(fields.id, fields.names("get", LONGEST_NAME))
    values = fields.numbers("set")
    if not values:
        raise fields.bad('"set" names no parameter')
    return SetParameters(fields.id, values, _lease(fields))


def _name(fields: JsonFields) -> str:
    return fields.text("name", LONGEST_NAME) if "name" in fields else ""


def _lease(fields: JsonFields) -> int:
    return fields.integer("lease", 1, LARGEST_ID)


_READERS: dict[str, Callable[[JsonFields], Operation]] = {
    "login": _login,
    "subscribe": _subscribe,
    "request_control": lambda fields: RequestControl(fields.id, _name(fields)),
    "release_control": lambda fields: ReleaseControl(fields.id, _lease(fields)),
    "flight": _flight,
    "parameters": _parameters,
    "ping": lambda fields: Ping(fields.id),
    "bye": lambda fields: Bye(fields.id),
}

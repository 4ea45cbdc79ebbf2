"""Read messages of the link from JSON objects, and write them."""

import math
from collections.abc import Callable, Mapping
from dataclasses import fields
from enum import Enum

from workbench.link.codes import DeniedError, NackCode
from workbench.link.drone_topics import MAX_LINK_NAME_CHARS
from workbench.link.hello import MAX_PEER_NUMBER, Hello, read_hello
from workbench.link.json_fields import (
    MAX_REQUEST_ID,
    MAX_TOPIC_NAME_CHARS,
    JsonFields,
    read_json,
    write_json,
)
from workbench.link.messages import (
    Bye,
    ControlOwner,
    ControlState,
    DescribeVehicle,
    Error,
    FlightDone,
    FlightOperation,
    GetParameters,
    LinkLossStage,
    Login,
    Nack,
    ParameterValues,
    Ping,
    Pong,
    ReleaseControl,
    RequestControl,
    Role,
    SetParameters,
    Subscribe,
)
from workbench.link.wire import MAX_PAYLOAD_BYTES

FLIGHT_OPERATIONS = ("arm", "take_off", "land", "stop", "hold", "reset")
TAKE_OFF_HEIGHT_M = 1.5
"""Default height of a take-off [m]."""
MAX_TAKE_OFF_HEIGHT_M = 1000.0
MIN_TOPIC_RATE_HZ = 0.1
MAX_TOPIC_RATE_HZ = 10_000.0
"""Limits of the requested frames per second [1/s]."""
LONGEST_TOKEN = 1024
"""Size limit of a token [bytes]."""
NONCE_DIGITS = 32
PROOF_DIGITS = 64
FlightRequest = (
    RequestControl
    | ReleaseControl
    | FlightOperation
    | GetParameters
    | SetParameters
    | DescribeVehicle
)
"""Requests that the flight answers."""
Operation = Login | Subscribe | FlightRequest | Ping | Bye
"""Messages of a client."""
ServerMessage = (
    Hello
    | Login
    | Subscribe
    | RequestControl
    | ReleaseControl
    | ParameterValues
    | DescribeVehicle
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
    found = _message_fields(operation)
    if not found.get("id"):
        found.pop("id", None)
    return write_json(found)


def write_message(message: ServerMessage) -> bytes:
    """Return the payload of a control frame for a message."""
    if isinstance(message, Hello):
        return write_json({"op": "hello"} | message.values())
    return write_json(_message_fields(message))


def _message_fields(message: Operation | ServerMessage) -> dict[str, object]:
    """Return a message in JSON types, without fields that are None, or optional and empty."""
    found: dict[str, object] = {"op": message.op}
    for each in fields(message):
        value = getattr(message, each.name)
        empty = value in ("", 0) and value == each.default and each.name != "id"
        if value is not None and not empty:
            found[each.name] = _field_as_json(value)
    return found


def _field_as_json(value: object) -> object:
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
    token = found.text("token", LONGEST_TOKEN) if "token" in found else ""
    nonce = found.digits("nonce", NONCE_DIGITS) if "nonce" in found else ""
    proof = found.digits("proof", PROOF_DIGITS) if "proof" in found else ""
    return Login(found.id, _requester_name(found), role, token, nonce, proof)


def _subscribe(found: JsonFields) -> Subscribe:
    rate = found.number("rate", MIN_TOPIC_RATE_HZ, MAX_TOPIC_RATE_HZ) if "rate" in found else None
    return Subscribe(found.id, found.names("topics", MAX_TOPIC_NAME_CHARS), rate)


def _flight(found: JsonFields) -> FlightOperation:
    what = found.choice("what", FLIGHT_OPERATIONS)
    height = TAKE_OFF_HEIGHT_M
    if "height" in found:
        height = found.number("height", 0.0, MAX_TAKE_OFF_HEIGHT_M)
        if height == 0.0:
            raise found.bad('"height" must be above the ground [m]')
    return FlightOperation(found.id, what, height, _lease(found))


def _read_parameters(found: JsonFields) -> GetParameters | SetParameters:
    if ("get" in found) == ("set" in found):
        raise found.bad('give either "get" or "set"')
    if "get" in found:
        return GetParameters(found.id, found.names("get", MAX_LINK_NAME_CHARS))
    values = found.numbers("set")
    if not values:
        raise found.bad('"set" names no parameter')
    return SetParameters(found.id, values, _lease(found))


def _requester_name(found: JsonFields) -> str:
    return found.text("name", MAX_LINK_NAME_CHARS) if "name" in found else ""


def _lease(found: JsonFields) -> int:
    return found.integer("lease", 1, MAX_REQUEST_ID)


def _control_state(found: JsonFields) -> ControlState:
    return ControlState(
        hand=found.member("hand", ControlOwner),
        peer=found.integer("peer", 0, MAX_PEER_NUMBER),
        name=found.text("name", MAX_LINK_NAME_CHARS),
        stage=found.member("stage", LinkLossStage),
        age=found.number("age") if "age" in found else math.inf,
        reason=found.sentence("reason"),
    )


def _nack(found: JsonFields) -> Nack:
    return Nack(
        code=found.text("code", MAX_LINK_NAME_CHARS),
        said=found.sentence("said"),
        id=found.id if "id" in found else None,
        seq=found.integer("seq", 0, MAX_REQUEST_ID) if "seq" in found else None,
    )


_OPERATIONS: dict[str, Callable[[JsonFields], Operation]] = {
    "login": _login,
    "subscribe": _subscribe,
    "request_control": lambda found: RequestControl(found.id, _requester_name(found)),
    "release_control": lambda found: ReleaseControl(found.id, _lease(found)),
    "flight": _flight,
    "parameters": _read_parameters,
    "description": lambda found: DescribeVehicle(found.id),
    "ping": lambda found: Ping(found.id),
    "bye": lambda found: Bye(found.id or None),
}
_MESSAGES: dict[str, Callable[[JsonFields], ServerMessage]] = {
    "hello": read_hello,
    "login": lambda found: Login(found.id, role=found.member("role", Role)),
    "subscribe": lambda found: Subscribe(found.id, found.names("topics", MAX_TOPIC_NAME_CHARS)),
    "request_control": lambda found: RequestControl(
        found.id, lease=_lease(found), expires=found.number("expires", 0.0)
    ),
    "release_control": lambda found: ReleaseControl(found.id),
    "parameters": lambda found: ParameterValues(
        found.id,
        found.numbers("values"),
        found.integer("applied_ns", 0, MAX_PEER_NUMBER) if "applied_ns" in found else None,
    ),
    "description": lambda found: DescribeVehicle(found.id, found.text("urdf", MAX_PAYLOAD_BYTES)),
    "flight": lambda found: FlightDone(
        found.id,
        found.choice("what", FLIGHT_OPERATIONS),
        found.integer("applied_ns", 0, MAX_PEER_NUMBER),
    ),
    "control_state": _control_state,
    "pong": lambda found: Pong(found.id, found.integer("t_ns", 0, MAX_PEER_NUMBER)),
    "nack": _nack,
    "error": lambda found: Error(found.text("code", MAX_LINK_NAME_CHARS), found.sentence("said")),
    "bye": lambda found: Bye(said=found.sentence("said") if "said" in found else ""),
}

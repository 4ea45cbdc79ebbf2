"""The first message of the server: all that a client needs to decode the others."""

from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar

from workbench.link.drone_topics import MAX_LINK_NAME_CHARS
from workbench.link.json_fields import MAX_REQUEST_ID, JsonFields
from workbench.link.topics import Topic, topic_from
from workbench.link.wire import (
    MAX_BYTES_BEFORE_LOGIN,
    MAX_OPERATION_BYTES,
    MAX_PAYLOAD_BYTES,
    PROTOCOL_VERSION,
)

MAX_PEER_NUMBER = 2**63 - 1
MAX_CLIENTS = 1_000_000


@dataclass(frozen=True, slots=True)
class ServerLimits:
    """The limits of the server.

    Attributes:
        level_speed: largest level speed of commands [m/s].
        climb_rate: up or down [m/s].
        yaw_rate: either way [rad/s].
        largest: bytes allowed after a header.
        largest_before_login: the same, before login.
        largest_operation: the same, for a frame with an operation.
        clients: number of simultaneous clients.
        clients_an_address: number of simultaneous clients from one address.
        hold_after: silence after which the drone holds its position, simulated [s].
        lost_after: silence after which anybody may request control [s].
        land_after: silence after which the drone lands [s].
        oldest_state: largest age of the state that a command acts on [s].
    """

    level_speed: float
    climb_rate: float
    yaw_rate: float
    largest: int = MAX_PAYLOAD_BYTES
    largest_before_login: int = MAX_BYTES_BEFORE_LOGIN
    clients: int = 16
    clients_an_address: int = 4
    hold_after: float = 0.5
    lost_after: float = 2.0
    land_after: float = 5.0
    oldest_state: float = 1.0
    largest_operation: int = MAX_OPERATION_BYTES


@dataclass(frozen=True, slots=True)
class ParameterRow:
    """A live parameter, with bounds and default in its unit."""

    name: str
    unit: str
    low: float
    high: float
    default: float
    help: str


@dataclass(frozen=True, slots=True)
class Hello:
    """The first frame.

    Attributes:
        server: its name and version.
        session: id of this start of the server, hexadecimal.
        peer: number of this connection, as in control_state.
        vehicle: name of the vehicle.
        nonce: for login, 32 hexadecimal digits.
        login: whether login is required.
        limits: of the server.
        topics: those that clients may subscribe to, or send.
        parameters: those that clients may get and set.
        protocol: lowest and highest supported version.
    """

    op: ClassVar[str] = "hello"
    server: str
    session: str
    peer: int
    vehicle: str
    nonce: str
    login: bool
    limits: ServerLimits
    topics: tuple[Topic, ...]
    parameters: tuple[ParameterRow, ...]
    protocol: tuple[int, int] = (PROTOCOL_VERSION, PROTOCOL_VERSION)

    def values(self) -> dict[str, object]:
        """Return the content in JSON types."""
        return {
            "protocol": list(self.protocol),
            "server": self.server,
            "session": self.session,
            "peer": self.peer,
            "vehicle": self.vehicle,
            "nonce": self.nonce,
            "login": self.login,
            "limits": asdict(self.limits),
            "topics": [topic.definition() for topic in self.topics],
            "parameters": [asdict(row) for row in self.parameters],
        }


def read_hello(found: JsonFields) -> Hello:
    """Return the content of the first frame.

    Raises:
        DeniedError: if something is missing or wrong.
    """
    return Hello(
        protocol=_read_bounds(found),
        server=found.sentence("server"),
        session=found.text("session", MAX_LINK_NAME_CHARS),
        peer=found.integer("peer", 0, MAX_PEER_NUMBER),
        vehicle=found.sentence("vehicle"),
        nonce=found.digits("nonce", 32),
        login=found.truth("login"),
        limits=_read_limits(found.within("limits")),
        topics=_read_topics(found),
        parameters=tuple(_parameter(found.part(each)) for each in found.objects("parameters")),
    )


def _read_bounds(found: JsonFields) -> tuple[int, int]:
    low, high = found.integers("protocol", 2)
    if not low <= PROTOCOL_VERSION <= high:
        raise found.bad(
            f"the server speaks versions {low} to {high}, this client {PROTOCOL_VERSION}"
        )
    return low, high


def _read_limits(found: JsonFields) -> ServerLimits:
    most = dict.fromkeys(("clients", "clients_an_address"), MAX_CLIENTS)
    values: dict[str, Any] = {
        each.name: found.integer(each.name, 1, most.get(each.name, MAX_REQUEST_ID))
        if each.type is int
        else found.number(each.name, 0.0)
        for each in fields(ServerLimits)
        if each.name != "largest_operation"  # not read, as older servers do not state it
    }
    return ServerLimits(**values)


def _read_topics(found: JsonFields) -> tuple[Topic, ...]:
    try:
        topics = tuple(topic_from(each) for each in found.objects("topics"))
    except ValueError as error:
        raise found.bad(f'"topics": {error}') from error
    if len({topic.id for topic in topics}) < len(topics):
        raise found.bad('"topics": two have the same number')
    return topics


def _parameter(found: JsonFields) -> ParameterRow:
    return ParameterRow(
        name=found.text("name", MAX_LINK_NAME_CHARS),
        unit=found.text("unit", MAX_LINK_NAME_CHARS),
        low=found.number("low"),
        high=found.number("high"),
        default=found.number("default"),
        help=found.sentence("help"),
    )

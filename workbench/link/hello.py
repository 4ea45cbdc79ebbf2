"""The first message of the server: all that a client needs to decode the others."""

from dataclasses import asdict, dataclass, fields
from typing import Any, ClassVar

from workbench.link.drone_topics import LONGEST_NAME
from workbench.link.json_fields import LARGEST_ID, JsonFields
from workbench.link.topics import Topic, topic_from
from workbench.link.wire import LARGEST, LARGEST_BEFORE_LOGIN, LARGEST_OPERATION, VERSION

LARGEST_PEER = 2**63 - 1
MOST_CLIENTS = 1_000_000


@dataclass(frozen=True, slots=True)
class Limits:
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
    largest: int = LARGEST
    largest_before_login: int = LARGEST_BEFORE_LOGIN
    clients: int = 16
    clients_an_address: int = 4
    hold_after: float = 0.5
    lost_after: float = 2.0
    land_after: float = 5.0
    oldest_state: float = 1.0
    largest_operation: int = LARGEST_OPERATION


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
    limits: Limits
    topics: tuple[Topic, ...]
    parameters: tuple[ParameterRow, ...]
    protocol: tuple[int, int] = (VERSION, VERSION)

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
        protocol=_range(found),
        server=found.sentence("server"),
        session=found.text("session", LONGEST_NAME),
        peer=found.integer("peer", 0, LARGEST_PEER),
        vehicle=found.sentence("vehicle"),
        nonce=found.digits("nonce", 32),
        login=found.truth("login"),
        limits=_limits(found.within("limits")),
        topics=_topics(found),
        parameters=tuple(_parameter(found.part(each)) for each in found.objects("parameters")),
    )


def _range(found: JsonFields) -> tuple[int, int]:
    low, high = found.integers("protocol", 2)
    if not low <= VERSION <= high:
        raise found.bad(f"the server speaks versions {low} to {high}, this client {VERSION}")
    return low, high


def _limits(found: JsonFields) -> Limits:
    most = dict.fromkeys(("clients", "clients_an_address"), MOST_CLIENTS)
    values: dict[str, Any] = {
        each.name: found.integer(each.name, 1, most.get(each.name, LARGEST_ID))
        if each.type is int
        else found.number(each.name, 0.0)
        for each in fields(Limits)
        if each.name != "largest_operation"  # not read, as older servers do not state it
    }
    return Limits(**values)


def _topics(found: JsonFields) -> tuple[Topic, ...]:
    try:
        topics = tuple(topic_from(each) for each in found.objects("topics"))
    except ValueError as error:
        raise found.bad(f'"topics": {error}') from error
    if len({topic.id for topic in topics}) < len(topics):
        raise found.bad('"topics": two have the same number')
    return topics


def _parameter(found: JsonFields) -> ParameterRow:
    return ParameterRow(
        name=found.text("name", LONGEST_NAME),
        unit=found.text("unit", LONGEST_NAME),
        low=found.number("low"),
        high=found.number("high"),
        default=found.number("default"),
        help=found.sentence("help"),
    )

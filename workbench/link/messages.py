"""The messages between clients and server, as records to write and read.

Requests to the flight are passed on with the number of the client, and the flight answers with such
records, see `backplane`. A request and an answer with the same content share one record.
"""

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import Enum
from typing import ClassVar


class Role(Enum):
    """The roles of clients."""

    VIEW = "view"
    COMMAND = "command"


class ControlOwner(Enum):
    """Who is in control."""

    NOBODY = "nobody"
    CLIENT = "client"
    OPERATOR = "operator"


class LinkLossStage(Enum):
    """The stages of silence of a holder."""

    LIVE = "live"
    HOLD = "hold"
    LOST = "lost"
    LAND = "land"


@dataclass(frozen=True, slots=True)
class Login:
    """The login of a client, with the token of its role if one is required.

    The answer has only id and role. Older clients prove that they have the token, with a nonce.
    """

    op: ClassVar[str] = "login"
    id: int = 0
    name: str = ""
    role: Role | None = None
    token: str = field(default="", repr=False)
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
    """A client requests arm, take_off to a height above the ground [m], land, stop, hold or reset.

    A reset starts the flight again, and ends the lease.
    """

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
class DescribeVehicle:
    """A client requests the description of the vehicle; the answer has it as URDF.

    Links have the names of the frames in the topic frames, and meshes are `file://` addresses on
    the computer that flies.
    """

    op: ClassVar[str] = "description"
    id: int = 0
    urdf: str = ""


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
    hand: ControlOwner
    peer: int
    name: str
    stage: LinkLossStage
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


COMMANDING = (RequestControl, ReleaseControl, FlightOperation, SetParameters)
"""Operations that need the role command."""

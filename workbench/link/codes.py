"""The words with which a server refuses, for programs; docs/protocol.md says what to do at each."""

from enum import StrEnum


class NackCode(StrEnum):
    """Why a request or a command was not done; the connection goes on."""

    UNKNOWN_OP = "unknown_op"
    """An operation that this server does not know."""
    BAD_VALUE = "bad_value"
    """A value is missing, of the wrong type, too long or out of its range."""
    UNKNOWN_TOPIC = "unknown_topic"
    """No such topic, or none that a client may send."""
    BAD_SIZE = "bad_size"
    """A data frame has not its topic's size."""
    UNKNOWN_PARAMETER = "unknown_parameter"
    NOT_ALLOWED = "not_allowed"
    """The role only watches, or the server takes no commands."""
    NOT_HOLDER = "not_holder"
    """The lease is another's, has run out, or is not the one that was granted last."""
    HELD = "held"
    """Another holds control."""
    NEUTRAL_FIRST = "neutral_first"
    """A new holder's first command must be zero on all axes."""
    NOT_FINITE = "not_finite"
    """NaN or infinity: the whole command is refused."""
    NO_AXES = "no_axes"
    """No axis is asked for, or one that is not there."""
    TOO_FAST = "too_fast"
    """Over twice a limit."""
    SCALED = "scaled"
    """Applied, but smaller: it was over a limit."""
    STALE = "stale"
    """The state that was acted on is too old, or not there yet."""
    NOT_NOW = "not_now"
    """The flight mode does not allow it."""


class ErrorCode(StrEnum):
    """Why the server ends a connection."""

    MAGIC = "magic"
    VERSION = "version"
    KIND = "kind"
    LENGTH = "length"
    JSON = "json"
    LOGIN = "login"
    """Something else came before login, or no login in time."""
    BAD_LOGIN = "bad_login"
    """The proof is wrong, or login came twice."""
    PROOF = "proof"
    """A frame that commands has no proof, or a wrong one."""
    SEQ = "seq"
    """A frame that commands has a number that was used before."""
    TOO_MANY = "too_many"
    """As many clients as the server takes, all in all or from this address."""
    BACK_OFF = "back_off"
    """Too many bad logins from this address: wait."""
    SLOW = "slow"
    """Nothing was acknowledged, or nothing could be written, for too long."""
    OVERFLOW = "overflow"
    """Too many events and answers wait to be read."""
    DISCONNECTED = "disconnected"
    """The operator at the screen has ended it."""
    INTERNAL = "internal"
    """The server has failed at this connection; a bug."""


class DeniedError(Exception):
    """An operation or a command that is not carried out; the connection goes on.

    Attributes:
        code: a word for programs: a `NackCode`, or where the connection does end, an `ErrorCode`.
        said: a sentence.
        id: of the operation, 0 without one.
    """

    def __init__(self, code: str, said: str, id: int = 0) -> None:
        super().__init__(said)
        self.code = code
        self.said = said
        self.id = id

"""Codes of rejections by a server; docs/protocol.md explains how to handle each."""

from enum import StrEnum


class NackCode(StrEnum):
    """Reasons why a request or a command was rejected; the connection continues."""

    UNKNOWN_OP = "unknown_op"
    """An operation that this server does not know."""
    BAD_VALUE = "bad_value"
    """A value is missing, of the wrong type, too long or out of range."""
    UNKNOWN_TOPIC = "unknown_topic"
    """The topic is unknown, or clients may not send it."""
    BAD_SIZE = "bad_size"
    """The size of a data frame does not match its topic."""
    UNKNOWN_PARAMETER = "unknown_parameter"
    NOT_ALLOWED = "not_allowed"
    """The role may only watch, or the server accepts no commands."""
    NOT_HOLDER = "not_holder"
    """The lease belongs to another client, has expired, or is not the last one granted."""
    HELD = "held"
    """Another client has control."""
    NEUTRAL_FIRST = "neutral_first"
    """The first command of a new holder must be zero on all axes."""
    NOT_FINITE = "not_finite"
    """NaN or infinity; the whole command is rejected."""
    NO_AXES = "no_axes"
    """The command has no axis, or an unknown one."""
    TOO_FAST = "too_fast"
    """The command exceeds twice a limit."""
    SCALED = "scaled"
    """The command exceeded a limit, and was scaled down."""
    STALE = "stale"
    """The state that the command acts on is too old, or does not exist yet."""
    NOT_NOW = "not_now"
    """The flight mode does not permit it."""


class ErrorCode(StrEnum):
    """Why the server ends a connection."""

    MAGIC = "magic"
    VERSION = "version"
    KIND = "kind"
    LENGTH = "length"
    JSON = "json"
    LOGIN = "login"
    """Another message came before login, or login took too long."""
    BAD_LOGIN = "bad_login"
    """The token is wrong, or login was repeated."""
    TOO_MANY = "too_many"
    """The limit of clients is reached, in total or for this address."""
    BACK_OFF = "back_off"
    """Too many bad logins from this address: wait."""
    SLOW = "slow"
    """No acknowledgement came, or nothing could be written, for too long."""
    OVERFLOW = "overflow"
    """Too many events and answers are waiting to be read."""
    DISCONNECTED = "disconnected"
    """The operator at the screen has ended the connection."""
    INTERNAL = "internal"
    """The server has failed on this connection, due to a bug."""


class DeniedError(Exception):
    """An operation or a command is rejected; the connection continues.

    Attributes:
        code: a `NackCode`, or an `ErrorCode` if the connection ends.
        said: the reason, a sentence.
        id: of the operation, 0 without one.
    """

    def __init__(self, code: str, said: str, id: int = 0) -> None:
        super().__init__(said)
        self.code = code
        self.said = said
        self.id = id

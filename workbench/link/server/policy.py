"""The policy of a server: its greeting, and the permissions of clients."""

import secrets
from collections.abc import Sequence
from dataclasses import asdict, dataclass, field
from functools import cached_property

from workbench.common.errors import unknown_name
from workbench.link.authentication import Tokens, shows_token
from workbench.link.backplane import ServedFlight
from workbench.link.codes import DeniedError, ErrorCode, NackCode
from workbench.link.drone_topics import COMMAND_SIGNAL
from workbench.link.hello import Hello, ServerLimits
from workbench.link.json_fields import write_json
from workbench.link.messages import Login, Role
from workbench.link.topics import Topic, TopicDirection
from workbench.link.wire import WireFrame

SESSION_BYTES = 8


@dataclass(frozen=True)
class Policy:
    """The greeting of a server, and the permissions of clients.

    Attributes:
        flight: the flight served.
        tokens: None if no login is required.
        allow_commands: whether clients may send commands.
        clients: largest number at once.
        server: name and version.
        session: id of this start of the server.
    """

    flight: ServedFlight
    tokens: Tokens | None = None
    allow_commands: bool = True
    clients: int = 16
    server: str = "drake-drone-workbench"
    session: str = field(default_factory=lambda: secrets.token_hex(SESSION_BYTES))

    @property
    def open_role(self) -> Role | None:
        """The role of a client without login; None if login is required."""
        if self.tokens is not None:
            return None
        return self.best_role

    @property
    def best_role(self) -> Role:
        """The highest role of any client."""
        return Role.COMMAND if self.allow_commands else Role.VIEW

    def hindrance(self, role: Role | None) -> str | None:
        """Return why a client with this role may not send commands, or None if it may."""
        if not self.allow_commands:
            return "this server takes no commands: start it with commands allowed"
        if role is not Role.COMMAND:
            return "this client only watches: log in with the role command"
        return None

    def role_of(self, login: Login, nonce: str) -> Role:
        """Return the role of a client that logs in.

        Args:
            login: of the client.
            nonce: of this connection, from the server.

        Raises:
            DeniedError: if the token is wrong.
        """
        if self.tokens is None:
            return Role.VIEW if login.role is Role.VIEW else self.best_role
        if login.role is None or not (login.token or (login.nonce and login.proof)):
            said = "login needs role and token: this server has tokens"
            raise DeniedError(ErrorCode.BAD_LOGIN, said)
        if not shows_token(login, self.tokens.of(login.role), nonce):
            said = f"the token is not that of role {login.role.value}"
            raise DeniedError(ErrorCode.BAD_LOGIN, said)
        return login.role if self.allow_commands else Role.VIEW

    def command_fault(self, frame: WireFrame, role: Role | None) -> tuple[NackCode, str] | None:
        """Return why a frame of data is no command that a client with this role may send."""
        topic = self.command
        if topic is None or frame.topic != topic.id:
            return NackCode.UNKNOWN_TOPIC, f"topic {frame.topic} is not one that clients send"
        size, right = len(frame.payload), topic.packer.size
        if size != right:
            return NackCode.BAD_SIZE, f"{topic.name} has {right} bytes, the frame has {size}"
        if (hindrance := self.hindrance(role)) is not None:
            return NackCode.NOT_ALLOWED, hindrance
        return None

    @cached_property
    def command(self) -> Topic | None:
        """The topic of commands."""
        found = [topic for topic in self.flight.topics if topic.id == COMMAND_SIGNAL.id]
        return found[0] if found else None

    def topics(self, names: Sequence[str], id: int) -> tuple[Topic, ...]:
        """Return topics by name, "*" for all that the server sends.

        Raises:
            DeniedError: if a topic is unknown.
        """
        sent = {
            topic.name: topic
            for topic in self.flight.topics
            if topic.direction is not TopicDirection.IN
        }
        if "*" in names:
            return tuple(sent.values())
        for name in names:
            if name not in sent:
                said = str(unknown_name("topic", name, sent))
                raise DeniedError(NackCode.UNKNOWN_TOPIC, said, id)
        return tuple(sent[name] for name in dict.fromkeys(names))

    def hello(self, peer: int, nonce: str, an_address: int) -> bytes:
        """Return the payload of the first frame.

        Args:
            peer: number of the client.
            nonce: for its login.
            an_address: largest number of clients from its address.
        """
        limits = {**asdict(self._limits), "clients_an_address": an_address}
        own = write_json({"op": Hello.op, "peer": peer, "nonce": nonce, "limits": limits})
        return own[:-1] + b"," + self._hello[1:]

    @cached_property
    def _limits(self) -> ServerLimits:
        level, climb, turn = self.flight.limits
        return ServerLimits(level, climb, turn, clients=self.clients)

    @cached_property
    def _hello(self) -> bytes:
        """The part of the first frame that is equal for all clients, encoded once."""
        hello = Hello(
            server=self.server,
            session=self.session,
            peer=0,
            vehicle=self.flight.vehicle,
            nonce="",
            login=self.tokens is not None,
            limits=self._limits,
            topics=self.flight.topics,
            parameters=self.flight.parameters,
        )
        own = ("peer", "nonce", "limits")
        return write_json({name: each for name, each in hello.values().items() if name not in own})

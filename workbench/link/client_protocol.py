"""The client side of one connection, without sockets: bytes in; bytes, samples and messages out."""

import math
from collections.abc import Sequence
from dataclasses import dataclass, field

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.link.codes import DeniedError
from workbench.link.drone_topics import COMMAND_SIGNAL, MAX_LINK_NAME_CHARS
from workbench.link.hello import Hello
from workbench.link.message_json import (
    MAX_TOPIC_RATE_HZ,
    MIN_TOPIC_RATE_HZ,
    Operation,
    ServerMessage,
    read_message,
    write_operation,
)
from workbench.link.messages import Bye, Error, Login, Nack, Pong, Role, Subscribe
from workbench.link.sample import Sample
from workbench.link.topics import PREFIX, Topic
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireError, WireFrame

LOGIN_ID = 1
SUBSCRIBE_ID = 2
"""Id of the protocol's own request; other ids come after."""
ACKNOWLEDGE_FLAG = int(FrameFlag.ACKNOWLEDGE)
"""A plain number, as combining flags takes microseconds at each frame."""
ALL_TOPICS = "*"
NOT_A_SERVER = "the first frame is not HELLO: this is not a server of this protocol"


@dataclass(frozen=True)
class ClientOptions:
    """The options of a client, checked before anything is sent.

    Attributes:
        name: of the client.
        token: of its role; empty without one.
        role: the requested one.
        topics: names, or "*" for all.
        rate: largest number of frames per second for each topic [1/s]; None for all.
    """

    name: str = ""
    token: str = field(default="", repr=False)
    role: Role = Role.COMMAND
    topics: tuple[str, ...] = (ALL_TOPICS,)
    rate: float | None = None


class ClientProtocol:
    """Greets, logs in and subscribes; then receives samples and sends operations.

    Attributes:
        hello: first message of the server, None before.
        ready: whether login and subscription are done.
        end: why the connection ended, None before.
        newest_ns: simulated time of the newest state [ns], None before the first.
        samples: received samples; the reader empties the list.
        messages: answers, refusals and control states, in order; the reader empties the list.
        seq: number of the last frame sent.
    """

    def __init__(self, options: ClientOptions) -> None:
        self.hello: Hello | None = None
        self.ready = False
        self.end: Error | None = None
        self.newest_ns: int | None = None
        self.samples: list[Sample] = []
        self.messages: list[ServerMessage] = []
        self._options = options
        self._decoder = Decoder()
        self._topics: dict[int, Topic] = {}
        self._outgoing = bytearray()
        self.seq = 0
        self._last_id = SUBSCRIBE_ID

    def receive(self, data: bytes) -> None:
        """Process received bytes."""
        try:
            for frame in self._decoder.feed(data):
                if self.end is None:
                    self._take(frame)
        except (WireError, DeniedError) as error:
            self._finish(error.code, f"what the server sent cannot be understood: {error}")

    def take_outgoing(self) -> bytes:
        """Return the bytes to send now."""
        data = bytes(self._outgoing)
        self._outgoing.clear()
        return data

    def new_id(self) -> int:
        """Return a number for a request."""
        self._last_id += 1
        return self._last_id

    def send(self, operation: Operation) -> None:
        """Send an operation."""
        self._send_frame(FrameKind.CONTROL, 0, 0, write_operation(operation))

    def command(self, payload: bytes) -> None:
        """Send a command that acts on the newest state; `seq` becomes its number."""
        self._send_frame(FrameKind.DATA, COMMAND_SIGNAL.id, self.newest_ns or 0, payload)

    @property
    def command_topic(self) -> Topic | None:
        """The topic of commands, None if the server accepts none."""
        return self._topics.get(COMMAND_SIGNAL.id)

    def _send_frame(self, kind: FrameKind, topic: int, t_ns: int, payload: bytes) -> None:
        self.seq += 1
        self._outgoing += WireFrame(kind, topic, 0, self.seq, t_ns, payload).to_bytes()

    def _take(self, frame: WireFrame) -> None:
        if frame.kind == FrameKind.CONTROL:
            self._receive(read_message(frame.payload))
        elif self.hello is None:
            self._finish("hello", NOT_A_SERVER)
        elif frame.kind == FrameKind.DATA:
            self._keep(frame)
        if frame.flags & ACKNOWLEDGE_FLAG:
            self._outgoing += WireFrame(
                FrameKind.ACKNOWLEDGEMENT, 0, 0, frame.seq, 0, b""
            ).to_bytes()

    def _receive(self, message: ServerMessage | None) -> None:
        """Handle messages about the connection itself; pass on the rest."""
        match message:
            case Error(code, sentence):
                self._finish(code, f"the server ended the connection: {sentence}")
            case Bye(_, sentence):
                self._finish("bye", f"the server said goodbye: {sentence or 'it stops'}")
            case Hello() if self.hello is None:
                self._greet(message)
            case _ if self.hello is None:
                self._finish("hello", NOT_A_SERVER)
            case Login() if not self.ready:
                self._subscribe()
            case Subscribe():
                self.ready = True
            case None:  # from a newer server
                pass
            case Nack(code, sentence) if not self.ready:
                self._finish(code, f"the server refused: {sentence}")
            case _:
                if isinstance(message, Pong):  # it has the time if there are no states
                    self.newest_ns = message.t_ns
                self.messages.append(message)

    def _greet(self, hello: Hello) -> None:
        self.hello = hello
        self._topics = {topic.id: topic for topic in hello.topics}
        options = self._options
        if hello.login and not options.token:
            self._finish(
                "login", "the server wants a token: give the one for your role from its token file"
            )
        elif hello.login:
            self.send(Login(LOGIN_ID, options.name, options.role, options.token))
        elif options.name:
            self.send(Login(LOGIN_ID, options.name))
        else:
            self._subscribe()

    def _subscribe(self) -> None:
        self.send(Subscribe(SUBSCRIBE_ID, self._options.topics, self._options.rate))

    def _finish(self, code: str, said: str) -> None:
        self.end = self.end or Error(code, said)

    def _keep(self, frame: WireFrame) -> None:
        """Keep a sample; topics that are not known are from a newer server."""
        topic = self._topics.get(frame.topic)
        if topic is None:
            return
        if len(frame.payload) != topic.packer.size:
            raise WireError(
                "bad_size",
                f"a frame of {topic.name} has {len(frame.payload)} bytes instead of "
                f"{topic.packer.size}",
            )
        self.newest_ns = frame.t_ns
        self.samples.append(Sample(topic, frame.t_ns, frame.payload))


def make_options(
    name: str, token: str, role: Role | str | None, topics: Sequence[str], rate: float | None
) -> ClientOptions:
    """Return the options for the arguments of a user.

    Raises:
        WorkbenchError: if one of them is invalid.
    """
    if not name.isprintable() or len(name.encode()) > MAX_LINK_NAME_CHARS:
        raise WorkbenchError(
            f"the name {name[:MAX_LINK_NAME_CHARS]!r} is not valid: give at most "
            f"{MAX_LINK_NAME_CHARS} "
            "bytes of printable text"
        )
    if rate is not None and not (
        math.isfinite(rate) and MIN_TOPIC_RATE_HZ <= rate <= MAX_TOPIC_RATE_HZ
    ):
        raise WorkbenchError(
            f"the rate {rate} is not within {MIN_TOPIC_RATE_HZ:g} .. {MAX_TOPIC_RATE_HZ:g} a second"
        )
    if isinstance(topics, str):
        topics = (topics,)
    try:
        wanted = Role.COMMAND if role is None else Role(role)
    except ValueError:
        raise unknown_name("role", str(role), (each.value for each in Role)) from None
    return ClientOptions(name, token, wanted, tuple(full_name(topic) for topic in topics), rate)


def full_name(topic: str) -> str:
    """Return the name of a topic with the common prefix."""
    return topic if topic == ALL_TOPICS or topic.startswith("/") else PREFIX + topic

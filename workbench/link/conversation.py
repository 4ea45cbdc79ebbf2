"""A client's side of one connection, without sockets: bytes in, bytes and news out."""

from dataclasses import dataclass, replace

from workbench.link.authentication import login_proof, new_nonce, prove, session_key
from workbench.link.drone_topics import COMMAND
from workbench.link.hello import Hello
from workbench.link.json_fields import BadOperation
from workbench.link.operations import COMMANDING, Login, Operation, Subscribe, write_operation
from workbench.link.sample import Sample
from workbench.link.server_messages import (
    Error,
    Goodbye,
    LoggedIn,
    Nack,
    Pong,
    ServerMessage,
    Subscribed,
    read_message,
)
from workbench.link.topics import Topic
from workbench.link.wire import Decoder, Flag, Frame, Kind, WireError
from workbench.link.wishes import Wishes

LOGIN_ID = 1
SUBSCRIBE_ID = 2
"""Requests of the conversation's own; those of others come after."""
ACKNOWLEDGE = int(Flag.ACKNOWLEDGE)
"""As a plain number: a flag takes microseconds to combine, at each frame."""
NO_SERVER = "the first frame is not HELLO: that is no server of this protocol"


@dataclass(frozen=True)
class End:
    """Why a conversation ended.

    Attributes:
        code: a word, as in an error frame.
        said: a sentence.
    """

    code: str
    said: str


class Conversation:
    """Greets, logs in, subscribes; then takes samples in and passes on what is asked.

    Attributes:
        hello: what the server said first, None until then.
        ready: whether login and subscription are done.
        end: why it is over, None while it is not.
        newest_ns: simulated time of the newest state [ns], None before the first.
        samples: what arrived; whoever takes it empties it.
        said: answers, refusals and states of control, in their order; likewise.
        seq: number of the last frame that was sent.
    """

    def __init__(self, wishes: Wishes) -> None:
        self.hello: Hello | None = None
        self.ready = False
        self.end: End | None = None
        self.newest_ns: int | None = None
        self.samples: list[Sample] = []
        self.said: list[ServerMessage] = []
        self._wishes = wishes
        self._decoder = Decoder()
        self._topics: dict[int, Topic] = {}
        self._outgoing = bytearray()
        self.seq = 0
        self._last_id = SUBSCRIBE_ID
        self._key = b""

    def receive(self, data: bytes) -> None:
        """Take in bytes as they came."""
        try:
            for frame in self._decoder.feed(data):
                if self.end is None:
                    self._take(frame)
        except (WireError, BadOperation) as error:
            self._finish(error.code, f"what the server sent cannot be understood: {error}")

    def take_outgoing(self) -> bytes:
        """Return what is to be sent now."""
        data = bytes(self._outgoing)
        self._outgoing.clear()
        return data

    def new_id(self) -> int:
        """Return a number for a request."""
        self._last_id += 1
        return self._last_id

    def ask(self, operation: Operation) -> None:
        """Send an operation, with a proof where one is due."""
        frame = Frame(Kind.CONTROL, 0, 0, 0, 0, write_operation(operation))
        self._send(frame, commanding=isinstance(operation, COMMANDING))

    def command(self, payload: bytes) -> None:
        """Send a command that acts on the newest state; `seq` is its number."""
        frame = Frame(Kind.DATA, COMMAND, 0, 0, self.newest_ns or 0, payload)
        self._send(frame, commanding=True)

    @property
    def command_topic(self) -> Topic | None:
        """The definition of a command, None where the server takes none."""
        return self._topics.get(COMMAND)

    def _send(self, frame: Frame, commanding: bool = False) -> None:
        self.seq += 1
        numbered = replace(frame, seq=self.seq)
        proven = prove(numbered, self._key) if self._key and commanding else numbered
        self._outgoing += proven.to_bytes()

    def _take(self, frame: Frame) -> None:
        if frame.kind == Kind.CONTROL:
            self._hear(read_message(frame.payload))
        elif self.hello is None:
            self._finish("hello", NO_SERVER)
        elif frame.kind == Kind.DATA:
            self._keep(frame)
        if frame.flags & ACKNOWLEDGE:
            self._outgoing += Frame(Kind.ACKNOWLEDGEMENT, 0, 0, frame.seq, 0, b"").to_bytes()

    def _hear(self, said: ServerMessage) -> None:
        """Act on what concerns the conversation itself; pass on the rest."""
        match said:
            case Error(code, sentence):
                self._finish(code, f"the server ended the connection: {sentence}")
            case Goodbye(sentence):
                self._finish("bye", f"the server said goodbye: {sentence or 'it stops'}")
            case Hello() if self.hello is None:
                self._greet(said)
            case _ if self.hello is None:
                self._finish("hello", NO_SERVER)
            case LoggedIn() if not self.ready:
                self._subscribe()
            case Subscribed():
                self.ready = True
            case Nack(code, sentence) if not self.ready:
                self._finish(code, f"the server refused: {sentence}")
            case _:
                if isinstance(said, Pong):  # tells the time where no states come
                    self.newest_ns = said.t_ns
                self.said.append(said)

    def _greet(self, hello: Hello) -> None:
        self.hello = hello
        self._topics = {topic.id: topic for topic in hello.topics}
        wishes = self._wishes
        if hello.login and not wishes.token:
            self._finish(
                "login", "the server wants a token: give the one for your role from its token file"
            )
        elif hello.login:
            nonce = new_nonce()
            self._key = session_key(wishes.token, hello.nonce, nonce)
            proof = login_proof(wishes.token, wishes.role, hello.nonce, nonce)
            self.ask(Login(LOGIN_ID, wishes.name, wishes.role, nonce, proof))
        elif wishes.name:
            self.ask(Login(LOGIN_ID, wishes.name))
        else:
            self._subscribe()

    def _subscribe(self) -> None:
        self.ask(Subscribe(SUBSCRIBE_ID, self._wishes.topics, self._wishes.rate))

    def _finish(self, code: str, said: str) -> None:
        self.end = self.end or End(code, said)

    def _keep(self, frame: Frame) -> None:
        """Keep a sample; topics that are not known are of a newer server."""
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

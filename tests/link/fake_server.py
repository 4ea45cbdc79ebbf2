"""A server of the link that says what a test tells it to, for tests of clients."""

import contextlib
import socket
import ssl
import threading
import time
from collections.abc import Callable

from workbench.link.authentication import Tokens, new_nonce, shows_token
from workbench.link.drone_topics import drone_topics
from workbench.link.hello import Hello, ParameterRow, ServerLimits
from workbench.link.message_json import ServerMessage, read_operation, write_message
from workbench.link.messages import (
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
from workbench.link.signal import TopicOptions
from workbench.link.wire import Decoder, FrameFlag, FrameKind, WireError, WireFrame

TOPICS = drone_topics(TopicOptions(rotors=4, fast=200.0, slow=10.0, rates={"gps": 10.0}))
BY_NAME = {topic.name.rsplit("/", 1)[1]: topic for topic in TOPICS}
LEASE = 4711


class Peer:
    """A connection, as the server has it."""

    def __init__(self, server: "FakeServer", stream: socket.socket, number: int) -> None:
        self.server, self.stream, self.number = server, stream, number
        self.nonce = new_nonce()
        self.seq = 0
        self.acknowledged = 0
        self.topics: tuple[str, ...] = ()
        self.lock = threading.Lock()

    def send(self, frame: WireFrame) -> None:
        with contextlib.suppress(OSError):
            self.stream.sendall(frame.to_bytes())

    def say(self, said: ServerMessage) -> None:
        with self.lock:
            self.seq += 1
            frame = WireFrame(
                FrameKind.CONTROL, 0, 0, self.seq, self.server.t_ns, write_message(said)
            )
            self.send(frame)

    def publish(self, t_ns: int, payloads: list[tuple[int, bytes]]) -> None:
        with self.lock:
            for index, (topic, payload) in enumerate(payloads):
                self.seq += 1
                last = index == len(payloads) - 1
                flags = FrameFlag.ACKNOWLEDGE if last else 0
                self.send(WireFrame(FrameKind.DATA, topic, flags, self.seq, t_ns, payload))

    def read(self) -> None:
        decoder = Decoder()
        with self.stream, contextlib.suppress(OSError, WireError):
            self.server.greet(self)
            while data := self.stream.recv(65536):
                for frame in decoder.feed(data):
                    self.server.take(self, frame)


class FakeServer:
    """Listens on loopback, greets, answers, and keeps what clients send.

    Attributes:
        commands: (lease, axes, v_x, v_y, v_z, yaw_rate) of each command, with its t_ns.
        operations: what clients said, in its order.
        answer: replaces an answer where it returns something.
        greet: says the first words.
    """

    def __init__(self, tokens: Tokens | None = None, tls: ssl.SSLContext | None = None) -> None:
        self.tokens, self.tls = tokens, tls
        self.t_ns = 5_000_000_000
        self.commands: list[tuple[int, tuple]] = []
        self.operations: list[object] = []
        self.peers: list[Peer] = []
        self.answer: Callable[[Peer, object], ServerMessage | None] = lambda peer, operation: None
        self.greet: Callable[[Peer], None] = lambda peer: peer.say(self.hello(peer))
        self.connections = 0
        self.listen(0)

    def heard(self, kind: type) -> list[object]:
        """Return the operations of a kind that clients asked for."""
        return [each for each in self.operations if isinstance(each, kind)]

    def listen(self, port: int) -> None:
        self.listener = socket.create_server(("127.0.0.1", port))
        self.port = self.listener.getsockname()[1]
        self.address = f"127.0.0.1:{self.port}"
        self.threads = [threading.Thread(target=self.accept)]
        self.threads[0].start()

    def accept(self) -> None:
        while True:
            try:
                stream, _ = self.listener.accept()
            except OSError:
                return
            try:
                if self.tls:
                    stream.settimeout(10.0)
                    stream = self.tls.wrap_socket(stream, server_side=True)
                    stream.settimeout(None)
            except OSError:
                stream.close()
                continue
            self.connections += 1
            peer = Peer(self, stream, self.connections)
            self.peers.append(peer)
            thread = threading.Thread(target=peer.read)
            self.threads.append(thread)
            thread.start()

    def hello(self, peer: Peer) -> Hello:
        return Hello(
            server="fake 1",
            session="ab12",
            peer=peer.number,
            vehicle="dh_drone",
            nonce=peer.nonce,
            login=self.tokens is not None,
            limits=ServerLimits(8.0, 8.0, 0.4),
            topics=TOPICS,
            parameters=(ParameterRow("take_off_speed", "m/s", 0.1, 2.0, 0.5, "how fast"),),
        )

    def take(self, peer: Peer, frame: WireFrame) -> None:
        if frame.kind == FrameKind.ACKNOWLEDGEMENT:
            peer.acknowledged = frame.seq
            return
        if frame.kind == FrameKind.DATA:
            values = BY_NAME["command_velocity"].unpack(frame.payload)
            self.commands.append((frame.t_ns, tuple(values.values())))
            said = self.answer(peer, frame)
        else:
            operation = read_operation(frame.payload)
            self.operations.append(operation)
            said = self.answer(peer, operation) or self.usual(peer, operation)
        if said is not None:
            peer.say(said)

    def usual(self, peer: Peer, operation: object) -> ServerMessage | None:
        match operation:
            case Login(id):
                return self.log_in(peer, operation)
            case Subscribe(id, topics):
                peer.topics = topics
                return Subscribe(id, topics)
            case RequestControl(id):
                peer.say(RequestControl(id, lease=LEASE, expires=0.5))
                return self.held_by(peer)
            case ReleaseControl(id):
                return ReleaseControl(id)
            case FlightOperation(id, what):
                return FlightDone(id, what, self.t_ns)
            case GetParameters(id):
                return ParameterValues(id, {"take_off_speed": 0.5})
            case SetParameters(id, values):
                return ParameterValues(id, values)
            case DescribeVehicle(id):
                return DescribeVehicle(id, '<robot name="fake"/>')
            case Ping(id):
                return Pong(id, self.t_ns)
        return None

    def log_in(self, peer: Peer, login: Login) -> ServerMessage:
        if self.tokens is None:
            return Login(login.id, role=Role.COMMAND)
        assert login.role is not None
        if not shows_token(login, self.tokens.of(login.role), peer.nonce):
            return Error("bad_login", "the token is wrong")
        return Login(login.id, role=login.role)

    def held_by(self, peer: Peer) -> ControlState:
        return ControlState(
            ControlOwner.CLIENT, peer.number, "", LinkLossStage.LIVE, 0.0, "granted"
        )

    def nobody(self, reason: str) -> ControlState:
        return ControlState(ControlOwner.NOBODY, 0, "", LinkLossStage.LIVE, 0.0, reason)

    def refuse(self, kind: type, code: str, said: str) -> None:
        """Refuse requests of a kind."""
        self.answer = lambda peer, operation: (
            Nack(code, said, id=operation.id) if isinstance(operation, kind) else None
        )

    def publish(self, t_ns: int, **values: tuple) -> None:
        """Send a batch: values of each topic by its short name."""
        self.t_ns = t_ns
        payloads = [(BY_NAME[name].id, BY_NAME[name].pack(each)) for name, each in values.items()]
        for peer in self.peers:
            if peer.topics:  # it has subscribed, so it was greeted before
                peer.publish(t_ns, payloads)

    def say(self, said: ServerMessage) -> None:
        for peer in self.peers:
            peer.say(said)

    def cut(self) -> None:
        """End all connections."""
        for peer in self.peers:
            with contextlib.suppress(OSError):
                peer.stream.shutdown(socket.SHUT_RDWR)
        self.peers = []

    def close(self) -> None:
        with contextlib.suppress(OSError):
            self.listener.shutdown(socket.SHUT_RDWR)
        self.listener.close()
        self.cut()
        for thread in self.threads:
            thread.join(20.0)
            assert not thread.is_alive()


def wait_until(condition: Callable[[], object], limit: float = 20.0) -> None:
    """Wait for something that comes soon; the limit is generous."""
    end = time.monotonic() + limit
    while not holds(condition):
        assert time.monotonic() < end, "it did not come"
        time.sleep(0.002)


def holds(condition: Callable[[], object]) -> bool:
    """Return whether a condition holds; what it asks about may not be there yet."""
    try:
        return bool(condition())
    except (AttributeError, IndexError):
        return False

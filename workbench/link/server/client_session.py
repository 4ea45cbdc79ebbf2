"""The session of one client: its role, its requests, and its time limits. Nothing here blocks."""

import math
from typing import Protocol

from workbench.link.address import host_of
from workbench.link.authentication import new_nonce
from workbench.link.backplane import ClientRequest, ClientStatus, ToFlight, VelocityCommand
from workbench.link.codes import DeniedError, ErrorCode, NackCode
from workbench.link.message_json import (
    FlightRequest,
    Operation,
    ServerMessage,
    read_operation,
    write_message,
)
from workbench.link.messages import (
    COMMANDING,
    Bye,
    Error,
    Login,
    Nack,
    Ping,
    Pong,
    RequestControl,
    Subscribe,
)
from workbench.link.server.admission import Admission
from workbench.link.server.outgoing import MAX_FRAME_NUMBER, Outgoing
from workbench.link.server.policy import Policy
from workbench.link.server.rate_limiter import RateLimiter
from workbench.link.wire import (
    MAX_BYTES_BEFORE_LOGIN,
    MAX_OPERATION_BYTES,
    MAX_PAYLOAD_BYTES,
    Decoder,
    FrameKind,
    WireError,
    WireFrame,
)

MAX_OPEN_REQUESTS = 16
"""Largest number of requests that the flight has not answered."""
FRAME_COST_BYTES = 128
"""Cost of a frame without its operation [bytes of operations]."""
OPERATION_COST_BYTES = 512
"""Cost of processing an operation, or a command that the flight rejects [bytes of operations]. The
flight may have to answer, topics are subscribed, or similar names are searched. A ping is free."""
LOGIN_TIMEOUT_S = 3.0
"""Time limit for login [s]."""
ACKNOWLEDGE_TIMEOUT_S = 5.0
"""Time limit for an acknowledgement [s]."""
ACKNOWLEDGE_REQUEST_AFTER_S = 5.0
"""Silence after which a client is asked for an acknowledgement [s]."""
SEND_TIMEOUT_S = 2.0
"""Time limit while the system sends no written bytes [s]."""
MAX_TRANSPORT_BYTES = 32 * 1024
"""Largest number of bytes waiting in a transport before more are written."""


class Transport(Protocol):
    """A connection by TCP, TLS or WebSocket; after `close` or `abort`, methods have no effect."""

    @property
    def unsent(self) -> int:
        """Approximate number of written bytes that the system has not taken yet."""

    def write(self, data: bytes) -> None:
        """Send complete frames."""

    def close(self) -> None:
        """End the connection after all written bytes are sent, or after a second at most.

        Further received bytes are dropped.
        """

    def abort(self) -> None:
        """End the connection at once."""


class ClientSession:
    """One client and its connection; callers pass the time of a monotonic clock [s].

    Args:
        number: of the client, never reused.
        transport: its connection.
        address: host and port.
        kind: tcp, tls or websocket.
        decoder: holds the received bytes.
        policy: for all clients.
        admission: of clients; this one takes a place as soon as it has a role.
        tell: sends a record to the flight without waiting.
        t_ns: newest simulated time [ns].
        now: time of the connection.

    Attributes:
        number: see above.
        transport: see above.
        host: of the address.
        name: chosen by the client.
        role: None before login.
        nonce: for its login.
        out: frames to the client.
        limiter: of what it sends.
        last: last message to the client; None while it stays connected.
        last_due: time at which to send that message.
        asked: time at which it was last asked for an acknowledgement.
        flies: whether it has control, as last reported by the flight.
        gone: whether it has left.
    """

    def __init__(
        self,
        number: int,
        transport: Transport,
        address: str,
        kind: str,
        decoder: Decoder,
        policy: Policy,
        admission: Admission,
        tell: ToFlight,
        t_ns: int,
        now: float,
    ) -> None:
        self.number = number
        self.transport = transport
        self.host = host_of(address)
        self.name = ""
        self.role = policy.open_role
        self.nonce = new_nonce()
        self.out = Outgoing(t_ns)
        self.last: ServerMessage | None = None
        self.last_due = now
        self.asked = -math.inf
        self.flies = False
        self.gone = False
        self._address, self._kind = address, kind
        self._policy, self._admission, self._tell = policy, admission, tell
        self.limiter = RateLimiter(now)
        self._decoder = decoder
        decoder.largest = MAX_PAYLOAD_BYTES if self.role else MAX_BYTES_BEFORE_LOGIN
        decoder.largest_operation = MAX_OPERATION_BYTES
        self._requests = 0
        self._worked = 0
        self._logged_in = False
        self._refused = 0
        self._since = self._heard = self._moved = now
        self._unsent = 0

    def work(self, now: float) -> int:
        """Process the next frame.

        Returns:
            Approximate cost [bytes of operations]; 0 if there is no frame to process now.
        """
        if self.last is not None or self.limiter.pause(now) > 0.0:
            return 0
        try:
            frame = self._decoder.next()
            if frame is None:
                return 0
            self._heard = now
            self._worked = FRAME_COST_BYTES
            self.limiter.take_frame()
            if frame.kind == FrameKind.CONTROL:
                self._charge(len(frame.payload))  # before parsing, which is the main cost
                self._operate(frame, now)
            elif frame.kind == FrameKind.DATA and self._is_in():
                if fault := self._policy.command_fault(frame, self.role):
                    self.refuse(*fault, seq=frame.seq)
                elif topic := self._policy.command:
                    if not self.flies:
                        self._charge(OPERATION_COST_BYTES)
                    lease, axes, v_x, v_y, v_z, yaw_rate = topic.packer.unpack(frame.payload)
                    velocity, t_ns = (v_x, v_y, v_z), frame.t_ns
                    self._tell(
                        VelocityCommand(
                            self.number, frame.seq, t_ns, lease, axes, velocity, yaw_rate
                        )
                    )
            elif (
                frame.kind == FrameKind.ACKNOWLEDGEMENT
                and self._is_in()
                and self.out.acknowledge(frame.seq, now)
            ):
                self.limiter.give_back()
        except WireError as error:
            self.end(error.code, str(error))
        return self._worked

    def reply(self, answer: ServerMessage) -> None:
        """Send the flight's answer to a request."""
        self._requests = max(0, self._requests - 1)
        if isinstance(answer, Nack):
            self._note(answer.code, answer.said)
        try:
            payload = write_message(answer)
        except ValueError as error:  # a number that is not finite
            id = getattr(answer, "id", None)
            payload = write_message(Nack(NackCode.BAD_VALUE, f"the answer: {error}", id))
        self.limiter.take_operation(len(payload))
        self.out.answer(payload)

    def refuse(self, code: str, said: str, id: int | None = None, seq: int | None = None) -> None:
        """Tell the client that something was rejected."""
        self._note(code, said)
        self.out.answer(write_message(Nack(str(code), said, id, seq)))

    def end(self, code: str, said: str) -> None:
        """End the connection with an error."""
        if self.last is None:
            self._note(code, said)
            self.last = Error(code, said)

    def bye(self, said: str) -> None:
        """End the connection in order."""
        if self.last is None:
            self.last = Bye(said=said)

    def flush(self, now: float) -> bool:
        """Write the frames to send now, and return whether the last message was sent."""
        if self.last is None:
            while self.transport.unsent < MAX_TRANSPORT_BYTES and (data := self.out.take(now)):
                self.transport.write(data)
            if self.out.overflowed:
                waits = "too many events and answers wait to be read"
                self.end(ErrorCode.OVERFLOW, f"{waits}: read faster, or subscribe to less")
        if self.last is None or now < self.last_due:
            return False
        self.transport.write(self.out.last(write_message(self.last)))
        self.transport.close()
        return True

    def check_times(self, now: float) -> None:
        """End the connection of a client that takes too long."""
        waiting = self.transport.unsent
        if not waiting or waiting < self._unsent:
            self._moved = now
        self._unsent = waiting
        if self.role is None and now - self._since > LOGIN_TIMEOUT_S:
            self.end(ErrorCode.LOGIN, f"there was no login within {LOGIN_TIMEOUT_S:g} s")
        elif self.out.silence(now) > ACKNOWLEDGE_TIMEOUT_S:
            said = (
                f"nothing was acknowledged for {ACKNOWLEDGE_TIMEOUT_S:g} s: acknowledge each batch"
            )
            self.end(ErrorCode.SLOW, said)
        elif now - self._moved > SEND_TIMEOUT_S:
            self.end(ErrorCode.SLOW, f"nothing was read for {SEND_TIMEOUT_S:g} s")
        elif self.out.seq > MAX_FRAME_NUMBER:
            self.bye("the numbers of frames are used up: connect again")

    def is_quiet(self, now: float) -> bool:
        """Return whether a silent client should be asked for an acknowledgement now."""
        if self.role is None or self.out.silence(now) > 0.0:
            return False
        return now - max(self._heard, self.asked) >= ACKNOWLEDGE_REQUEST_AFTER_S

    def status(self, now: float, wall_ns: int) -> ClientStatus:
        """Return its status for the operator."""
        sampled = self.out.acknowledged_ns
        return ClientStatus(
            peer=self.number,
            address=self._address,
            name=self.name,
            transport=self._kind,
            role=self.role,
            rate=self.out.rate(now),
            age=max(0.0, 1e-9 * (wall_ns - sampled)) if sampled else 0.0,
            dropped=self.out.dropped,
            refused=self._refused,
        )

    def _charge(self, work: int) -> None:
        """Count work for this client [bytes of operations]."""
        self._worked += work
        self.limiter.take_operation(work)

    def _note(self, code: str, said: str) -> None:
        self._refused += 1
        who = f"{self._address} ({self.name})" if self.name else self._address
        self._admission.refusals.add(code, f"{who}: {code}: {said}")

    def _is_in(self) -> bool:
        if self.role is None:
            self.end(ErrorCode.LOGIN, "log in first: hello says that this server asks for it")
        return self.role is not None

    def _operate(self, frame: WireFrame, now: float) -> None:
        """Process an operation."""
        try:
            operation = read_operation(frame.payload)
            match operation:
                case Bye():
                    self.bye("goodbye")
                case Login():
                    self._log_in(operation, now)
                case _ if not self._is_in():
                    pass
                case Ping(id):
                    self.out.answer(write_message(Pong(id, self.out.t_ns)))
                case _:
                    self._charge(OPERATION_COST_BYTES)
                    self._request(operation)
        except DeniedError as error:
            self._charge(OPERATION_COST_BYTES)
            if self.role is None:
                self.end(ErrorCode.LOGIN, f"log in first: {error.said}")
            else:
                self.refuse(error.code, error.said, error.id)

    def _log_in(self, login: Login, now: float) -> None:
        if self._logged_in:
            self.end(ErrorCode.BAD_LOGIN, "this client has logged in already")
            return
        # There may have been bad logins from its address since it connected.
        rejection = self._admission.wait(self.host, now)
        if rejection is not None:
            self.end(rejection.code, rejection.said)
            return
        try:
            role = self._policy.role_of(login, self.nonce)
        except DeniedError as error:
            self.last_due = now + self._admission.bad_login(self.host, now)
            self.end(error.code, error.said)
            return
        if self.role is None:
            self._admission.good_login(self.host)
            rejection = self._admission.enter(self.host)
            if rejection is not None:
                self.end(rejection.code, rejection.said)
                return
        self.role = role
        self._logged_in = True
        self.name = login.name
        self._decoder.largest = MAX_PAYLOAD_BYTES
        self.out.answer(write_message(Login(login.id, role=self.role)))

    def _request(self, operation: Operation) -> None:
        """Subscribe to topics, or pass a request on to the flight."""
        if isinstance(operation, Subscribe):
            topics = self._policy.topics(operation.topics, operation.id)
            self.out.subscribe(topics, operation.rate)
            names = tuple(topic.name for topic in topics)
            self.out.answer(write_message(Subscribe(operation.id, names)))
            return
        if isinstance(operation, COMMANDING):
            said = self._policy.hindrance(self.role)
            if said is not None:
                self.refuse(NackCode.NOT_ALLOWED, said, operation.id)
                return
        if self._requests >= MAX_OPEN_REQUESTS:
            said = f"{self._requests} requests wait for the flight's answer: wait for them first"
            self.refuse(NackCode.NOT_NOW, said, operation.id)
            return
        self._requests += 1
        if isinstance(operation, RequestControl):
            self.name = operation.name or self.name
            operation = RequestControl(operation.id, self.name or f"client {self.number}")
        assert isinstance(operation, FlightRequest)  # all others are handled above
        self._tell(ClientRequest(self.number, operation))

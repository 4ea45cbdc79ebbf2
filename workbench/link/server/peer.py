"""One client: what it may do, and what comes of the bytes it sends; nothing here waits or sends."""

from collections.abc import Mapping

from workbench.link.answers import (
    ByeSaid,
    Error,
    Granted,
    LoggedIn,
    Nack,
    Pong,
    Said,
    Subscribed,
    write_said,
)
from workbench.link.authentication import is_proven, new_nonce
from workbench.link.backplane import Asked, Command
from workbench.link.codes import ErrorCode, NackCode
from workbench.link.json_fields import BadOperation
from workbench.link.operations import (
    COMMANDING,
    Bye,
    Login,
    Operation,
    Ping,
    RequestControlOp,
    Subscribe,
    read_operation,
)
from workbench.link.server.admission import Admission
from workbench.link.server.bucket import Bucket
from workbench.link.server.login import BadLoginError, check_login
from workbench.link.server.networks import host_of
from workbench.link.server.outgoing import Outgoing
from workbench.link.server.refusals import Refusals
from workbench.link.server.requests import for_flight
from workbench.link.server.terms import Terms
from workbench.link.strict_json import write_json
from workbench.link.wire import (
    LARGEST,
    LARGEST_BEFORE_LOGIN,
    LARGEST_OPERATION,
    SKIPPABLE,
    Decoder,
    Frame,
    Kind,
    WireError,
)

MOST_REQUESTS = 16
"""Without an answer of the flight."""
FRAME_WORK = 128
"""What a frame takes besides its operation [bytes of operations]."""
LABOUR = 512
"""What an operation takes besides its reading, or a command that the flight has to refuse: it goes
to the flight and back, makes subscriptions, or looks for what may have been meant. The same unit;
a ping is for free."""


class Peer:
    """One client.

    Args:
        number: never used twice.
        address: host and port.
        decoder: of what it sends.
        terms: that hold for all.
        admission: who gets a place; this one has one as soon as it has a role.
        refusals: where what is refused is counted.
        t_ns: the flight's newest time [ns].
        now: by any clock that only rises [s]; so in the methods.

    Attributes:
        number: see above.
        address: see above.
        host: of the address.
        name: what it calls itself.
        role: what it may do, None before login.
        nonce: for its login.
        out: what goes to it.
        asked: what goes to the flight; whoever sends it empties it.
        last: what it is told last; None while it stays.
        last_due: when it is told so.
        refused: commands and operations that were refused.
        heard: when its last frame was dealt with, or it came.
    """

    def __init__(
        self,
        number: int,
        address: str,
        decoder: Decoder,
        terms: Terms,
        admission: Admission,
        refusals: Refusals,
        t_ns: int,
        now: float,
    ) -> None:
        self.number = number
        self.address = address
        self.host = host_of(address)
        self.name = ""
        self.role = terms.open_role
        self.nonce = new_nonce()
        self.out = Outgoing(t_ns)
        self.asked: list[Asked] = []
        self.last: Said | None = None
        self.last_due = now
        self.refused = 0
        self.heard = now
        self._terms = terms
        self._admission = admission
        self._refusals = refusals
        self._bucket = Bucket(now)
        self._decoder = decoder
        decoder.largest = LARGEST if self.role else LARGEST_BEFORE_LOGIN
        decoder.largest_operation = LARGEST_OPERATION
        self._key: bytes | None = None
        self._proven = 0
        self._requests = 0
        self._lease: object = 0
        self._worked = 0
        self._logged_in = False

    def feed(self, data: bytes, now: float) -> None:
        """Keep what it has sent, any piece of it, until `work` is called."""
        self._bucket.take(len(data), now)
        self._decoder.keep(data)

    def work(self, now: float) -> int:
        """Do what the next frame asks for.

        Returns:
            what it took, about [bytes of operations]; 0 if there is no frame that may be dealt
            with now.
        """
        if self.last is not None or self.pause(now) > 0.0:
            return 0
        try:
            frame = self._decoder.next()
            if frame is None:
                return 0
            self.heard = now
            self._worked = FRAME_WORK
            self._bucket.take_frame()
            if frame.kind == Kind.CONTROL:  # before it is read: that is what it costs
                self._charge(len(frame.payload))
            self._take(frame, now)
        except WireError as error:
            self.end(ErrorCode(error.code), str(error))
        return self._worked

    def _charge(self, work: int) -> None:
        """Count what it makes us do [bytes of operations]."""
        self._worked += work
        self._bucket.take_operation(work)

    def came_to_nothing(self) -> None:
        """Note a piece that finished no frame: pieces of a byte, and of none, are not for free."""
        self._bucket.take_frame()

    def pause(self, now: float) -> float:
        """Return how long to read nothing from it, 0 for not at all [s]."""
        self._bucket.take(0, now)
        return self._bucket.pause()

    def reply(self, id: int, operation: Mapping[str, object]) -> None:
        """Hand on what the flight says to a request."""
        self._requests = max(0, self._requests - 1)
        if operation.get("op") == Granted.op:
            self._lease = operation.get("lease", 0)
        if operation.get("op") == Nack.op:
            self._note(str(operation.get("code")), str(operation.get("said")))
        try:
            answer = write_json({**operation, "id": id})
        except ValueError as error:  # a number that is not finite
            answer = write_said(Nack(NackCode.BAD_VALUE, f"the answer: {error}", id))
        self._bucket.take_operation(len(answer))
        self.out.answer(answer)

    def refuse(self, code: str, said: str, id: int | None = None, seq: int | None = None) -> None:
        """Say that something was not done."""
        self._note(code, said)
        self.out.answer(write_said(Nack(str(code), said, id, seq)))

    def end(self, code: ErrorCode, said: str) -> None:
        """Say why the connection ends."""
        if self.last is None:
            self._note(code, said)
            self.last = Error(code, said)

    def bye(self, said: str) -> None:
        """Say that the connection ends as it should."""
        if self.last is None:
            self.last = ByeSaid(said)

    def _note(self, code: str, said: str) -> None:
        self.refused += 1
        who = f"{self.address} ({self.name})" if self.name else self.address
        self._refusals.add(code, f"{who}: {code}: {said}")

    def _take(self, frame: Frame, now: float) -> None:
        if frame.kind == Kind.ACKNOWLEDGEMENT:
            if self._is_in() and self.out.acknowledge(frame.seq, now):
                self._bucket.give_back()
        elif frame.kind == Kind.DATA:
            if self._is_in():
                self._command(frame)
        elif frame.kind == Kind.CONTROL:
            try:
                self._operate(read_operation(frame.payload), frame, now)
            except BadOperation as error:
                self._charge(LABOUR)
                if self.role is None:
                    self.end(ErrorCode.LOGIN, f"log in first: {error.said}")
                else:
                    self.refuse(error.code, error.said, error.id)
        elif not frame.kind & SKIPPABLE:
            raise WireError("kind", f"frames of kind {frame.kind} may not be skipped")

    def _is_in(self) -> bool:
        if self.role is None:
            self.end(ErrorCode.LOGIN, "log in first: hello says that this server asks for it")
        return self.role is not None

    def _command(self, frame: Frame) -> None:
        topic = self._terms.command
        if topic is None or frame.topic != topic.id:
            said = f"topic {frame.topic} is none that a client sends"
            self.refuse(NackCode.UNKNOWN_TOPIC, said, seq=frame.seq)
        elif len(frame.payload) != topic.packer.size:
            said = f"{topic.name} has {topic.packer.size} bytes, the frame has {len(frame.payload)}"
            self.refuse(NackCode.BAD_SIZE, said, seq=frame.seq)
        elif (hindrance := self._terms.hindrance(self.role)) is not None:
            self.refuse(NackCode.NOT_ALLOWED, hindrance, seq=frame.seq)
        elif self._proves(frame):
            lease, axes, v_x, v_y, v_z, yaw_rate = topic.packer.unpack(frame.payload)
            if lease != self._lease:
                self._charge(LABOUR)
            velocity = (v_x, v_y, v_z)
            self.asked.append(
                Command(self.number, frame.seq, frame.t_ns, lease, axes, velocity, yaw_rate)
            )

    def _proves(self, frame: Frame) -> bool:
        """Return whether a frame comes from who has logged in; else the connection ends."""
        if self._key is None:
            return True
        if not is_proven(frame, self._key):
            found = "is wrong" if frame.proof else "is missing"
            self.end(ErrorCode.PROOF, f"the proof of frame {frame.seq}, which commands, {found}")
            return False
        if frame.seq <= self._proven:
            self.end(
                ErrorCode.SEQ,
                f"frame {frame.seq} came after frame {self._proven}: numbers must rise",
            )
            return False
        self._proven = frame.seq
        return True

    def _operate(self, operation: Operation, frame: Frame, now: float) -> None:
        match operation:
            case Bye():
                return self.bye("goodbye")
            case Login():
                return self._log_in(operation, now)
        if not self._is_in():
            return None
        if isinstance(operation, Ping):
            self.out.answer(write_said(Pong(operation.id, self.out.t_ns)))
            return None
        self._charge(LABOUR)
        match operation:
            case Subscribe(id, names, rate):
                topics = self._terms.topics(names, id)
                self.out.subscribe(topics, rate)
                said = Subscribed(id, tuple(topic.name for topic in topics))
                self.out.answer(write_said(said))
            case _:
                self._request(operation, frame)
        return None

    def _log_in(self, login: Login, now: float) -> None:
        if self._logged_in:
            self.end(ErrorCode.BAD_LOGIN, "this client has logged in already")
            return
        # Others of its address may have guessed since it came.
        refused = self._admission.wait(self.host, now)
        if refused is not None:
            self.end(*refused)
            return
        try:
            role, key = check_login(login, self._terms, self.nonce)
        except BadLoginError as error:
            self.last_due = now + self._admission.bad_login(self.host, now)
            self.end(ErrorCode.BAD_LOGIN, str(error))
            return
        if self.role is None:
            self._admission.good_login(self.host)
            refused = self._admission.enter(self.host)
            if refused is not None:
                self.end(*refused)
                return
        self.role, self._key = role, key
        self._logged_in = True
        self.name = login.name
        self._decoder.largest = LARGEST
        self.out.answer(write_said(LoggedIn(login.id, self.role)))

    def _request(self, operation: Operation, frame: Frame) -> None:
        """Ask the flight."""
        if isinstance(operation, COMMANDING):
            said = self._terms.hindrance(self.role)
            if said is not None:
                self.refuse(NackCode.NOT_ALLOWED, said, operation.id)
                return
            if not self._proves(frame):
                return
        if self._requests >= MOST_REQUESTS:
            said = f"{self._requests} requests wait for the flight's answer: wait for them first"
            self.refuse(NackCode.NOT_NOW, said, operation.id)
            return
        self._requests += 1
        if isinstance(operation, RequestControlOp):
            self.name = operation.name or self.name
        self.asked.append(for_flight(operation, self.number, self.name))

"""The hub between clients and the flight: passes messages on, and shares the time of the loop."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterable
from dataclasses import replace

from workbench.link.address import host_of
from workbench.link.backplane import (
    ClientDisconnected,
    CommandRefusal,
    Disconnect,
    Published,
    Reply,
    ServedFlight,
    ServerStatus,
    StopServer,
    ToFlight,
)
from workbench.link.codes import ErrorCode
from workbench.link.message_json import write_message
from workbench.link.messages import ControlState
from workbench.link.server.admission import Admission
from workbench.link.server.client_session import ClientSession, Transport
from workbench.link.server.outgoing import Outgoing, data_frames
from workbench.link.server.policy import Policy
from workbench.link.wire import Decoder

STATUS_PERIOD_S = 0.45
"""Period between statuses without a change of clients; they come with the next tick [s]."""
MAX_STRANGERS_LISTED = 8
"""Largest number of connections without a login in a status: a crowd is no news to the flight."""
MAX_PRINTED_ERRORS = 10
"""Largest number of our own errors printed."""
TURN_WORK_BYTES = 4096
"""Work for all clients except the holder of control in a turn of the loop, about a millisecond; the
last frame may increase it to three times as much [bytes of operations]."""
STRANGERS_WORK_BYTES = TURN_WORK_BYTES // 2
"""Part of that for connections that are no clients yet; the last work may exceed it."""
CLIENT_WORK_BYTES = 1024
"""Work for one client in a turn while others wait [bytes of operations]."""
NEXT_TURN_DELAY_S = 1e-6
"""Delay of a timer that is due in the next turn of the loop [s]."""
TICK_PERIOD_S = 0.1
"""Period between checks for timeouts [s]."""


class Hub:
    """Connects clients with the flight.

    Args:
        policy: for all clients.
        admission: of clients.
        tell: sends a record to the flight without waiting.
        clock: a monotonic clock [s].
        call_soon: the event loop's method; the default calls at once, so that the work of a turn
            has no limit.

    Attributes:
        policy: see above.
        refusals: rejections of clients.
        address: for clients to connect to, "HOST:PORT".
        page: address of the page for phones, "" without.
        stopped: set when the flight stops the server.
    """

    def __init__(
        self,
        policy: Policy,
        admission: Admission,
        tell: ToFlight,
        clock: Callable[[], float] = time.monotonic,
        call_soon: Callable[[Callable[[], None]], object] = lambda call: call(),
    ) -> None:
        self.policy = policy
        self.refusals = admission.refusals
        self.address = ""
        self.page = ""
        self.stopped = asyncio.Event()
        self._admission = admission
        self._tell = tell
        self._clock = clock
        self._call_soon = call_soon
        self._worked = 0  # in this turn of the loop
        self._strangers: list[Callable[[], int]] = []
        self._queue: dict[int, None] = {}  # numbers of clients that wait for the next turn
        self._sessions: dict[int, ClientSession] = {}
        self._count = 0
        self._t_ns = 0
        self._faults = 0
        self._control: bytes | None = None
        self._changed = True
        self._told = clock()

    def open(
        self, transport: Transport, address: str, kind: str, decoder: Decoder
    ) -> ClientSession | None:
        """Greet a client and return its session; None after telling it that it is rejected.

        Args:
            transport: for the frames to it.
            address: host and port of the client.
            kind: tcp, tls or websocket.
            decoder: holds the received bytes, see `receive`.
        """
        now = self._clock()
        host = host_of(address)
        rejection = self._admission.wait(host, now)
        if rejection is None and self.policy.open_role is not None:
            rejection = self._admission.enter(host)
        if rejection is not None:
            self.refusals.add(rejection.code, f"{address}: {rejection.said}")
            transport.write(Outgoing().last(write_message(rejection)))
            transport.close()
            return None
        self._count += 1
        session = ClientSession(
            self._count,
            transport,
            address,
            kind,
            decoder,
            self.policy,
            self._admission,
            self._tell,
            self._t_ns,
            now,
        )
        self._sessions[session.number] = session
        most = self._admission.most_of(host)
        session.out.answer(self.policy.hello(session.number, session.nonce, most))
        self._tell_control(session)
        self._flush(session, now)
        self._changed = self._changed or session.role is not None
        return session

    def receive(self, session: ClientSession, size: int | None = None) -> float:
        """Process the received bytes of a client, which its decoder holds.

        Args:
            session: of the client.
            size: number of bytes just received; None after a pause.

        Returns:
            For how long to stop reading from it [s]; the caller then calls this again.
        """
        if session.gone:
            return 0.0
        now = self._clock()
        if size is not None:
            session.limiter.take(size, now)
        role, name, worked = session.role, session.name, False
        try:
            if session.flies:  # the holder of control is served at once
                self._queue.pop(session.number, None)
                while session.work(now):
                    worked = True
            else:
                worked = self._work_in_turn(session, now)
            if not worked and size is not None:
                session.limiter.take_frame()  # tiny pieces cost time, too
        except Exception as error:  # a bug of ours must not affect other clients
            self.failed(f"client {session.number}", error)
            session.end(ErrorCode.INTERNAL, "the server has failed: tell its operator")
        if session.role is not role:
            self._tell_control(session)
        if session.role is not role or session.name != name:
            self._changed = True
        self._flush(session, now)
        if session.gone:
            return 0.0
        pause = session.limiter.pause(now)
        return max(pause, NEXT_TURN_DELAY_S) if session.number in self._queue else pause

    def later(self, call: Callable[[], int]) -> None:
        """Call for a connection that is no client yet, as soon as a turn of the loop has time.

        The newest call is the first: those for which the others are too late have given up.

        Args:
            call: does the work, and returns its cost [bytes of operations].
        """
        self._strangers.append(call)
        self._work_for_strangers()

    def lost(self, session: ClientSession) -> None:
        """Note that a connection has ended."""
        if session.gone:
            return
        session.gone = True
        del self._sessions[session.number]
        self._queue.pop(session.number, None)
        if session.role is not None:
            self._admission.leave(session.host)
            self._changed = True
        self._tell(ClientDisconnected(session.number))

    def hear(self, records: Iterable[object]) -> None:
        """Process records from the flight."""
        for record in records:
            match record:
                case Published():
                    self._t_ns = record.t_ns
                    samples = data_frames(record)
                    for session in self._sessions.values():
                        session.out.publish(record.t_ns, samples if session.role else ())
                case Reply(number, answer) if number in self._sessions:
                    self._sessions[number].reply(answer)
                case CommandRefusal(number, seq, code, said) if number in self._sessions:
                    self._sessions[number].refuse(code, said, seq=seq)
                case ControlState():
                    self._control = write_message(record)
                    for session in self._sessions.values():
                        session.flies = session.number == record.peer
                        self._tell_control(session)
                case Disconnect(number, reason) if number in self._sessions:
                    self._sessions[number].end(ErrorCode.DISCONNECTED, reason)
                case ServedFlight():  # another controller took over
                    self.policy = replace(self.policy, flight=record)
                case StopServer.STOP:
                    self.stopped.set()
        now = self._clock()
        for session in list(self._sessions.values()):
            if session.role is not None or session.last is not None:
                self._flush(session, now)

    def tick(self) -> None:
        """Check time limits, and report the status to the flight if it is due."""
        now = self._clock()
        for session in list(self._sessions.values()):
            session.check_times(now)
            if self._control is not None and session.is_quiet(now):
                session.asked = now
                session.out.ask(self._control)
            self._flush(session, now)
        if self._changed or now - self._told > STATUS_PERIOD_S:
            self._changed = False
            self._told = now
            self._tell(self.status())

    def status(self) -> ServerStatus:
        """Return the status of the server."""
        now, wall_ns = self._clock(), time.time_ns()
        strangers = [each.number for each in self._sessions.values() if each.role is None]
        left_out = set(strangers[MAX_STRANGERS_LISTED:])
        told = [each for each in self._sessions.values() if each.number not in left_out]
        return ServerStatus(
            address=self.address,
            page=self.page,
            clients=tuple(session.status(now, wall_ns) for session in told),
            refusals=self.refusals.counts,
            log=self.refusals.log,
        )

    def stop(self, said: str) -> None:
        """Take leave of all clients."""
        for session in list(self._sessions.values()):
            session.bye(said)
            self._flush(session, self._clock())

    def failed(self, where: str, error: BaseException | None) -> None:
        """Log a bug of ours with its trace; only the first ones, as clients may cause many."""
        self._faults += 1
        self.refusals.add(ErrorCode.INTERNAL, f"{where}: {type(error).__name__}: {error}")
        if self._faults <= MAX_PRINTED_ERRORS:
            logging.getLogger(__name__).error("%s", where, exc_info=error)

    def _work_in_turn(self, session: ClientSession, now: float) -> bool:
        """Process frames of a client without control, and return whether there was one.

        All of them share a limited amount of work in each turn of the loop, so that together they
        cannot delay the holder of control. They wait in a queue; a client that has used its share
        goes to the end of it.
        """
        number = session.number
        is_next = next(iter(self._queue), number) == number
        share = CLIENT_WORK_BYTES if len(self._queue) > 1 else TURN_WORK_BYTES
        done = 0
        while is_next and done < share and self._worked < TURN_WORK_BYTES:
            work = session.work(now)
            if not work:
                self._queue.pop(number, None)
                return done > 0
            done += work
            self._count_work(work)
        if done:
            self._queue.pop(number, None)
        if session.limiter.pause(now) > 0.0:  # it pauses due to its own rate, and delays nobody
            self._queue.pop(number, None)
        else:
            self._queue[number] = None
        return done > 0

    def _count_work(self, work: int) -> None:
        is_first = not self._worked
        self._worked += work
        if is_first:
            self._call_soon(self._begin_turn)

    def _begin_turn(self) -> None:
        self._worked = 0
        self._work_for_strangers()

    def _work_for_strangers(self) -> None:
        while self._strangers and self._worked < STRANGERS_WORK_BYTES:
            if work := self._strangers.pop()():
                self._count_work(work)

    def _tell_control(self, session: ClientSession) -> None:
        """Send the control state to a client that may watch."""
        if self._control is not None and session.role is not None:
            session.out.answer(self._control)

    def _flush(self, session: ClientSession, now: float) -> None:
        """Write the waiting frames of a client, and remove it after its last message."""
        if not session.gone and session.flush(now):
            self.lost(session)

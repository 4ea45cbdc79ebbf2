"""Where clients and the flight meet: who is here, who gets what, and who must go."""

import asyncio
import logging
import time
from collections.abc import Callable, Iterable

from workbench.link.answers import Error, Said, control_state_said, write_said
from workbench.link.backplane import (
    Asked,
    ControlState,
    Disconnect,
    Gone,
    Published,
    Refused,
    Reply,
    ServerStatus,
    Stop,
)
from workbench.link.codes import ErrorCode
from workbench.link.server.admission import Admission
from workbench.link.server.networks import host_of
from workbench.link.server.outgoing import Outgoing
from workbench.link.server.peer import Peer
from workbench.link.server.refusals import Refusals
from workbench.link.server.seat import Seat
from workbench.link.server.terms import Terms
from workbench.link.server.transport import Transport
from workbench.link.wire import Decoder

STATUS_PERIOD = 0.45
"""Between two statuses where nothing changes; they come with the next tick [s]."""
MOST_FAULTS = 10
"""Of ours, that are printed."""
TURN = 4096
"""Work of all clients but the pilot in a turn of the loop, about a millisecond; with the last of
their frames it may become three times as much [bytes of operations]."""
SHARE = 1024
"""Of that, what a client may have while others wait."""
NEXT_TURN = 1e-6
"""Until the next turn of the loop: a timer that is due at once [s]."""
TICK_PERIOD = 0.1
"""Between two looks at who takes too long [s]."""


class Hub:
    """Where clients and the flight meet.

    Args:
        terms: that hold for all clients.
        admission: who may come in.
        tell: sends a record to the flight without waiting.
        clock: rises, whatever happens to the date [s].
        soon: calls a function when all else that is due has had its turn, as a loop's `call_soon`;
            without it the work of a turn has no bound.

    Attributes:
        terms: see above.
        refusals: what was refused.
        address: where clients connect to, "HOST:PORT".
        page: address of the page for phones, "" without.
        stopped: set when the flight has said so.
    """

    def __init__(
        self,
        terms: Terms,
        admission: Admission,
        tell: Callable[[Asked | ServerStatus], None],
        clock: Callable[[], float] = time.monotonic,
        soon: Callable[[Callable[[], None]], object] = lambda call: call(),
    ) -> None:
        self.terms = terms
        self.refusals = Refusals()
        self.address = ""
        self.page = ""
        self.stopped = asyncio.Event()
        self._admission = admission
        self._tell = tell
        self._clock = clock
        self._soon = soon
        self._worked = 0  # in this turn of the loop
        self._line: dict[int, None] = {}  # numbers of clients that wait for the next one
        self._pilot = 0
        self._seats: dict[int, Seat] = {}
        self._count = 0
        self._t_ns = 0
        self._faults = 0
        self._control: bytes | None = None
        self._changed = True
        self._told = clock()

    def open(
        self, transport: Transport, address: str, kind: str, decoder: Decoder | None = None
    ) -> Seat | None:
        """Say hello to a client; None if it is refused, which it was told then.

        Args:
            transport: where the answers go.
            address: host and port of the client.
            kind: websocket, for instance.
            decoder: of what it sends; one of plain frames if it is left out.
        """
        now = self._clock()
        host = host_of(address)
        refused = self._admission.wait(host, now)
        if refused is None and self.terms.open_role is not None:
            refused = self._admission.enter(host)
        if refused is not None:
            self.refusals.add(refused.code, f"{address}: {refused.said}")
            transport.write(Outgoing().last(write_said(Error(refused.code, refused.said))))
            transport.close()
            return None
        self._count += 1
        peer = Peer(
            self._count,
            address,
            decoder or Decoder(),
            self.terms,
            self._admission,
            self.refusals,
            self._t_ns,
            now,
        )
        seat = Seat(peer, transport, kind, now, now)
        self._seats[peer.number] = seat
        most = self._admission.most_of(host)
        peer.out.answer(self.terms.hello(peer.number, peer.nonce, most))
        self._welcome(seat)
        self._settle(seat, now)
        self._changed = True
        return seat

    def receive(self, seat: Seat, data: bytes) -> float:
        """Take what a client has sent; return how long to read nothing more from it [s]."""
        if seat.gone:
            return 0.0
        now = self._clock()
        seat.peer.feed(data, now)
        if not self._serve(seat, now):
            seat.peer.came_to_nothing()
        return self._rest(seat, now)

    def go_on(self, seat: Seat) -> float:
        """Take what a client has sent before, after a pause; return how long the next one is."""
        if seat.gone:
            return 0.0
        now = self._clock()
        self._serve(seat, now)
        return self._rest(seat, now)

    def _serve(self, seat: Seat, now: float) -> bool:
        """Do what a client asks for, and what comes of it; return whether there was a frame."""
        peer = seat.peer
        role, name = peer.role, peer.name
        try:
            worked = self._work(peer, now)
        except Exception as error:  # a fault of ours must not reach the others
            worked = True
            self.failed(f"client {peer.number}", error)
            peer.asked.clear()
            peer.end(ErrorCode.INTERNAL, "the server has failed at this: tell who runs it")
        for asked in peer.asked:
            self._tell(asked)
        peer.asked.clear()
        if peer.role is not role:
            self._welcome(seat)
        if peer.role is not role or peer.name != name:
            self._changed = True
        self._settle(seat, now)
        return worked

    def _work(self, peer: Peer, now: float) -> bool:
        """Deal with a client's frames; return whether there was one.

        Who flies is served at once. All others share a bounded work in each turn of the loop, so
        that not even all of them together keep the pilot waiting. They wait in a line, and who has
        had its share goes to the end of it.
        """
        number = peer.number
        if number == self._pilot:
            self._line.pop(number, None)
            worked = False
            while peer.work(now):
                worked = True
            return worked
        is_next = next(iter(self._line), number) == number
        share = SHARE if len(self._line) > 1 else TURN
        done = 0
        while is_next and done < share and self._worked < TURN:
            work = peer.work(now)
            if not work:
                self._line.pop(number, None)
                return done > 0
            done += work
            self._count_work(work)
        if done:
            self._line.pop(number, None)
        if peer.pause(now) > 0.0:  # it rests for a reason of its own, and is in nobody's way
            self._line.pop(number, None)
        else:
            self._line[number] = None
        return done > 0

    def _rest(self, seat: Seat, now: float) -> float:
        """Return how long to read nothing from a client [s]."""
        if seat.gone:
            return 0.0
        pause = seat.peer.pause(now)
        return max(pause, NEXT_TURN) if seat.peer.number in self._line else pause

    def _count_work(self, work: int) -> None:
        is_first = not self._worked
        self._worked += work
        if is_first:
            self._soon(self._begin_turn)

    def _begin_turn(self) -> None:
        self._worked = 0

    def lost(self, seat: Seat) -> None:
        """Note that a connection has ended."""
        if seat.gone:
            return
        seat.gone = True
        del self._seats[seat.peer.number]
        self._line.pop(seat.peer.number, None)
        if seat.peer.role is not None:
            self._admission.leave(seat.peer.host)
        self._tell(Gone(seat.peer.number))
        self._changed = True

    def hear(self, records: Iterable[object]) -> None:
        """Take what the flight says."""
        for record in records:
            match record:
                case Published():
                    self._t_ns = record.t_ns
                    for seat in self._seats.values():
                        seat.peer.out.publish(record)
                case Reply(number, id, operation) if number in self._seats:
                    self._seats[number].peer.reply(id, operation)
                case Refused(number, seq, code, said) if number in self._seats:
                    self._seats[number].peer.refuse(code, said, seq=seq)
                case ControlState():
                    self._pilot = record.peer
                    self._control = write_said(control_state_said(record))
                    for seat in self._seats.values():
                        self._welcome(seat)
                case Disconnect(number, reason) if number in self._seats:
                    self._seats[number].peer.end(ErrorCode.DISCONNECTED, reason)
                case Stop.STOP:
                    self.stopped.set()
        now = self._clock()
        for seat in list(self._seats.values()):
            self._settle(seat, now)

    def tick(self) -> None:
        """Look who takes too long, and tell the flight how all do, if it is time."""
        now = self._clock()
        for seat in list(self._seats.values()):
            seat.look(now)
            if self._control is not None and seat.is_quiet(now):
                seat.asked = now
                seat.peer.out.ask(self._control)
            self._settle(seat, now)
        if self._changed or self.refusals.changed or now - self._told > STATUS_PERIOD:
            self._changed = self.refusals.changed = False
            self._told = now
            self._tell(self.status())

    def status(self) -> ServerStatus:
        """Return how the server does."""
        now, wall_ns = self._clock(), time.time_ns()
        return ServerStatus(
            address=self.address,
            page=self.page,
            peers=tuple(seat.status(now, wall_ns) for seat in self._seats.values()),
            refusals=self.refusals.counts,
            log=self.refusals.log,
        )

    def stop(self, said: str) -> None:
        """Say goodbye to all."""
        for seat in list(self._seats.values()):
            seat.peer.bye(said)
            self._settle(seat, self._clock())

    def failed(self, where: str, error: BaseException | None) -> None:
        """Print a fault of ours with its trace, but only the first ones, as strangers make them."""
        self._faults += 1
        self.refusals.add(ErrorCode.INTERNAL, f"{where}: {type(error).__name__}: {error}")
        if self._faults <= MOST_FAULTS:
            logging.getLogger(__name__).error("%s", where, exc_info=error)

    def _welcome(self, seat: Seat) -> None:
        """Say who commands, to a client that is in."""
        if self._control is not None and seat.peer.role is not None:
            seat.peer.out.answer(self._control)

    def _settle(self, seat: Seat, now: float) -> None:
        """Write what may go to a client, and end the connection if it must."""
        if seat.gone:
            return
        if seat.peer.last is None:
            seat.flush(now)
        last: Said | None = seat.peer.last
        if last is not None and now >= seat.peer.last_due:
            seat.transport.write(seat.peer.out.last(write_said(last)))
            seat.transport.close()
            self.lost(seat)

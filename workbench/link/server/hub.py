"""Where clients and the flight meet: who is here, who gets what, and who must go."""

import asyncio
import contextlib
import logging
import time
from collections.abc import AsyncIterator, Callable, Iterable

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

STATUS_PERIOD = 0.45
"""Between two statuses where nothing changes; they come with the next tick [s]."""
MOST_FAULTS = 10
"""Of ours, that are printed."""
TICK_PERIOD = 0.1
"""Between two looks at who takes too long [s]."""


class Hub:
    """Where clients and the flight meet.

    Args:
        terms: that hold for all clients.
        admission: who may come in.
        tell: sends a record to the flight without waiting.
        clock: rises, whatever happens to the date [s].

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
    ) -> None:
        self.terms = terms
        self.refusals = Refusals()
        self.address = ""
        self.page = ""
        self.stopped = asyncio.Event()
        self._admission = admission
        self._tell = tell
        self._clock = clock
        self._seats: dict[int, Seat] = {}
        self._count = 0
        self._t_ns = 0
        self._faults = 0
        self._control: bytes | None = None
        self._changed = True
        self._told = clock()

    async def attend(
        self, incoming: AsyncIterator[bytes], transport: Transport, address: str, kind: str
    ) -> None:
        """Run one connection from HELLO to its end.

        Args:
            incoming: what the client sends, in any pieces; ends when the connection does.
            transport: where the answers go.
            address: host and port of the client.
            kind: websocket, for instance.
        """
        seat = self.open(transport, address, kind)
        if seat is None:
            return
        try:
            with contextlib.suppress(OSError):
                async for data in incoming:
                    pause = self.receive(seat, data)
                    while pause > 0.0:  # who sends too much is read later
                        await asyncio.sleep(pause)
                        pause = self.go_on(seat)
                    if seat.gone:
                        break
        finally:
            self.lost(seat)

    def open(self, transport: Transport, address: str, kind: str) -> Seat | None:
        """Say hello to a client; None if it is refused, which it was told then."""
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
            self._count, address, self.terms, self._admission, self.refusals, self._t_ns, now
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
        return self._serve(seat, lambda now: seat.peer.feed(data, now))

    def go_on(self, seat: Seat) -> float:
        """Take what a client has sent before, after a pause; return how long the next one is."""
        return self._serve(seat, seat.peer.go_on)

    def _serve(self, seat: Seat, work: Callable[[float], float]) -> float:
        """Let a client be served, and do what comes of it."""
        if seat.gone:
            return 0.0
        now, peer = self._clock(), seat.peer
        role, name = peer.role, peer.name
        try:
            pause = work(now)
        except Exception as error:  # a fault of ours must not reach the others
            self.failed(f"client {peer.number}", error)
            peer.asked.clear()
            peer.end(ErrorCode.INTERNAL, "the server has failed at this: tell who runs it")
            pause = 0.0
        for asked in peer.asked:
            self._tell(asked)
        peer.asked.clear()
        if peer.role is not role:
            self._welcome(seat)
        if peer.role is not role or peer.name != name:
            self._changed = True
        self._settle(seat, now)
        return pause

    def lost(self, seat: Seat) -> None:
        """Note that a connection has ended."""
        if seat.gone:
            return
        seat.gone = True
        del self._seats[seat.peer.number]
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

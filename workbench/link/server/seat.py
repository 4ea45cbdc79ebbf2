"""A connected client with its connection, and whether it still deserves its place."""

import math
from dataclasses import dataclass

from workbench.link.answers import ByeSaid
from workbench.link.backplane import PeerStatus
from workbench.link.codes import ErrorCode
from workbench.link.server.outgoing import LAST_SEQ
from workbench.link.server.peer import Peer
from workbench.link.server.transport import Transport

LOGIN_TIME = 3.0
"""Until login [s]."""
SILENT_TIME = 5.0
"""Until what was asked to be acknowledged is [s]."""
QUIET_TIME = 5.0
"""Without a frame of a client, until it is asked whether it is there [s]."""
BLOCKED_TIME = 2.0
"""While nothing that was written goes out [s]."""
ROOM = 32 * 1024
"""Bytes that may wait in a transport before more is written."""


@dataclass(slots=True)
class Seat:
    """A connected client with its connection; times are told [s].

    Attributes:
        peer: the client.
        transport: its connection.
        kind: tcp, tls or websocket.
        since: when it came.
        moved: when bytes last went out, or none waited.
        unsent: bytes that waited then.
        asked: when it was last asked whether it is there.
        gone: whether it has left its place.
    """

    peer: Peer
    transport: Transport
    kind: str
    since: float
    moved: float
    unsent: int = 0
    asked: float = -math.inf
    gone: bool = False

    def flush(self, now: float) -> None:
        """Write what may go out now."""
        out = self.peer.out
        while self.transport.unsent < ROOM:
            data = out.take(now)
            if not data:
                break
            self.transport.write(data)
        if out.overflowed:
            said = "too many events and answers wait to be read: read faster, or subscribe to less"
            self.peer.end(ErrorCode.OVERFLOW, said)

    def look(self, now: float) -> None:
        """End the connection of a client that takes too long."""
        peer, waiting = self.peer, self.transport.unsent
        if not waiting or waiting < self.unsent:
            self.moved = now
        self.unsent = waiting
        if peer.role is None and now - self.since > LOGIN_TIME:
            peer.end(ErrorCode.LOGIN, f"there was no login within {LOGIN_TIME:g} s")
        elif peer.out.silence(now) > SILENT_TIME:
            said = f"nothing was acknowledged for {SILENT_TIME:g} s: acknowledge each batch"
            peer.end(ErrorCode.SLOW, said)
        elif now - self.moved > BLOCKED_TIME:
            peer.end(ErrorCode.SLOW, f"nothing was read for {BLOCKED_TIME:g} s")
        elif peer.out.seq > LAST_SEQ and peer.last is None:
            peer.last = ByeSaid("the numbers of frames are used up: connect again")

    def is_quiet(self, now: float) -> bool:
        """Return whether it is time to ask a client that says nothing whether it is there."""
        if self.peer.role is None or self.peer.out.silence(now) > 0.0:
            return False
        return now - max(self.peer.heard, self.asked) >= QUIET_TIME

    def status(self, now: float, wall_ns: int) -> PeerStatus:
        """Return what the operator sees of it."""
        peer, out = self.peer, self.peer.out
        taken = out.acknowledged_ns
        return PeerStatus(
            peer=peer.number,
            address=peer.address,
            name=peer.name,
            transport=self.kind,
            role=peer.role,
            rate=out.rate(now),
            age=max(0.0, 1e-9 * (wall_ns - taken)) if taken else 0.0,
            dropped=out.dropped,
            refused=peer.refused,
        )

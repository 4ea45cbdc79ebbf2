"""What goes to a client: answers, events and state, never more than it is able to read.

Answers go at once. Events and state go in batches whose last frame asks for an acknowledgement, and
no more than two batches are on their way: buffers on the way hold seconds of data, which would be
old when they are read.
"""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from workbench.link.backplane import Published
from workbench.link.topics import Delivery, Topic
from workbench.link.wire import HEADER, MAGIC, VERSION, Flag, Kind

KEPT = 0.5
"""Samples of a topic are kept for so long, so that a client may pause without a gap [s]."""
LEAST_KEPT = 2
EARLY = 0.01
"""A sample may come so much of a period early where a client wants less than there are."""
LONGEST_QUEUE = 64
"""Answers, or events, that may wait."""
BATCHES = 2
"""On their way."""
SMALLEST_BATCH = 8
BATCH_TIME = 0.1
"""A batch has no more frames than the client reads in this time [s]."""
KEPT_TIME = 0.4
"""What it does not read in this time is dropped for newer [s]."""
ACKNOWLEDGED_EVERY = 32
"""In a long batch every so many frames ask too, as it may be long for a client that got slow."""
LAST_SEQ = 2**32 - 2**20
"""A connection with so high a number is to be made anew: numbers only rise."""
RATE_SPAN = 1.0
"""Frames are counted over so long [s]."""
LAST_BATCHES = 4
"""Number of last batches for the rate."""
SHORTEST_BATCH = 1e-4
"""No batch counts as read in less time [s]."""
# Plain numbers: an enumeration's operations cost a microsecond, and there are many frames.
_CONTROL = int(Kind.CONTROL)
_DATA = int(Kind.DATA)
_ACKNOWLEDGE = int(Flag.ACKNOWLEDGE)


class DataFrame(NamedTuple):
    """A frame of data without its number; times in ns."""

    topic: int
    t_ns: int
    wall_ns: int
    payload: bytes


class SampleBuffer:
    """One ring buffer for each topic; when it is full, its oldest sample is dropped.

    Args:
        topics: of state, that the client wants.
        rate: largest frames a second of each, None for all there are [1/s of simulated time].

    Attributes:
        waiting: samples in all buffers.
        dropped: samples that went without being sent.
    """

    def __init__(self, topics: Iterable[Topic], rate: float | None) -> None:
        self._buffers: dict[int, deque[DataFrame]] = {
            topic.id: deque(maxlen=max(LEAST_KEPT, math.ceil(KEPT * topic.rate)))
            for topic in topics
        }
        self._order = list(self._buffers.values())
        self._first = 0
        self._period = 0 if rate is None else round((1.0 - EARLY) * 1e9 / rate)
        self._last: dict[int, int] = {}
        self.waiting = 0
        self.dropped = 0

    def add(self, topic: int, t_ns: int, wall_ns: int, payload: bytes) -> None:
        """Keep a sample, if the client wants it."""
        buffer = self._buffers.get(topic)
        if buffer is None:
            return
        if self._period:
            last = self._last.get(topic)
            # Time that went back is that of a flight that begins anew.
            if last is not None and 0 <= t_ns - last < self._period:
                return
            self._last[topic] = t_ns
        if len(buffer) == buffer.maxlen:
            self.dropped += 1
        else:
            self.waiting += 1
        buffer.append(DataFrame(topic, t_ns, wall_ns, payload))

    def thin(self, keep: int) -> None:
        """Drop the oldest samples where more wait than a client can be expected to read soon.

        Each topic keeps its newest one.
        """
        if self.waiting <= keep:
            return
        filled = [buffer for buffer in self._order if buffer]
        share = max(1, keep // len(filled))
        for buffer in filled:
            while len(buffer) > share:
                buffer.popleft()
                self.dropped += 1
                self.waiting -= 1

    def take(self, most: int) -> list[DataFrame]:
        """Return the oldest samples, as many as may be, a topic after the other in turns."""
        taken: list[DataFrame] = []
        count = len(self._order)
        most = min(most, self.waiting)
        at = self._first
        while len(taken) < most:
            buffer = self._order[at]
            at = at + 1 if at + 1 < count else 0
            if buffer:
                taken.append(buffer.popleft())
        self._first = at
        self.waiting -= len(taken)
        return taken


class _Batch(NamedTuple):
    """What waits for an acknowledgement; without frames of data, a question."""

    seq: int
    frames: int
    sent: float
    wall_ns: int


class Outgoing:
    """What goes to one client; times are told [s].

    Args:
        t_ns: the flight's newest time [ns].

    Attributes:
        t_ns: see above.
        seq: number of the last frame.
        acknowledged_ns: when the newest sample was taken that it has acknowledged, 0 before.
    """

    def __init__(self, t_ns: int = 0) -> None:
        self.t_ns = t_ns
        self.seq = 0
        self.acknowledged_ns = 0
        self._answers: deque[bytes] = deque()
        self._question = b""
        self._events: deque[DataFrame] = deque()
        self._event_topics: frozenset[int] = frozenset()
        self._states = SampleBuffer((), None)
        self._dropped_before = 0
        self._batches: deque[_Batch] = deque()
        self._acknowledged = 0
        self._heard = 0.0
        self._reading = ReadRate()

    @property
    def dropped(self) -> int:
        """Samples that the client was too slow for."""
        return self._dropped_before + self._states.dropped

    @property
    def overflowed(self) -> bool:
        """Whether more is left after a `take` than may wait, so that the connection must end."""
        return max(len(self._answers), len(self._events)) > LONGEST_QUEUE

    def subscribe(self, topics: Sequence[Topic], rate: float | None) -> None:
        """Send these topics from now on, of state ones at most so many frames a second each."""
        self._dropped_before += self._states.dropped
        self._states = SampleBuffer(
            (each for each in topics if each.delivery is Delivery.STATE), rate
        )
        self._event_topics = frozenset(
            each.id for each in topics if each.delivery is Delivery.EVENT
        )

    def answer(self, payload: bytes) -> None:
        """Send an operation."""
        self._answers.append(payload)

    def ask(self, payload: bytes) -> None:
        """Send an operation that is to be acknowledged, so that a client shows that it is there."""
        self._question = payload

    def publish(self, published: Published) -> None:
        """Keep what the client wants of this."""
        self.t_ns = t_ns = published.t_ns
        wall_ns = published.wall_ns
        add = self._states.add
        events = self._event_topics
        for topic, payload in published.payloads:
            if topic in events:
                self._events.append(DataFrame(topic, t_ns, wall_ns, payload))
            else:
                add(topic, t_ns, wall_ns, payload)

    def take(self, now: float) -> bytes:
        """Return what may be written now: whole frames, perhaps none."""
        parts: list[bytes] = []
        while self._answers:
            self._add_frame(parts, _CONTROL, 0, 0, self.t_ns, self._answers.popleft())
        if self._question:
            self._add_frame(parts, _CONTROL, 0, _ACKNOWLEDGE, self.t_ns, self._question)
            self._question = b""
            self._batches.append(_Batch(self.seq, 0, now, 0))
        if len(self._batches) < BATCHES and (self._events or self._states.waiting):
            self._add_batch(parts, now)
        return b"".join(parts)

    def last(self, payload: bytes) -> bytes:
        """Return the frame of an operation that is the last one."""
        parts: list[bytes] = []
        self._add_frame(parts, _CONTROL, 0, 0, self.t_ns, payload)
        return b"".join(parts)

    def acknowledge(self, seq: int, now: float) -> bool:
        """Note the last frame that the client has processed; return whether that can be."""
        if not self._acknowledged < seq <= self.seq or not self._batches:
            return False
        self._reading.acknowledged(seq - self._acknowledged, now)
        self._acknowledged = seq
        self._heard = now
        while self._batches and self._batches[0].seq <= seq:
            batch = self._batches.popleft()
            if batch.frames:
                self._reading.batch(batch.frames, now - batch.sent)
            self.acknowledged_ns = max(self.acknowledged_ns, batch.wall_ns)
        return True

    def silence(self, now: float) -> float:
        """Return for how long an acknowledgement is due [s]."""
        if not self._batches:
            return 0.0
        return now - max(self._heard, self._batches[0].sent)

    def rate(self, now: float) -> float:
        """Return the frames that the client reads [1/s]."""
        return self._reading.shown(now)

    def _add_batch(self, parts: list[bytes], now: float) -> None:
        shown = self._reading.shown(now)
        most = max(SMALLEST_BATCH, int(BATCH_TIME * shown))
        # A client that is fast may have been sent little yet, so its last batch counts too.
        keep = max(SMALLEST_BATCH, int(KEPT_TIME * shown), int(BATCH_TIME * self._reading.of_batch))
        self._states.thin(keep)
        samples = [*self._events, *self._states.take(most)]
        self._events.clear()
        left = len(samples)
        newest = 0
        for topic, t_ns, wall_ns, payload in samples:
            left -= 1
            flags = 0 if left % ACKNOWLEDGED_EVERY else _ACKNOWLEDGE
            self._add_frame(parts, _DATA, topic, flags, t_ns, payload)
            newest = max(newest, wall_ns)
        self._batches.append(_Batch(self.seq, len(samples), now, newest))

    def _add_frame(
        self, parts: list[bytes], kind: int, topic: int, flags: int, t_ns: int, payload: bytes
    ) -> None:
        self.seq += 1
        parts.append(HEADER.pack(MAGIC, VERSION, kind, topic, flags, self.seq, len(payload), t_ns))
        parts.append(payload)


class ReadRate:
    """How fast a client reads, by its acknowledgements; times are told [s]."""

    def __init__(self) -> None:
        self._batches: deque[float] = deque(maxlen=LAST_BATCHES)
        self._counts: deque[tuple[float, int]] = deque()
        self._sum = 0

    @property
    def of_batch(self) -> float:
        """Frames a second of the fastest of the last batches, from its sending to its reading.

        One late reading is a hiccup of the machine; who is slow is slow each time.
        """
        return max(self._batches, default=0.0)

    def acknowledged(self, frames: int, now: float) -> None:
        """Note frames that were read."""
        self._counts.append((now, frames))
        self._sum += frames
        self._forget(now)

    def batch(self, frames: int, seconds: float) -> None:
        """Note how long it took until a batch was read."""
        self._batches.append(frames / max(seconds, SHORTEST_BATCH))

    def shown(self, now: float) -> float:
        """Return the frames that were read in the last second [1/s]."""
        self._forget(now)
        return self._sum / RATE_SPAN

    def _forget(self, now: float) -> None:
        while self._counts and self._counts[0][0] < now - RATE_SPAN:
            self._sum -= self._counts.popleft()[1]

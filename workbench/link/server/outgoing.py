"""The frames to a client: answers, events and states, at the rate at which it reads.

Answers are sent at once. Events and states are sent in batches; the last frame of a batch requires
an acknowledgement, and at most two batches are unacknowledged. Without that limit, buffers in the
network would hold seconds of outdated data.
"""

import math
from collections import deque
from collections.abc import Iterable, Sequence
from typing import NamedTuple

from workbench.link.backplane import Published
from workbench.link.topics import Delivery, Topic
from workbench.link.wire import (
    FRAME_HEADER,
    FRAME_MAGIC,
    PROTOCOL_VERSION,
    SEQ_SLICE,
    FrameFlag,
    FrameKind,
)

SAMPLE_KEEP_TIME_S = 0.5
"""Time for which samples of a topic are kept, so that a client may pause without a gap [s]."""
MIN_KEPT_SAMPLES = 2
EARLY_PERIOD_SHARE = 0.01
"""Share of the requested period by which a sample may be early."""
MAX_QUEUED_ANSWERS = 64
"""Largest number of waiting answers, and of waiting events."""
MAX_OPEN_BATCHES = 2
"""Largest number of unacknowledged batches."""
MIN_BATCH_FRAMES = 8
BATCH_TIME_S = 0.1
"""Time in which the client should read a batch; it limits the size of the batch [s]."""
MAX_SAMPLE_DELAY_S = 0.4
"""Samples that the client would not read within this time are replaced by newer ones [s]."""
FRAMES_PER_ACKNOWLEDGEMENT = 32
"""Number of frames per acknowledgement in a long batch, in case the client has become slow."""
MAX_FRAME_NUMBER = 2**32 - 2**20
"""Frame number at which the client must reconnect, as numbers only increase."""
RATE_SPAN_S = 1.0
"""Time over which frames are counted [s]."""
RATE_BATCH_COUNT = 4
"""Number of batches that determine the rate."""
MIN_BATCH_READ_TIME_S = 1e-4
"""Smallest time counted for reading a batch [s]."""
# Plain numbers, as operations of an enumeration take a microsecond, at every frame.
_CONTROL_KIND = int(FrameKind.CONTROL)
_DATA_KIND = int(FrameKind.DATA)
_ACKNOWLEDGE_BIT = int(FrameFlag.ACKNOWLEDGE)


class DataFrame(NamedTuple):
    """A data frame without its number, which is all that differs between clients.

    Attributes:
        topic: its number.
        t_ns: simulated time [ns].
        wall_ns: when it was sampled [ns].
        head: its bytes before the number.
        tail: its bytes behind the number.
    """

    topic: int
    t_ns: int
    wall_ns: int
    head: bytes
    tail: bytes


def data_frames(published: Published) -> list[DataFrame]:
    """Return the frames of published topics, for all clients."""
    t_ns, wall_ns = published.t_ns, published.wall_ns
    frames = []
    for topic, payload in published.payloads:
        header = FRAME_HEADER.pack(
            FRAME_MAGIC, PROTOCOL_VERSION, _DATA_KIND, topic, 0, 0, len(payload), t_ns
        )
        head, tail = header[: SEQ_SLICE.start], header[SEQ_SLICE.stop :] + payload
        frames.append(DataFrame(topic, t_ns, wall_ns, head, tail))
    return frames


class SampleBuffer:
    """A ring buffer for each topic; a full one drops its oldest sample.

    Args:
        topics: subscribed topics of state.
        rate: largest number of frames per simulated second for each topic [1/s], None for all.

    Attributes:
        waiting: number of samples in all buffers.
        dropped: number of samples dropped without being sent.
    """

    def __init__(self, topics: Iterable[Topic], rate: float | None) -> None:
        self._buffers: dict[int, deque[DataFrame]] = {
            topic.id: deque(
                maxlen=max(MIN_KEPT_SAMPLES, math.ceil(SAMPLE_KEEP_TIME_S * topic.rate))
            )
            for topic in topics
        }
        self._order = list(self._buffers.values())
        self._first = 0
        self._period = 0 if rate is None else round((1.0 - EARLY_PERIOD_SHARE) * 1e9 / rate)
        self._last: dict[int, int] = {}
        self.waiting = 0
        self.dropped = 0

    def add(self, sample: DataFrame) -> None:
        """Add a sample if its topic is subscribed."""
        topic = sample.topic
        buffer = self._buffers.get(topic)
        if buffer is None:
            return
        if self._period:
            last = self._last.get(topic)
            # Time goes back if the flight restarts.
            if last is not None and 0 <= sample.t_ns - last < self._period:
                return
            self._last[topic] = sample.t_ns
        if len(buffer) == buffer.maxlen:
            self.dropped += 1
        else:
            self.waiting += 1
        buffer.append(sample)

    def thin(self, keep: int) -> None:
        """Drop the oldest samples until about `keep` are left.

        Each topic keeps its newest sample.
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
        """Return up to `most` of the oldest samples, from each topic in turn."""
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
    """A batch without an acknowledgement yet; with no data frames it is a question."""

    seq: int
    frames: int
    sent: float
    wall_ns: int


class Outgoing:
    """The frames to one client; callers pass the time [s].

    Args:
        t_ns: newest simulated time [ns].

    Attributes:
        t_ns: see above.
        seq: number of the last frame.
        acknowledged_ns: wall time of the newest acknowledged sample [ns], 0 before the first.
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
        """Number of samples dropped as the client was too slow."""
        return self._dropped_before + self._states.dropped

    @property
    def overflowed(self) -> bool:
        """Whether too much is left after `take`, so that the connection must end."""
        return max(len(self._answers), len(self._events)) > MAX_QUEUED_ANSWERS

    def subscribe(self, topics: Sequence[Topic], rate: float | None) -> None:
        """Subscribe to topics; `rate` limits the frames per second of each topic of state."""
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
        """Send an operation that requires an acknowledgement, to check that the client responds."""
        self._question = payload

    def publish(self, t_ns: int, samples: Iterable[DataFrame]) -> None:
        """Add the samples of a time, of subscribed topics."""
        self.t_ns = t_ns
        add = self._states.add
        events = self._event_topics
        for sample in samples:
            if sample.topic in events:
                self._events.append(sample)
            else:
                add(sample)

    def take(self, now: float) -> bytes:
        """Return the bytes of the frames to write now, possibly none."""
        parts: list[bytes] = []
        while self._answers:
            self._add_operation(parts, 0, self._answers.popleft())
        if self._question:
            self._add_operation(parts, _ACKNOWLEDGE_BIT, self._question)
            self._question = b""
            self._batches.append(_Batch(self.seq, 0, now, 0))
        if self._may_send(now) and (self._events or self._states.waiting):
            self._add_batch(parts, now)
        return b"".join(parts)

    def last(self, payload: bytes) -> bytes:
        """Return the last frame, with an operation."""
        parts: list[bytes] = []
        self._add_operation(parts, 0, payload)
        return b"".join(parts)

    def acknowledge(self, seq: int, now: float) -> bool:
        """Process an acknowledgement of a frame number, and return whether it is valid."""
        if not self._acknowledged < seq <= self.seq or not self._batches:
            return False
        self._reading.acknowledged(seq - self._acknowledged, now)
        self._acknowledged = seq
        self._heard = now
        while self._batches and self._batches[0].seq <= seq:
            batch = self._batches.popleft()
            self._reading.batch(batch.frames, now - batch.sent)
            self.acknowledged_ns = max(self.acknowledged_ns, batch.wall_ns)
        return True

    def silence(self, now: float) -> float:
        """Return the time since an acknowledgement became due [s]."""
        if not self._batches:
            return 0.0
        return now - max(self._heard, self._batches[0].sent)

    def rate(self, now: float) -> float:
        """Return the rate at which the client reads frames [1/s]."""
        return self._reading.shown(now)

    def _may_send(self, now: float) -> bool:
        """Return whether a batch may be sent now.

        The batches on a long way are spread evenly over it. Otherwise they would come together,
        and a client far away would hear nothing for a whole round trip.
        """
        if not self._batches:
            return True
        spread = self._reading.trip / MAX_OPEN_BATCHES
        return len(self._batches) < MAX_OPEN_BATCHES and now - self._batches[-1].sent >= spread

    def _add_batch(self, parts: list[bytes], now: float) -> None:
        shown = self._reading.shown(now)
        # As a far client reads a batch in each part of the round trip, it must have all of that.
        most = max(
            MIN_BATCH_FRAMES, int((BATCH_TIME_S + self._reading.trip / MAX_OPEN_BATCHES) * shown)
        )
        # A fast client may not have received many frames yet, so its last batches count, too.
        keep = max(
            MIN_BATCH_FRAMES,
            int(MAX_SAMPLE_DELAY_S * shown),
            int(BATCH_TIME_S * self._reading.of_batch),
        )
        self._states.thin(keep)
        samples = [*self._events, *self._states.take(most)]
        self._events.clear()
        left, seq, newest = len(samples), self.seq, 0
        for topic, _, wall_ns, head, tail in samples:
            left -= 1
            seq += 1
            if not left % FRAMES_PER_ACKNOWLEDGEMENT:
                asking = FRAME_HEADER.pack(
                    FRAME_MAGIC, PROTOCOL_VERSION, _DATA_KIND, topic, _ACKNOWLEDGE_BIT, 0, 0, 0
                )
                head = asking[: SEQ_SLICE.start]
            parts += (head, seq.to_bytes(4, "little"), tail)
            if wall_ns > newest:
                newest = wall_ns
        self.seq = seq
        self._batches.append(_Batch(seq, len(samples), now, newest))

    def _add_operation(self, parts: list[bytes], flags: int, payload: bytes) -> None:
        self.seq += 1
        header = (
            FRAME_MAGIC,
            PROTOCOL_VERSION,
            _CONTROL_KIND,
            0,
            flags,
            self.seq,
            len(payload),
            self.t_ns,
        )
        parts += (FRAME_HEADER.pack(*header), payload)


class ReadRate:
    """The rate at which a client reads, from its acknowledgements; callers pass the time [s].

    Attributes:
        trip: shortest time from a batch to its acknowledgement [s], 0 before the first.
    """

    def __init__(self) -> None:
        self.trip = 0.0
        self._batches: deque[float] = deque(maxlen=RATE_BATCH_COUNT)
        self._counts: deque[tuple[float, int]] = deque()
        self._sum = 0

    @property
    def of_batch(self) -> float:
        """Rate of the fastest of the last batches, from sending to acknowledgement [1/s].

        A single late batch may be a delay of the machine; a slow client is slow every time.
        """
        return max(self._batches, default=0.0)

    def acknowledged(self, frames: int, now: float) -> None:
        """Count frames that were read."""
        self._counts.append((now, frames))
        self._sum += frames
        self._forget(now)

    def batch(self, frames: int, seconds: float) -> None:
        """Add the time that it took to read a batch, of no frames if that was a question."""
        self.trip = min(self.trip or seconds, seconds)
        if frames:
            self._batches.append(frames / max(seconds, MIN_BATCH_READ_TIME_S))

    def shown(self, now: float) -> float:
        """Return the number of frames read in the last second [1/s]."""
        self._forget(now)
        return self._sum / RATE_SPAN_S

    def _forget(self, now: float) -> None:
        while self._counts and self._counts[0][0] < now - RATE_SPAN_S:
            self._sum -= self._counts.popleft()[1]

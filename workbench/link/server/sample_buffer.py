"""The samples of state topics that a client has not got yet: the newest of each, a few."""

import math
from collections import deque
from collections.abc import Iterable
from typing import NamedTuple

from workbench.link.topics import Topic

KEPT = 0.5
"""Samples of a topic are kept for so long, so that a client may pause without a gap [s]."""
LEAST_KEPT = 2
EARLY = 0.01
"""A sample may come so much of a period early where a client wants less than there are."""


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

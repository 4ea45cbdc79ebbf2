"""Samples of topics, and the queue of samples not read yet."""

import threading
import time
from collections import deque
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from types import MappingProxyType

from workbench.link.topics import Delivery, FieldValue, Topic

MAX_QUEUE_AGE_S = 0.5
"""Age in the queue after which newer states replace a state [s]."""
MAX_QUEUED_SAMPLES = 2048
"""Largest number of waiting samples of one topic, of any age."""


@dataclass(frozen=True)
class Sample:
    """A sample of a topic at one time; its fields are unpacked on first access.

    Attributes:
        definition: of the topic, from the server.
        t_ns: simulated time [ns].
        payload: as received.
    """

    definition: Topic
    t_ns: int
    payload: bytes

    @property
    def topic(self) -> str:
        """Name of the topic, such as `/dh_drone/velocity_data`."""
        return self.definition.name

    @property
    def time(self) -> float:
        """Simulated time [s]."""
        return self.t_ns / 1e9

    @cached_property
    def values(self) -> Mapping[str, FieldValue]:
        """The fields by name, in SI units and in the frames of the definition."""
        return MappingProxyType(self.definition.unpack(self.payload))

    def __getitem__(self, field: str) -> FieldValue:
        return self.values[field]


@dataclass
class _TopicQueue:
    """The waiting samples of one topic, oldest first.

    Attributes:
        waiting: each with its number and arrival time [s].
        turn: number of the arrival that gives this topic its place in the order.
    """

    waiting: deque[tuple[int, float, Sample]] = field(default_factory=deque)
    turn: int = 0


class SampleQueue:
    """Samples between the network and a reader that may be slow.

    A reader that keeps up gets each sample, in order of arrival. For a slower one, states older
    than `MAX_QUEUE_AGE_S` are replaced by the newest of their topic, so age and memory stay small.
    A sample that replaces another takes its turn, so no topic starves.

    Args:
        clock: time now [s].

    Attributes:
        arrived: total number of samples.
        dropped: number of samples dropped as the reader was too slow.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.arrived = 0
        self.dropped = 0
        self._clock = clock
        self._topics: dict[str, _TopicQueue] = {}
        self._newest: dict[str, Sample] = {}
        self._open = True
        self._change = threading.Condition()

    def put(self, samples: list[Sample]) -> None:
        """Add samples that have arrived."""
        with self._change:
            now = self._clock()
            for sample in samples:
                queue = self._topics.setdefault(sample.topic, _TopicQueue())
                self.arrived += 1
                if not queue.waiting:
                    queue.turn = self.arrived
                queue.waiting.append((self.arrived, now, sample))
                self._newest[sample.topic] = sample
                self._drop_old(queue, now)
            self._change.notify_all()

    def take(self) -> Sample | None:
        """Return the next sample, or None."""
        with self._change:
            return self._take()

    def wait(self) -> Sample | None:
        """Wait for the next sample; None once the queue is closed and empty."""
        with self._change:
            while (sample := self._take()) is None and self._open:
                self._change.wait()
            return sample

    def newest(self, topic: str) -> Sample | None:
        """Return the newest sample of a topic, read or not."""
        with self._change:
            return self._newest.get(topic)

    def close(self) -> None:
        """Release all waiting callers."""
        with self._change:
            self._open = False
            self._change.notify_all()

    def _take(self) -> Sample | None:
        waiting = [queue for queue in self._topics.values() if queue.waiting]
        if not waiting:
            return None
        queue = min(waiting, key=lambda each: each.turn)
        self._drop_old(queue, self._clock())
        _, _, sample = queue.waiting.popleft()
        if queue.waiting:
            queue.turn = queue.waiting[0][0]
        return sample

    def _drop_old(self, queue: _TopicQueue, now: float) -> None:
        """Drop samples that are too old, but never the newest; drop events only if too many."""
        waiting = queue.waiting
        lasting = waiting[-1][2].definition.delivery is Delivery.EVENT
        while len(waiting) > 1 and (
            len(waiting) > MAX_QUEUED_SAMPLES
            or (not lasting and now - waiting[0][1] > MAX_QUEUE_AGE_S)
        ):
            waiting.popleft()
            self.dropped += 1

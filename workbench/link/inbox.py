"""What has arrived and was not read yet, bounded however slow its reader is."""

import threading
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field

from workbench.link.sample import Sample
from workbench.link.topics import Delivery

PATIENCE = 0.5
"""A state that waited longer than this gives way to newer ones [s]."""
DEEPEST = 2048
"""Samples of one topic that may wait, whatever their age."""


@dataclass
class _Shelf:
    """The samples of one topic that wait, oldest first.

    Attributes:
        waiting: each with its number and when it arrived [s].
        turn: number of the arrival since which the reader owes this topic a look.
    """

    waiting: deque[tuple[int, float, Sample]] = field(default_factory=deque)
    turn: int = 0


class Inbox:
    """Samples between the network and a reader who may be slow.

    A reader who keeps up gets each sample, in the order in which they came. For one who does not,
    states older than `PATIENCE` give way to the newest of their topic, so age and memory stay
    small. A sample that inherits another's place also inherits its turn: so no topic starves.

    Args:
        clock: time now [s].

    Attributes:
        arrived: samples in all.
        dropped: samples that the reader was too slow for.
    """

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.arrived = 0
        self.dropped = 0
        self._clock = clock
        self._shelves: dict[str, _Shelf] = {}
        self._newest: dict[str, Sample] = {}
        self._open = True
        self._change = threading.Condition()

    def put(self, samples: list[Sample]) -> None:
        """Take in what has arrived."""
        with self._change:
            now = self._clock()
            for sample in samples:
                shelf = self._shelves.setdefault(sample.topic, _Shelf())
                self.arrived += 1
                if not shelf.waiting:
                    shelf.turn = self.arrived
                shelf.waiting.append((self.arrived, now, sample))
                self._newest[sample.topic] = sample
                self._thin_out(shelf, now)
            self._change.notify_all()

    def take(self) -> Sample | None:
        """Return the next sample, None if none waits."""
        with self._change:
            return self._take()

    def wait(self) -> Sample | None:
        """Wait for the next sample; None once the inbox is closed and empty."""
        with self._change:
            while (sample := self._take()) is None and self._open:
                self._change.wait()
            return sample

    def newest(self, topic: str) -> Sample | None:
        """Return a topic's newest sample, whether it was read or not."""
        with self._change:
            return self._newest.get(topic)

    def close(self) -> None:
        """Let nobody wait any longer."""
        with self._change:
            self._open = False
            self._change.notify_all()

    def _take(self) -> Sample | None:
        waiting = [shelf for shelf in self._shelves.values() if shelf.waiting]
        if not waiting:
            return None
        shelf = min(waiting, key=lambda each: each.turn)
        self._thin_out(shelf, self._clock())
        _, _, sample = shelf.waiting.popleft()
        if shelf.waiting:
            shelf.turn = shelf.waiting[0][0]
        return sample

    def _thin_out(self, shelf: _Shelf, now: float) -> None:
        """Drop what is too old, but never the newest; events only where there are too many."""
        waiting = shelf.waiting
        lasting = waiting[-1][2].definition.delivery is Delivery.EVENT
        while len(waiting) > 1 and (
            len(waiting) > DEEPEST or (not lasting and now - waiting[0][1] > PATIENCE)
        ):
            waiting.popleft()
            self.dropped += 1

"""How fast a client is, as its acknowledgements show."""

from collections import deque

SPAN = 1.0
"""Frames are counted over so long [s]."""
LAST = 4
"""Batches whose pace counts."""
SHORTEST = 1e-4
"""No batch is taken to have been read in less [s]."""


class Pace:
    """Counts what a client has acknowledged; times are told [s]."""

    def __init__(self) -> None:
        self._batches: deque[float] = deque(maxlen=LAST)
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
        self._batches.append(frames / max(seconds, SHORTEST))

    def shown(self, now: float) -> float:
        """Return the frames that were read in the last second [1/s]."""
        self._forget(now)
        return self._sum / SPAN

    def _forget(self, now: float) -> None:
        while self._counts and self._counts[0][0] < now - SPAN:
            self._sum -= self._counts.popleft()[1]

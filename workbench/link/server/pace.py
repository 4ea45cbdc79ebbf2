"""How fast a client is, as its acknowledgements show."""

from collections import deque

SPAN = 1.0
"""Frames are counted over so long [s]."""
SHORTEST = 1e-4
"""No batch is taken to have been read in less [s]."""


class Pace:
    """Counts what a client has acknowledged; times are told [s].

    Attributes:
        of_batch: frames a second of the last batch, from its sending to its acknowledgement.
    """

    def __init__(self) -> None:
        self.of_batch = 0.0
        self._counts: deque[tuple[float, int]] = deque()
        self._sum = 0

    def acknowledged(self, frames: int, now: float) -> None:
        """Note frames that were read."""
        self._counts.append((now, frames))
        self._sum += frames
        self._forget(now)

    def batch(self, frames: int, seconds: float) -> None:
        """Note how long it took until a batch was read."""
        self.of_batch = frames / max(seconds, SHORTEST)

    def shown(self, now: float) -> float:
        """Return the frames that were read in the last second [1/s]."""
        self._forget(now)
        return self._sum / SPAN

    def _forget(self, now: float) -> None:
        while self._counts and self._counts[0][0] < now - SPAN:
            self._sum -= self._counts.popleft()[1]

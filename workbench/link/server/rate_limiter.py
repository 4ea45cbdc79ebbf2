"""How much a client may send: beyond that the server reads later, so a flood waits outside."""

from workbench.link.wire import LARGEST_OPERATION

FRAMES = 1000.0
"""Frames a second, in the long run."""
FRAME_BURST = 200.0
"""Frames at once."""
BYTES = 1_000_000.0
BYTE_BURST = 128 * 1024.0
OPERATIONS = 64_000.0
"""Bytes of operations a second, and of the flight's answers to them: to read and to write JSON
takes a hundred times as long as to pass on bytes."""
OPERATION_BURST = 2 * LARGEST_OPERATION
LEAST_PAUSE = 0.02
"""A pause costs a timer, so short ones are made longer [s]."""


class RateLimiter:
    """Three token buckets, of frames, bytes and operations: time fills them, input empties them.

    Args:
        now: by any clock that only rises [s]; so in the methods.
    """

    def __init__(self, now: float) -> None:
        self._frames = FRAME_BURST
        self._bytes = BYTE_BURST
        self._operations = float(OPERATION_BURST)
        self._filled = now

    def take(self, size: int, now: float) -> None:
        """Take the bytes that have come, even below zero."""
        passed = now - self._filled
        self._filled = now
        self._frames = min(FRAME_BURST, self._frames + FRAMES * passed)
        self._bytes = min(BYTE_BURST, self._bytes + BYTES * passed) - size
        self._operations = min(OPERATION_BURST, self._operations + OPERATIONS * passed)

    def take_frame(self) -> None:
        """Take a frame, or what came and was none, even below zero."""
        self._frames -= 1.0

    def take_operation(self, size: int) -> None:
        """Take the bytes of an operation, or of the answer to one, even below zero."""
        self._operations -= size

    def give_back(self) -> None:
        """Put a frame back, as we asked for it."""
        self._frames += 1.0

    def pause(self) -> float:
        """Return how long not to read, 0 for not at all [s]."""
        lacking = max(
            (1.0 - self._frames) / FRAMES,
            -self._bytes / BYTES,
            -self._operations / OPERATIONS,
        )
        return max(lacking, LEAST_PAUSE) if lacking > 0.0 else 0.0

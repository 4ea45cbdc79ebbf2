"""Limit how fast a client sends."""

from workbench.link.wire import MAX_OPERATION_BYTES

FRAMES_PER_S = 1000.0
"""Sustained rate of frames [1/s]."""
FRAME_BURST_COUNT = 200.0
"""Largest burst of frames."""
RECEIVED_BYTES_PER_S = 1_000_000.0
RECEIVED_BURST_BYTES = 128 * 1024.0
OPERATION_BYTES_PER_S = 64_000.0
"""Rate of bytes of operations, and of the answers to them [1/s]: parsing and writing JSON takes a
hundred times as long as passing bytes on."""
OPERATION_BURST_BYTES = 2 * MAX_OPERATION_BYTES
MIN_READ_PAUSE_S = 0.02
"""Shortest pause, as each one needs a timer [s]."""


class RateLimiter:
    """Three token buckets, for frames, bytes and operations.

    Args:
        now: time of a monotonic clock [s], here and in the methods.
    """

    def __init__(self, now: float) -> None:
        self._frames = FRAME_BURST_COUNT
        self._bytes = RECEIVED_BURST_BYTES
        self._operations = float(OPERATION_BURST_BYTES)
        self._filled = now

    def take(self, size: int, now: float) -> None:
        """Take received bytes, even below zero."""
        passed = now - self._filled
        self._filled = now
        self._frames = min(FRAME_BURST_COUNT, self._frames + FRAMES_PER_S * passed)
        self._bytes = min(RECEIVED_BURST_BYTES, self._bytes + RECEIVED_BYTES_PER_S * passed) - size
        self._operations = min(
            OPERATION_BURST_BYTES, self._operations + OPERATION_BYTES_PER_S * passed
        )

    def take_frame(self) -> None:
        """Take a frame, or received bytes that completed none, even below zero."""
        self._frames -= 1.0

    def take_operation(self, size: int) -> None:
        """Take the bytes of an operation or of an answer, even below zero."""
        self._operations -= size

    def give_back(self) -> None:
        """Return a frame, as the server asked for it."""
        self._frames += 1.0

    def pause(self, now: float) -> float:
        """Return for how long to stop reading [s], 0 to read on."""
        self.take(0, now)
        lacking = max(
            (1.0 - self._frames) / FRAMES_PER_S,
            -self._bytes / RECEIVED_BYTES_PER_S,
            -self._operations / OPERATION_BYTES_PER_S,
        )
        return max(lacking, MIN_READ_PAUSE_S) if lacking > 0.0 else 0.0

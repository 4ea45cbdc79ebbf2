"""How much a client may send: beyond it the server reads later, so that a flood waits outside."""

FRAMES = 1000.0
"""Frames a second, in the long run."""
FRAME_BURST = 200.0
"""Frames at once."""
BYTES = 1_000_000.0
BYTE_BURST = 128 * 1024.0
LEAST_PAUSE = 0.02
"""A pause costs a timer, so short ones are made longer [s]."""


class Bucket:
    """Fills with time and is emptied by what comes.

    Args:
        now: by any clock that only rises [s]; so in the methods.
    """

    def __init__(self, now: float) -> None:
        self._frames = FRAME_BURST
        self._bytes = BYTE_BURST
        self._filled = now

    def take(self, size: int, now: float) -> None:
        """Take the bytes that have come, even if there are less in it."""
        passed = now - self._filled
        self._filled = now
        self._frames = min(FRAME_BURST, self._frames + FRAMES * passed)
        self._bytes = min(BYTE_BURST, self._bytes + BYTES * passed) - size

    def take_frame(self) -> bool:
        """Take one frame, if there is one in it."""
        if self._frames < 1.0:
            return False
        self._frames -= 1.0
        return True

    def take_piece(self) -> None:
        """Take a frame, even if there is none in it, for what came and was none."""
        self._frames -= 1.0

    def give_back(self) -> None:
        """Put a frame back, as we asked for it."""
        self._frames += 1.0

    def pause(self) -> float:
        """Return how long not to read, 0 for not at all [s]."""
        lacking = max((1.0 - self._frames) / FRAMES, -self._bytes / BYTES)
        return max(lacking, LEAST_PAUSE) if lacking > 0.0 else 0.0

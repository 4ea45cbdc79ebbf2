"""Where a connection's bytes go: TCP, TLS and WebSocket look alike to the hub."""

from typing import Protocol


class Transport(Protocol):
    """One connection; nothing here waits, and after `close` or `abort` all does nothing."""

    @property
    def unsent(self) -> int:
        """Bytes that were written here and not yet taken by the system, about."""

    def write(self, data: bytes) -> None:
        """Send bytes: whole frames, in their order."""

    def close(self) -> None:
        """End the connection when all that was written is out, or after a second at most.

        What still comes in is dropped.
        """

    def abort(self) -> None:
        """End it at once."""

"""Everything that a flight publishes, sample by sample, on its way to who draws it."""

from workbench.ipc.send_queue import SendQueue
from workbench.link.backplane import Published
from workbench.live.messages import Streamed


class Stream:
    """Gathers what is published between two reports, and sends it in one message.

    A reader that stands still costs no memory: what it is too slow for is left out, and counted.

    Args:
        send_queue: where it goes.
    """

    wanted = True

    def __init__(self, send_queue: SendQueue) -> None:
        self._send_queue = send_queue
        self._gathered: list[Published] = []
        self._lost = 0

    def add(self, published: Published) -> None:
        """Take topics at one time."""
        self._gathered.append(published)

    def flush(self) -> None:
        """Send what was gathered."""
        if not self._gathered:
            return
        gathered, self._gathered = tuple(self._gathered), []
        if self._send_queue.offer(Streamed(gathered, self._lost)):
            self._lost = 0
        else:
            self._lost += len(gathered)


class NoStream:
    """Stands for a stream that nobody wants."""

    wanted = False

    def add(self, published: Published) -> None:
        """Let it go."""

    def flush(self) -> None:
        """Do nothing."""

"""Everything that a flight publishes, sample by sample, on its way to who draws it."""

from workbench.ipc.send_queue import SendQueue
from workbench.link.backplane import Published
from workbench.live.messages import Streamed


class Stream:
    """Gathers what is published between two reports, and sends it in one message.

    A reader that stands still costs no memory: what it is too slow for is left out, and counted.

    Args:
        send_queue: where it goes; None where it is not wanted.
    """

    def __init__(self, send_queue: SendQueue | None = None) -> None:
        self._send_queue = send_queue
        self._gathered: list[Published] = []
        self._lost = 0

    @property
    def wanted(self) -> bool:
        """Whether it goes anywhere."""
        return self._send_queue is not None

    def add(self, published: Published) -> None:
        """Take topics at one time."""
        if self.wanted:
            self._gathered.append(published)

    def flush(self) -> None:
        """Send what was gathered."""
        if self._send_queue is None or not self._gathered:
            return
        gathered, self._gathered = tuple(self._gathered), []
        if self._send_queue.offer(Streamed(gathered, self._lost)):
            self._lost = 0
        else:
            self._lost += len(gathered)

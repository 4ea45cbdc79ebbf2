"""Everything that a flight publishes, sample by sample, on its way to the charts."""

from workbench.ipc.send_queue import SendQueue
from workbench.link.backplane import Published
from workbench.live.messages import StreamedRecords


class RecordStream:
    """Collects what is published between two reports, and sends it in one message.

    A stopped reader costs no memory: data that it is too slow for is left out and counted.

    Args:
        send_queue: destination; None without one.
    """

    def __init__(self, send_queue: SendQueue | None = None) -> None:
        self._send_queue = send_queue
        self._gathered: list[Published] = []
        self._lost = 0

    @property
    def wanted(self) -> bool:
        """Whether there is a destination."""
        return self._send_queue is not None

    def add(self, published: Published) -> None:
        """Add topics of one time."""
        if self.wanted:
            self._gathered.append(published)

    def flush(self) -> None:
        """Send the collected topics."""
        if self._send_queue is None or not self._gathered:
            return
        gathered, self._gathered = tuple(self._gathered), []
        if self._send_queue.offer(StreamedRecords(gathered, self._lost)):
            self._lost = 0
        else:
            self._lost += len(gathered)

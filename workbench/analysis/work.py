"""What someone who works on an answer knows of the asker."""

from collections.abc import Callable, Iterator
from dataclasses import dataclass

from workbench.analysis.messages import Progressed
from workbench.analysis.replies import Reply, Searched
from workbench.analysis.request_queue import RequestQueue
from workbench.common.errors import WorkbenchError
from workbench.ipc.send_queue import SendQueue

STOPPED = "it was stopped before it was done"

Working = Iterator[Reply | None]
"""An answer in the making: gives None as often as it can rest, and the reply in the end."""


@dataclass(frozen=True)
class Work:
    """One question's being worked on.

    Attributes:
        number: of the question.
        requests: where a stop is heard.
        send_queue: where progress is told.
    """

    number: int
    requests: RequestQueue
    send_queue: SendQueue

    @property
    def stopped(self) -> bool:
        """Whether the asker wants it no more."""
        return self.number <= self.requests.stopped

    def check(self, _share: float = 0.0) -> None:
        """Give up if the asker wants it no more; a callback of progress.

        Raises:
            WorkbenchError: if so.
        """
        if self.stopped:
            raise WorkbenchError(STOPPED)

    def on_stop(self, act: Callable[[], None]) -> None:
        """Call when the asker wants it no more: at once, in another thread."""
        self.requests.on_stop(self.number, act)

    def tell(self, searched: Searched) -> None:
        """Tell how it goes."""
        self.send_queue.show(Progressed(self.number, searched))

"""A Qt application that times every event it handles, in wall time and in processor time."""

import time
from collections import Counter

from PyQt6 import sip
from PyQt6.QtCore import QEvent, QObject
from PyQt6.QtWidgets import QApplication


class WatchedApplication(QApplication):
    """Takes note of how long the thread of the screens is busy with each event.

    Events within an event, as the paints of a frame, are part of the outer one.

    Attributes:
        walls: what each took [s].
        processors: of the processor [s]; other programs on the machine do not count.
    """

    def __init__(self, arguments: list[str]) -> None:
        super().__init__(arguments)
        self._depth = 0
        self.forget()

    def forget(self) -> None:
        """Begin to count anew."""
        self.walls: list[float] = []
        self.processors: list[float] = []
        self._paints: Counter[int] = Counter()

    @property
    def frames(self) -> int:
        """How often the widget was painted that was painted most often."""
        return max(self._paints.values(), default=0)

    def notify(self, receiver: QObject | None, event: QEvent | None) -> bool:
        """Handle an event."""
        if event is not None and event.type() == QEvent.Type.Paint:
            self._paints[sip.unwrapinstance(receiver)] += 1
        if self._depth:
            return super().notify(receiver, event)
        wall, processor = time.perf_counter(), time.thread_time()
        self._depth += 1
        try:
            return super().notify(receiver, event)
        finally:
            self._depth -= 1
            self.walls.append(time.perf_counter() - wall)
            self.processors.append(time.thread_time() - processor)

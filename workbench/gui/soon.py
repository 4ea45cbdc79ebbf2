"""What is to be shown after several changes that come with one event."""

from collections.abc import Callable

from PyQt6.QtCore import QObject, QTimer


class Soon(QObject):
    """Calls once when the present event is over, however often it was asked to.

    Args:
        call: to be called.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, call: Callable[[], None], parent: QObject) -> None:
        super().__init__(parent)
        self._timer = QTimer(self)
        self._timer.setSingleShot(True)
        self._timer.setInterval(0)
        self._timer.timeout.connect(call)

    def ask(self, *_: object) -> None:
        """Ask for the call; any signal may."""
        self._timer.start()

"""A timer that calls once, some time after it was started last."""

from collections.abc import Callable

from PyQt6.QtCore import QObject, QTimer


def single_shot(call: Callable[[], object], parent: QObject, after: int = 0) -> QTimer:
    """Return a timer, not yet started; each start begins the wait again.

    Args:
        call: to be called.
        parent: the Qt parent; the timer is deleted with it.
        after: the wait [ms]; with 0 it calls when the present event is over.
    """
    timer = QTimer(parent)
    timer.setSingleShot(True)
    timer.setInterval(after)
    timer.timeout.connect(call)
    return timer

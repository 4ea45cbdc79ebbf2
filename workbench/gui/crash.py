"""Turns unhandled exceptions into notices: otherwise one in a slot would end the process."""

import sys
import threading
import traceback
from types import TracebackType

from PyQt6.QtCore import QObject, Qt, pyqtSignal

from workbench.gui.notices import Notice, Notices, Severity

REMEDY = "The window goes on. Reset the flight (Ctrl+R) if it looks wrong; copy the details."
LONGEST = 200
"""Largest length of an exception's message in the banner [characters]."""


class CrashGuard(QObject):
    """Catches unhandled exceptions of all threads while it is installed.

    Args:
        notices: takes the report.
        parent: the Qt parent; this object is deleted with it.
    """

    interrupted = pyqtSignal()
    """Ctrl-C was pressed in the terminal."""
    _caught = pyqtSignal(object)

    def __init__(self, notices: Notices, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._notices = notices
        queued = Qt.ConnectionType.QueuedConnection  # in whatever thread it happened
        self._caught.connect(self._tell, queued)  # type: ignore[call-arg]
        self._before = (sys.excepthook, threading.excepthook)

    def install(self) -> None:
        """Install the handlers."""
        self._before = (sys.excepthook, threading.excepthook)
        sys.excepthook = self.catch
        threading.excepthook = self._catch_in_thread

    def uninstall(self) -> None:
        """Restore the former handlers."""
        sys.excepthook, threading.excepthook = self._before

    def catch(
        self, kind: type[BaseException], error: BaseException, trace: TracebackType | None
    ) -> None:
        """Report an exception; Ctrl-C closes the app."""
        if issubclass(kind, KeyboardInterrupt):
            self.interrupted.emit()
            return
        details = "".join(traceback.format_exception(kind, error, trace))
        print(details, file=sys.stderr)
        words = " ".join(str(error).split())[:LONGEST]
        where = _place(trace)
        what = f"something went wrong in the app: {kind.__name__}: {words}{where}"
        self._caught.emit(Notice(Severity.FAILURE, what, REMEDY, details))

    def _catch_in_thread(self, caught: threading.ExceptHookArgs) -> None:
        if caught.exc_value is not None and not issubclass(caught.exc_type, SystemExit):
            self.catch(caught.exc_type, caught.exc_value, caught.exc_traceback)

    def _tell(self, notice: Notice) -> None:
        self._notices.told.emit(notice)


def _place(trace: TracebackType | None) -> str:
    """Return file and line of the exception."""
    frames = traceback.extract_tb(trace)
    if not frames:
        return ""
    last = frames[-1]
    return f" ({last.filename.rpartition('/')[2]}:{last.lineno})"

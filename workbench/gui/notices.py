"""Notices of the app: a sentence about an event, and one about what to do."""

from dataclasses import dataclass
from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal


class Severity(Enum):
    """Severity of a notice; shown as a word and a shape, not only as a colour."""

    INFORMATION = "note"
    WARNING = "warning"
    FAILURE = "failure"


@dataclass(frozen=True)
class Notice:
    """Something that the user should know.

    Attributes:
        severity: its severity.
        what: the event, as a sentence.
        remedy: what to do about it, "" for nothing.
        details: stack trace of a programming error; else "".
    """

    severity: Severity
    what: str
    remedy: str = ""
    details: str = ""


class Notices(QObject):
    """Collects notices from all parts of the app; the banner shows them."""

    told = pyqtSignal(object)
    """A `Notice`."""

    def inform(self, what: str) -> None:
        """Report success."""
        self.told.emit(Notice(Severity.INFORMATION, what))

    def warn(self, what: str, remedy: str = "") -> None:
        """Report something that did not go as wished."""
        self.told.emit(Notice(Severity.WARNING, what, remedy))

    def fail(self, what: str, remedy: str = "") -> None:
        """Report a failure that lasts until something is done."""
        self.told.emit(Notice(Severity.FAILURE, what, remedy))

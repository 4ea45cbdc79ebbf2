"""What the app has to tell: a sentence that says what happened, and one that says what to do."""

from dataclasses import dataclass
from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal


class Severity(Enum):
    """How much a notice matters; shown as a word and a shape, not as a colour alone."""

    INFORMATION = "note"
    WARNING = "warning"
    FAILURE = "failure"


@dataclass(frozen=True)
class Notice:
    """Something that the user should know.

    Attributes:
        severity: how much it matters.
        what: happened, as a sentence.
        remedy: what to do about it, "" where there is nothing to do.
        details: the stack trace of a fault of ours; "" else.
    """

    severity: Severity
    what: str
    remedy: str = ""
    details: str = ""


class Notices(QObject):
    """Where all parts of the app tell what happened; the banner shows it."""

    told = pyqtSignal(object)
    """A `Notice`."""

    def inform(self, what: str) -> None:
        """Tell what was done."""
        self.told.emit(Notice(Severity.INFORMATION, what))

    def warn(self, what: str, remedy: str = "") -> None:
        """Tell what did not go as wished."""
        self.told.emit(Notice(Severity.WARNING, what, remedy))

    def fail(self, what: str, remedy: str = "") -> None:
        """Tell what is broken until something is done."""
        self.told.emit(Notice(Severity.FAILURE, what, remedy))

"""Notices of the app: a sentence about an event, and one about what to do."""

from dataclasses import dataclass, field
from enum import Enum

from PyQt6.QtCore import QObject, pyqtSignal


class Severity(Enum):
    """Severity of a notice; shown as a word and a shape, not only as a colour."""

    INFORMATION = "note"
    WARNING = "warning"
    FAILURE = "failure"


NOTICE_DURATIONS_S = {Severity.INFORMATION: 8.0, Severity.WARNING: 20.0, Severity.FAILURE: 20.0}
"""How long a notice is new, and comes before older ones whatever their severity [s]."""


@dataclass(frozen=True)
class Notice:
    """Something that the user should know.

    Attributes:
        severity: its severity.
        what: the event, as a sentence.
        remedy: what to do about it, "" for nothing.
        details: stack trace of a programming error; else "".
        of_flight: whether it is an alarm of the flight, which ends with its cause or a reset.
        times: how often it was told.
        told_at: monotonic time of the last time, once it is listed [s].
        is_over: whether its cause has ended, or it was dismissed.
    """

    severity: Severity
    what: str
    remedy: str = ""
    details: str = ""
    of_flight: bool = False
    times: int = 1
    told_at: float = field(default=0.0, compare=False)
    is_over: bool = False

    @property
    def advice(self) -> str:
        """What to do, in words: the remedy, or else what an error says after its colon."""
        return self.remedy or (self.what if self.severity is not Severity.INFORMATION else "")

    def is_new(self, now: float) -> bool:
        """Return whether it was told lately, and is not over."""
        return not self.is_over and now - self.told_at < NOTICE_DURATIONS_S[self.severity]

    @property
    def stays(self) -> bool:
        """Whether it stays when it is no longer new: a failure, or an alarm with its cause."""
        return (self.severity is Severity.FAILURE or self.of_flight) and not self.is_over

    @property
    def sentence(self) -> str:
        """The event, and how often it was told, as a sentence."""
        what = self.what.rstrip(".")
        times = f" (×{self.times})" if self.times > 1 else ""
        return f"{what[:1].upper()}{what[1:]}{times}."


class Notices(QObject):
    """Collects notices from all parts of the app; the banner shows them."""

    told = pyqtSignal(object)
    """A `Notice`."""
    ended = pyqtSignal(str)
    """The event of an alarm of the flight whose cause has ended."""

    def inform(self, what: str) -> None:
        """Report success."""
        self.told.emit(Notice(Severity.INFORMATION, what))

    def warn(self, what: str, remedy: str = "") -> None:
        """Report something that did not go as wished."""
        self.told.emit(Notice(Severity.WARNING, what, remedy))

    def fail(self, what: str, remedy: str = "") -> None:
        """Report a failure that lasts until something is done."""
        self.told.emit(Notice(Severity.FAILURE, what, remedy))

    def alarm(self, what: str, remedy: str = "") -> None:
        """Report an alarm of the flight."""
        self.told.emit(Notice(Severity.WARNING, what, remedy, of_flight=True))

    def end_alarm(self, what: str) -> None:
        """Report that the cause of an alarm has ended."""
        self.ended.emit(what)

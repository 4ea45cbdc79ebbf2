"""The analyst as screens see it: they ask, and hear by signals; nobody waits."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analyst.questions import Question
from workbench.gui.notices import Notices
from workbench.scenario import Scenario


class Analysis(QObject):
    """Asks the analyst about gains of the vehicle that flies.

    Args:
        notices: where refusals are told.
        parent: whose life it shares.
    """

    judged = pyqtSignal(object)
    """A `Judged`."""
    ranges_found = pyqtSignal(object)
    """A `Ranges`."""
    predicted = pyqtSignal(object)
    """A `Predicted`."""
    mapped = pyqtSignal(object)
    """A `Mapped`."""
    weighed = pyqtSignal(object)
    """A `Weighed`."""
    searched = pyqtSignal(object)
    """A `Searched`: how tuning goes."""
    tuned = pyqtSignal(object)
    """A `Tuned`."""
    forked = pyqtSignal(object)
    """A `Forked`."""
    pinned = pyqtSignal(object)
    """A `Pinned`."""
    refused = pyqtSignal(object, str)
    """A question that could not be answered, and why."""

    def __init__(self, notices: Notices, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._notices = notices

    def begin(self, scenario: Scenario, settings: Mapping[str, float]) -> None:
        """Judge another vehicle from now on; what is asked before is forgotten."""

    def ask(self, question: Question) -> None:
        """Ask; the answer comes by the signal of its kind, of the newest question alone."""

    def stop(self) -> None:
        """End a search soon, and keep its best; end any other long work."""

    def close(self) -> None:
        """End the analyst's processes."""

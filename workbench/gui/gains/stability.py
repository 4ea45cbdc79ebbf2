"""Whether gains are known to be stable, or asks the analysis before they fly."""

from collections import deque
from collections.abc import Callable, Mapping

from PyQt6.QtCore import QObject, QTimer, pyqtSignal

from workbench.analysis.questions import FindRanges, Judge, Question
from workbench.analysis.replies import Judged, Ranges
from workbench.gui.analysis import Analysis
from workbench.gui.gains.gain_rows import controller_gains, loop_gains

PATIENCE = 1500
"""After which it is said that there is no answer yet [ms]; it may come all the same."""
MOST_ASKED = 20
"""So many questions of ours may be answered late."""
RANGES_AFTER = 300
"""Ranges are asked for when gains have not moved for so long [ms]."""

Values = Mapping[str, float]


class StabilityCheck(QObject):
    """Knows which gains are stable, or asks.

    Args:
        analysis: answers.
        start: returns the values of the flight's start, for answers that name only what differs.
        parent: owner.

    Attributes:
        ranges: the stable range of each gain, and the gains around which they were found; None
            where they are not known.
    """

    accepted = pyqtSignal()
    """The gains that were asked about are stable."""
    doubted = pyqtSignal(str)
    """They are not, or nobody can tell: a sentence. They may be accepted later all the same."""
    ranges_changed = pyqtSignal()
    """There are others, or none."""

    def __init__(
        self, analysis: Analysis, start: Callable[[], Values], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._analysis, self._start = analysis, start
        self._asked: Values | None = None
        self._asked_before: deque[Values] = deque(maxlen=MOST_ASKED)
        self._range_gains: Values = {}
        self.ranges: Ranges | None = None
        self._patience = self._timer(PATIENCE, self._tell_late)
        self._rest = self._timer(RANGES_AFTER, self._ask_for_ranges)
        analysis.judged.connect(self._hear_judged)
        analysis.ranges_found.connect(self._hear_ranges)
        analysis.refused.connect(self._hear_refused)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is due still."""
        return self._asked is not None

    def begin(self) -> None:
        """Forget all that is known: another vehicle flies."""
        self.cancel()
        self._rest.stop()
        self.ranges = None
        self.ranges_changed.emit()

    def knows(self, gains: Values) -> bool:
        """Return whether gains are stable by the ranges, without asking.

        A range tells of one gain that moves while the others stay. Of several that have moved, each
        a share of its way to its own end, it is taken for known where the shares add up to no more
        than 1: the corner-cutting region between the ends, not the box around them.
        """
        if self.ranges is None:
            return False
        found, used = self.ranges, 0.0
        for name, value in loop_gains(gains).items():
            if name not in found.gains:
                return False
            used += _share(value, found.gains[name], found.stable.get(name))
        return used <= 1.0

    def has_ranges_of(self, gains: Values) -> bool:
        """Return whether the ranges were found around these gains."""
        return self.ranges is not None and _has_loops(self.ranges.gains, gains)

    def ask(self, gains: Values) -> None:
        """Ask about gains; answers about earlier ones no longer count."""
        if self._asked is not None:
            self._asked_before.append(self._asked)
        self._asked = controller_gains(gains)
        self._patience.start()
        self._analysis.ask(Judge(self._asked))

    def cancel(self) -> None:
        """Want no answer any more."""
        self._asked = None
        self._patience.stop()

    def find_ranges(self, gains: Values) -> None:
        """Find the ranges around gains, once they have rested."""
        self._range_gains = controller_gains(gains)
        self._rest.start()

    def _ask_for_ranges(self) -> None:
        if self._range_gains and not self.has_ranges_of(self._range_gains):
            self._analysis.ask(FindRanges(self._range_gains))

    def _hear_judged(self, judged: Judged) -> None:
        if self._asked is None:
            return
        gains = {**self._start(), **judged.gains}
        if not _has_loops(gains, self._asked):
            if not any(_has_loops(gains, ours) for ours in self._asked_before):
                self._analysis.ask(Judge(self._asked))  # another's question has displaced ours
            return
        self.cancel()
        if judged.stable:
            self.accepted.emit()
        else:
            self.doubted.emit(judged.said or "the closed loop would be unstable")

    def _hear_ranges(self, found: Ranges) -> None:
        self.ranges = Ranges({**self._start(), **found.gains}, found.stable)
        self.ranges_changed.emit()

    def _hear_refused(self, question: Question, said: str) -> None:
        if isinstance(question, Judge) and self._asked is not None:
            self.cancel()
            self.doubted.emit(f"whether this is stable could not be judged, as {said}")

    def _tell_late(self) -> None:
        if self._asked is not None:
            self.doubted.emit(
                "whether this is stable is not known yet: the analyst is starting, or busy"
            )

    def _timer(self, interval: int, slot: Callable[[], None]) -> QTimer:
        timer = QTimer(self)
        timer.setSingleShot(True)
        timer.setInterval(interval)
        timer.timeout.connect(slot)
        return timer


def same_loops(a: Values, b: Values) -> bool:
    """Return whether two sets of values make the same loops near hover."""
    return loop_gains(a) == loop_gains(b)


def _has_loops(values: Values, gains: Values) -> bool:
    """Return whether values have the gains that loops near hover feel; they may have more."""
    return all(values.get(name) == value for name, value in loop_gains(gains).items())


def _share(value: float, base: float, stable: tuple[float, float] | None) -> float:
    """Return which share of the way to the end of its range a gain has gone; inf beyond it."""
    if value == base:
        return 0.0 if stable is None or stable[0] <= base <= stable[1] else float("inf")
    if stable is None:
        return float("inf")
    low, high = stable
    if not (low <= base <= high and low <= value <= high):
        return float("inf")
    return (value - base) / ((high if value > base else low) - base)

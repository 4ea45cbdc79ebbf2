"""Asks the analyst whether gains may be flown, and within which they may."""

from collections import deque
from collections.abc import Callable, Mapping

from PyQt6.QtCore import QObject, QTimer, pyqtSignal

from workbench.analysis.questions import FindRanges, Judge, Question
from workbench.analysis.replies import Judged, Ranges
from workbench.gui.analysis import Analysis
from workbench.gui.gains.gain_rows import is_gain
from workbench.gui.gains.stability import known_stable, same_loops
from workbench.scenario.parameters import find_parameter

PATIENCE = 1500
"""After which it is said that there is no judgement yet [ms]; it may come all the same."""
MOST_ASKED = 20
"""So many questions of ours may be answered late."""
RANGES_AFTER = 300
"""Ranges are looked for when gains have not moved for so long [ms]."""

Values = Mapping[str, float]


class GainJudge(QObject):
    """Knows which gains are stable, or finds out.

    Args:
        analysis: is asked.
        start: tells the values of the flight's start, for answers that name only what differs.
        parent: whose life it shares.
    """

    passed = pyqtSignal()
    """The gains that were asked about are stable."""
    doubted = pyqtSignal(str)
    """They are not, or nobody can tell: a sentence. They may pass later all the same."""
    ranges_changed = pyqtSignal()
    """There are others, or none."""

    def __init__(
        self, analysis: Analysis, start: Callable[[], Values], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._analysis, self._start = analysis, start
        self._asked: Values | None = None
        self._asked_before: deque[Values] = deque(maxlen=MOST_ASKED)
        self._to_range: Values = {}
        self.ranges: Ranges | None = None
        self._patience = self._timer(PATIENCE, self._give_up)
        self._rest = self._timer(RANGES_AFTER, self._look)
        analysis.judged.connect(self._hear_judged)
        analysis.ranges_found.connect(self._hear_ranges)
        analysis.refused.connect(self._hear_refused)

    @property
    def is_asking(self) -> bool:
        """Whether a judgement is due still."""
        return self._asked is not None

    def begin(self) -> None:
        """Forget all that is known: another vehicle flies."""
        self.drop()
        self._rest.stop()
        self.ranges = None
        self.ranges_changed.emit()

    def knows(self, gains: Values) -> bool:
        """Return whether gains are stable by what is known, without asking."""
        return known_stable(self.ranges, gains)

    def is_fresh(self, gains: Values) -> bool:
        """Return whether the ranges were found at these gains."""
        return self.ranges is not None and same_loops(self.ranges.gains, gains)

    def ask(self, gains: Values) -> None:
        """Ask about gains; answers about earlier ones no longer count."""
        if self._asked is not None:
            self._asked_before.append(self._asked)
        self._asked = _of_controller(gains)
        self._patience.start()
        self._analysis.ask(Judge(self._asked))

    def drop(self) -> None:
        """Want no answer any more."""
        self._asked = None
        self._patience.stop()

    def look_for_ranges(self, gains: Values) -> None:
        """Find the ranges around gains, once they have rested."""
        self._to_range = _of_controller(gains)
        self._rest.start()

    def _look(self) -> None:
        if self._to_range and not self.is_fresh(self._to_range):
            self._analysis.ask(FindRanges(self._to_range))

    def _hear_judged(self, judged: Judged) -> None:
        if self._asked is None:
            return
        gains = {**self._start(), **judged.gains}
        if not same_loops(gains, self._asked):
            if not any(same_loops(gains, ours) for ours in self._asked_before):
                self._analysis.ask(Judge(self._asked))  # another's question has displaced ours
            return
        self.drop()
        if judged.stable:
            self.passed.emit()
        else:
            self.doubted.emit(judged.said or "the closed loop would be unstable")

    def _hear_ranges(self, found: Ranges) -> None:
        self.ranges = Ranges({**self._start(), **found.gains}, found.stable)
        self.ranges_changed.emit()

    def _hear_refused(self, question: Question, said: str) -> None:
        if isinstance(question, Judge) and self._asked is not None:
            self.drop()
            self.doubted.emit(f"whether this is stable could not be judged, as {said}")

    def _give_up(self) -> None:
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


def _of_controller(values: Values) -> dict[str, float]:
    return {name: value for name, value in values.items() if is_gain(find_parameter(name))}

"""The check of whether gains are stable near hover, before they fly."""

from collections.abc import Callable, Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import FindRanges, Judge, Query
from workbench.analysis.replies import Judged
from workbench.gui.analysis import SETTLING_MS, Analysis, QueryStream
from workbench.gui.errands import single_shot
from workbench.gui.gains.flown_gains import GainValues
from workbench.gui.gains.gain_rows import controller_gains, loop_gains

LATE_RESULT_DELAY_MS = 1500
"""Delay before the screen says that there is no answer yet [ms]; it may still arrive."""


class StabilityCheck(QObject):
    """Knows which gains are stable, or asks.

    Args:
        analysis: answers the questions.
        start: returns the initial values, for answers that name only differences.
        parent: the Qt parent.

    Attributes:
        ranges: the stable range of each gain by name; None if unknown.
    """

    accepted = pyqtSignal()
    """The gains in the question are stable."""
    doubted = pyqtSignal(str)
    """They are unstable, or their stability is unknown: a sentence. They may still be accepted
    later."""
    ranges_changed = pyqtSignal()
    """The ranges changed."""

    def __init__(
        self, analysis: Analysis, start: Callable[[], GainValues], parent: QObject | None = None
    ) -> None:
        super().__init__(parent)
        self._analysis, self._start = analysis, start
        self._accepted: GainValues | None = None
        self._judging = QueryStream(analysis, self, seen=True)
        self._range_gains: GainValues = {}
        self._base: GainValues = {}
        self.ranges: Mapping[str, tuple[float, float]] | None = None
        self._patience = single_shot(self._tell_late, self, LATE_RESULT_DELAY_MS)
        self._rest = single_shot(self._ask_for_ranges, self, SETTLING_MS)
        self._judging.answered.connect(self._show_judged)
        self._judging.refused.connect(self._show_refusal)
        analysis.answered.connect(self._take_ranges)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is pending."""
        return self._judging.is_waiting

    def begin(self, gains: GainValues | None = None) -> None:
        """Clear everything: another vehicle flies; find the ranges around its gains, if given."""
        self.cancel()
        self._rest.stop()
        self.ranges = None
        self.ranges_changed.emit()
        if gains is not None:
            self.find_ranges(gains)

    def knows(self, gains: GainValues) -> bool:
        """Return whether gains were accepted, or are stable by the ranges, without asking.

        A range describes the change of a single gain. If several have moved, each by a share of the
        way to the end of its range, they are stable for certain only if the shares add up to at
        most 1: the region between the ends that cuts the corners, not the box around them.
        """
        if self._accepted is not None and _has_loops(gains, self._accepted):
            return True
        if self.ranges is None:
            return False
        used = 0.0
        for name, value in loop_gains(gains).items():
            if name not in self._base:
                return False
            used += _range_share(value, self._base[name], self.ranges.get(name))
        return used <= 1.0

    def has_ranges_of(self, gains: GainValues) -> bool:
        """Return whether the ranges were found around these gains."""
        return self.ranges is not None and _has_loops(self._base, gains)

    def ask(self, gains: GainValues) -> None:
        """Ask about gains; answers about earlier ones no longer count."""
        self._judging.forget()
        self._accepted = None
        self._patience.start()
        self._judging.ask(Judge(controller_gains(gains)))

    def accept(self, gains: GainValues) -> None:
        """Let gains count as known until the next question, or `cancel`."""
        self._accepted = gains

    def cancel(self) -> None:
        """Drop the question, and what was accepted."""
        self._judging.forget()
        self._accepted = None
        self._patience.stop()

    def find_ranges(self, gains: GainValues) -> None:
        """Find the ranges around gains, once they have not changed for a while."""
        self._range_gains = controller_gains(gains)
        self._rest.start()

    def _ask_for_ranges(self) -> None:
        if self._range_gains and not self.has_ranges_of(self._range_gains):
            self._analysis.ask(FindRanges(self._range_gains))

    def _take_ranges(self, question: Query, reply: Mapping[str, tuple[float, float]]) -> None:
        if isinstance(question, FindRanges):
            self._base, self.ranges = {**self._start(), **question.gains}, reply
            self.ranges_changed.emit()

    def _show_judged(self, question: Judge, judged: Judged) -> None:
        self._patience.stop()
        if judged.stable:
            self.accept({**self._start(), **question.gains})
            self.accepted.emit()
        else:
            self.doubted.emit(judged.said or "the closed loop would be unstable")

    def _show_refusal(self, said: str) -> None:
        self._patience.stop()
        self.doubted.emit(f"whether this is stable could not be judged, because {said}")

    def _tell_late(self) -> None:
        self.doubted.emit(
            "whether this is stable is not known yet: the analyst is starting, or busy"
        )


def same_loops(a: GainValues, b: GainValues) -> bool:
    """Return whether two sets of values give the same loops near hover."""
    return loop_gains(a) == loop_gains(b)


def _has_loops(values: GainValues, gains: GainValues) -> bool:
    """Return whether values include all that affects the loops near hover."""
    return all(values.get(name) == value for name, value in loop_gains(gains).items())


def _range_share(value: float, base: float, stable: tuple[float, float] | None) -> float:
    """Return a gain's share of the way to the end of its range, 0 .. 1; inf beyond it."""
    if value == base:
        return 0.0 if stable is None or stable[0] <= base <= stable[1] else float("inf")
    if stable is None:
        return float("inf")
    low, high = stable
    if not (low <= base <= high and low <= value <= high):
        return float("inf")
    return (value - base) / ((high if value > base else low) - base)

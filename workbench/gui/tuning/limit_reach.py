"""Where over a loop's reach all limits of all loops hold."""

from collections.abc import Callable, Sequence

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import SampleReach, ShapeLoop
from workbench.analysis.replies import LoopShaped, MarginSample, ReachSampled
from workbench.control.loop import loop_label
from workbench.design.judge.margins import LoopMargins
from workbench.gui.analysis import Analysis, QueryStream
from workbench.gui.tuning.limits import MARGIN_LIMITS, LimitValues

ValueRange = tuple[float, float]


class LimitReach(QObject):
    """Asks for the margins of all loops over the reach of one, and applies the limits.

    Args:
        analysis: answers the question.
        limits: limits of the margins.
        parent: the Qt parent.
    """

    changed = pyqtSignal()
    """The ranges changed, with an answer or a limit."""

    def __init__(self, analysis: Analysis, limits: LimitValues, parent: QObject) -> None:
        super().__init__(parent)
        self._limits = limits
        self._sampled = ReachSampled()
        self._queries = QueryStream(analysis, self)
        self._queries.answered.connect(self._take)
        self._queries.refused.connect(lambda _: self.forget())
        limits.changed.connect(lambda _: self.changed.emit())

    def set_seen(self, seen: bool) -> None:
        """Ask only while it is visible."""
        self._queries.set_seen(seen)

    def ask(self, asked: ShapeLoop, shaped: LoopShaped) -> None:
        """Ask for the reach of an answer; the present ranges stay until this answer comes."""
        reach = shaped.bandwidths, shaped.reach
        question = SampleReach(asked.gains, asked.loop, *reach, asked.linked, asked.robustness)
        self._queries.ask(question)

    def forget(self) -> None:
        """Drop the question, and the ranges of earlier gains."""
        self._queries.forget()
        if self._sampled != ReachSampled():
            self._sampled = ReachSampled()
            self.changed.emit()

    def bandwidths(self, present: float) -> ValueRange | None:
        """Return the range of the bandwidth around a present one [rad/s], None if there is none."""
        return held_range(self._sampled.bandwidths, present, self._keeps)

    def margins(self, present: float) -> ValueRange | None:
        """Return the range of the margin around a present one, None if there is none."""
        return held_range(self._sampled.margins, present, self._keeps)

    @property
    def obstacle(self) -> str:
        """Why there is no such range, as a sentence: what no bandwidth of this loop brings back."""
        samples = self._sampled.bandwidths
        for place, name in enumerate(self._sampled.loops if samples else ()):
            for limit in MARGIN_LIMITS:
                least = self._limits.value(limit.name)
                values = [limit.of(loops[place]) for _, loops in samples]
                if not any(limit.keeps(value, least) for value in values):
                    return (
                        f"No bandwidth keeps all limits: the {limit.label.lower()} of "
                        f"{loop_label(name)} stays below {least:g} {limit.unit}".rstrip()
                        + "."
                    )
        return ""

    def _take(self, _: SampleReach, sampled: ReachSampled) -> None:
        self._sampled = sampled
        self.changed.emit()

    def _keeps(self, loops: Sequence[LoopMargins]) -> bool:
        return all(
            limit.keeps(limit.of(loop), self._limits.value(limit.name))
            for loop in loops
            for limit in MARGIN_LIMITS
        )


def held_range(
    samples: Sequence[MarginSample],
    present: float,
    keeps: Callable[[Sequence[LoopMargins]], bool],
) -> ValueRange | None:
    """Return the connected range of values that keep all limits, the nearest to the present one.

    Args:
        samples: in rising order.
        present: present value.
        keeps: tells whether the margins of all loops keep their limits.
    """
    ranges: list[ValueRange] = []
    before = False
    for value, loops in samples:
        good = keeps(loops)
        if good:
            ranges.append((ranges.pop()[0], value) if before else (value, value))
        before = good

    def distance(span: ValueRange) -> float:
        return max(span[0] - present, present - span[1], 0.0)

    return min(ranges, key=distance, default=None)

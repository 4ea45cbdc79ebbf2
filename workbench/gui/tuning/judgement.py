"""The known stability with the flown gains, and with the proposed ones."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import Judge, JudgePlantInput
from workbench.analysis.replies import Judged
from workbench.gui.analysis import SETTLING_MS, Analysis, QueryStream
from workbench.gui.errands import single_shot
from workbench.gui.gains.gain_rows import controller_gains

STALE_RESULT_DELAY_MS = 500
"""Delay after which the screen says that a result is of earlier gains [ms]."""
JudgedGains = Mapping[str, float]
InputMargins = tuple[float, float]
"""Disk margins at the plant's input, while the pilot steers and while the place is held."""


def with_caveat(caveat: str, said: str, tone: str) -> tuple[str, str]:
    """Return what a card says with its tone: its headline, or a caveat in place of it.

    A headline that is bad stays before the caveat.
    """
    if not caveat:
        return said, tone
    if tone == "bad":
        return f"{said.removesuffix('.')}. {caveat}", tone
    return caveat, "warning"


class StabilityFollower(QObject):
    """Follows the stability of two sets of gains, one question at a time.

    The margin at the plant's input, which takes longer, is requested once they have settled.

    Args:
        analysis: answers the questions.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        proposed: result for the proposed gains, or for the last known ones before them.
        gains: the gains of that result.
        flown: result for the flown gains, likewise.
        said: why there is no result, "" without an error.
        input_said: why there is none at the plant's input, likewise.
        vehicle_said: that results are of the vehicle before a change, "" if they are not.
    """

    changed = pyqtSignal()
    """The known answers changed."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._queries = QueryStream(analysis, self)
        self._queries.answered.connect(self._take)
        self._queries.refused.connect(self._show_refusal)
        self._input_queries = QueryStream(analysis, self)
        self._input_queries.answered.connect(self._take_input)
        self._input_queries.refused.connect(self._say_input)
        self._rest = single_shot(self._ask_input, self, SETTLING_MS)
        self._gains: tuple[JudgedGains, JudgedGains] = ({}, {})
        self._wait = single_shot(self._tell_late, self, STALE_RESULT_DELAY_MS)
        self.clear()

    @property
    def caveat(self) -> str:
        """Why `proposed` does not belong to the proposed gains and the vehicle, "" if it does."""
        if self.proposed is not None and self.vehicle_said:
            return self.vehicle_said
        if self.proposed is None or self._is_fresh or not (self.said or self._is_late):
            return ""
        return f"Of earlier gains: {self.said or 'the analyst is busy.'}"

    @property
    def inputs(self) -> tuple[InputMargins | None, InputMargins | None]:
        """Margins of the proposed and the flown gains at the plant's input; None while unknown."""
        proposed, flown = (self._analysis.known(JudgePlantInput(gains)) for gains in self._gains)
        return proposed, flown

    @property
    def _is_fresh(self) -> bool:
        return self.proposed is not None and self.gains == self._gains[0]

    def clear(self) -> None:
        """Clear all: another flight begins."""
        self.proposed: Judged | None = None
        self.gains: JudgedGains = {}
        self.flown: Judged | None = None
        self.said = self.input_said = self.vehicle_said = ""
        self._is_late = False
        self._wait.stop()
        self._rest.stop()
        self._queries.forget()
        self._input_queries.forget()
        self.changed.emit()

    def follow(self, proposed: JudgedGains, flown: JudgedGains) -> None:
        """Evaluate these gains from now on."""
        before, shown = self._gains, self.inputs
        self._gains = controller_gains(proposed), controller_gains(flown)
        self._queries.ask(*(Judge(gains) for gains in self._gains if gains))
        self._show()
        if shown != self.inputs:
            self.changed.emit()
        if before != self._gains or not self._rest.isActive():
            self._rest.start()
        if self._is_fresh:
            self._come_in_time()
        elif not self._wait.isActive():
            self._wait.start()

    def note_vehicle(self, said: str) -> None:
        """Let results be those of an earlier vehicle, for a reason; "" for the present one."""
        if said != self.vehicle_said:
            self.vehicle_said = said
            self.changed.emit()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._queries.set_seen(seen)
        self._input_queries.set_seen(seen)

    def _ask_input(self) -> None:
        self._input_queries.ask(*(JudgePlantInput(gains) for gains in self._gains if gains))

    def _take_input(self, question: JudgePlantInput, _: InputMargins) -> None:
        self._say_input("" if question.gains == self._gains[0] else self.input_said)

    def _say_input(self, said: str) -> None:
        self.input_said = said
        self.changed.emit()

    def _take(self, question: Judge, judged: Judged) -> None:
        is_shown, (proposed, flown) = self._show(), self._gains
        if question.gains == flown != proposed:
            return  # it says nothing about the proposed ones
        if not is_shown:  # while a slider moves: the newest so far
            self.proposed, self.gains, self.said = judged, question.gains, ""
            self.changed.emit()
        self._come_in_time()

    def _show(self) -> bool:
        """Show the known results; return whether they belong to the present gains."""
        before = self.proposed, self.flown
        proposed, flown = (self._analysis.known(Judge(gains)) for gains in self._gains)
        if proposed is not None:
            self.proposed, self.gains = proposed, self._gains[0]
        self.flown = flown or self.flown
        if self.proposed is not before[0] or self.flown is not before[1]:
            self.changed.emit()
        return proposed is not None

    def _come_in_time(self) -> None:
        """Note that an answer has arrived; while gains still change, wait for the next one."""
        if self._is_fresh:
            self._wait.stop()
        else:
            self._wait.start()
        if self._is_late or (self.said and self._is_fresh):
            self._is_late, self.said = False, ""
            self.changed.emit()

    def _tell_late(self) -> None:
        self._is_late = True
        self.changed.emit()

    def _show_refusal(self, said: str) -> None:
        self.said = said
        self.changed.emit()

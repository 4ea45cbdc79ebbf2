"""The known stability with the flown gains, and with the proposed ones."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import Judge, JudgePlantInput
from workbench.analysis.replies import Judged, JudgedPlantInput
from workbench.gui.analysis import Analysis, Memory
from workbench.gui.errands import single_shot
from workbench.gui.gains.gain_rows import controller_gains

LATE = 500
"""Delay after which the screen says that a result is of earlier gains [ms]."""
REST = 300
"""Gains have settled if they have not changed for this time [ms]."""
Gains = Mapping[str, float]


class Judgement(QObject):
    """Follows the stability of two sets of gains, one question at a time.

    The margin at the plant's input, which takes longer, is requested once they have settled.

    Args:
        analysis: answers the questions.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        proposed: result for the proposed gains, or for the last known ones before them.
        flown: result for the flown gains, likewise.
        said: why there is no result, "" without an error.
        input_said: why there is none at the plant's input, likewise.
    """

    changed = pyqtSignal()
    """The known answers changed."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._memory = Memory(analysis, Judge, self)
        self._memory.refused.connect(self._hear_refusal)
        analysis.answers[Judge].connect(self._hear)
        self._input_memory = Memory(analysis, JudgePlantInput, self)
        self._input_memory.answered.connect(self._hear_input)
        self._input_memory.refused.connect(self._hear_input_refusal)
        self._rest = single_shot(self._ask_input, self, REST)
        self._gains: tuple[Gains, Gains] = ({}, {})
        self._wait = single_shot(self._tell_late, self, LATE)
        self.clear()

    @property
    def caveat(self) -> str:
        """Why `proposed` does not belong to the proposed gains, "" if it does."""
        if self.proposed is None or self._is_fresh or not (self.said or self._is_late):
            return ""
        return f"Of earlier gains: {self.said or 'the analyst is busy.'}"

    @property
    def proposed_input(self) -> JudgedPlantInput | None:
        """Margin of the proposed gains at the plant's input; None while unknown."""
        return self._known_input(self._gains[0])

    @property
    def flown_input(self) -> JudgedPlantInput | None:
        """Margin of the flown gains at the plant's input; None while unknown."""
        return self._known_input(self._gains[1])

    def _known_input(self, gains: Gains) -> JudgedPlantInput | None:
        known: JudgedPlantInput | None = self._input_memory.known(JudgePlantInput(gains))
        return known

    @property
    def _is_fresh(self) -> bool:
        return self.proposed is not None and _are_of(self.proposed, self._gains[0])

    def clear(self) -> None:
        """Clear all: another flight begins."""
        self.proposed: Judged | None = None
        self.flown: Judged | None = None
        self.said = self.input_said = ""
        self._is_late = False
        self._wait.stop()
        self._rest.stop()
        self._memory.forget()
        self._input_memory.forget()
        self.changed.emit()

    def follow(self, proposed: Gains, flown: Gains) -> None:
        """Evaluate these gains from now on."""
        before, shown = self._gains, (self.proposed_input, self.flown_input)
        self._gains = controller_gains(proposed), controller_gains(flown)
        self._ask()
        self._show()
        if shown != (self.proposed_input, self.flown_input):
            self.changed.emit()
        if before != self._gains or not self._rest.isActive():
            self._rest.start()
        if self._is_fresh:
            self._come_in_time()
        elif not self._wait.isActive():
            self._wait.start()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._memory.set_seen(seen)
        self._input_memory.set_seen(seen)

    def _ask(self) -> None:
        self._memory.ask_first(Judge(gains) for gains in self._gains if gains)

    def _ask_input(self) -> None:
        self._input_memory.ask_first(JudgePlantInput(gains) for gains in self._gains if gains)

    def _hear_input(self, judged: JudgedPlantInput) -> None:
        self.input_said = ""
        self.changed.emit()
        if not self._rest.isActive():
            self._ask_input()

    def _hear_input_refusal(self, said: str) -> None:
        self.input_said = said
        self.changed.emit()

    def _hear(self, judged: Judged) -> None:
        """Show any result, whoever asked."""
        self.said = ""
        if not self._show() and not _are_of(judged, self._gains[1]):
            self.proposed = judged  # while a slider moves: the newest result so far
            self.changed.emit()
        self._come_in_time()
        self._ask()

    def _show(self) -> bool:
        """Show the known results; return whether they belong to the present gains."""
        proposed, flown = (self._memory.known(Judge(gains)) for gains in self._gains)
        if (proposed or self.proposed) is not self.proposed or (flown or self.flown) is not (
            self.flown
        ):
            self.proposed = proposed or self.proposed
            self.flown = flown or self.flown
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

    def _hear_refusal(self, said: str) -> None:
        self.said = said
        self.changed.emit()


def _are_of(judged: Judged, gains: Gains) -> bool:
    return controller_gains(judged.asked.gains) == gains

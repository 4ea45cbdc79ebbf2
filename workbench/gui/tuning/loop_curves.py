"""The curves of one loop over frequency, with proposed, flown and kept gains."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import DrawFrequency
from workbench.design.judge.gang_of_four import GangOfFour
from workbench.gui.analysis import Analysis, QueryStream
from workbench.gui.tuning.designs import FLOWN_SET, KEPT_SET, PROPOSED_SET

CurveGains = Mapping[str, float]


class LoopCurves(QObject):
    """Asks for the curves of a loop, one question at a time; proposed gains have priority.

    Args:
        analysis: answers the questions.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        loop: name of the loop, "" before one is selected.
        cut: where the loop is opened: actuator or error.
        said: why there is no answer, "" without an error.
    """

    changed = pyqtSignal()
    """The known answers changed."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._analysis = analysis
        self._queries = QueryStream(analysis, self)
        self._queries.answered.connect(self._take)
        self._queries.refused.connect(self._show_refusal)
        self.loop, self.cut = "", "actuator"
        self._sets: dict[str, CurveGains] = {}
        self.clear()

    def clear(self) -> None:
        """Clear all: another flight begins."""
        self._newest: GangOfFour | None = None
        self.said = ""
        self._queries.forget()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._queries.set_seen(seen)

    def choose(self, loop: str, cut: str) -> None:
        """Ask about another loop, or another cut."""
        if (loop, cut) != (self.loop, self.cut):
            self.loop, self.cut = loop, cut
            self._newest, self.said = None, ""
            self._ask()
            self.changed.emit()

    def follow(self, sets: Mapping[str, CurveGains]) -> None:
        """Ask about these gains from now on: proposed, flown and kept ones, by these names."""
        changed = dict(sets) != self._sets
        self._sets = dict(sets)
        self._ask()
        if changed:
            self.changed.emit()

    @property
    def shown(self) -> dict[str, GangOfFour]:
        """Known curves of each set, by name; a set equal to another one is left out.

        While gains change faster than answers arrive, the newest answer represents the proposed
        ones.
        """
        found: dict[str, GangOfFour] = {}
        seen: list[DrawFrequency] = []
        for name in (FLOWN_SET, PROPOSED_SET, KEPT_SET):
            question = self._question(name)
            known = self._analysis.known(question)
            if known is None and name == PROPOSED_SET:
                known = self._newest
            if known is not None and question not in seen:
                found[name] = known
                seen.append(question)
        return found

    def _ask(self) -> None:
        names = (PROPOSED_SET, FLOWN_SET, KEPT_SET) if self.loop else ()
        self._queries.ask(*(self._question(name) for name in names if self._sets.get(name)))

    def _question(self, name: str) -> DrawFrequency:
        return DrawFrequency(self._sets.get(name, {}), self.loop, self.cut)

    def _take(self, asked: DrawFrequency, drawn: GangOfFour) -> None:
        at_rest = asked in (self._question(FLOWN_SET), self._question(KEPT_SET))
        if not at_rest and (asked.loop, asked.cut) == (self.loop, self.cut):
            self._newest = drawn  # of a slider's gains
        if not at_rest or asked == self._question(PROPOSED_SET):
            self.said = ""
        self.changed.emit()

    def _show_refusal(self, said: str) -> None:
        self.said = said
        self.changed.emit()

"""What is known of one loop over frequency, with the gains that are proposed, fly and were kept."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import DrawFrequency
from workbench.analysis.replies import FrequencyCurves
from workbench.gui.analysis import Analysis
from workbench.gui.tuning.designs import FLOWN, KEPT, PROPOSED
from workbench.gui.tuning.follower import Follower

REMEMBERED = 32
"""Curves that are remembered."""
Gains = Mapping[str, float]
Key = tuple[tuple[tuple[str, float], ...], str, str]


class LoopCurves(QObject):
    """Asks for the curves of a loop, one question at a time; proposed gains come first.

    Args:
        analysis: who answers.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        loop: name of the loop, "" before one is chosen.
        cut: where it is opened: actuator or error.
        said: why there is no answer, "" where nothing is wrong.
    """

    changed = pyqtSignal()
    """Something else is known now."""

    def __init__(self, analysis: Analysis, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._follower = Follower(analysis, DrawFrequency, self)
        self._follower.answered.connect(self._hear)
        self._follower.refused.connect(self._hear_refusal)
        self.loop, self.cut = "", "actuator"
        self._sets: dict[str, Gains] = {}
        self.clear()

    def clear(self) -> None:
        """Forget all: another flight begins."""
        self._known: dict[Key, FrequencyCurves] = {}
        self._newest: FrequencyCurves | None = None
        self.said = ""
        self._follower.forget()

    def set_seen(self, seen: bool) -> None:
        """Ask only while somebody looks."""
        self._follower.set_seen(seen)

    def choose(self, loop: str, cut: str) -> None:
        """Ask about another loop, or about another cut."""
        if (loop, cut) != (self.loop, self.cut):
            self.loop, self.cut = loop, cut
            self._newest, self.said = None, ""
            self._ask()
            self.changed.emit()

    def follow(self, sets: Mapping[str, Gains]) -> None:
        """Ask about these gains from now on: proposed, flown and kept ones, by these names."""
        changed = dict(sets) != self._sets
        self._sets = dict(sets)
        self._ask()
        if changed:
            self.changed.emit()

    @property
    def shown(self) -> dict[str, FrequencyCurves]:
        """What is known of each set, by its name; a set that is like another one is left out.

        While gains move faster than answers come, the newest answer stands for the proposed ones.
        """
        found: dict[str, FrequencyCurves] = {}
        keys: list[Key] = []
        for name in (FLOWN, PROPOSED, KEPT):
            key = self._key(self._sets.get(name, {}))
            known = self._known.get(key)
            if known is None and name == PROPOSED:
                known = self._newest
            if known is not None and key not in keys:
                found[name] = known
                keys.append(key)
        return found

    def _ask(self) -> None:
        for name in (PROPOSED, FLOWN, KEPT):
            gains = self._sets.get(name, {})
            if self.loop and gains and self._key(gains) not in self._known:
                self._follower.ask(DrawFrequency(gains, self.loop, self.cut))
                return

    def _key(self, gains: Gains) -> Key:
        return tuple(sorted(gains.items())), self.loop, self.cut

    def _hear(self, drawn: FrequencyCurves) -> None:
        asked = drawn.asked
        if (asked.loop, asked.cut) == (self.loop, self.cut):
            self._known[self._key(asked.gains)] = drawn
            while len(self._known) > REMEMBERED:
                del self._known[next(iter(self._known))]
            if self._key(asked.gains) not in map(self._key, self._settled):
                self._newest = drawn
        self.said = ""
        self.changed.emit()
        self._ask()

    @property
    def _settled(self) -> list[Gains]:
        """The sets that do not move with a slider."""
        return [self._sets.get(name, {}) for name in (FLOWN, KEPT)]

    def _hear_refusal(self, said: str) -> None:
        self.said = said
        self.changed.emit()

"""A drag of a pole: asks which gains of a loop bring it there, and proposes them."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import MovePole
from workbench.analysis.replies import PoleMoved
from workbench.gui.analysis import Analysis
from workbench.gui.tuning.follower import Follower
from workbench.gui.tuning.margins_card import loop_label
from workbench.gui.tuning.trial import Trial


class PoleDrag(QObject):
    """Moves one pole at a time; from being taken to being released is one step of undo.

    Args:
        analysis: who finds the gains.
        trial: whose gains.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        said: what is in the way, "" for nothing.
    """

    moved = pyqtSignal(object)
    """Where the pole is with the gains that are proposed now [1/s]."""
    ended = pyqtSignal()
    """It is released, and the last answer is there."""

    def __init__(self, analysis: Analysis, trial: Trial, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._trial = trial
        self._follower = Follower(analysis, MovePole, self)
        self._follower.answered.connect(self._hear)
        self._follower.refused.connect(self._hear_refusal)
        self._follower.set_seen(True)
        self.begin()

    def begin(self) -> None:
        """Forget another flight."""
        self.said = ""
        self._loop, self._pole = "", 0j
        self._base: dict[str, float] | None = None
        self._released = False
        self._follower.forget()

    @property
    def is_held(self) -> bool:
        """Whether a pole is taken, or its last answer is still to come."""
        return self._base is not None

    def take(self, loop: str, pole: complex) -> None:
        """Take a pole of the proposed gains, by the gains of a loop."""
        if self._base is None:
            self._trial.gains.begin_edit()
            self._base = dict(self._trial.judged)
            self._loop, self._pole = loop, pole
        self.said, self._released = "", False

    def want(self, place: complex) -> None:
        """Bring it to a place [1/s]."""
        if self._base is not None:
            linked = self._trial.linked_with(self._loop)
            self._follower.ask(MovePole(self._base, self._loop, self._pole, place, linked))

    def release(self) -> None:
        """End the drag, once the last answer is there."""
        self._released = True
        if self._base is not None and not self._follower.is_waiting:
            self._end()

    def give_up(self) -> None:
        """Propose what was proposed before it was taken."""
        if self._base is not None:
            names = self._trial.gains_of(self._loop)
            names += self._trial.linked_with(self._loop).values()
            self._propose({name: self._base[name] for name in names if name in self._base})
            self._follower.forget()
            self._end()

    def _hear(self, moved: PoleMoved) -> None:
        if self._base is None:
            return
        self._propose(moved.gains)
        self.said = moved.said
        self.moved.emit(moved.pole)
        if self._released and not self._follower.is_waiting:
            self._end()

    def _hear_refusal(self, said: str) -> None:
        self.said = said
        self.moved.emit(self._pole)
        if self._released:
            self._end()

    def _propose(self, gains: Mapping[str, float]) -> None:
        self._trial.gains.propose_all(gains, f"Pole of {loop_label(self._loop)}")

    def _end(self) -> None:
        self._base, self._released = None, False
        self._trial.gains.end_edit()
        self.ended.emit()

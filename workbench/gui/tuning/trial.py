"""What is being tried: the proposed gains, and the step by which they are judged."""

from collections.abc import Mapping

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import Step
from workbench.gui.gains.gain_desk import GainDesk
from workbench.gui.tuning.controller_gains import controller_gains, tunable


class Trial(QObject):
    """Tells all cards what they are about.

    Args:
        desk: of the gains.
        parent: whose life it shares.
    """

    changed = pyqtSignal()
    """Gains or step are others now."""

    def __init__(self, desk: GainDesk, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.desk = desk
        self._step: Step | None = None
        desk.proposed_changed.connect(lambda _: self.changed.emit())
        desk.flown_changed.connect(lambda _: self.changed.emit())

    @property
    def proposed(self) -> dict[str, float]:
        """The controller's gains as proposed."""
        return controller_gains(self.desk.proposed)

    @property
    def flown(self) -> dict[str, float]:
        """The controller's gains as they fly."""
        return controller_gains(self.desk.flown)

    @property
    def names(self) -> tuple[str, ...]:
        """Gains that may be tuned."""
        return tunable(self.desk.proposed)

    @property
    def step(self) -> Step | None:
        """By which gains are judged; None where nothing of the kind is excited."""
        return self._step

    def set_step(self, step: Step | None) -> None:
        """Judge by another step."""
        if step != self._step:
            self._step = step
            self.changed.emit()

    def begin(self) -> None:
        """Tell of another flight."""
        self.changed.emit()

    def adopt(self, gains: Mapping[str, float], what: str) -> None:
        """Fly gains that somebody has chosen, as one step of undo."""
        self.desk.adopt(gains, what)

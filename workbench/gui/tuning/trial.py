"""What is being tried: the proposed gains, and the step by which they are judged."""

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import Step
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_rows import controller_gains, loop_gains, partner


class Trial(QObject):
    """The gains and the step that all cards are about.

    Args:
        gains: that are tuned.
        parent: owner.
    """

    changed = pyqtSignal()
    """The gains or the step changed."""

    def __init__(self, gains: GainEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.gains = gains
        self._excited: Step | None = None
        gains.proposed_changed.connect(lambda _: self.changed.emit())
        gains.flown_changed.connect(lambda _: self.changed.emit())
        gains.set_changed.connect(self.changed.emit)

    @property
    def proposed(self) -> dict[str, float]:
        """The controller's gains as proposed."""
        return controller_gains(self.gains.proposed)

    @property
    def flown(self) -> dict[str, float]:
        """The controller's gains as they fly."""
        return controller_gains(self.gains.flown)

    @property
    def judged(self) -> dict[str, float]:
        """The proposed gains that are judged: of scheduled ones those of the set that is shown."""
        return self.gains.of_set(self.proposed)

    @property
    def judged_flown(self) -> dict[str, float]:
        """The same, as they fly."""
        return self.gains.of_set(self.flown)

    @property
    def judged_kept(self) -> dict[str, float]:
        """Those that were kept, over what flies where they say nothing, as of filters."""
        return self.gains.of_set({**self.flown, **controller_gains(self.gains.kept)})

    @property
    def names(self) -> tuple[str, ...]:
        """Gains that may be tuned."""
        return tuple(loop_gains(self.gains.of_set(self.gains.proposed)))

    def gains_of(self, loop: str) -> list[str]:
        """Return the names of a loop's gains, of the set that is shown."""
        law = self.gains.table.controller
        of_loop = {gain for each in law.loops if each.name == loop for gain in each.gains}
        return [name for name in self.judged if law.gain_of(name) in of_loop]

    def linked_with(self, loop: str) -> dict[str, str]:
        """Return the gains that move along with a loop's, by those."""
        if not self.gains.linked:
            return {}
        found = {name: partner(name) for name in self.gains_of(loop)}
        return {name: other for name, other in found.items() if other in self.gains.proposed}

    @property
    def step(self) -> Step | None:
        """By which gains are judged; None where no step of a command is excited."""
        return None if self._excited is None or self._excited.is_load else self._excited

    @property
    def excited(self) -> Step | None:
        """What is predicted and pinned, of a command or a load; None for a chirp."""
        return self._excited

    def set_step(self, step: Step | None) -> None:
        """Judge by another step."""
        if step != self._excited:
            self._excited = step
            self.changed.emit()

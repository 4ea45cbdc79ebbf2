"""The trial: the proposed gains, and the step for which they are evaluated."""

from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import RequestedStep
from workbench.gui.gains.gain_editor import GainEditor
from workbench.gui.gains.gain_rows import controller_gains, linked_gain, loop_gains

NO_TRIAL_STEP_TEXT = "Choose a step of velocity or yaw rate."
"""What a card shows that flies the step of a trial, while there is none."""


class TuningTrial(QObject):
    """The gains and the step of all cards.

    Args:
        gains: the editor of the gains.
        parent: the Qt parent.

    Attributes:
        excited: the step of a command or a load that is predicted and pinned; None for a chirp.
    """

    changed = pyqtSignal()
    """The gains or the step changed."""

    def __init__(self, gains: GainEditor, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.gains = gains
        self.excited: RequestedStep | None = None
        gains.proposed_changed.connect(lambda _: self.changed.emit())
        gains.flown_changed.connect(lambda _: self.changed.emit())
        gains.set_changed.connect(self.changed.emit)

    @property
    def proposed(self) -> dict[str, float]:
        """The controller's gains as proposed."""
        return controller_gains(self.gains.proposed)

    @property
    def flown(self) -> dict[str, float]:
        """The controller's flown gains."""
        return controller_gains(self.gains.flown)

    @property
    def judged(self) -> dict[str, float]:
        """The proposed gains to evaluate: with a schedule, those of the shown set."""
        return self.gains.of_set(self.proposed)

    @property
    def judged_flown(self) -> dict[str, float]:
        """The flown gains to evaluate, likewise."""
        return self.gains.of_set(self.flown)

    @property
    def judged_kept(self) -> dict[str, float]:
        """The kept gains, completed by flown values that are never kept, as of filters."""
        return self.gains.of_set({**self.flown, **controller_gains(self.gains.kept)})

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the gains that can be tuned."""
        return tuple(loop_gains(self.gains.of_set(self.gains.proposed)))

    def gains_of(self, loop: str) -> list[str]:
        """Return the names of a loop's gains, in the shown set."""
        law = self.gains.controller
        of_loop = {gain for each in law.loops if each.name == loop for gain in each.gains}
        return [name for name in self.judged if law.gain_of(name) in of_loop]

    def linked_with(self, loop: str) -> dict[str, str]:
        """Return the gains linked with a loop's gains, by the latter."""
        if not self.gains.linked:
            return {}
        found = {name: linked_gain(name) for name in self.gains_of(loop)}
        return {name: other for name, other in found.items() if other in self.gains.proposed}

    @property
    def step(self) -> RequestedStep | None:
        """The step for evaluation; None unless a step of a velocity or yaw rate is excited."""
        step = self.excited
        return None if step is None or step.is_load or step.is_attitude else step

    @property
    def setpoint_step(self) -> RequestedStep | None:
        """The step of a setpoint of any loop; None unless one is excited."""
        return None if self.excited is None or self.excited.is_load else self.excited

    def is_moved(self, loop: str) -> bool:
        """Return whether a gain of a loop is proposed that is not the kept one."""
        kept, proposed = self.judged_kept, self.judged
        return any(proposed[name] != kept[name] for name in self.gains_of(loop))

    def set_step(self, step: RequestedStep | None) -> None:
        """Set the step."""
        if step != self.excited:
            self.excited = step
            self.changed.emit()

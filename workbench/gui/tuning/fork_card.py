"""The card of forks: from this instant fly two sets of gains side by side, and keep one."""

from collections.abc import Mapping

from PyQt6.QtCore import pyqtSignal
from PyQt6.QtWidgets import QCheckBox, QComboBox, QGridLayout, QHBoxLayout, QPushButton, QWidget

from workbench.analysis.questions import Fork, Question, Step
from workbench.analysis.replies import Forked
from workbench.design.branches import Branch
from workbench.gui.charts.curve import CurveStyle
from workbench.gui.charts.plot import StaticPlot
from workbench.gui.gains.gain_rows import controller_gains
from workbench.gui.number_field import NumberField, buddy
from workbench.gui.style import dressed
from workbench.gui.tuning.card import SPACING, Card
from workbench.gui.tuning.fork_curves import QUANTITIES
from workbench.gui.tuning.gains_text import gains_text
from workbench.gui.tuning.trial import Trial
from workbench.gui.units import Unit
from workbench.gui.workspace import Workspace
from workbench.session.checkpoint import Checkpoint

NOW = "now"
PROPOSED = "proposed"
DURATIONS = (0.5, 20.0)
"""That may be flown ahead [s]."""


class ForkCard(Card):
    """Flies on from the present instant in another process, with the gains now and with others.

    Args:
        workspace: flight, analysis and colours.
        trial: what is tried.
        parent: the Qt parent; this object is deleted with it.
    """

    busy_changed = pyqtSignal(bool)
    """Whether a fork is being flown for the user: a ghost must not take its place."""

    def __init__(self, workspace: Workspace, trial: Trial, parent: QWidget | None = None) -> None:
        super().__init__("Fork the flight", parent)
        self._flight, self._analysis, self._trial = workspace.flight, workspace.analysis, trial
        self._busy = False
        self._asked: Fork | None = None
        self._other = Branch(PROPOSED, {})
        self._flown: Mapping[str, float] = {}
        self._words = ""
        self._forked: Forked | None = None
        self._axis = "x"
        self.other, self.quantity = QComboBox(), QComboBox()
        self.other.addItem("proposed", PROPOSED)
        for each in QUANTITIES:
            self.quantity.addItem(each.label)
        self.duration = NumberField("Time ahead", 1, 0.5)
        self.duration.set_range(Unit("s"), *DURATIONS)
        self.duration.show_si(5.0)
        self.duration.refused.connect(lambda _: self.refresh())
        self.with_step = QCheckBox("With a s&tep")
        self.with_step.setChecked(True)
        self.with_step.setToolTip("The step of the excitation is asked for at once")
        self.button = dressed(QPushButton("&Fork now"), "primary")
        self.plot = StaticPlot(workspace)
        self.plot.set_hint("Fork: both go on from this instant")
        self.keep = QPushButton("&Keep proposed")
        self.keep.setToolTip("Fly these gains from now on")
        self.drop = QPushButton("Keep &now")
        self.drop.setToolTip("Propose again what flies now")
        self._lay_out()
        self.button.clicked.connect(self.fork)
        self.keep.clicked.connect(self._keep)
        self.drop.clicked.connect(self._drop)
        self.quantity.currentIndexChanged.connect(self._draw)
        trial.changed.connect(self.refresh)
        trial.gains.state_changed.connect(self.refresh)
        self._analysis.forked.connect(self._hear)
        self._analysis.refused.connect(self._hear_refusal)
        self._show_state()

    @property
    def is_busy(self) -> bool:
        """Whether a fork is being flown."""
        return self._busy

    def begin(self) -> None:
        """Forget the forks of another flight."""
        self._forked, self._asked = None, None
        self.plot.clear()
        self._set_busy(False)
        self.refresh()

    def refresh(self) -> None:
        """Offer the slots that are filled."""
        wanted = [PROPOSED, *self._trial.gains.slots]
        if wanted != [self.other.itemData(index) for index in range(self.other.count())]:
            chosen = self.other.currentData()
            self.other.clear()
            for each in wanted:
                self.other.addItem("proposed" if each == PROPOSED else f"slot {each}", each)
            self.other.setCurrentIndex(max(0, self.other.findData(chosen)))
        self._show_state()

    def fork(self) -> None:
        """Fork the flight at its present instant."""
        if self._busy:
            return
        self._other = Branch(self._name(), self._other_gains())
        self._set_busy(True)
        self._flight.order(lambda live: live.checkpoint(), self._ask, self._refuse)

    def _ask(self, checkpoint: Checkpoint) -> None:
        step = self._trial.step if self.with_step.isChecked() else None
        self._axis = step.axis if step is not None else self._axis
        duration = self.duration.si
        if step is not None:
            step = Step(step.axis, step.amplitude, duration)
        branches = (Branch(NOW, self._trial.flown), self._other)
        self._asked = Fork(checkpoint, branches, duration, step)
        self._analysis.ask(self._asked)

    def _hear(self, forked: Forked) -> None:
        asked = self._asked
        if asked is None or [each.name for each in forked.branches] != [
            branch.name for branch in asked.branches
        ]:
            return
        now, other = asked.branches
        self._asked, self._forked, self._flown = None, forked, other.gains
        self._words = gains_text(other.gains, now.gains)
        self._set_busy(False)
        self._draw()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if self._asked is not None and question == self._asked:
            self._refuse(said)

    def _refuse(self, said: str) -> None:
        self._asked = None
        self._set_busy(False)
        self.said.say(said, "warning")

    def _draw(self) -> None:
        self._draw_branches()
        self._show_state()

    def _draw_branches(self) -> None:
        self.plot.clear()
        if self._forked is None:
            return
        quantity = QUANTITIES[self.quantity.currentIndex()]
        self.plot.set_axes("time ahead s", quantity.label, quantity.unit_of(self._axis))
        for index, branch in enumerate(self._forked.branches):
            style = CurveStyle.SOLID if index == 0 else CurveStyle.DASHED
            time = branch.time - branch.time[0] if len(branch.time) else branch.time
            self.plot.set_curve(
                branch.name, time, quantity.values(branch, self._axis), style, index
            )
        lost = [f"{each.name}: {each.lost}" for each in self._forked.branches if each.lost]
        if lost:
            self.said.say("; ".join(lost), "bad")
        else:
            self.said.say(f"{self._branch}: {self._words}")

    def _keep(self) -> None:
        self._trial.adopt(self._flown, "a branch of a fork")

    def _drop(self) -> None:
        self._trial.gains.discard()
        self.said.say("What flies now is kept.")

    def _name(self) -> str:
        return self.other.currentText() or PROPOSED

    @property
    def _branch(self) -> str:
        """Name of the branch that was flown, and can be kept; before, of the one that would be."""
        return self._forked.branches[-1].name if self._forked is not None else self._name()

    def _other_gains(self) -> dict[str, float]:
        chosen = self.other.currentData()
        if chosen in self._trial.gains.slots:
            stored = controller_gains(self._trial.gains.slots[chosen])
            return {**self._trial.flown, **stored}
        return self._trial.proposed

    def _set_busy(self, busy: bool) -> None:
        if busy != self._busy:
            self._busy = busy
            self.busy_changed.emit(busy)
        self._show_state()
        if busy:
            self.said.say("Flying both …")

    def _show_state(self) -> None:
        can = bool(self._trial.flown) and not self.duration.fault
        self.button.setEnabled(not self._busy and can)
        done = self._forked is not None and not self._busy
        self.keep.setEnabled(done)
        self.drop.setEnabled(done)
        self.keep.setText(f"&Keep {self._branch}")

    def _lay_out(self) -> None:
        grid = QGridLayout()
        grid.setSpacing(SPACING)
        fields = (("Now a&gainst", self.other), ("Ti&me", self.duration), ("S&how", self.quantity))
        for column, (text, field) in enumerate(fields):
            grid.addWidget(buddy(text, field), 0, column)
            grid.addWidget(field, 1, column)
            grid.setColumnStretch(column, 1)
            field.setMinimumWidth(78)
        self.body.addLayout(grid)
        line = QHBoxLayout()
        self.head.addWidget(self.with_step)
        line.addStretch(1)
        for button in (self.drop, self.keep, self.button):
            line.addWidget(button)
        self.body.addWidget(self.plot, 1)
        self.body.addLayout(line)

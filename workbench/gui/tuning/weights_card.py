"""The card of sensitivities: which gain moves the metric on show most."""

from PyQt6.QtCore import QTimer
from PyQt6.QtWidgets import QComboBox, QHBoxLayout, QWidget

from workbench.analysis.questions import Question, Weigh
from workbench.analysis.replies import Reply, Weighed
from workbench.gui.number_field import buddy
from workbench.gui.tuning.card import Card, wrapped
from workbench.gui.tuning.follower import Follower
from workbench.gui.tuning.limit_table import STEP_LIMITS, find_limit
from workbench.gui.tuning.trial import Trial
from workbench.gui.tuning.weight_bars import WeightBars
from workbench.gui.workspace import Workspace

REST = 600
"""Gains have settled when they have not moved for so long [ms]."""


class WeightsCard(Card):
    """Asks what every gain does once the proposed ones have settled.

    Args:
        workspace: analysis and colours.
        trial: what is tried.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, trial: Trial, parent: QWidget | None = None) -> None:
        super().__init__("Sensitivity", parent)
        self._trial = trial
        self._weighed: Weighed | None = None
        self._follower = Follower(
            workspace.analysis, workspace.analysis.weighed, Weigh, _answers, self
        )
        self.number = QComboBox()
        for row in STEP_LIMITS:
            self.number.addItem(row.label, row.name)
        self.bars = WeightBars(workspace.look, trial.gains.words)
        self.words = wrapped()
        line = QHBoxLayout()
        line.addWidget(buddy("What moves the &metric", self.number))
        line.addWidget(self.number, 1)
        self.body.addLayout(line)
        self.body.addWidget(self.bars, 1)
        self.body.addWidget(self.words)
        self._rest = QTimer(self)
        self._rest.setSingleShot(True)
        self._rest.setInterval(REST)
        self._rest.timeout.connect(self._ask)
        self.number.currentIndexChanged.connect(self._show)
        trial.changed.connect(self._follow)
        self._follower.answered.connect(self._take)
        self._follower.refused.connect(lambda said: self.said.say(said, "warning"))
        self._show()

    def begin(self) -> None:
        """Forget another vehicle."""
        self._follower.forget()
        self._weighed = None
        self._show()
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the bars are seen."""
        self._follower.set_seen(seen)
        self._say_waiting()

    def _follow(self) -> None:
        if self._weighed is not None and self._weighed.gains != self._trial.judged:
            self.said.say("Of the gains before; new ones follow …")
        self._rest.start()

    def _ask(self) -> None:
        step, gains = self._trial.step, self._trial.judged
        if step is None:
            self.said.say("A chirp has no step to measure.")
        elif gains:
            self._follower.ask(Weigh(gains, step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._follower.is_waiting:
            self.said.say("Flying a few hundred steps …")

    def _take(self, weighed: Weighed) -> None:
        self._weighed = weighed
        self.said.say("")
        self._show()

    def _show(self) -> None:
        limit = find_limit(self.number.currentData())
        weights = self._weighed.weights.get(limit.name, ()) if self._weighed is not None else ()
        self.bars.show_weights(weights, limit)
        texts = self.bars.texts
        none = "No gain moves it." if self._weighed is not None else ""
        self.words.setText(f"{texts[0]}." if texts else none)


def _answers(question: Question, reply: Reply) -> bool:
    assert isinstance(question, Weigh)
    return (
        isinstance(reply, Weighed)
        and reply.step == question.step
        and dict(reply.gains) == dict(question.gains)
    )

"""The next five seconds with the proposed gains, while a slider is dragged."""

from collections.abc import Callable

import numpy as np
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.questions import Fork, Question
from workbench.analysis.replies import Forked
from workbench.design.branches import Branch
from workbench.gui.analysis import Analysis
from workbench.gui.flight_model import FlightModel
from workbench.gui.tuning.trial import Trial
from workbench.session.checkpoint import Checkpoint

NAME = "next five seconds"
AHEAD = 5.0
"""[s]"""


class Ghost(QObject):
    """Flies ahead of the flight with gains that are proposed and do not fly yet.

    One question at a time; the newest gains are flown next. It asks for nothing while they fly
    already, while nobody looks, and while something longer is worked on.

    Args:
        flight: from whose present it goes on.
        analysis: flies it.
        trial: what is tried.
        may_ask: whether nothing longer is worked on.
        parent: the Qt parent; this object is deleted with it.
    """

    seen_ahead = pyqtSignal(object, object)
    """Simulated times [s] and velocity or yaw rate along the trial's axis; both may be empty."""

    def __init__(
        self,
        flight: FlightModel,
        analysis: Analysis,
        trial: Trial,
        may_ask: Callable[[], bool],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flight, self._analysis, self._trial = flight, analysis, trial
        self._may_ask = may_ask
        self._seen = False
        self._busy = False
        self._again = False
        self._asked: Fork | None = None
        trial.changed.connect(self.follow)
        analysis.forked.connect(self._hear)
        analysis.refused.connect(self._hear_refusal)

    def set_seen(self, seen: bool) -> None:
        """Fly ahead only while somebody looks."""
        self._seen = seen

    def begin(self) -> None:
        """Forget another flight."""
        self._busy = self._again = False
        self._asked = None
        self._clear()

    def follow(self) -> None:
        """Fly ahead with what is proposed now."""
        if self._trial.proposed == self._trial.flown:
            self._again = False
            self._clear()
        elif self._busy:
            self._again = True
        elif self._seen and self._trial.step is not None and self._may_ask():
            self._busy, self._again = True, False
            self._flight.order(lambda live: live.checkpoint(), self._ask, lambda said: self._rest())

    def _ask(self, checkpoint: Checkpoint) -> None:
        branch = Branch(NAME, self._trial.proposed)
        self._asked = Fork(checkpoint, (branch,), AHEAD)
        self._analysis.ask(self._asked)

    def _hear(self, forked: Forked) -> None:
        if self._asked is None:
            return
        branch = forked.branches[0]
        step = self._trial.step
        waited = self._trial.proposed != self._trial.flown
        if branch.name == NAME and step is not None and waited:
            self.seen_ahead.emit(branch.time, branch.response(step.axis))
        self._rest()

    def _hear_refusal(self, question: Question, said: str) -> None:
        if isinstance(question, Fork):  # the card of forks tells why, where it has asked
            self._rest()

    def _rest(self) -> None:
        self._busy, self._asked = False, None
        if self._again:
            self.follow()

    def _clear(self) -> None:
        self.seen_ahead.emit(np.empty(0), np.empty(0))

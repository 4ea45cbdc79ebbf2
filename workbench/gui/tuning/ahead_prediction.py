"""The prediction of the flight's future with proposed gains that do not fly yet."""

from collections.abc import Callable, Sequence

import numpy as np
from PyQt6.QtCore import QObject, pyqtSignal

from workbench.analysis.queries import Fork
from workbench.design.branches import Branch, FlownBranch
from workbench.design.step_metrics import StepMetrics
from workbench.gui.analysis import Analysis, QueryStream
from workbench.gui.flight_model import FlightModel
from workbench.gui.tuning.trial import TuningTrial
from workbench.live.orders import FlightOrder
from workbench.session.checkpoint import Checkpoint

AHEAD_BRANCH_NAME = "next five seconds"
PREDICTION_HORIZON_S = 5.0
"""Predicted time [s]."""


class AheadPrediction(QObject):
    """Predicts the future of the flight with proposed gains that do not fly yet.

    It asks one question at a time, next about the newest gains. It asks nothing while the gains
    already fly, while the screen is hidden, and during longer work.

    Args:
        flight: the flight to continue.
        analysis: computes the prediction.
        trial: the gains that are being tried.
        may_ask: returns whether no longer work is in progress.
        parent: the Qt parent; this object is deleted with it.
    """

    seen_ahead = pyqtSignal(object, object)
    """Simulated times [s] and velocity or yaw rate along the trial's axis; both may be empty."""
    foreseen = pyqtSignal(float, object)
    """End of the predicted path [s], and its positions in W (N, 3) [m]; N may be 0."""

    def __init__(
        self,
        flight: FlightModel,
        analysis: Analysis,
        trial: TuningTrial,
        may_ask: Callable[[], bool],
        parent: QObject | None = None,
    ) -> None:
        super().__init__(parent)
        self._flight, self._trial = flight, trial
        self._may_ask = may_ask
        self._seen = False
        self._busy = False
        self._again = False
        self._forks = QueryStream(analysis, self, seen=True)
        self._forks.answered.connect(self._show)
        self._forks.refused.connect(lambda _: self._rest())  # a notice says why
        trial.changed.connect(self.follow)

    def set_seen(self, seen: bool) -> None:
        """Predict only while the screen is visible."""
        self._seen = seen

    def begin(self) -> None:
        """Clear the last flight."""
        self._busy = self._again = False
        self._forks.forget()
        self._clear()

    def follow(self) -> None:
        """Predict with the present proposed gains."""
        if self._trial.proposed == self._trial.flown:
            self._again = False
            self._clear()
        elif self._busy:
            self._again = True
        elif self._seen and self._trial.step is not None and self._may_ask():
            self._busy, self._again = True, False
            self._flight.do(FlightOrder.GET_CHECKPOINT, self._ask, lambda said: self._rest())

    def _ask(self, checkpoint: Checkpoint) -> None:
        branch = Branch(AHEAD_BRANCH_NAME, self._trial.proposed)
        self._forks.ask(Fork(checkpoint, (branch,), PREDICTION_HORIZON_S))

    def _show(self, _: Fork, forked: Sequence[tuple[FlownBranch, StepMetrics | None]]) -> None:
        ((branch, _numbers),) = forked
        step = self._trial.step
        waited = self._trial.proposed != self._trial.flown
        if step is not None and waited:
            self.seen_ahead.emit(branch.time, branch.response(step.axis))
            self.foreseen.emit(branch.time[-1] if len(branch.time) else 0.0, branch.position)
        self._rest()

    def _rest(self) -> None:
        self._busy = False
        if self._again:
            self.follow()

    def _clear(self) -> None:
        self.seen_ahead.emit(np.empty(0), np.empty(0))
        self.foreseen.emit(0.0, np.empty((0, 3)))

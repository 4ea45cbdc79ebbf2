"""How a run tells what it does and how far it is: stages of one share that never goes back."""

from collections.abc import Callable

import numpy as np

from workbench.design.tune.evaluation import Budget, Candidate
from workbench.design.tune.problem import FlownProblem
from workbench.design.tune.tuning import Progress

Listener = Callable[[Progress], None]

PREPARED, SEARCHED, PROVED, EXPLAINED = 0.1, 0.6, 0.75, 0.97
"""Shares of a run at which its stages end; why wishes cannot be met takes the place of a proof."""


class Telling:
    """Tells a listener how a run goes.

    Args:
        listener: hears of it; None for nobody.
    """

    def __init__(self, listener: Listener | None = None) -> None:
        self._listener = listener
        self._last = Progress("", 0.0)

    def prepare(self, phase: str, part: float) -> None:
        """Tell what is made ready, and which part of that is done, 0 .. 1."""
        self._tell(phase, PREPARED * part)

    def search(self, problem: FlownProblem, best: Candidate, budget: Budget) -> None:
        """Tell of the best of a search so far."""
        worst = int(np.argmin(best.reserves)) if len(best.reserves) else -1
        doing = "improving" if best.met else "searching"
        self._last = Progress(
            phase="",
            share=self._last.share,
            best=best,
            worst=problem.requirements[worst] if worst >= 0 else None,
            value=float(best.values[worst]) if worst >= 0 else float("nan"),
            gains=problem.variables.rounded(best.point),
        )
        phase = f"{doing}, candidate {budget.spent} of {budget.evaluations} at most"
        self._tell(phase, PREPARED + (SEARCHED - PREPARED) * budget.share)

    def prove(self, phase: str, part: float) -> None:
        """Tell which flight of the proof is flown, and which part of all is done, 0 .. 1."""
        self._tell(phase, SEARCHED + (PROVED - SEARCHED) * part)

    def explain(self, phase: str, part: float) -> None:
        """Tell how far it is with why wishes cannot be met, 0 .. 1."""
        self._tell(phase, SEARCHED + (EXPLAINED - SEARCHED) * part)

    def finish(self, phase: str) -> None:
        """Tell what is done last."""
        self._tell(phase, EXPLAINED)

    def _tell(self, phase: str, share: float) -> None:
        last = self._last
        self._last = Progress(
            phase, max(share, last.share), last.best, last.worst, last.value, last.gains
        )
        if self._listener:
            self._listener(self._last)

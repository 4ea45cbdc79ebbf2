"""How a tuning run goes, and what it found.

Progress has stages, and one share of the run that never goes back.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from workbench.control.controller import Controller
from workbench.design.tune.case import NOMINAL, Case
from workbench.design.tune.conflict import Conflict
from workbench.design.tune.evaluation import Budget, Candidate, Problem
from workbench.design.tune.measure import Responses, Step
from workbench.design.tune.proof import Proof
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.wish import GUARD, Wish
from workbench.gains.gains import GainFile

PREPARED, SEARCHED, PROVED, EXPLAINED = 0.1, 0.6, 0.75, 0.97
"""Shares of a run at which its stages end; why wishes cannot be met takes the place of a proof."""


@dataclass(frozen=True)
class Progress:
    """How a run goes.

    Attributes:
        phase: what it does, in words.
        share: of the run, 0 .. 1; it never goes back.
        best: the best candidate so far; None before the first.
        worst: the requirement of which it has least to spare; None before the first.
        value: of it.
        gains: of the best candidate, those that are searched.
    """

    phase: str
    share: float
    best: Candidate | None = None
    worst: Requirement | None = None
    value: float = float("nan")
    gains: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class Result:
    """One requirement, before and after."""

    required: Requirement
    before: float
    after: float

    @property
    def met(self) -> bool:
        """Whether it is, after."""
        return self.required.met(self.after)

    @property
    def reserve(self) -> float:
        """Share of the bound that is left, after."""
        return self.required.reserve(self.after)


def worst_of_each(results: Iterable[Result]) -> list[Result]:
    """Return for each wish the result with least to spare."""
    worst: dict[Wish, Result] = {}
    for result in results:
        known = worst.get(result.required.wish)
        if known is None or result.reserve < known.reserve:
            worst[result.required.wish] = result
    return list(worst.values())


@dataclass(frozen=True)
class Tuning:
    """What a run found.

    Attributes:
        vehicle: its name.
        controller: whose gains they are.
        wishes: all of them, defaults included.
        steps: that were flown, by axis.
        results: of every requirement, in every case.
        before: values of the gains that were searched, as given.
        gains: and as found.
        profile: the gain file of all values with those.
        proof: of the full diagram; None if nothing was found that needs one.
        conflicts: why the wishes are not met.
        shortfalls: what is kept of defaults that gave way to what the rule's gains reach, and why,
            a sentence each.
        remarks: what else should be known.
        responses: flown steps (2, M), before and after, by axis and case.
        evaluations: candidates that were looked at.
        stopped: whether somebody ended it early.
    """

    vehicle: str
    controller: Controller
    wishes: tuple[Wish, ...]
    steps: Mapping[str, Step]
    results: tuple[Result, ...]
    before: Mapping[str, float]
    gains: Mapping[str, float]
    profile: GainFile
    proof: Proof | None
    conflicts: tuple[Conflict, ...]
    shortfalls: tuple[str, ...]
    remarks: tuple[str, ...]
    responses: Mapping[tuple[str, Case], Responses]
    evaluations: int
    stopped: bool

    @property
    def met(self) -> bool:
        """Whether all wishes are met, in every case and on the full diagram."""
        return (
            self.proof is not None
            and not self.proof.missed
            and all(result.met for result in self.results)
        )

    @property
    def as_described(self) -> list[Result]:
        """The wishes on the vehicle as described."""
        return [
            result
            for result in self.results
            if result.required.case == NOMINAL and result.required.wish.origin != GUARD
        ]

    @property
    def guarded(self) -> list[Result]:
        """What was kept of loops that no written wish is about."""
        return [result for result in self.results if result.required.wish.origin == GUARD]

    @property
    def in_corners(self) -> list[Result]:
        """What is left of each wish in corners: the one with least to spare of each."""
        return worst_of_each(each for each in self.results if each.required.case != NOMINAL)

    @property
    def worst_corner(self) -> Result | None:
        """The result in corners with least to spare."""
        return min(self.in_corners, key=lambda result: result.reserve, default=None)


Listener = Callable[[Progress], None]


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

    def search(self, problem: Problem, best: Candidate, budget: Budget) -> None:
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

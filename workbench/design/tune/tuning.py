"""The progress of a tuning run, and its result.

Progress has stages, and one share of the run that never decreases.
"""

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from workbench.control.controller import Controller
from workbench.design.tune.case import NOMINAL_CASE, VehicleCase
from workbench.design.tune.conflict import Conflict
from workbench.design.tune.evaluation import Budget, Problem, TuneCandidate
from workbench.design.tune.measure import Responses, TuneStep
from workbench.design.tune.proof import Proof
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.wish import DEFAULT_ORIGIN, GUARD_ORIGIN, Wish
from workbench.gains.gains import GainFile

PREPARED_SHARE, SEARCHED_SHARE, PROVED_SHARE, EXPLAINED_SHARE = 0.1, 0.6, 0.75, 0.97
"""Shares of a run at which its stages end; an explanation of unmet wishes replaces a proof."""


@dataclass(frozen=True)
class TuningProgress:
    """The progress of a run.

    Attributes:
        phase: the present work, in words.
        share: of the run, 0 .. 1; it never decreases.
        best: the best candidate so far; None before the first.
        worst: the requirement with its smallest reserve; None before the first.
        value: for that requirement.
        gains: the tuned ones, of the best candidate.
    """

    phase: str
    share: float
    best: TuneCandidate | None = None
    worst: Requirement | None = None
    value: float = float("nan")
    gains: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class WishResult:
    """One requirement, before and after."""

    required: Requirement
    before: float
    after: float

    @property
    def met(self) -> bool:
        """Whether it is met, after."""
        return self.required.met(self.after)

    @property
    def reserve(self) -> float:
        """Reserve as a share of the bound, after."""
        return self.required.reserve(self.after)


def worst_of_each(results: Iterable[WishResult]) -> list[WishResult]:
    """Return for each wish the result with the smallest reserve."""
    worst: dict[Wish, WishResult] = {}
    for result in results:
        known = worst.get(result.required.wish)
        if known is None or result.reserve < known.reserve:
            worst[result.required.wish] = result
    return list(worst.values())


@dataclass(frozen=True)
class Tuning:
    """The result of a run.

    Attributes:
        vehicle: its name.
        controller: of the gains.
        wishes: all of them, defaults included.
        steps: the flown ones, by axis.
        results: of every requirement, in every case.
        before: initial values of the tuned gains.
        gains: their values found.
        profile: the gain file of all values with these.
        proof: on the full diagram; None if there is nothing to prove.
        conflicts: why the wishes are not met.
        shortfalls: a sentence on each default that was widened to what the rule's gains reach.
        remarks: further remarks.
        responses: flown steps (2, M), before and after, by axis and case.
        evaluations: number of candidates.
        stopped: whether it was ended early.
    """

    vehicle: str
    controller: Controller
    wishes: tuple[Wish, ...]
    steps: Mapping[str, TuneStep]
    results: tuple[WishResult, ...]
    before: Mapping[str, float]
    gains: Mapping[str, float]
    profile: GainFile
    proof: Proof | None
    conflicts: tuple[Conflict, ...]
    shortfalls: tuple[str, ...]
    remarks: tuple[str, ...]
    responses: Mapping[tuple[str, VehicleCase], Responses]
    evaluations: int
    stopped: bool

    @property
    def deciding(self) -> list[WishResult]:
        """The results that decide: of defaults only if nothing was wished."""
        if not any(wish.is_written for wish in self.wishes):
            return list(self.results)
        return [each for each in self.results if each.required.wish.origin != DEFAULT_ORIGIN]

    @property
    def met(self) -> bool:
        """Whether what was wished is met, in every case and on the full diagram."""
        deciding = {each.required for each in self.deciding}
        return (
            self.proof is not None
            and not any(required in deciding for required, _ in self.proof.missed)
            and all(result.met for result in self.deciding)
        )

    @property
    def given_up(self) -> list[WishResult]:
        """The worst result of each default that is not met, although what was wished is."""
        if not self.met:
            return []
        return worst_of_each(each for each in self.results if not each.met)

    @property
    def as_described(self) -> list[WishResult]:
        """The results on the vehicle as described."""
        return [
            result
            for result in self.results
            if result.required.case == NOMINAL_CASE and result.required.wish.origin != GUARD_ORIGIN
        ]

    @property
    def guarded(self) -> list[WishResult]:
        """The results of guards of loops without a written wish."""
        return [result for result in self.results if result.required.wish.origin == GUARD_ORIGIN]

    @property
    def in_corners(self) -> list[WishResult]:
        """The results in corners: for each wish the one with the smallest reserve."""
        return worst_of_each(each for each in self.results if each.required.case != NOMINAL_CASE)

    @property
    def worst_corner(self) -> WishResult | None:
        """The result in corners with the smallest reserve."""
        return min(self.in_corners, key=lambda result: result.reserve, default=None)


ProgressListener = Callable[[TuningProgress], None]


class ProgressReporter:
    """Reports the progress of a run to a listener.

    Args:
        listener: called with the progress; None for none.
    """

    def __init__(self, listener: ProgressListener | None = None) -> None:
        self._listener = listener
        self._last = TuningProgress("", 0.0)

    def prepare(self, phase: str, part: float) -> None:
        """Report a preparation, and its share done, 0 .. 1."""
        self._tell(phase, PREPARED_SHARE * part)

    def search(self, problem: Problem, best: TuneCandidate, budget: Budget) -> None:
        """Report the best candidate of a search so far."""
        worst = int(np.argmin(best.reserves)) if len(best.reserves) else -1
        doing = "improving" if best.met else "searching"
        self._last = TuningProgress(
            phase="",
            share=self._last.share,
            best=best,
            worst=problem.requirements[worst] if worst >= 0 else None,
            value=float(best.values[worst]) if worst >= 0 else float("nan"),
            gains=problem.variables.rounded(best.point),
        )
        phase = f"{doing}, candidate {budget.spent} of {budget.evaluations} at most"
        self._tell(phase, PREPARED_SHARE + (SEARCHED_SHARE - PREPARED_SHARE) * budget.share)

    def prove(self, phase: str, part: float) -> None:
        """Report the present flight of the proof, and the share done of all, 0 .. 1."""
        self._tell(phase, SEARCHED_SHARE + (PROVED_SHARE - SEARCHED_SHARE) * part)

    def explain(self, phase: str, part: float) -> None:
        """Report the progress of explaining unmet wishes, 0 .. 1."""
        self._tell(phase, SEARCHED_SHARE + (EXPLAINED_SHARE - SEARCHED_SHARE) * part)

    def finish(self, phase: str) -> None:
        """Report the last stage."""
        self._tell(phase, EXPLAINED_SHARE)

    def _tell(self, phase: str, share: float) -> None:
        last = self._last
        self._last = TuningProgress(
            phase, max(share, last.share), last.best, last.worst, last.value, last.gains
        )
        if self._listener:
            self._listener(self._last)

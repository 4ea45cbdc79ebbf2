"""Search gains that meet the requirements of a tuning, in rounds."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.design.tune.case import NOMINAL_CASE, VehicleCase
from workbench.design.tune.evaluation import Budget, Evaluation, Problem, TuneCandidate
from workbench.design.tune.proof import Proof, flights_to_fly, prove_gains
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.search import ENOUGH_RESERVE, find_candidate
from workbench.design.tune.tuning import ProgressReporter
from workbench.design.tune.tuning_plan import TuningPlan

MAX_TUNING_ROUNDS = 6
"""Number of repeated searches, with an omitted corner or with the results of the proof."""


@dataclass(frozen=True)
class Solution:
    """The result of a search.

    Attributes:
        gains: the tuned ones.
        values: of all requirements of the plan (R).
        proof: None if the wishes are not met, or the full diagram does not agree.
        problem: of the last search.
        best: its best candidate.
        smallest: for each widened requirement, the best value of a candidate that met all others.
    """

    gains: Mapping[str, float]
    values: np.ndarray
    proof: Proof | None
    problem: Problem
    best: TuneCandidate
    smallest: Mapping[Requirement, float]

    @property
    def proved(self) -> bool:
        """Whether all requirements of the search are met, on the full diagram as well."""
        return self.best.met and self.proof is not None and not self.proof.missed


class Solver:
    """Solves one plan.

    Args:
        plan: of the run.
        budget: of all its searches.
        seed: of random points, for the case that no start leads to a solution.
        telling: reports progress.
    """

    def __init__(
        self, plan: TuningPlan, budget: Budget, seed: int, telling: ProgressReporter | None = None
    ) -> None:
        self._plan = plan
        self._budget = budget
        self._seed = seed
        self._telling = telling or ProgressReporter()
        self._smallest: dict[Requirement, float] = {}

    def solve(self) -> Solution:
        """Return gains that meet all requirements, or the best ones found."""
        whole = self._plan.problem
        cases = self._first_cases()
        starts = list(self._plan.starts)
        for _ in range(MAX_TUNING_ROUNDS):
            problem = whole.demanding([r for r in whole.requirements if r.case in cases])
            best = self._searched(problem, starts)
            gains = self._tidy(problem, best)
            values = whole.measured([{**whole.base, **gains}])[0]
            found = Solution(gains, values, None, problem, best, self._smallest)
            if not best.met:
                return found
            missed = [
                required
                for required, value in zip(whole.requirements, values, strict=True)
                if not required.met(value)
            ]
            starts = [best.point, *self._plan.starts]
            if missed:
                cases |= {required.case for required in missed}
                continue
            proof = self._proof(whole, gains, values)
            if not proof.missed:
                return dataclasses.replace(found, proof=proof)
            whole = whole.corrected(proof.values, values)
        return found

    def _first_cases(self) -> set[VehicleCase]:
        """Return the vehicle as described and, for each wish, the corner worst under the rule."""
        required = self._plan.problem.requirements
        values = self._plan.at_rule
        worst: dict[object, tuple[float, VehicleCase]] = {}
        for each, value in zip(required, values, strict=True):
            reserve = each.reserve(value)
            if (
                each.case != NOMINAL_CASE
                and reserve < worst.get(each.wish, (np.inf, NOMINAL_CASE))[0]
            ):
                worst[each.wish] = (reserve, each.case)
        return {NOMINAL_CASE, *(case for _, case in worst.values())}

    def _searched(self, problem: Problem, starts: list[np.ndarray]) -> TuneCandidate:
        """Return the best candidate of a problem."""

        def heard(best: TuneCandidate) -> None:
            self._telling.search(problem, best, self._budget)

        evaluation = Evaluation(problem, self._budget, heard, ENOUGH_RESERVE)
        best = find_candidate(evaluation, starts, self._seed)
        self._note_smallest(problem, evaluation.seen)
        return best

    def _note_smallest(self, problem: Problem, seen: list[TuneCandidate]) -> None:
        """Note the best value of each widened requirement among candidates that met all others."""
        reserves = np.array([candidate.reserves for candidate in seen])
        for index, required in enumerate(problem.requirements):
            if required.widened is None:
                continue
            others = np.delete(reserves, index, axis=1)
            good = np.flatnonzero((others >= 0.0).all(axis=1))
            if len(good):
                best = seen[max(good, key=lambda row: reserves[row, index])]
                self._smallest[required] = float(best.values[index])

    def _tidy(self, problem: Problem, best: TuneCandidate) -> dict[str, float]:
        """Return the gains of a candidate with few digits, or with all if needed."""
        rounded = problem.variables.rounded(best.point)
        values = problem.measured([{**problem.base, **rounded}])[0]
        pairs = zip(problem.requirements, values, strict=True)
        if best.met and not all(required.met(value) for required, value in pairs):
            return problem.variables.gains(best.point)
        return rounded

    def _proof(self, whole: Problem, gains: Mapping[str, float], values: np.ndarray) -> Proof:
        """Return the proof of gains on the full diagram."""
        reserves = {
            required: required.reserve(value)
            for required, value in zip(whole.requirements, values, strict=True)
        }
        return prove_gains(
            self._plan.setup,
            gains,
            whole.instruments.steps,
            whole.requirements,
            flights_to_fly(whole.requirements, reserves),
            self._telling.prove,
            whole.instruments.point.velocity,
        )

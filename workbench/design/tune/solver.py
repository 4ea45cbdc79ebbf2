"""Solve a plan: search, look at all corners, fly the proof, and go back where one disagrees."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.design.tune.case import NOMINAL, Case
from workbench.design.tune.evaluation import Budget, Candidate, Evaluation
from workbench.design.tune.plan import Plan
from workbench.design.tune.problem import FlownProblem
from workbench.design.tune.proof import Proof, flights_to_fly, prove
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.search import ENOUGH, find
from workbench.design.tune.telling import Telling

ROUNDS = 6
"""So often the search goes back: to a corner that it left out, or to what the proof has shown."""


@dataclass(frozen=True)
class Solution:
    """Where a search has ended.

    Attributes:
        gains: those that were searched.
        values: of all requirements of the plan (R).
        proof: None if the wishes are not met, or the full diagram does not agree.
        problem: the last that was searched.
        best: its best candidate.
        smallest: of each requirement that gave way, the best value of a candidate that met all
            others.
    """

    gains: Mapping[str, float]
    values: np.ndarray
    proof: Proof | None
    problem: FlownProblem
    best: Candidate
    smallest: Mapping[Requirement, float]


class Solver:
    """Solves one plan.

    Args:
        plan: what to do.
        budget: of all its searches.
        seed: of what is tried where no start leads to a solution.
        telling: tells of progress.
    """

    def __init__(
        self, plan: Plan, budget: Budget, seed: int, telling: Telling | None = None
    ) -> None:
        self._plan = plan
        self._budget = budget
        self._seed = seed
        self._telling = telling or Telling()
        self._smallest: dict[Requirement, float] = {}

    def solve(self) -> Solution:
        """Return gains that meet all requirements, or the best that there are."""
        whole = self._plan.problem
        cases = self._first_cases()
        starts = list(self._plan.starts)
        for _ in range(ROUNDS):
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
            whole = _corrected(whole, proof, values)
        return found

    def _first_cases(self) -> set[Case]:
        """Return the vehicle as described and, for each wish, the corner worst under the rule."""
        required = self._plan.problem.requirements
        values = self._plan.at_rule
        worst: dict[object, tuple[float, Case]] = {}
        for each, value in zip(required, values, strict=True):
            reserve = float(each.reserves(np.array([value]))[0])
            if each.case != NOMINAL and reserve < worst.get(each.wish, (np.inf, NOMINAL))[0]:
                worst[each.wish] = (reserve, each.case)
        return {NOMINAL, *(case for _, case in worst.values())}

    def _searched(self, problem: FlownProblem, starts: list[np.ndarray]) -> Candidate:
        """Return the best candidate of a problem."""

        def heard(best: Candidate) -> None:
            self._telling.search(problem, best, self._budget)

        evaluation = Evaluation(problem, self._budget, heard, ENOUGH)
        best = find(evaluation, starts, self._seed)
        self._note_smallest(problem, evaluation.seen)
        return best

    def _note_smallest(self, problem: FlownProblem, seen: list[Candidate]) -> None:
        """Note how far each requirement that gave way was met by who met all others."""
        reserves = np.array([candidate.reserves for candidate in seen])
        for index, required in enumerate(problem.requirements):
            if required.widened is None:
                continue
            others = np.delete(reserves, index, axis=1)
            good = np.flatnonzero((others >= 0.0).all(axis=1))
            if len(good):
                best = seen[max(good, key=lambda row: reserves[row, index])]
                self._smallest[required] = float(best.values[index])

    def _tidy(self, problem: FlownProblem, best: Candidate) -> dict[str, float]:
        """Return the gains of a candidate with few digits, or with all where those are needed."""
        rounded = problem.variables.rounded(best.point)
        values = problem.measured([{**problem.base, **rounded}])[0]
        pairs = zip(problem.requirements, values, strict=True)
        if best.met and not all(required.met(value) for required, value in pairs):
            return problem.variables.gains(best.point)
        return rounded

    def _proof(self, whole: FlownProblem, gains: Mapping[str, float], values: np.ndarray) -> Proof:
        """Return what the full diagram says of gains."""
        reserves = {
            required: float(required.reserves(np.array([value]))[0])
            for required, value in zip(whole.requirements, values, strict=True)
        }
        return prove(
            self._plan.scenario,
            {**self._plan.settings, **gains},
            whole.instruments.steps,
            whole.requirements,
            flights_to_fly(whole.requirements, reserves),
            self._telling.prove,
            whole.instruments.point.velocity,
        )


def _corrected(whole: FlownProblem, proof: Proof, values: np.ndarray) -> FlownProblem:
    """Return the problem with what the full diagram had more than the instruments added."""
    measured = dict(zip(whole.requirements, values, strict=True))
    corrections = dict(whole.corrections)
    for required, value in proof.values:
        if np.isfinite(value) and np.isfinite(measured[required]):
            corrections[required] = corrections.get(required, 0.0) + value - measured[required]
    return dataclasses.replace(whole, corrections=corrections)

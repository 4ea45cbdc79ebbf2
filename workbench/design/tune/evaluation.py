"""The problem of a search, and its evaluations: counted, cached, and stopped."""

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.design.tune.measure import Instruments
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import Variables, loops_for


@dataclass(frozen=True)
class Problem:
    """The problem: gains to find, and requirements on flights and loops with them.

    Attributes:
        instruments: for the measurements.
        variables: the gains that may change.
        base: all parameter values, for the other gains.
        requirements: (R).
        corrections: difference of the full diagram from the instruments, by requirement.
    """

    instruments: Instruments
    variables: Variables
    base: Mapping[str, float]
    requirements: tuple[Requirement, ...]
    corrections: Mapping[Requirement, float] = field(default_factory=dict)

    @property
    def low(self) -> np.ndarray:
        """Smallest coordinates (n)."""
        return self.variables.low

    @property
    def high(self) -> np.ndarray:
        """Largest coordinates (n)."""
        return self.variables.high

    @property
    def matters(self) -> np.ndarray:
        """Which coordinates (n) affect the requirements."""
        subjects = [requirement.wish.subject for requirement in self.requirements]
        law = self.instruments.controller
        loops = [loop for subject in subjects for loop in loops_for(law, subject)]
        names = {name for loop in loops for name in loop.gains}
        return np.array([not names.isdisjoint(group) for group in self.variables.groups])

    def gains(self, point: np.ndarray) -> dict[str, float]:
        """Return all parameter values at coordinates (n)."""
        return {**self.base, **self.variables.gains(point)}

    def values(self, points: np.ndarray) -> np.ndarray:
        """Return the values (N, R) for the requirements at points (N, n)."""
        return self.measured([self.gains(point) for point in points])

    def measured(self, gains: Sequence[Mapping[str, float]]) -> np.ndarray:
        """Return the values (N, R) for the requirements with N sets of all parameter values."""
        values = self.instruments.measure(gains, self.requirements)
        added = [self.corrections.get(requirement, 0.0) for requirement in self.requirements]
        return np.asarray(values + np.array(added))

    def demanding(self, requirements: Sequence[Requirement]) -> "Problem":
        """Return the problem with other requirements."""
        return dataclasses.replace(self, requirements=tuple(requirements))

    def corrected(
        self, proved: Sequence[tuple[Requirement, float]], values: np.ndarray
    ) -> "Problem":
        """Return the problem, corrected by how far the full diagram is from the instruments.

        Args:
            proved: requirements with their values on the full diagram; what has none adds nothing.
            values: (R) of this problem for the same gains.
        """
        measured = dict(zip(self.requirements, values, strict=True))
        corrections = dict(self.corrections)
        for required, value in proved:
            if np.isfinite(value) and np.isfinite(measured[required]):
                corrections[required] = corrections.get(required, 0.0) + value - measured[required]
        return dataclasses.replace(self, corrections=corrections)


class SearchEndedError(Exception):
    """The search was stopped, or its budget is spent."""


@dataclass(frozen=True)
class TuneCandidate:
    """A point with its results.

    Attributes:
        point: (n).
        values: (R) for the requirements.
        reserves: (R) distances from the bounds, as shares of them.
    """

    point: np.ndarray
    values: np.ndarray
    reserves: np.ndarray

    @property
    def reserve(self) -> float:
        """The smallest reserve; below 0 a requirement is not met."""
        return float(self.reserves.min(initial=np.inf))

    @property
    def met(self) -> bool:
        """Whether all requirements are met."""
        return self.reserve >= 0.0


@dataclass
class Budget:
    """The budget of a search.

    Attributes:
        evaluations: largest number of candidates.
        seconds: longest time, by the clock.
        whole: the budget that includes this one.
        told: whether it was stopped.
        spent: number of candidates so far.
    """

    evaluations: int
    seconds: float = float("inf")
    whole: "Budget | None" = None
    told: bool = False
    spent: int = 0
    _began: float = field(default_factory=time.monotonic)

    @property
    def stopped(self) -> bool:
        """Whether it was stopped."""
        return self.told or bool(self.whole and self.whole.stopped)

    @property
    def share(self) -> float:
        """Share spent, 0 .. 1."""
        elapsed = (time.monotonic() - self._began) / self.seconds
        return min(1.0, max(self.spent / self.evaluations, elapsed))

    @property
    def ended(self) -> bool:
        """Whether it is spent or stopped."""
        return self.stopped or self.share >= 1.0

    def part(self, evaluations: int) -> "Budget":
        """Return the budget of a further search, which stops with this one."""
        return Budget(evaluations, self.seconds, whole=self)


CandidateListener = Callable[[TuneCandidate], None]
"""Function called with the best candidate so far."""


class Evaluation:
    """Evaluates points of a problem, each once, and keeps the best.

    Args:
        problem: of the search.
        budget: of this search and of others.
        listener: called after every evaluation.
        enough: smallest reserve at which the search ends.
    """

    def __init__(
        self,
        problem: Problem,
        budget: Budget,
        listener: CandidateListener | None = None,
        enough: float = math.inf,
    ) -> None:
        self.problem = problem
        self.budget = budget
        self._enough = enough
        self._listener = listener
        self._known: dict[bytes, TuneCandidate] = {}
        self._best: TuneCandidate | None = None

    @property
    def best(self) -> TuneCandidate:
        """The candidate with the largest value of its smallest reserve."""
        if self._best is None:
            raise ValueError("nothing was evaluated yet")
        return self._best

    @property
    def seen(self) -> list[TuneCandidate]:
        """All candidates evaluated."""
        return list(self._known.values())

    def evaluate(self, points: np.ndarray) -> np.ndarray:
        """Return the reserves (N, R) at points (N, n).

        Raises:
            SearchEndedError: if the reserve is sufficient, the budget is spent, or the search was
                stopped.
        """
        new = [point for point in points if point.tobytes() not in self._known]
        if new:
            if self._best and (self.budget.ended or self._best.reserve >= self._enough):
                raise SearchEndedError
            self.budget.spent += len(new)
            self._look(np.array(new))
        return np.array([self._known[point.tobytes()].reserves for point in points])

    def _look(self, points: np.ndarray) -> None:
        values = self.problem.values(points)
        columns = [
            requirement.reserves(values[:, index])
            for index, requirement in enumerate(self.problem.requirements)
        ]
        reserves = np.column_stack(columns) if columns else np.empty((len(points), 0))
        for point, value, reserve in zip(points, values, reserves, strict=True):
            found = TuneCandidate(point, value, reserve)
            self._known[point.tobytes()] = found
            if self._best is None or _better(found, self._best):
                self._best = found
        if self._listener:
            self._listener(self.best)


def _better(one: TuneCandidate, other: TuneCandidate) -> bool:
    """Return whether one is better: by its smallest reserve, and if equal by all violations."""
    if abs(one.reserve - other.reserve) > 1e-9:
        return one.reserve > other.reserve
    return _violation(one) < _violation(other)


def _violation(candidate: TuneCandidate) -> float:
    return float(np.maximum(0.0, -candidate.reserves).sum())

"""What is searched, and what a search has looked at so far: counted, remembered, and stopped."""

import dataclasses
import math
import time
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.design.tune.measure import Instruments, Quantity
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import Variables, loops_for


@dataclass(frozen=True)
class Problem:
    """What is searched: gains to find, and what is required of flights and loops with them.

    Attributes:
        instruments: what measures.
        variables: the gains that may change.
        base: all parameter values, for those that may not.
        requirements: what is required (R).
        corrections: what the full diagram had more than the instruments, by requirement.
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
        """Which coordinates (n) what is required depends on."""
        subjects = [requirement.wish.subject for requirement in self.requirements]
        law = self.instruments.controller
        loops = [loop for subject in subjects for loop in loops_for(law, subject)]
        names = {name for loop in loops for name in loop.gains}
        return np.array([not names.isdisjoint(group) for group in self.variables.groups])

    def gains(self, point: np.ndarray) -> dict[str, float]:
        """Return all parameter values at coordinates (n)."""
        return {**self.base, **self.variables.gains(point)}

    def values(self, points: np.ndarray) -> np.ndarray:
        """Return the values (N, R) of what is required, at points (N, n)."""
        return self.measured([self.gains(point) for point in points])

    def measured(self, gains: Sequence[Mapping[str, float]]) -> np.ndarray:
        """Return the values (N, R) of what is required, with N sets of all parameter values."""
        quantities = [quantity(requirement) for requirement in self.requirements]
        values = self.instruments.measure(gains, quantities)
        added = [self.corrections.get(requirement, 0.0) for requirement in self.requirements]
        return np.asarray(values + np.array(added))

    def demanding(self, requirements: Sequence[Requirement]) -> "Problem":
        """Return the problem with other requirements."""
        return dataclasses.replace(self, requirements=tuple(requirements))


def quantity(requirement: Requirement) -> Quantity:
    """Return what a requirement bounds."""
    wish = requirement.wish
    return Quantity(requirement.case, wish.metric.kind, wish.subject, wish.metric.name)


class SearchEndedError(Exception):
    """The search was told to stop, or may not look any further."""


@dataclass(frozen=True)
class Candidate:
    """A point, and how well it does.

    Attributes:
        point: (n).
        values: (R) of what is required.
        reserves: (R) shares of the bounds to spare.
    """

    point: np.ndarray
    values: np.ndarray
    reserves: np.ndarray

    @property
    def reserve(self) -> float:
        """The smallest of them; below 0 something required is not met."""
        return float(self.reserves.min(initial=np.inf))

    @property
    def met(self) -> bool:
        """Whether all is met."""
        return self.reserve >= 0.0


@dataclass
class Budget:
    """How long a search may take.

    Attributes:
        evaluations: so many candidates.
        seconds: so long, by the clock.
        whole: the budget that this is a part of.
        told: whether somebody has told it to stop.
        spent: candidates so far.
    """

    evaluations: int
    seconds: float = float("inf")
    whole: "Budget | None" = None
    told: bool = False
    spent: int = 0
    _began: float = field(default_factory=time.monotonic)

    @property
    def stopped(self) -> bool:
        """Whether somebody has told it to stop."""
        return self.told or bool(self.whole and self.whole.stopped)

    @property
    def share(self) -> float:
        """What is spent of it, 0 .. 1."""
        elapsed = (time.monotonic() - self._began) / self.seconds
        return min(1.0, max(self.spent / self.evaluations, elapsed))

    @property
    def ended(self) -> bool:
        """Whether there is nothing left, or somebody said so."""
        return self.stopped or self.share >= 1.0

    def part(self, evaluations: int) -> "Budget":
        """Return the budget of a further search, which stops when this one is told to."""
        return Budget(evaluations, self.seconds, whole=self)


Listener = Callable[[Candidate], None]
"""Hears of the best so far."""


class Evaluation:
    """Looks at points of a problem, each once, and keeps the best.

    Args:
        problem: what is searched.
        budget: of this search and of others.
        listener: called after every look.
        enough: with such a smallest reserve, the search ends.
    """

    def __init__(
        self,
        problem: Problem,
        budget: Budget,
        listener: Listener | None = None,
        enough: float = math.inf,
    ) -> None:
        self.problem = problem
        self.budget = budget
        self._enough = enough
        self._listener = listener
        self._known: dict[bytes, Candidate] = {}
        self._best: Candidate | None = None

    @property
    def best(self) -> Candidate:
        """The candidate with the largest smallest reserve."""
        if self._best is None:
            raise ValueError("nothing was looked at yet")
        return self._best

    @property
    def seen(self) -> list[Candidate]:
        """All that was looked at."""
        return list(self._known.values())

    def evaluate(self, points: np.ndarray) -> np.ndarray:
        """Return the reserves (N, R) at points (N, n).

        Raises:
            SearchEndedError: if there is enough, the budget is spent, or the search was stopped.
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
            found = Candidate(point, value, reserve)
            self._known[point.tobytes()] = found
            if self._best is None or _better(found, self._best):
                self._best = found
        if self._listener:
            self._listener(self.best)


def _better(one: Candidate, other: Candidate) -> bool:
    """Return whether one is better: by its worst, and among equals by all that is short."""
    if abs(one.reserve - other.reserve) > 1e-9:
        return one.reserve > other.reserve
    return _short(one) < _short(other)


def _short(candidate: Candidate) -> float:
    return float(np.maximum(0.0, -candidate.reserves).sum())

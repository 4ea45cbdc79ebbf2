"""Why wishes cannot be met: which of them stand against which.

Wishes are left out one by one, those that nobody wrote first; one without which the rest can be met
is needed, one without which it still cannot is not. What is left cannot be met together, and can
without any one of it.
"""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.tune.evaluation import (
    Budget,
    Candidate,
    Evaluation,
    Problem,
    SearchEndedError,
)
from workbench.design.tune.metric import Metric, shown
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.search import CLIMBS, climb, find_from
from workbench.design.tune.twins import ALONG_X
from workbench.design.tune.wish import DEFAULT, Wish

MOST = 3
ATTEMPTS = 5
"""So many conflicts are told, and so often one is looked for."""
ACTIVE = 0.05
"""A wish that has more to spare at the best compromise stands against nothing."""
EVALUATIONS = 200
NEAREST_EVALUATIONS = 300
"""Of each search, and of the one for the nearest."""


@dataclass(frozen=True)
class Conflict:
    """Wishes that cannot be met together, while any one fewer can.

    Attributes:
        wish: the first that somebody wrote.
        against: the others; without any, it cannot be met at all.
        required: where it is missed: as wished, or what is left of it in a corner.
        nearest: the best value that was found while the others were met.
    """

    wish: Wish
    against: tuple[Wish, ...]
    required: Requirement
    nearest: float

    def __str__(self) -> str:
        best = f"the nearest has {shown(self.wish.metric, self.nearest)}"
        if not self.against:
            return f"{self.required} cannot be met, even alone: {best}"
        others = " and ".join(map(_named, self.against))
        without = " or ".join(wish.name for wish in self.against)
        return (
            f"{self.required} cannot be met together with {others}: {best}; "
            f"without {without} it is met"
        )


def conflicts(problem: Problem, starts: Sequence[np.ndarray], budget: Budget) -> list[Conflict]:
    """Return what stands against what, in a problem for which no solution was found.

    Args:
        problem: with all its requirements.
        starts: points (n) to search from.
        budget: that is spent; when it is told to stop, the further searches here do, too.

    Raises:
        SearchEndedError: if it was told to stop.
    """
    search = _Search(problem, list(starts), budget)
    bundles = bundled([requirement.wish for requirement in problem.requirements])
    found: list[Conflict] = []
    for _ in range(ATTEMPTS):
        best = search.best(bundles)
        if best.met or not bundles or len(found) == MOST:
            break
        conflict = _described(search, _irreducible(search, bundles, best))
        if conflict:
            found.append(conflict)
            bundles = [bundle for bundle in bundles if conflict.wish not in bundle]
    return found


Bundle = tuple[Wish, ...]
"""Wishes that ask the same along x and along y: they stand or fall together."""


class _Search:
    """Searches for some of the wishes, each beginning where the others ended."""

    def __init__(self, problem: Problem, starts: list[np.ndarray], budget: Budget) -> None:
        self._problem = problem
        self._starts = starts
        self._last: list[np.ndarray] = []
        self._budget = budget

    def evaluation(self, bundles: Sequence[Bundle], most: int = EVALUATIONS) -> Evaluation:
        """Return what looks at only these wishes, at so many candidates, until they are met."""
        wishes = {wish for bundle in bundles for wish in bundle}
        required = [r for r in self._problem.requirements if r.wish in wishes]
        if self._budget.stopped:
            raise SearchEndedError
        return Evaluation(self._problem.demanding(required), self._budget.part(most), enough=0.0)

    def best(self, bundles: Sequence[Bundle]) -> Candidate:
        """Return the best candidate for these wishes."""
        best = find_from(self.evaluation(bundles), [*self._last, *self._starts])
        self.learn(best.point)
        return best

    def learn(self, point: np.ndarray) -> None:
        """Begin the next search at a point (n), too."""
        self._last = [point]


def _irreducible(search: _Search, bundles: Sequence[Bundle], best: Candidate) -> list[Bundle]:
    """Return wishes that cannot be met together, none of which can be spared."""
    evaluation = search.evaluation(bundles)
    evaluation.evaluate(best.point[None])
    active = _active(evaluation, bundles)
    core = active if not search.best(active).met else list(bundles)
    for bundle in sorted(core, key=lambda bundle: bundle[0].origin != DEFAULT):
        rest = [other for other in core if other != bundle]
        if rest and not search.best(rest).met:
            core = rest
    return core


def _active(evaluation: Evaluation, bundles: Sequence[Bundle]) -> list[Bundle]:
    """Return the wishes that are short, or nearly, at the best candidate."""
    pairs = zip(evaluation.problem.requirements, evaluation.best.reserves, strict=True)
    short = {required.wish for required, reserve in pairs if reserve < ACTIVE}
    return [bundle for bundle in bundles if not short.isdisjoint(bundle)]


def _described(search: _Search, core: list[Bundle]) -> Conflict | None:
    """Return the conflict of an irreducible set of wishes; none if it turns out not to be one."""
    yielding = next((bundle for bundle in core if bundle[0].origin != DEFAULT), core[0])
    others = [other for other in core if other != yielding]
    points = [search.best(some).point for some in (others, core) if some]
    evaluation = search.evaluation(core, NEAREST_EVALUATIONS)
    evaluation.evaluate(np.array(points))
    required = list(evaluation.problem.requirements)
    mine = np.array([each.wish in yielding for each in required])
    try:
        for point in points:
            for _ in range(CLIMBS):
                point = climb(evaluation, point, mine)
    except SearchEndedError:
        pass

    def nearness(candidate: Candidate) -> tuple[float, float]:
        rest = float(candidate.reserves[~mine].min(initial=np.inf))
        return min(0.0, rest), float(candidate.reserves[mine].min())

    nearest = max(evaluation.seen, key=nearness)
    if nearest.met:
        search.learn(nearest.point)
        return None
    short = min(np.flatnonzero(mine), key=lambda index: nearest.reserves[index])
    return Conflict(
        wish=required[short].wish,
        against=tuple(other[0] for other in others),
        required=required[short],
        nearest=float(nearest.values[short]),
    )


def bundled(wishes: Sequence[Wish]) -> list[Bundle]:
    """Return wishes by what they ask for, along x and y in one."""
    bundles: dict[tuple[str, Metric, bool, float], Bundle] = {}
    for wish in dict.fromkeys(wishes):
        key = (ALONG_X.get(wish.subject, wish.subject), wish.metric, wish.at_least, wish.bound)
        bundles[key] = (*bundles.get(key, ()), wish)
    return list(bundles.values())


def _named(wish: Wish) -> str:
    return f"{wish} (a default)" if wish.origin == DEFAULT else str(wish)

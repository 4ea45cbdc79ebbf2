"""Explain why wishes cannot be met: the conflicts between them, and the nearest compromise.

Wishes are left out one by one, defaults first. A wish without which the rest can be met belongs to
the conflict, others do not. The remaining wishes cannot be met together, but can be without any one
of them. The nearest candidate meets all other wishes and misses these by the least. A run reports
only that candidate, so all its results are for the same gains.
"""

import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.metrics import Metric
from workbench.design.tune.evaluation import (
    Budget,
    Evaluation,
    Problem,
    SearchEndedError,
    TuneCandidate,
)
from workbench.design.tune.requirement import NO_INTEGRAL_TEXT, Requirement
from workbench.design.tune.search import MAX_CLIMBS, climb, find_from
from workbench.design.tune.wish import DEFAULT_ORIGIN, GUARD_ORIGIN, Wish

MAX_CONFLICTS = 3
MAX_CONFLICT_ATTEMPTS = 5
"""Largest number of conflicts reported, and of attempts to find one."""
MAX_ACTIVE_RESERVE = 0.05
"""Reserve at the best compromise above which a wish is not part of a conflict."""
HALF_PROGRESS_SEARCHES = 12.0
"""Number of searches after which progress is one half."""
CONFLICT_EVALUATIONS = 200
NEAREST_EVALUATIONS = 300
"""Evaluations in each search, and in that for the nearest candidate."""


@dataclass(frozen=True)
class Conflict:
    """Wishes that cannot be met together, but can be without any one of them.

    Attributes:
        wish: the first one written by the user.
        against: the others; if empty, the wish cannot be met at all.
        required: the missed requirement: as wished, or relaxed for a corner.
        nearest: its value with the reported gains, which meet all other wishes if possible, and
            come nearest to it.
    """

    wish: Wish
    against: tuple[Wish, ...]
    required: Requirement
    nearest: float

    def __str__(self) -> str:
        best = f"the nearest has {self.wish.metric.text(self.nearest)}"
        if self.wish.metric.name == "steady_state_error":
            best += f" ({NO_INTEGRAL_TEXT})"
        if not self.against:
            return f"{self.required} cannot be met, even alone: {best}"
        others = " and ".join(map(_wish_with_origin, self.against))
        without = " or ".join(wish.name for wish in self.against)
        return (
            f"{self.required} cannot be met together with {others}: {best}; "
            f"without {without} it is met"
        )


@dataclass(frozen=True)
class Unmet:
    """The explanation of wishes that cannot be met together.

    Attributes:
        conflicts: between wishes; empty if no reason was found.
        nearest: the candidate that meets all other wishes, if possible, and comes nearest to those
            that cannot be met; None without conflicts.
    """

    conflicts: tuple[Conflict, ...] = ()
    nearest: TuneCandidate | None = None

    def measured(
        self, requirements: Sequence[Requirement], values: Sequence[float]
    ) -> tuple[Conflict, ...]:
        """Return the conflicts with the values for the reported gains.

        Args:
            requirements: of all cases (R).
            values: of them (R).
        """
        return tuple(_with_nearest_values(each, requirements, values) for each in self.conflicts)


def conflicts(
    problem: Problem,
    starts: Sequence[np.ndarray],
    budget: Budget,
    along_x: Mapping[str, str],
    tell: Callable[[str, float], None] = lambda phase, part: None,
) -> Unmet:
    """Return the conflicts in a problem without a known solution.

    Args:
        problem: with all its requirements.
        starts: points (n) to search from.
        budget: already spent; a stop of it also stops the searches here.
        along_x: subjects along x that correspond to those along y, see `counterparts`.
        tell: called with the present work and its share done, 0 .. 1.

    Raises:
        SearchEndedError: if it was stopped.
    """
    search = _Search(problem, list(starts), budget, tell)
    everything = bundled([requirement.wish for requirement in problem.requirements], along_x)
    bundles = everything
    found: list[Conflict] = []
    points: list[np.ndarray] = []
    for _ in range(MAX_CONFLICT_ATTEMPTS):
        best = search.best(bundles)
        if best.met or not bundles or len(found) == MAX_CONFLICTS:
            break
        described = _described(search, _irreducible(search, bundles, best))
        if described:
            conflict, point = described
            found.append(conflict)
            points.append(point)
            bundles = [bundle for bundle in bundles if conflict.wish not in bundle]
    if not found:
        return Unmet()
    yielding = {w for each in everything for w in each if not any(w in b for b in bundles)}
    nearest = _nearest_candidate(
        search, everything, yielding, [search.best(bundles).point, *points]
    )
    pairs = (list(problem.requirements), nearest.values.tolist())
    return Unmet(tuple(_with_nearest_values(each, *pairs) for each in found), nearest)


Bundle = tuple[Wish, ...]
"""Wishes that are the same along x and along y, and are met or missed together."""


class _Search:
    """Searches for subsets of the wishes, each starting from the results of the others."""

    def __init__(
        self,
        problem: Problem,
        starts: list[np.ndarray],
        budget: Budget,
        tell: Callable[[str, float], None],
    ) -> None:
        self._problem = problem
        self._tell = tell
        self._searches = 0
        self._starts = starts
        self._last: list[np.ndarray] = []
        self._budget = budget

    def evaluation(self, bundles: Sequence[Bundle], most: int = CONFLICT_EVALUATIONS) -> Evaluation:
        """Return what looks at only these wishes, at so many candidates, until they are met."""
        wishes = {wish for bundle in bundles for wish in bundle}
        required = [r for r in self._problem.requirements if r.wish in wishes]
        if self._budget.stopped:
            raise SearchEndedError
        self._searches += 1
        part = self._budget.part(most)
        return Evaluation(self._problem.demanding(required), part, self._heard(part), enough=0.0)

    def _heard(self, part: Budget) -> Callable[[TuneCandidate], None]:
        """Return what tells of one more search; how many there will be is not known."""
        number = self._searches

        def heard(best: TuneCandidate) -> None:
            self._tell(
                f"finding which wishes contradict each other: search {number}, candidate "
                f"{part.spent}",
                1.0 - HALF_PROGRESS_SEARCHES / (HALF_PROGRESS_SEARCHES + number - 1.0 + part.share),
            )

        return heard

    def best(self, bundles: Sequence[Bundle]) -> TuneCandidate:
        """Return the best candidate for these wishes."""
        best = find_from(self.evaluation(bundles), [*self._last, *self._starts])
        self.learn(best.point)
        return best

    def learn(self, point: np.ndarray) -> None:
        """Begin the next search at a point (n), too."""
        self._last = [point]


def _irreducible(search: _Search, bundles: Sequence[Bundle], best: TuneCandidate) -> list[Bundle]:
    """Return wishes that cannot be met together, none of which can be spared."""
    evaluation = search.evaluation(bundles)
    evaluation.evaluate(best.point[None])
    active = _active(evaluation, bundles)
    core = active if not search.best(active).met else list(bundles)
    for bundle in sorted(core, key=lambda bundle: bundle[0].is_written):
        rest = [other for other in core if other != bundle]
        if rest and not search.best(rest).met:
            core = rest
    return core


def _active(evaluation: Evaluation, bundles: Sequence[Bundle]) -> list[Bundle]:
    """Return the wishes that are short, or nearly, at the best candidate."""
    pairs = zip(evaluation.problem.requirements, evaluation.best.reserves, strict=True)
    short = {required.wish for required, reserve in pairs if reserve < MAX_ACTIVE_RESERVE}
    return [bundle for bundle in bundles if not short.isdisjoint(bundle)]


def _described(search: _Search, core: list[Bundle]) -> tuple[Conflict, np.ndarray] | None:
    """Return the conflict of an irreducible set of wishes and the point (n) that is nearest.

    None if it turns out not to be one.
    """
    yielding = next((bundle for bundle in core if bundle[0].is_written), core[0])
    others = [other for other in core if other != yielding]
    points = [search.best(some).point for some in (others, core) if some]
    evaluation = search.evaluation(core, NEAREST_EVALUATIONS)
    evaluation.evaluate(np.array(points))
    required = list(evaluation.problem.requirements)
    mine = np.array([each.wish in yielding for each in required])
    nearest = _climbed(evaluation, points, mine)
    if nearest.met:
        search.learn(nearest.point)
        return None
    short = min(np.flatnonzero(mine), key=lambda index: nearest.reserves[index])
    conflict = Conflict(
        wish=required[short].wish,
        against=tuple(other[0] for other in others),
        required=required[short],
        nearest=float(nearest.values[short]),
    )
    return conflict, nearest.point


def _nearest_candidate(
    search: _Search, bundles: Sequence[Bundle], yielding: set[Wish], points: Sequence[np.ndarray]
) -> TuneCandidate:
    """Return the candidate that keeps all wishes but some, and comes nearest to those."""
    evaluation = search.evaluation(bundles, NEAREST_EVALUATIONS)
    evaluation.evaluate(np.array(points))
    mine = np.array([each.wish in yielding for each in evaluation.problem.requirements])
    return _climbed(evaluation, points, mine)


def _climbed(
    evaluation: Evaluation, points: Sequence[np.ndarray], mine: np.ndarray
) -> TuneCandidate:
    """Return who comes nearest to some requirements (R) on the ways from points, the rest met."""

    def nearness(candidate: TuneCandidate) -> tuple[float, float]:
        rest = float(candidate.reserves[~mine].min(initial=np.inf))
        return min(0.0, rest), float(candidate.reserves[mine].min())

    try:
        for point in points:
            for _ in range(MAX_CLIMBS):
                point = climb(evaluation, point, mine)
    except SearchEndedError:
        pass
    return max(evaluation.seen, key=nearness)


def _with_nearest_values(
    conflict: Conflict, requirements: Sequence[Requirement], values: Sequence[float]
) -> Conflict:
    """Return a conflict with what is missed by most of its wish, among values (R)."""
    mine = [
        (each.reserve(value), index)
        for index, (each, value) in enumerate(zip(requirements, values, strict=True))
        if each.wish == conflict.wish
    ]
    _, index = min(mine)
    return dataclasses.replace(conflict, required=requirements[index], nearest=float(values[index]))


def bundled(wishes: Sequence[Wish], along_x: Mapping[str, str]) -> list[Bundle]:
    """Return wishes by what they ask for, along x and y in one."""
    bundles: dict[tuple[str, Metric, bool, float], Bundle] = {}
    for wish in dict.fromkeys(wishes):
        key = (along_x.get(wish.subject, wish.subject), wish.metric, wish.at_least, wish.bound)
        bundles[key] = (*bundles.get(key, ()), wish)
    return list(bundles.values())


def _wish_with_origin(wish: Wish) -> str:
    origins = {
        DEFAULT_ORIGIN: " (a default)",
        GUARD_ORIGIN: " (keeps a loop that no wish is about)",
    }
    return f"{wish}{origins.get(wish.origin, '')}"

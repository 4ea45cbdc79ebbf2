"""Search for coordinates that meet all requirements with the largest reserve.

The search is generic: a `Problem` has bounds, requirements, and their values at points. Reserves
are shares of the bounds (see `Requirement.reserves`). The goal is the point with the largest value
t of the smallest reserve, a problem with constraints

    maximise t  so that  reserve_i(x) >= t  for all i,

which scipy's SLSQP solves in a few steps. Far from any solution, least squares of max(0, r -
reserve_i) come first.
"""

from collections.abc import Sequence

import numpy as np
from scipy.optimize import least_squares, minimize
from scipy.stats import qmc

from workbench.design.tune.evaluation import Candidate, Evaluation, SearchEndedError

ENOUGH = 0.2
"""Reserve at which the search ends."""
FAR = -1.0
"""Reserve below which least squares come first."""
TARGET = 0.02
"""Target reserve of least squares."""
PULL = 2e-3
"""Weight in least squares of the distance from the start, per e-fold of a gain: no gain moves
without need."""
DIFFERENCE = 0.02
"""Step for derivatives, in e-folds: well above the effect of the resolution of samples."""
REACH = 0.7
"""Largest distance of gains from the start of a climb, in e-folds."""
GAIN = 0.01
"""Smallest gain of a climb for another to follow."""
CLIMBS = 4
ITERATIONS = 12
KEPT = 0.002
"""Reserve of requirements that must stay met while others are improved."""
SCATTERED = 16
SCATTER_WIDTH = 1.6
"""Spread of gains around the first start, in e-folds: a factor of five each way."""
DESCENTS = 2
"""Number of scattered points to follow."""


def find(evaluation: Evaluation, starts: Sequence[np.ndarray], seed: int) -> Candidate:
    """Return the best candidate: one that meets all requirements, if one is found.

    Args:
        evaluation: of the problem; it keeps the best and ends the search when stopped or spent.
        starts: initial points (n), the most promising first.
        seed: of random points, for the case that no start leads to a solution.
    """
    best = find_from(evaluation, starts)
    if not best.met and not evaluation.budget.ended:
        best = find_around(evaluation, starts[0], seed)
    return best


def find_from(evaluation: Evaluation, starts: Sequence[np.ndarray]) -> Candidate:
    """Return the best candidate of climbs from points (n), the most promising first."""
    try:
        for start in _by_promise(evaluation, starts):
            _follow(evaluation, start)
            if evaluation.best.met:
                break
    except SearchEndedError:
        pass
    return evaluation.best


def find_around(evaluation: Evaluation, middle: np.ndarray, seed: int) -> Candidate:
    """Return the best candidate of climbs from points scattered around one (n)."""
    sampler = qmc.Sobol(len(middle), seed=seed)
    around = middle + SCATTER_WIDTH * (2.0 * sampler.random(SCATTERED) - 1.0)
    points = np.clip(around, evaluation.problem.low, evaluation.problem.high)
    try:
        promising = _by_promise(evaluation, list(points))[:DESCENTS]
    except SearchEndedError:
        return evaluation.best
    return find_from(evaluation, promising)


def climb(evaluation: Evaluation, start: np.ndarray, pushed: np.ndarray) -> np.ndarray:
    """Return the point (n) near a start with the largest value of the smallest of some reserves.

    Args:
        evaluation: of the problem.
        start: initial point (n).
        pushed: mask of requirements (R) to improve; the others must be or become met.

    Raises:
        SearchEndedError: if the search was stopped, or its budget is spent.
    """
    problem, n = evaluation.problem, len(start)
    low, high = np.maximum(problem.low, start - REACH), np.minimum(problem.high, start + REACH)

    def short(z: np.ndarray) -> np.ndarray:
        return evaluation.evaluate(z[None, :n])[0] - np.where(pushed, z[n], KEPT)

    def slopes(z: np.ndarray) -> np.ndarray:
        return np.hstack([_slopes(evaluation, z[:n]), -pushed[:, None].astype(float)])

    reached = float(evaluation.evaluate(start[None])[0][pushed].min())
    down = np.append(np.zeros(n), -1.0)
    found = minimize(
        lambda z: -z[n],
        np.append(start, min(reached, ENOUGH)),
        jac=lambda z: down,
        constraints=[{"type": "ineq", "fun": short, "jac": slopes}],
        bounds=[*zip(low, high, strict=True), (None, ENOUGH)],
        method="SLSQP",
        options={"maxiter": ITERATIONS, "ftol": 1e-3},
    )
    return np.clip(found.x[:n], low, high)


def _follow(evaluation: Evaluation, start: np.ndarray) -> None:
    """Climb from a point as long as it improves enough."""
    everything = np.ones(len(evaluation.problem.requirements), dtype=bool)
    point = start
    if float(evaluation.evaluate(point[None]).min()) < FAR:
        point = _descend(evaluation, point)
    for _ in range(CLIMBS):
        before = float(evaluation.evaluate(point[None]).min())
        higher = climb(evaluation, point, everything)
        if float(evaluation.evaluate(higher[None]).min()) < before + GAIN:
            break
        point = higher


def _descend(evaluation: Evaluation, start: np.ndarray) -> np.ndarray:
    """Return a point (n) with the least violation of all reserves."""
    low, high = evaluation.problem.low, evaluation.problem.high

    def residuals(point: np.ndarray) -> np.ndarray:
        hinges = np.maximum(0.0, TARGET - evaluation.evaluate(point[None])[0])
        return np.append(hinges, PULL * (point - start))

    def slopes(point: np.ndarray) -> np.ndarray:
        short = evaluation.evaluate(point[None])[0] < TARGET
        return np.vstack([-_slopes(evaluation, point) * short[:, None], PULL * np.eye(len(point))])

    found = least_squares(
        residuals,
        np.clip(start, low + 1e-9, high - 1e-9),
        jac=slopes,
        bounds=(low, high),
        xtol=1e-4,
        ftol=1e-2,
        gtol=1e-7,
        max_nfev=ITERATIONS,
    )
    return np.clip(found.x, low, high)


def _slopes(evaluation: Evaluation, point: np.ndarray) -> np.ndarray:
    """Return the derivatives of the reserves (R, n); 0 for coordinates without effect."""
    problem = evaluation.problem
    moving = np.flatnonzero(problem.matters)
    steps = np.where(point + DIFFERENCE > problem.high, -DIFFERENCE, DIFFERENCE)
    rows = evaluation.evaluate(np.vstack([point, point + np.diag(steps)[moving]]))
    found = np.zeros((rows.shape[1], len(point)))
    found[:, moving] = ((rows[1:] - rows[0]) / steps[moving, None]).T
    return found


def _by_promise(evaluation: Evaluation, points: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return points by their smallest reserve, the largest first."""
    reserves = evaluation.evaluate(np.array(points)).min(axis=1, initial=np.inf)
    return [points[index] for index in np.argsort(-reserves, kind="stable")]

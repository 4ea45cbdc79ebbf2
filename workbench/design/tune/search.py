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

from workbench.design.tune.evaluation import Evaluation, SearchEndedError, TuneCandidate

ENOUGH_RESERVE = 0.2
"""Reserve at which the search ends."""
FAR_RESERVE = -1.0
"""Reserve below which least squares come first."""
TARGET_RESERVE = 0.02
"""Target reserve of least squares."""
START_PULL_WEIGHT = 2e-3
"""Weight in least squares of the distance from the start, per e-fold of a gain: no gain moves
without need."""
LOG_GAIN_STEP = 0.02
"""Step for derivatives, in e-folds: well above the effect of the resolution of samples."""
MAX_CLIMB_LOG_GAIN = 0.7
"""Largest distance of gains from the start of a climb, in e-folds."""
MIN_CLIMB_IMPROVEMENT = 0.01
"""Smallest gain of a climb for another to follow."""
MAX_CLIMBS = 4
MAX_CLIMB_ITERATIONS = 12
KEPT_RESERVE = 0.002
"""Reserve of requirements that must stay met while others are improved."""
SCATTERED_POINTS = 16
SCATTER_LOG_GAIN = 1.6
"""Spread of gains around the first start, in e-folds: a factor of five each way."""
MAX_DESCENTS = 2
"""Number of scattered points to follow."""


def find_candidate(
    evaluation: Evaluation, starts: Sequence[np.ndarray], seed: int
) -> TuneCandidate:
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


def find_from(evaluation: Evaluation, starts: Sequence[np.ndarray]) -> TuneCandidate:
    """Return the best candidate of climbs from points (n), the most promising first."""
    try:
        for start in _by_promise(evaluation, starts):
            _climb_repeatedly(evaluation, start)
            if evaluation.best.met:
                break
    except SearchEndedError:
        pass
    return evaluation.best


def find_around(evaluation: Evaluation, middle: np.ndarray, seed: int) -> TuneCandidate:
    """Return the best candidate of climbs from points scattered around one (n)."""
    sampler = qmc.Sobol(len(middle), seed=seed)
    around = middle + SCATTER_LOG_GAIN * (2.0 * sampler.random(SCATTERED_POINTS) - 1.0)
    points = np.clip(around, evaluation.problem.low, evaluation.problem.high)
    try:
        promising = _by_promise(evaluation, list(points))[:MAX_DESCENTS]
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
    low, high = (
        np.maximum(problem.low, start - MAX_CLIMB_LOG_GAIN),
        np.minimum(problem.high, start + MAX_CLIMB_LOG_GAIN),
    )

    def short(z: np.ndarray) -> np.ndarray:
        return evaluation.evaluate(z[None, :n])[0] - np.where(pushed, z[n], KEPT_RESERVE)

    def slopes(z: np.ndarray) -> np.ndarray:
        return np.hstack([_reserve_slopes(evaluation, z[:n]), -pushed[:, None].astype(float)])

    reached = float(evaluation.evaluate(start[None])[0][pushed].min())
    down = np.append(np.zeros(n), -1.0)
    found = minimize(
        lambda z: -z[n],
        np.append(start, min(reached, ENOUGH_RESERVE)),
        jac=lambda z: down,
        constraints=[{"type": "ineq", "fun": short, "jac": slopes}],
        bounds=[*zip(low, high, strict=True), (None, ENOUGH_RESERVE)],
        method="SLSQP",
        options={"maxiter": MAX_CLIMB_ITERATIONS, "ftol": 1e-3},
    )
    return np.clip(found.x[:n], low, high)


def _climb_repeatedly(evaluation: Evaluation, start: np.ndarray) -> None:
    """Climb from a point as long as it improves enough."""
    everything = np.ones(len(evaluation.problem.requirements), dtype=bool)
    point = start
    if float(evaluation.evaluate(point[None]).min()) < FAR_RESERVE:
        point = _descend(evaluation, point)
    for _ in range(MAX_CLIMBS):
        before = float(evaluation.evaluate(point[None]).min())
        higher = climb(evaluation, point, everything)
        if float(evaluation.evaluate(higher[None]).min()) < before + MIN_CLIMB_IMPROVEMENT:
            break
        point = higher


def _descend(evaluation: Evaluation, start: np.ndarray) -> np.ndarray:
    """Return a point (n) with the least violation of all reserves."""
    low, high = evaluation.problem.low, evaluation.problem.high

    def residuals(point: np.ndarray) -> np.ndarray:
        hinges = np.maximum(0.0, TARGET_RESERVE - evaluation.evaluate(point[None])[0])
        return np.append(hinges, START_PULL_WEIGHT * (point - start))

    def slopes(point: np.ndarray) -> np.ndarray:
        short = evaluation.evaluate(point[None])[0] < TARGET_RESERVE
        return np.vstack(
            [
                -_reserve_slopes(evaluation, point) * short[:, None],
                START_PULL_WEIGHT * np.eye(len(point)),
            ]
        )

    found = least_squares(
        residuals,
        np.clip(start, low + 1e-9, high - 1e-9),
        jac=slopes,
        bounds=(low, high),
        xtol=1e-4,
        ftol=1e-2,
        gtol=1e-7,
        max_nfev=MAX_CLIMB_ITERATIONS,
    )
    return np.clip(found.x, low, high)


def _reserve_slopes(evaluation: Evaluation, point: np.ndarray) -> np.ndarray:
    """Return the derivatives of the reserves (R, n); 0 for coordinates without effect."""
    problem = evaluation.problem
    moving = np.flatnonzero(problem.matters)
    steps = np.where(point + LOG_GAIN_STEP > problem.high, -LOG_GAIN_STEP, LOG_GAIN_STEP)
    rows = evaluation.evaluate(np.vstack([point, point + np.diag(steps)[moving]]))
    found = np.zeros((rows.shape[1], len(point)))
    found[:, moving] = ((rows[1:] - rows[0]) / steps[moving, None]).T
    return found


def _by_promise(evaluation: Evaluation, points: Sequence[np.ndarray]) -> list[np.ndarray]:
    """Return points by their smallest reserve, the largest first."""
    reserves = evaluation.evaluate(np.array(points)).min(axis=1, initial=np.inf)
    return [points[index] for index in np.argsort(-reserves, kind="stable")]

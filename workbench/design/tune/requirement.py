"""What a wish asks of one vehicle, and how far a value is from it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.tune.case import NOMINAL, Case, Robustness
from workbench.design.tune.metric import LOOP, shown
from workbench.design.tune.wish import Wish

HOPELESS = -12.0
"""The reserve of a value that is not there: the flight diverged, or the loop is unstable."""


@dataclass(frozen=True)
class Requirement:
    """A wish as it counts in one case.

    Attributes:
        wish: whose it is.
        case: which vehicle.
        bound: the wish's own, or a relaxed one in a corner.
    """

    wish: Wish
    case: Case
    bound: float

    def __str__(self) -> str:
        wish = self.wish
        sign = ">=" if wish.at_least else "<="
        text = f"{wish.name} {sign} {shown(wish.metric, self.bound)}"
        return text if self.case == NOMINAL else f"{text} with {self.case}"

    def reserves(self, values: np.ndarray) -> np.ndarray:
        """Return how far values are on the right side, as shares of the bound; below 0 is short.

        Far on the wrong side the share grows as its logarithm, so that a search that starts
        there is not ruled by it.
        """
        sign = 1.0 if self.wish.at_least else -1.0
        scale = max(abs(self.bound), self.wish.metric.scale)
        with np.errstate(invalid="ignore"):
            share = sign * (np.asarray(values, dtype=float) - self.bound) / scale
        share = np.where(share < -1.0, -1.0 - np.log(np.maximum(-share, 1.0)), share)
        share = np.where(np.isnan(share), HOPELESS, share)
        return np.asarray(np.clip(share, HOPELESS, -HOPELESS))

    def met(self, value: float) -> bool:
        """Whether a value is as required; a NaN never is."""
        return value >= self.bound if self.wish.at_least else value <= self.bound


def requirements(
    wishes: Sequence[Wish], cases: Sequence[Case], robustness: Robustness
) -> tuple[Requirement, ...]:
    """Return what wishes ask of the vehicle as described, and of its corners.

    In a corner margins and overshoot count, relaxed; rise time, rotor use and noise follow from
    the vehicle there more than from its gains.
    """
    found = []
    for case in cases:
        for wish in wishes:
            bound = wish.bound if case == NOMINAL else _relaxed(wish, robustness)
            if bound is not None:
                found.append(Requirement(wish, case, bound))
    return tuple(found)


def _relaxed(wish: Wish, robustness: Robustness) -> float | None:
    """Return what is asked of a corner, None if nothing."""
    metric = wish.metric
    if metric.name == "overshoot" and not wish.at_least:
        return robustness.overshoot_factor * max(wish.bound, metric.scale)
    if metric.kind != LOOP or not wish.at_least or metric.name == "bandwidth":
        return None
    share = robustness.margin_share
    if metric.name == "gain_margin":  # a factor: its logarithm is what shrinks
        return math.exp(share * math.log(wish.bound))
    return share * wish.bound

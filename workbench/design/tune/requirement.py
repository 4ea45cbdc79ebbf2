"""What a wish asks of one vehicle, and how far a value is from it."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.design.metrics import LOOP, shown
from workbench.design.tune.case import NOMINAL, Case, Robustness
from workbench.design.tune.wish import GUARD, Wish

HOPELESS = -12.0
"""The reserve of a value that is not there: the flight diverged, or the loop is unstable."""


@dataclass(frozen=True)
class Requirement:
    """A wish as it counts in one case.

    Attributes:
        wish: whose it is.
        case: which vehicle.
        bound: the wish's own, or a relaxed one in a corner.
        widened: the bound that a default had before it gave way to what the rule's gains reach;
            None if it did not.
    """

    wish: Wish
    case: Case
    bound: float
    widened: float | None = None

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

    def meets_unwidened(self, value: float) -> bool:
        """Whether a value is as it was wished before the bound gave way."""
        bound = self.bound if self.widened is None else self.widened
        return value >= bound if self.wish.at_least else value <= bound


NO_INTEGRAL = (
    "a law without integral action leaves an error where mass, drag or wind are not as it knows "
    "them, which higher gains make smaller and do not remove: state the mass in the description, "
    "narrow `robustness` in a wishes file, or fly a law that has it, as --controller pid"
)
"""Why a steady-state error stays, and what to do."""


def shortfall(required: Requirement, value: float, smallest: float) -> str:
    """Return in a sentence what is kept of a default that gave way, and why.

    Args:
        required: with a widened bound.
        value: of the gains that were found.
        smallest: the best value of a candidate that met all else.
    """
    metric, sign = required.wish.metric, ">=" if required.wish.at_least else "<="
    assert required.widened is not None
    said = (
        f"{required.wish.name} stays at {shown(metric, value)} with {required.case}: a good flight "
        f"has {sign} {shown(metric, required.widened)} there, which the rule's gains do not reach, "
        f"so {sign} {shown(metric, required.bound)} was asked for; the best with all else met had "
        f"{shown(metric, smallest)}"
    )
    return f"{said}; {NO_INTEGRAL}" if metric.name == "steady_state_error" else said


def requirements(
    wishes: Sequence[Wish], cases: Sequence[Case], robustness: Robustness
) -> tuple[Requirement, ...]:
    """Return what wishes ask of the vehicle as described, and of its corners.

    In a corner margins, overshoot and steady-state error count, relaxed; rise time, rotor use and
    noise follow from the vehicle there more than from its gains. What keeps a loop that nobody
    asked about counts for the vehicle as described.
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
    if wish.origin == GUARD:
        return None
    if metric.name in ("overshoot", "steady_state_error") and not wish.at_least:
        return robustness.overshoot_factor * max(wish.bound, metric.scale)
    if metric.kind != LOOP or not wish.at_least or metric.name == "bandwidth":
        return None
    share = robustness.margin_share
    if metric.name == "gain_margin":  # a factor: its logarithm is what shrinks
        return math.exp(share * math.log(wish.bound))
    return share * wish.bound

"""The requirements of wishes on one vehicle, and the distance of values from them.

In addition to the user's wishes, a run requires properties of any good flight, and keeps the
margins of other loops.
"""

import dataclasses
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from workbench.control.controller import Controller
from workbench.design.metrics import LOOP_KIND, find_metric
from workbench.design.tune.case import NOMINAL_CASE, Robustness, VehicleCase
from workbench.design.tune.variables import loop_of
from workbench.design.tune.wish import DEFAULT_ORIGIN, GUARD_ORIGIN, Wish
from workbench.scenario.axes import AXIS_NAMES

MISSING_VALUE_RESERVE = -12.0
"""The reserve of a missing value: the flight diverged, or the loop is unstable."""
MAX_WISHED_OVERSHOOT_PCT = 5.0
MAX_WISHED_ERROR_PCT = 5.0
"""Most [%]."""
MIN_WISHED_MARGINS = {"phase_margin": math.radians(40.0), "disk_margin": 0.6}
"""Least."""
RISE_TIME_FACTOR = 1.3
"""Limit of the rise time, as a factor on that with the gains of the rule."""
LIMIT_ROOM_FACTOR = 0.9
"""Tolerance added to the value for the rule's gains, if these do not meet a limit."""
LIMIT_DIGITS = 3


@dataclass(frozen=True)
class Requirement:
    """A wish in one case.

    Attributes:
        wish: the original one.
        case: the vehicle.
        bound: that of the wish, or a relaxed one in a corner.
        widened: original bound of a default that was widened to what the rule's gains reach; None
            if it was not.
    """

    wish: Wish
    case: VehicleCase
    bound: float
    widened: float | None = None

    def __str__(self) -> str:
        wish = self.wish
        sign = ">=" if wish.at_least else "<="
        text = f"{wish.name} {sign} {wish.metric.text(self.bound)}"
        return text if self.case == NOMINAL_CASE else f"{text} with {self.case}"

    def reserves(self, values: np.ndarray) -> np.ndarray:
        """Return the reserves of values, as shares of the bound; negative if it is violated.

        Large violations grow logarithmically, so that they do not dominate a search that starts
        there.
        """
        sign = 1.0 if self.wish.at_least else -1.0
        scale = max(abs(self.bound), self.wish.metric.scale)
        with np.errstate(invalid="ignore"):
            share = sign * (np.asarray(values, dtype=float) - self.bound) / scale
        share = np.where(share < -1.0, -1.0 - np.log(np.maximum(-share, 1.0)), share)
        share = np.where(np.isnan(share), MISSING_VALUE_RESERVE, share)
        return np.asarray(np.clip(share, MISSING_VALUE_RESERVE, -MISSING_VALUE_RESERVE))

    def reserve(self, value: float) -> float:
        """Return the reserve of one value, see `reserves`."""
        return float(self.reserves(np.array([value]))[0])

    def met(self, value: float) -> bool:
        """Whether a value meets the requirement; a NaN never does."""
        return value >= self.bound if self.wish.at_least else value <= self.bound

    def meets_unwidened(self, value: float) -> bool:
        """Whether a value meets the original bound of the wish."""
        bound = self.bound if self.widened is None else self.widened
        return value >= bound if self.wish.at_least else value <= bound


NO_INTEGRAL_TEXT = (
    "a law without integral action leaves an error where mass, drag or wind are not as it knows "
    "them, which higher gains make smaller and do not remove: state the mass in the description, "
    "narrow `robustness` in a wishes file, or fly a law that has it, as --controller pid"
)
"""Why a steady-state error remains, and what to do."""


def shortfall(required: Requirement, value: float, smallest: float) -> str:
    """Return a sentence on a default that was widened, and why.

    Args:
        required: with a widened bound.
        value: with the gains found.
        smallest: the best value of a candidate that met all other requirements.
    """
    metric, sign = required.wish.metric, ">=" if required.wish.at_least else "<="
    assert required.widened is not None
    said = (
        f"{required.wish.name} stays at {metric.text(value)} with {required.case}: a good "
        "flight "
        f"has {sign} {metric.text(required.widened)} there, which the law's own gains do "
        "not "
        f"reach, so {sign} {metric.text(required.bound)} was asked for; the best with all "
        "else "
        "met had "
        f"{metric.text(smallest)}"
    )
    return f"{said}; {NO_INTEGRAL_TEXT}" if metric.name == "steady_state_error" else said


def requirements(
    wishes: Sequence[Wish], cases: Sequence[VehicleCase], robustness: Robustness
) -> tuple[Requirement, ...]:
    """Return the requirements of wishes on the vehicle as described, and on its corners.

    In a corner margins, overshoot and steady-state error count, with relaxed bounds; rise time,
    rotor use and noise depend more on the vehicle there than on its gains. Guards of other loops
    count only for the vehicle as described.
    """
    found = []
    for case in cases:
        for wish in wishes:
            bound = wish.bound if case == NOMINAL_CASE else _relaxed(wish, robustness)
            if bound is not None:
                found.append(Requirement(wish, case, bound))
    return tuple(found)


def _relaxed(wish: Wish, robustness: Robustness) -> float | None:
    """Return the requirement on a corner, or None."""
    metric = wish.metric
    if wish.origin == GUARD_ORIGIN:
        return None
    if metric.name in ("overshoot", "steady_state_error") and not wish.at_least:
        return robustness.overshoot_factor * max(wish.bound, metric.scale)
    if metric.kind != LOOP_KIND or not wish.at_least or metric.name == "bandwidth":
        return None
    share = robustness.margin_share
    if metric.name == "gain_margin":  # a factor: its logarithm shrinks
        return math.exp(share * math.log(wish.bound))
    return share * wish.bound


def wished_quantities(law: Controller) -> list[Wish]:
    """Return the default wishes with the limits of any good flight.

    The loops are those that are closed while a pilot steers.

    Args:
        law: with the loops.
    """
    limits = {
        "rise_time": math.inf,
        "overshoot": MAX_WISHED_OVERSHOOT_PCT,
        "steady_state_error": MAX_WISHED_ERROR_PCT,
    }
    wishes = [
        Wish(axis, find_metric(name), False, limit)
        for axis in AXIS_NAMES
        for name, limit in limits.items()
    ]
    wishes += [
        Wish(loop.name, find_metric(name), True, least)
        for loop in law.loops
        if not loop.hold
        for name, least in MIN_WISHED_MARGINS.items()
    ]
    return wishes


def default_wishes(quantities: Sequence[Wish], reached: Sequence[float]) -> list[Wish]:
    """Return the default wishes for a vehicle.

    Args:
        quantities: see `wished_quantities`.
        reached: value of each with the rule's gains.
    """
    found = []
    for wish, value in zip(quantities, reached, strict=True):
        bound = wish.bound
        if wish.metric.name == "rise_time":
            bound = RISE_TIME_FACTOR * value
        elif not Requirement(wish, NOMINAL_CASE, bound).met(value):
            bound = _with_room(wish, value)
        if math.isfinite(bound) and wish.metric.minimum <= bound <= wish.metric.maximum:
            found.append(dataclasses.replace(wish, bound=float(f"{bound:.{LIMIT_DIGITS}g}")))
    return found


def completed_wishes(wishes: Sequence[Wish], defaults: Sequence[Wish]) -> list[Wish]:
    """Return wishes, with the defaults for quantities without a wish."""
    named = {wish.name for wish in wishes}
    return [*wishes, *(wish for wish in defaults if wish.name not in named)]


def guard_wishes(
    reached: Sequence[float], present: Sequence[float], quantities: Sequence[Wish]
) -> list[Wish]:
    """Return wishes that keep the margins of loops without a written wish.

    Each keeps 90 % of the smaller one of its present margin and that with the rule's gains: a loop
    that is slow at present has excessive margins, and must be allowed to become faster. A loop
    involved in a wished step keeps no more than the usual margins.

    Args:
        reached: value of each quantity with the rule's gains.
        present: value of each with the initial gains of the run.
        quantities: see `guarded_quantities`.
    """
    found = []
    for wish, rule, now in zip(quantities, reached, present, strict=True):
        bound = min(wish.bound, LIMIT_ROOM_FACTOR * min(rule, now))
        if wish.metric.minimum < bound <= wish.metric.maximum:
            found.append(dataclasses.replace(wish, bound=bound))
    return found


def guarded_quantities(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return the margins of loops without a written wish, with their upper limits.

    Args:
        law: with the loops.
        wishes: all of them; a default limit on a loop involved in a wished step is sufficient.
    """
    known = {wish.name for wish in wishes}
    asked = [wish.subject for wish in wishes if wish.is_written]
    named = {loop.name for loop in (loop_of(law, each) for each in asked) if loop}
    through = {loop.name for loop in law.loops if not loop.hold and loop.axis in asked}
    found = []
    for loop in (loop.name for loop in law.loops if loop.name not in named):
        for name, least in MIN_WISHED_MARGINS.items():
            bound = least if loop in through else math.inf
            wish = Wish(loop, find_metric(name), True, bound, GUARD_ORIGIN)
            if loop not in through or wish.name not in known:
                found.append(wish)
    return found


def softened_requirements(
    required: Sequence[Requirement], reached: np.ndarray
) -> list[Requirement]:
    """Return requirements; those of defaults in corners are no stricter than the rule's gains meet.

    Args:
        required: by all wishes in all cases (R).
        reached: their values with the rule's gains (R).
    """
    found = []
    for requirement, value in zip(required, reached, strict=True):
        wish = requirement.wish
        if (
            wish.origin == DEFAULT_ORIGIN
            and requirement.case != NOMINAL_CASE
            and not requirement.met(value)
        ):
            bound = _with_room(wish, float(value))
            if not math.isfinite(bound) or (wish.at_least and bound <= 0.0):
                continue
            requirement = dataclasses.replace(requirement, bound=bound, widened=requirement.bound)
        found.append(requirement)
    return found


def _with_room(wish: Wish, value: float) -> float:
    """Return a limit that a value meets."""
    return LIMIT_ROOM_FACTOR * value if wish.at_least else value / LIMIT_ROOM_FACTOR

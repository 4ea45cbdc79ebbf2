"""Wishes that nobody has to write: about what the rule's gains reach on the vehicle itself."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np

from workbench.control.controller import Controller
from workbench.design.metrics import find_metric
from workbench.design.tune.case import NOMINAL
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import loop_of
from workbench.design.tune.wish import DEFAULT, GUARD, Wish
from workbench.scenario.axes import AXES

OVERSHOOT = 5.0
STEADY_STATE_ERROR = 5.0
"""Most [%]."""
PHASE_MARGIN = math.radians(40.0)
DISK_MARGIN = 0.6
"""Least."""
SLOWER = 1.3
"""A rise may take so many times as long as with the rule's gains."""
ROOM = 0.9
"""Where the rule's gains do not reach a limit, it is what they reach, and so much room."""
DIGITS = 3


def wished_quantities(law: Controller) -> list[Wish]:
    """Return the default wishes with the limits that any good flight keeps.

    The loops are those that are closed while a pilot steers.

    Args:
        law: whose loops.
    """
    limits = {
        "rise_time": math.inf,
        "overshoot": OVERSHOOT,
        "steady_state_error": STEADY_STATE_ERROR,
    }
    wishes = [
        Wish(axis, find_metric(name), False, limit)
        for axis in AXES
        for name, limit in limits.items()
    ]
    margins = {"phase_margin": PHASE_MARGIN, "disk_margin": DISK_MARGIN}
    wishes += [
        Wish(loop.name, find_metric(name), True, least)
        for loop in law.loops
        if not loop.hold
        for name, least in margins.items()
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
            bound = SLOWER * value
        elif not Requirement(wish, NOMINAL, bound).met(value):
            bound = _with_room(wish, value)
        if math.isfinite(bound) and wish.metric.minimum <= bound <= wish.metric.maximum:
            found.append(dataclasses.replace(wish, bound=float(f"{bound:.{DIGITS}g}")))
    return found


def completed(wishes: Sequence[Wish], defaults: Sequence[Wish]) -> list[Wish]:
    """Return wishes and those defaults whose number nobody has a wish about."""
    named = {wish.name for wish in wishes}
    return [*wishes, *(wish for wish in defaults if wish.name not in named)]


def guards(
    reached: Sequence[float], present: Sequence[float], quantities: Sequence[Wish]
) -> list[Wish]:
    """Return wishes that keep the margins of loops which nobody asked about.

    Each keeps 90 % of the smaller of what it has now and what it has with the rule's gains: a loop
    that is slow now has more than it needs, and must not stay slow for it. One that a wished step
    goes through keeps no more than the usual margins.

    Args:
        reached: value of each quantity with the rule's gains.
        present: and with the gains that the run starts from.
        quantities: see `guarded_quantities`.
    """
    found = []
    for wish, rule, now in zip(quantities, reached, present, strict=True):
        bound = min(wish.bound, ROOM * min(rule, now))
        if wish.metric.minimum < bound <= wish.metric.maximum:
            found.append(dataclasses.replace(wish, bound=bound))
    return found


def guarded_quantities(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return the margins of loops that no written wish names, with the most that is kept of them.

    Args:
        law: whose loops.
        wishes: all of them; where a default limits a loop that a wished step goes through, that
            will do.
    """
    usual = {"phase_margin": PHASE_MARGIN, "disk_margin": DISK_MARGIN}
    known = {wish.name for wish in wishes}
    asked = [wish.subject for wish in wishes if wish.is_written]
    named = {loop.name for loop in (loop_of(law, each) for each in asked) if loop}
    through = {loop.name for loop in law.loops if not loop.hold and loop.axis in asked}
    found = []
    for loop in (loop.name for loop in law.loops if loop.name not in named):
        for name, least in usual.items():
            bound = least if loop in through else math.inf
            wish = Wish(loop, find_metric(name), True, bound, GUARD)
            if loop not in through or wish.name not in known:
                found.append(wish)
    return found


def softened(required: Sequence[Requirement], reached: np.ndarray) -> list[Requirement]:
    """Return requirements, those of default wishes in corners no harder than the rule manages.

    Args:
        required: by all wishes in all cases (R).
        reached: their values with the rule's gains (R).
    """
    found = []
    for requirement, value in zip(required, reached, strict=True):
        wish = requirement.wish
        if wish.origin == DEFAULT and requirement.case != NOMINAL and not requirement.met(value):
            bound = _with_room(wish, float(value))
            if not math.isfinite(bound) or (wish.at_least and bound <= 0.0):
                continue
            requirement = dataclasses.replace(requirement, bound=bound, widened=requirement.bound)
        found.append(requirement)
    return found


def _with_room(wish: Wish, value: float) -> float:
    """Return a limit that a value keeps."""
    return ROOM * value if wish.at_least else value / ROOM

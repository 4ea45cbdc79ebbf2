"""A wish: a metric of an axis, of a loop or of the rotors, and its bound."""

import re
from collections.abc import Sequence
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller, load_controller
from workbench.design.metrics import (
    LOOP,
    ROTORS,
    STEP,
    WISHED,
    Metric,
    find_metric,
    shown,
    si_value,
)
from workbench.scenario.axes import AXES

DEFAULT = "default"
"""The origin of a wish that nobody wrote."""
GUARD = "guard"
"""The origin of a wish that keeps a loop which no written wish is about."""
ATTITUDES = ("roll", "pitch")
"""Angles that can be stepped, besides the axes."""
ATTITUDE_METRICS = ("rise_time", "settling_time", "overshoot")
"""Of such a step; it has no command that is flown, and so no rotor use."""
_NO_LOOPS = {"roll_rate": "roll", "pitch_rate": "pitch"}
"""What some laws have a loop for, and the loop in which others damp it."""
GROUPS = {"level": ("x", "y"), "tilt": ("roll", "pitch")}
"""Names for several subjects at once."""

_FORM = re.compile(
    r"(?P<subject>\w+)\s*\.\s*(?P<metric>\w+)\s*(?P<sign><=|>=|≤|≥|<|>)"
    r"\s*(?P<number>[-+]?[\d.]+(?:[eE][-+]?\d+)?)\s*(?P<unit>[A-Za-z%°]\S*)?"
)


@dataclass(frozen=True)
class Wish:
    """One bound on one number.

    Attributes:
        subject: an axis, a loop, or "rotors".
        metric: of it.
        at_least: whether the bound is the smallest value that will do, else the largest.
        bound: in the metric's unit.
        origin: where it was written, or `DEFAULT`.
    """

    subject: str
    metric: Metric
    at_least: bool
    bound: float
    origin: str = DEFAULT

    @property
    def name(self) -> str:
        """Of the number that is bounded, as x.rise_time."""
        return f"{self.subject}.{self.metric.name}"

    @property
    def is_flown(self) -> bool:
        """Whether it is about a step that is flown; that of an attitude is the linear model's."""
        return self.metric.kind == STEP and self.subject in AXES

    @property
    def is_written(self) -> bool:
        """Whether somebody wrote it."""
        return self.origin not in (DEFAULT, GUARD)

    @property
    def key(self) -> tuple[str, bool]:
        """What no two wishes may bound differently."""
        return self.name, self.at_least

    def __str__(self) -> str:
        return f"{self.name} {'>=' if self.at_least else '<='} {shown(self.metric, self.bound)}"


def parse_wish(text: str, origin: str = "--wish", law: Controller | None = None) -> list[Wish]:
    """Return the wishes that a text as `x.rise_time <= 0.4 s` stands for, one for each subject.

    Args:
        text: of the form above.
        origin: where it was written.
        law: whose loops; the default one's where none is given.

    Raises:
        WorkbenchError: if it is not of that form, or asks for what there is not.
    """
    form = _FORM.fullmatch(text.strip())
    if not form:
        raise WorkbenchError(
            f"'{text[:60]}' is no wish: write SUBJECT.METRIC<=VALUE or >=, as x.rise_time<=0.4 or "
            "pitch.phase_margin>=45deg"
        )
    metric = find_metric(form["metric"], WISHED)
    subjects = members(form["subject"], metric, law or load_controller())
    try:
        number = float(form["number"])
    except ValueError:
        raise WorkbenchError(f"'{text[:60]}': {form['number'][:20]} is no number") from None
    bound = si_value(metric, number, form["unit"] or "")
    at_least = form["sign"] in (">=", "≥", ">")
    return [Wish(subject, metric, at_least, bound, origin) for subject in subjects]


def merged(wishes: Sequence[Wish]) -> list[Wish]:
    """Return wishes with each bound once; where two say it the later counts.

    Raises:
        WorkbenchError: if two contradict each other.
    """
    found = {wish.key: wish for wish in wishes}
    for (name, at_least), wish in found.items():
        other = found.get((name, not at_least))
        if at_least and other and wish.bound > other.bound:
            raise WorkbenchError(f"{wish} contradicts {other}: nothing is both, so drop one")
    return list(found.values())


def subjects_of(metric: Metric, law: Controller) -> tuple[str, ...]:
    """Return the axes, angles, loops, loop points or rotors that have a metric.

    A loop is cut at its actuator, or at the loop point that is named.
    """
    if metric.kind == ROTORS:
        return ("rotors",)
    loops = [loop.name for loop in law.loops]
    if metric.kind == LOOP:
        return (*loops, *law.points)
    angles = ATTITUDES if metric.name in ATTITUDE_METRICS else ()
    return (*AXES, *(angle for angle in angles if angle in loops))


def groups_of(metric: Metric, law: Controller) -> tuple[str, ...]:
    """Return the names that stand for several subjects which have a metric."""
    known = subjects_of(metric, law)
    return tuple(group for group, each in GROUPS.items() if set(each) <= set(known))


def members(name: str, metric: Metric, law: Controller) -> tuple[str, ...]:
    """Return the subjects of a name that have a metric.

    Raises:
        WorkbenchError: if there are none, with those that have it.
    """
    known, groups = subjects_of(metric, law), groups_of(metric, law)
    if name in known:
        return (name,)
    if name in groups:
        return GROUPS[name]
    loops = [loop.name for loop in law.loops]
    if name in (*AXES, *GROUPS, *loops, *law.points, "rotors"):
        listed = ", ".join((*known, *groups))
        raise WorkbenchError(f"{name} has no {metric.name}: that is of {listed}")
    if _NO_LOOPS.get(name) in loops:
        loop = _NO_LOOPS[name]
        raise WorkbenchError(
            f"{law.name} has no loop {name}: it damps the rate in the loop {loop}, so wish for "
            f"{loop}.{metric.name}"
        )
    kind = {STEP: "axis", LOOP: "loop", ROTORS: "subject"}[metric.kind]
    raise unknown_name(kind, name, (*known, *groups))

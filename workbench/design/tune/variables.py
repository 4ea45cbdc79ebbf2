"""The variables of a search: logarithms of gains, some of them kept equal.

On a vehicle that is symmetric in x and y, gains and wishes may treat both as one.
"""

import dataclasses
import math
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from workbench.control.controller import Controller
from workbench.control.loop import Loop
from workbench.design.tune.wish import Wish
from workbench.parameters.parameter_table import ParameterTable
from workbench.scenario.axes import AXIS_NAMES

MIN_GAIN_SHARE = 1e-3
"""Lower limit of a gain that may be 0, as a share of its largest value, as 0 has no logarithm."""
SYMMETRIC_TOLERANCE = 0.1
"""Largest relative difference of the rule's gains for roll and pitch of a symmetric vehicle."""
TUNED_GAIN_DIGITS = 4
"""Number of significant digits of a gain found; more would be noise."""


def loop_of(law: Controller, subject: str) -> Loop | None:
    """Return the loop with a name or a loop point; None for an axis, and for other points."""
    for loop in law.loops:
        if subject == loop.name:
            return loop
    return next((each for each in law.loops if subject in (each.error, each.actuator)), None)


def loops_for(law: Controller, subject: str) -> tuple[Loop, ...]:
    """Return the loops with gains that affect an axis, a loop or a loop point.

    An axis depends on all its loops, and a loop that holds a position is the outermost one.
    """
    loop = loop_of(law, subject)
    what = (loop.axis or loop.name) if loop else subject
    everything = loop is None and subject not in AXIS_NAMES  # the rotors, or a point of no loop
    inner = tuple(
        each
        for axis in (*AXIS_NAMES, "")
        for each in law.loops
        if each.axis == axis and not each.hold and (everything or what in (axis, each.name))
    )
    return (*inner, loop) if loop and loop.hold else inner


def twin_gains(law: Controller) -> dict[str, str]:
    """Return the gains along x, with those along y that are equal on a symmetric vehicle."""
    return {
        one: other
        for along_x, along_y in loop_pairs(law)
        for one, other in zip(along_x.gains, along_y.gains, strict=False)
        if one != other
    }


def loop_pairs(law: Controller) -> list[tuple[Loop, Loop]]:
    """Return each loop along x, with its counterpart along y."""
    along_x, along_y = ([loop for loop in law.loops if loop.axis == axis] for axis in "xy")
    return list(zip(along_x, along_y, strict=False))


@dataclass(frozen=True)
class Variables:
    """The coordinates of a search: ln of a gain, or of several kept equal.

    Attributes:
        table: the rows of the gains.
        groups: names of the gains of each coordinate.
    """

    table: ParameterTable
    groups: tuple[tuple[str, ...], ...]

    @property
    def low(self) -> np.ndarray:
        """Smallest coordinates (n)."""
        rows = [self.table.find(group[0]) for group in self.groups]
        return np.log([row.minimum or MIN_GAIN_SHARE * row.maximum for row in rows])

    @property
    def high(self) -> np.ndarray:
        """Largest coordinates (n)."""
        return np.log([self.table.find(group[0]).maximum for group in self.groups])

    def point(self, gains: Mapping[str, float]) -> np.ndarray:
        """Return the coordinates (n) nearest to gains; the mean for tied ones."""
        tiny = math.exp(-30.0)
        means = [
            np.mean([math.log(max(tiny, gains[name])) for name in group]) for group in self.groups
        ]
        return np.clip(means, self.low, self.high)

    def gains(self, point: np.ndarray) -> dict[str, float]:
        """Return the gains at coordinates (n)."""
        values = np.exp(np.clip(point, self.low, self.high))
        return {
            name: float(value)
            for group, value in zip(self.groups, values, strict=True)
            for name in group
        }

    def rounded(self, point: np.ndarray) -> dict[str, float]:
        """Return the gains at coordinates (n) with few digits."""
        return {
            name: self.table.find(name).check(float(f"{value:.{TUNED_GAIN_DIGITS}g}"))
            for name, value in self.gains(point).items()
        }


def variables_for(
    law: Controller, subjects: Iterable[str], *, tied: bool, flown_set: int | None = None
) -> Variables:
    """Return the gains that affect axes and loops.

    Args:
        law: with the gains.
        subjects: axes and loops with wishes; "rotors" means all axes.
        tied: whether roll and pitch, and x and y, have equal gains.
        flown_set: the set of scheduled gains to tune.
    """
    loops = [loop for subject in subjects for loop in loops_for(law, subject)]
    names = dict.fromkeys(name for loop in loops for name in loop.gains)
    if law.schedule:
        names = dict.fromkeys(n for n in names if law.schedule.number_of(n) in (None, flown_set))
    table = law.table
    if not tied:
        return Variables(table, tuple((name,) for name in names))
    other = twin_gains(law)
    first = {twin: name for name, twin in other.items()}
    heads = dict.fromkeys(first.get(name, name) for name in names)
    return Variables(
        table, tuple((name, other[name]) if name in other else (name,) for name in heads)
    )


def counterparts(law: Controller) -> dict[str, str]:
    """Return the counterparts along x of subjects along y: axes, loops and loop points."""
    found = {"y": "x"}
    for one, other in loop_pairs(law):
        found |= {other.name: one.name, other.error: one.error}
        if other.actuator:
            found[other.actuator] = one.actuator
    return found


def symmetric(law: Controller, rule: Mapping[str, float], wishes: Sequence[Wish]) -> bool:
    """Return whether x and y, roll and pitch should have equal gains.

    Args:
        law: with the gains.
        rule: the rule's gains for the vehicle.
        wishes: written ones; different ones for x and y need separate gains.
    """
    alike = all(
        abs(rule[one] - rule[other]) <= SYMMETRIC_TOLERANCE * max(rule[one], rule[other])
        for one, other in twin_gains(law).items()
    )
    along_x = counterparts(law)
    sides = [_subject_bounds(wishes, side) for side in (along_x.values(), along_x)]
    across = _subject_bounds(_swapped(law, wishes), along_x.values())
    return alike and (not all(sides) or sides[0] == across)


def mirrored_wishes(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return wishes along x or y for both."""
    known = {wish.key for wish in wishes}
    return [*wishes, *(wish for wish in _swapped(law, wishes) if wish.key not in known)]


def _swapped(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return the wishes with x and y exchanged."""
    along_x = counterparts(law)
    other = along_x | {one: another for another, one in along_x.items()}
    return [
        dataclasses.replace(wish, subject=other[wish.subject])
        for wish in wishes
        if wish.subject in other
    ]


def _subject_bounds(
    wishes: Sequence[Wish], subjects: Collection[str]
) -> set[tuple[str, bool, float]]:
    return {(*wish.key, wish.bound) for wish in wishes if wish.subject in subjects}

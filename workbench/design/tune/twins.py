"""Vehicles that are alike along x and y, and wishes that may treat both as one."""

import dataclasses
from collections.abc import Collection, Mapping, Sequence

from workbench.control.controller import Controller
from workbench.design.tune.variables import loop_pairs, twins
from workbench.design.tune.wish import Wish

ALIKE = 0.1
"""A vehicle is symmetric if the rule's gains for roll and pitch differ by no larger share."""


def counterparts(law: Controller) -> dict[str, str]:
    """Return the subjects along x of those along y: axes, loops and loop points."""
    found = {"y": "x"}
    for one, other in loop_pairs(law):
        found |= {other.name: one.name, other.error: one.error}
        if other.actuator:
            found[other.actuator] = one.actuator
    return found


def symmetric(law: Controller, rule: Mapping[str, float], wishes: Sequence[Wish]) -> bool:
    """Return whether x and y, roll and pitch should have equal gains.

    Args:
        law: whose gains.
        rule: the rule's gains for the vehicle.
        wishes: by somebody; where they ask different things of x and of y, they want two gains.
    """
    alike = all(
        abs(rule[one] - rule[other]) <= ALIKE * max(rule[one], rule[other])
        for one, other in twins(law).items()
    )
    along_x = counterparts(law)
    sides = [_bounds(wishes, side) for side in (along_x.values(), along_x)]
    across = _bounds(_swapped(law, wishes), along_x.values())
    return alike and (not all(sides) or sides[0] == across)


def mirrored(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return wishes along x or y for both."""
    known = {wish.key for wish in wishes}
    return [*wishes, *(wish for wish in _swapped(law, wishes) if wish.key not in known)]


def _swapped(law: Controller, wishes: Sequence[Wish]) -> list[Wish]:
    """Return the wishes along x and y, each for the other."""
    along_x = counterparts(law)
    other = along_x | {one: another for another, one in along_x.items()}
    return [
        dataclasses.replace(wish, subject=other[wish.subject])
        for wish in wishes
        if wish.subject in other
    ]


def _bounds(wishes: Sequence[Wish], subjects: Collection[str]) -> set[tuple[str, bool, float]]:
    return {(*wish.key, wish.bound) for wish in wishes if wish.subject in subjects}

"""Vehicles that are alike along x and y, and wishes that may treat both as one."""

import dataclasses
from collections.abc import Mapping, Sequence

from workbench.design.tune.variables import TWINS
from workbench.design.tune.wish import Wish

ALIKE = 0.1
"""A vehicle is symmetric if the rule's gains for roll and pitch differ by no larger share."""
PAIRS = (
    ("x", "y"),
    ("pitch", "roll"),
    ("velocity_x", "velocity_y"),
    ("position_x", "position_y"),
    ("pitch_error", "roll_error"),
    ("pitch_acceleration", "roll_acceleration"),
    ("acceleration_x", "acceleration_y"),
    ("velocity_x_error", "velocity_y_error"),
    ("position_x_error", "position_y_error"),
)
"""Subjects along x, and those along y."""
ALONG_X = {other: one for one, other in PAIRS}
"""The counterparts along x of subjects along y."""
_OTHER = {one: other for pair in PAIRS for one, other in (pair, pair[::-1])}


def symmetric(rule: Mapping[str, float], wishes: Sequence[Wish]) -> bool:
    """Return whether x and y, roll and pitch should have equal gains.

    Args:
        rule: the rule's gains for the vehicle.
        wishes: by somebody; where they ask different things of x and of y, they want two gains.
    """
    alike = all(
        abs(rule[one] - rule[other]) <= ALIKE * max(rule[one], rule[other])
        for one, other in TWINS.items()
    )
    sides = [_bounds(wishes, [pair[side] for pair in PAIRS]) for side in (0, 1)]
    across = _bounds(_swapped(wishes), [pair[0] for pair in PAIRS])
    return alike and (not all(sides) or sides[0] == across)


def mirrored(wishes: Sequence[Wish]) -> list[Wish]:
    """Return wishes along x or y for both."""
    known = {wish.key for wish in wishes}
    return [*wishes, *(wish for wish in _swapped(wishes) if wish.key not in known)]


def _swapped(wishes: Sequence[Wish]) -> list[Wish]:
    """Return the wishes along x and y, each for the other."""
    return [
        dataclasses.replace(wish, subject=_OTHER[wish.subject])
        for wish in wishes
        if wish.subject in _OTHER
    ]


def _bounds(wishes: Sequence[Wish], subjects: Sequence[str]) -> set[tuple[str, bool, float]]:
    return {(*wish.key, wish.bound) for wish in wishes if wish.subject in subjects}

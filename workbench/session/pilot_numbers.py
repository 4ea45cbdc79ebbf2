"""Checks of the numbers that a pilot gives."""

import math
from collections.abc import Sequence
from numbers import Real

from workbench.common.errors import WorkbenchError


def finite(what: str, values: Sequence[float], count: int) -> list[float]:
    """Return a given count of numbers as floats.

    Args:
        what: they are, for the message.
        values: from outside, so they may be anything.
        count: how many there must be.

    Raises:
        WorkbenchError: if there are more or fewer, or one is no finite number.
    """
    try:
        # Texts are left out, so that '123' is none of three numbers.
        numbers = [float(value) for value in values if not isinstance(value, str)]
    except (TypeError, ValueError, OverflowError):
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise WorkbenchError(f"{what} is {values!r:.60}: give it {count} finite number(s)")
    return numbers


def place_above(name: str, numbers: Sequence[float], standing: float) -> list[float]:
    """Return a place as floats, no lower than the drone stands [m].

    Raises:
        WorkbenchError: if it is none.
    """
    place = finite(name, numbers, 3)
    if place[2] < standing:
        raise WorkbenchError(
            f"cannot go to a height of {place[2]:g} m: the drone stands on the ground at "
            f"{standing:g} m"
        )
    return place


def check_height(what: str, height: object, standing: float, ceiling: float) -> None:
    """Refuse a height that no request can have [m].

    Args:
        what: is requested; only a take_off flies to a height.
        height: from outside, so it may be anything.
        standing: of the drone on the ground [m].
        ceiling: largest that is allowed [m].

    Raises:
        WorkbenchError: if it is no number, or no height to take off to.
    """
    if not isinstance(height, Real):
        raise WorkbenchError(f"the height of a {what} is {height!r:.60}: give it a number")
    if what == "take_off" and not standing < float(height) <= ceiling:
        raise WorkbenchError(
            f"the height of a take_off is {height:g} m: give it one above {standing:g} m, at "
            f"which the drone stands, up to the {ceiling:g} m of max_height"
        )

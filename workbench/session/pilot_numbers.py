"""Checks numbers from a pilot."""

import math
from collections.abc import Sequence
from numbers import Real

from workbench.common.errors import WorkbenchError


def finite(what: str, values: Sequence[float], count: int) -> list[float]:
    """Return an expected count of numbers as floats.

    Args:
        what: name of the numbers, for the message.
        values: untrusted input of any type.
        count: expected count.

    Raises:
        WorkbenchError: if the count is wrong, or a number is not finite.
    """
    try:
        # Exclude strings, so that '123' does not count as three numbers.
        numbers = [float(value) for value in values if not isinstance(value, str)]
    except (TypeError, ValueError, OverflowError):
        numbers = []
    if len(numbers) != count or not all(map(math.isfinite, numbers)):
        raise WorkbenchError(f"{what} is {values!r:.60}: give it {count} finite number(s)")
    return numbers


def place_above(name: str, numbers: Sequence[float], standing: float) -> list[float]:
    """Return a position as floats, no lower than the drone on the ground [m].

    Raises:
        WorkbenchError: if it is not a valid position.
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
        what: the request; only take_off has a height.
        height: untrusted input of any type.
        standing: height of the drone on the ground [m].
        ceiling: largest allowed height [m].

    Raises:
        WorkbenchError: if it is not a number, or not a height to take off to.
    """
    if not isinstance(height, Real):
        raise WorkbenchError(f"the height of a {what} is {height!r:.60}: give it a number")
    if what == "take_off" and not standing < float(height) <= ceiling:
        raise WorkbenchError(
            f"the height of a take_off is {height:g} m: give it one above {standing:g} m, at "
            f"which the drone stands, up to the {ceiling:g} m of max_height"
        )

"""The numbers that a pilot gives."""

import math
from collections.abc import Sequence

from workbench.errors import WorkbenchError


def finite(what: str, values: Sequence[float], count: int) -> list[float]:
    """Return so many numbers as floats.

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

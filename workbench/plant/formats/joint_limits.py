"""Limits of joints as published files write them."""

import math

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.vectors import float_triple
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import Freedom

REFUSED_JOINT_KINDS = ("screw", "gearbox")
"""Kinds of joints that tie two motions together, which Drake's continuous plant cannot."""
NO_LIMIT = 1e16
"""Gazebo's number for no limit, with either sign."""
_MAX_LIMIT = 1e9
"""Position of a joint from which on a limit means none [rad or m]."""


def limit_number(element: Element, text: str, default: float) -> float:
    """Return a limit from its text; other numbers of a file are never as large.

    Raises:
        WorkbenchError: naming the element, if it is not a number.
    """
    try:
        found = float(text) if text else default
    except ValueError:
        found = math.nan
    if math.isnan(found):
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag}> is '{shortened_text(text)}': give it a "
            "number"
        )
    return found


def has_range(freedom: Freedom) -> bool:
    """Return whether a freedom can move: limits of 0 to 0 mean fixed."""
    return freedom.lower < freedom.upper


def joint_limits(lower: float, upper: float) -> tuple[float, float]:
    """Return limits [rad or m], infinite where a large number, or an inverted pair, means none."""
    if lower > upper:
        return -math.inf, math.inf
    return (
        -math.inf if lower <= -_MAX_LIMIT else lower,
        math.inf if upper >= _MAX_LIMIT else upper,
    )


def planar_freedoms(normal: tuple[float, float, float]) -> tuple[Freedom, ...]:
    """Return two translations in the plane across a unit vector, and the turn about it.

    The translations are those of Drake: x and y, turned by the least rotation of z to the vector.
    """
    n, z = np.array(normal), np.array([0.0, 0.0, 1.0])
    first, second = np.array([1.0, 0.0, 0.0]), np.array([0.0, -1.0, 0.0])  # where n is -z
    if n[2] > -1.0 + 1e-12:
        first, second = (each - n @ each / (1.0 + n[2]) * (n + z) for each in (first, -second))
    return (
        Freedom("prismatic", float_triple(first)),
        Freedom("prismatic", float_triple(second)),
        Freedom("revolute", normal),
    )


def drive_limit(element: Element | None, text: str) -> float:
    """Return a limit of effort or velocity, infinite for none: no number, 0, or -1.

    Raises:
        WorkbenchError: naming the element, if it is not a number.
    """
    stated = limit_number(element, text, math.inf) if element is not None else math.inf
    return stated if 0.0 < stated < _MAX_LIMIT else math.inf

"""Read numbers, vectors and poses from XML attributes, as in URDF and MJCF."""

import math
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.xml import Element, element_location

MAX_URDF_NUMBER = 1e6
"""Limit of the lengths, masses and moments of a drone, in their units."""


def attribute_numbers(element: Element, attribute: str, default: str) -> tuple[float, ...]:
    """Return the numbers in an attribute.

    Raises:
        WorkbenchError: naming the element, if one is not a finite number, or too large.
    """
    text = element.get(attribute, default)
    try:
        found = tuple(float(word) for word in text.split())
    except ValueError:
        found = (math.nan,)
    if not all(abs(number) <= MAX_URDF_NUMBER for number in found):
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag} {attribute}='{shortened_text(text)}'>: "
            f"give it numbers within ±{MAX_URDF_NUMBER:g}"
        )
    return found


def attribute_number(element: Element, attribute: str, default: str | None = None) -> float:
    """Return the number in an attribute.

    Raises:
        WorkbenchError: naming the element, if it is missing or not one number.
    """
    if default is None and attribute not in element.attrib:
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag}> without {attribute}: add it"
        )
    found = attribute_numbers(element, attribute, default or "")
    if len(found) != 1:
        raise _count_error(element, attribute, 1)
    return found[0]


def positive_attribute(element: Element, attribute: str) -> float:
    """Return the positive number in an attribute.

    Raises:
        WorkbenchError: naming the element, if it is not positive.
    """
    found = attribute_number(element, attribute)
    if found <= 0.0:
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag} {attribute}='{found:g}'>: give it a "
            "positive number"
        )
    return found


def attribute_triple(element: Element, attribute: str, default: str) -> tuple[float, float, float]:
    """Return the three numbers in an attribute.

    Raises:
        WorkbenchError: naming the element, if there are more or fewer.
    """
    found = attribute_numbers(element, attribute, default)
    if len(found) != 3:
        raise _count_error(element, attribute, 3)
    return (found[0], found[1], found[2])


def origin(element: Element) -> RigidTransform:
    """Return the pose in the `<origin xyz rpy>` of an element; the identity without one."""
    found = element.find("origin")
    if not isinstance(found, Element):
        return RigidTransform()
    xyz = attribute_triple(found, "xyz", "0 0 0")
    rpy = attribute_triple(found, "rpy", "0 0 0")
    return RigidTransform(RollPitchYaw(np.array(rpy)), np.array(xyz))


def shortened_text(text: str) -> str:
    """Return a text shortened for a message."""
    text = " ".join(text.split())
    return text if len(text) <= 80 else f"{text[:77]}..."


def listed_names(names: Sequence[str]) -> str:
    """Return the first dozen names for a message."""
    more = f" and {len(names) - 12} more" if len(names) > 12 else ""
    return ", ".join(map(shortened_text, names[:12])) + more


def _count_error(element: Element, attribute: str, count: int) -> WorkbenchError:
    text = shortened_text(element.get(attribute, ""))
    return WorkbenchError(
        f"{element_location(element)}: <{element.tag} {attribute}='{text}'>: give it {count} "
        f"{'number' if count == 1 else 'numbers'}"
    )


def is_zero_text(text: str) -> bool:
    """Return whether a text is the number zero, or empty."""
    try:
        return float(text or "0") == 0.0
    except ValueError:
        return False

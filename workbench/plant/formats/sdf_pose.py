"""Read poses, numbers and truth values as SDF writes them: of sensors in any format, and of SDF."""

import math

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import MAX_URDF_NUMBER, shortened_text
from workbench.plant.formats.xml import Element, element_location

_TRUTH_VALUES = {"true": True, "1": True, "false": False, "0": False}
_MIN_QUATERNION_NORM = 1e-6


def element_text(element: Element) -> str:
    """Return the text of an element without surrounding spaces, or ""."""
    return (element.text or "").strip()


def sdf_numbers(element: Element, *counts: int) -> tuple[float, ...]:
    """Return the numbers in an element's text.

    Args:
        element: the element.
        counts: allowed numbers of them.

    Raises:
        WorkbenchError: naming the element, if one is not a finite number or too large, or if their
            count is wrong.
    """
    text = element_text(element)
    try:
        found = tuple(float(word) for word in text.split())
    except ValueError:
        found = (math.nan,)
    if len(found) not in counts or not all(abs(number) <= MAX_URDF_NUMBER for number in found):
        wanted = " or ".join(map(str, counts))
        raise _fault(
            element,
            f"<{element.tag}>{shortened_text(text)}</{element.tag}>: give it {wanted} "
            f"{'number' if counts == (1,) else 'numbers'} within ±{MAX_URDF_NUMBER:g}",
        )
    return found


def sdf_flag(element: Element, text: str) -> bool:
    """Return the truth value in a text of an element; an empty text is false.

    Raises:
        WorkbenchError: naming the element, if it is neither true nor false.
    """
    if not text:
        return False
    if text.lower() not in _TRUTH_VALUES:
        raise _fault(
            element,
            f"'{shortened_text(text)}' of <{element.tag}> is neither true nor false: write one",
        )
    return _TRUTH_VALUES[text.lower()]


def sdf_pose(element: Element | None) -> RigidTransform:
    """Return the pose in a `<pose>`; a missing or empty one is the identity.

    Raises:
        WorkbenchError: naming the element, if its numbers or attributes are invalid.
    """
    if element is None or not (text := element_text(element)):
        return RigidTransform()
    rotation_format = element.get("rotation_format", "").strip() or "euler_rpy"
    if rotation_format == "quat_xyzw":
        x, y, z, *xyzw = sdf_numbers(element, 7)
        length = math.hypot(*xyzw)
        if length < _MIN_QUATERNION_NORM:
            raise _fault(
                element, f"<pose>{shortened_text(text)}</pose>: its quaternion has no length"
            )
        qx, qy, qz, qw = (component / length for component in xyzw)
        return RigidTransform(RotationMatrix(Quaternion(qw, qx, qy, qz)), np.array([x, y, z]))
    if rotation_format != "euler_rpy":
        raise _fault(
            element,
            f"<pose rotation_format='{shortened_text(rotation_format)}'>: write euler_rpy or "
            "quat_xyzw",
        )
    x, y, z, *rpy = sdf_numbers(element, 6)
    unit = math.pi / 180.0 if sdf_flag(element, element.get("degrees", "").strip()) else 1.0
    return RigidTransform(RollPitchYaw(unit * np.array(rpy)), np.array([x, y, z]))


def _fault(element: Element, what: str) -> WorkbenchError:
    return WorkbenchError(f"{element_location(element)}: {what}")

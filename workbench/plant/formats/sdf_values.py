"""Numbers, flags and poses as SDF writes them in elements' texts."""

import math

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.values import LARGEST, shortened

_FLAGS = {"true": True, "1": True, "false": False, "0": False}
_SMALLEST_QUATERNION = 1e-6


def numbers(node: Node, *counts: int) -> tuple[float, ...]:
    """Return the numbers in an element's text.

    Args:
        node: the element.
        counts: how many there may be.

    Raises:
        WorkbenchError: naming the element, if one is no finite number or of absurd size, or if
            there are more or fewer.
    """
    try:
        found = tuple(float(word) for word in node.text.split())
    except ValueError:
        found = (math.nan,)
    if len(found) not in counts or not all(abs(number) <= LARGEST for number in found):
        wanted = " or ".join(map(str, counts))
        raise node.fault(
            f"<{node.element.tag}>{shortened(node.text)}</{node.element.tag}>: give it {wanted} "
            f"{'number' if counts == (1,) else 'numbers'} within ±{LARGEST:g}"
        )
    return found


def number(parent: Node, tag: str, default: float) -> float:
    """Return the number of a child element, the default where it is missing or empty."""
    node = parent.child(tag)
    return numbers(node, 1)[0] if node and node.text else default


def triple(
    parent: Node, tag: str, default: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the three numbers of a child element, the default where it is missing or empty."""
    node = parent.child(tag)
    if not node or not node.text:
        return default
    x, y, z = numbers(node, 3)
    return (x, y, z)


def flag(node: Node, text: str) -> bool:
    """Return what a text of an element says: true or false; nothing is false.

    Raises:
        WorkbenchError: naming the element, if it says neither.
    """
    if not text:
        return False
    if text.lower() not in _FLAGS:
        raise node.fault(
            f"'{shortened(text)}' of <{node.element.tag}> is neither true nor false: write one"
        )
    return _FLAGS[text.lower()]


def pose(node: Node | None) -> RigidTransform:
    """Return the pose that a `<pose>` gives; a missing or empty one is the identity.

    Raises:
        WorkbenchError: naming the element, if its numbers or attributes make no pose.
    """
    if not node or not node.text:
        return RigidTransform()
    rotation_format = node.attribute("rotation_format") or "euler_rpy"
    if rotation_format == "quat_xyzw":
        x, y, z, *xyzw = numbers(node, 7)
        length = math.hypot(*xyzw)
        if length < _SMALLEST_QUATERNION:
            raise node.fault(f"<pose>{shortened(node.text)}</pose>: its quaternion has no length")
        qx, qy, qz, qw = (component / length for component in xyzw)
        return RigidTransform(RotationMatrix(Quaternion(qw, qx, qy, qz)), np.array([x, y, z]))
    if rotation_format != "euler_rpy":
        raise node.fault(
            f"<pose rotation_format='{shortened(rotation_format)}'>: write euler_rpy or quat_xyzw"
        )
    x, y, z, *rpy = numbers(node, 6)
    unit = math.pi / 180.0 if flag(node, node.attribute("degrees")) else 1.0
    return RigidTransform(RollPitchYaw(unit * np.array(rpy)), np.array([x, y, z]))

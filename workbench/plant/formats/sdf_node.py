"""An element of an SDF file, with the context of its names."""

import dataclasses
import math
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import LARGEST, listed, shortened
from workbench.plant.formats.xml import Element, place

FRAME_SEMANTICS = (1, 7)
"""The first version in which poses name their reference frame."""
LONGEST_NAME = 200
_FLAGS = {"true": True, "1": True, "false": False, "0": False}
_SMALLEST_QUATERNION = 1e-6


@dataclass(frozen=True)
class Node:
    """An element with its context.

    Attributes:
        element: the XML element.
        file: that contains it.
        version: of SDF stated in that file.
        scope: prefix that makes a name in the element a full name: "" or `child::`.
        model: full name of the frame that `__model__` refers to.
    """

    element: Element
    file: Path
    version: tuple[int, int]
    scope: str
    model: str

    def child(self, tag: str) -> "Node | None":
        """Return the first child with a tag, or None."""
        return next(iter(self.children(tag)), None)

    def children(self, *tags: str) -> "list[Node]":
        """Return the children with one of these tags; all children without tags."""
        return [
            dataclasses.replace(self, element=element)
            for element in self.element
            if isinstance(element, Element) and (element.tag in tags or not tags)
        ]

    def attribute(self, name: str) -> str:
        """Return an attribute, or ""."""
        return self.element.get(name, "").strip()

    @property
    def text(self) -> str:
        """The text of the element."""
        return (self.element.text or "").strip()

    def text_of(self, tag: str) -> str:
        """Return the text of the first child with a tag, or ""."""
        child = self.child(tag)
        return child.text if child else ""

    @property
    def name(self) -> str:
        """The `name` attribute, as in the file.

        Raises:
            WorkbenchError: if it is missing or invalid.
        """
        name = self.attribute("name")
        if not name:
            raise self.fault(f"<{self.element.tag}> without a name: add it")
        return checked_name(self, name)

    @property
    def full_name(self) -> str:
        """The name with its scope."""
        return self.scope + self.name

    @property
    def title(self) -> str:
        """The element in messages: `link 'rotor_0'`, `<pose>`."""
        name = shortened(self.attribute("name"))
        return f"{self.element.tag} '{self.scope}{name}'" if name else f"<{self.element.tag}>"

    def fault(self, what: str) -> WorkbenchError:
        """Return an error with file, line and reason."""
        return WorkbenchError(f"{place(self.element)}: {what}")


def checked_name(node: Node, name: str) -> str:
    """Return a name if it is valid.

    Raises:
        WorkbenchError: if it is too long or not printable.
    """
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise node.fault(
            f"'{shortened(ascii(name)[1:-1])}' is not a name: give it up to {LONGEST_NAME} "
            "printable characters"
        )
    return name


def known_names(name: str, names: Iterable[str]) -> str:
    """Return the end of a message on an unknown name: similar names, or all names."""
    known = sorted(names)
    near = get_close_matches(name[:LONGEST_NAME], known, n=3)
    if near:
        quoted = [f"'{other}'" for other in near]
        return f"did you mean {' or '.join(quoted)}?"
    return f"known are {listed(known) or 'none'}"


def numbers(node: Node, *counts: int) -> tuple[float, ...]:
    """Return the numbers in an element's text.

    Args:
        node: the element.
        counts: allowed numbers of them.

    Raises:
        WorkbenchError: naming the element, if one is not a finite number or too large, or if their
            count is wrong.
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
    """Return the number in a child element, a default if it is missing or empty."""
    node = parent.child(tag)
    return numbers(node, 1)[0] if node and node.text else default


def triple(
    parent: Node, tag: str, default: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the three numbers in a child element, a default if it is missing or empty."""
    node = parent.child(tag)
    if not node or not node.text:
        return default
    x, y, z = numbers(node, 3)
    return (x, y, z)


def flag(node: Node, text: str) -> bool:
    """Return the truth value in a text of an element; an empty text is false.

    Raises:
        WorkbenchError: naming the element, if it is neither true nor false.
    """
    if not text:
        return False
    if text.lower() not in _FLAGS:
        raise node.fault(
            f"'{shortened(text)}' of <{node.element.tag}> is neither true nor false: write one"
        )
    return _FLAGS[text.lower()]


def pose(node: Node | None) -> RigidTransform:
    """Return the pose in a `<pose>`; a missing or empty one is the identity.

    Raises:
        WorkbenchError: naming the element, if its numbers or attributes are invalid.
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

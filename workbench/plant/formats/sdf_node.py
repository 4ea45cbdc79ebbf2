"""An element of an SDF file, and where its words hold."""

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
"""The version from which on poses name the frame they are given in."""
LONGEST_NAME = 200
_FLAGS = {"true": True, "1": True, "false": False, "0": False}
_SMALLEST_QUATERNION = 1e-6


@dataclass(frozen=True)
class Node:
    """An element with its context.

    Attributes:
        element: itself.
        file: it stands in.
        version: of SDF that this file says it is written in.
        scope: what a name gets in front to be a name of the whole: "" or `child::`.
        model: the frame that `__model__` means, as a name of the whole.
    """

    element: Element
    file: Path
    version: tuple[int, int]
    scope: str
    model: str

    def child(self, tag: str) -> "Node | None":
        """Return the first child of a tag, if there is one."""
        return next(iter(self.children(tag)), None)

    def children(self, *tags: str) -> "list[Node]":
        """Return the children of these tags, of all tags where none is given."""
        return [
            dataclasses.replace(self, element=element)
            for element in self.element
            if isinstance(element, Element) and (element.tag in tags or not tags)
        ]

    def attribute(self, name: str) -> str:
        """Return an attribute, "" where it is not given."""
        return self.element.get(name, "").strip()

    @property
    def text(self) -> str:
        """The text of the element."""
        return (self.element.text or "").strip()

    def text_of(self, tag: str) -> str:
        """Return the text of the first child of a tag, "" where there is none."""
        child = self.child(tag)
        return child.text if child else ""

    @property
    def name(self) -> str:
        """The `name` attribute, as the file has it.

        Raises:
            WorkbenchError: if there is none that could be referred to.
        """
        name = self.attribute("name")
        if not name:
            raise self.fault(f"<{self.element.tag}> without a name: add it")
        return checked_name(self, name)

    @property
    def full_name(self) -> str:
        """The name in the whole."""
        return self.scope + self.name

    @property
    def title(self) -> str:
        """What messages call the element: `link 'rotor_0'`, `<pose>`."""
        name = shortened(self.attribute("name"))
        return f"{self.element.tag} '{self.scope}{name}'" if name else f"<{self.element.tag}>"

    def fault(self, what: str) -> WorkbenchError:
        """Return the error that names file, line and what is wrong."""
        return WorkbenchError(f"{place(self.file, self.element)}: {what}")


def checked_name(node: Node, name: str) -> str:
    """Return a name, if it can be one.

    Raises:
        WorkbenchError: if it is endless or would break a line.
    """
    if len(name) > LONGEST_NAME or not name.isprintable():
        raise node.fault(
            f"'{shortened(ascii(name)[1:-1])}' is no name: give it up to {LONGEST_NAME} "
            "printable characters"
        )
    return name


def known_names(name: str, names: Iterable[str]) -> str:
    """Return the end of a message on an unknown name: what is near it, or what there is."""
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

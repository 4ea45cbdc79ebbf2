"""An element of an SDF file, with the context of its names."""

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_pose import element_text, sdf_numbers, sdf_pose
from workbench.plant.formats.values import listed_names, shortened_text
from workbench.plant.formats.xml import Element, element_location

FRAME_SEMANTICS_VERSION = (1, 7)
"""The first version in which poses name their reference frame."""
MAX_SDF_NAME_CHARS = 200


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
        return element_text(self.element)

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
        name = shortened_text(self.attribute("name"))
        return f"{self.element.tag} '{self.scope}{name}'" if name else f"<{self.element.tag}>"

    def fault(self, what: str) -> WorkbenchError:
        """Return an error with file, line and reason."""
        return WorkbenchError(f"{element_location(self.element)}: {what}")


def checked_name(node: Node, name: str) -> str:
    """Return a name if it is valid.

    Raises:
        WorkbenchError: if it is too long or not printable.
    """
    if len(name) > MAX_SDF_NAME_CHARS or not name.isprintable():
        raise node.fault(
            f"'{shortened_text(ascii(name)[1:-1])}' is not a name: give it up to "
            f"{MAX_SDF_NAME_CHARS} "
            "printable characters"
        )
    return name


def known_names(name: str, names: Iterable[str]) -> str:
    """Return the end of a message on an unknown name: similar names, or all names."""
    known = sorted(names)
    near = get_close_matches(name[:MAX_SDF_NAME_CHARS], known, n=3)
    if near:
        quoted = [f"'{other}'" for other in near]
        return f"did you mean {' or '.join(quoted)}?"
    return f"known are {listed_names(known) or 'none'}"


def sdf_number(parent: Node, tag: str, default: float) -> float:
    """Return the number in a child element, a default if it is missing or empty."""
    node = parent.child(tag)
    return sdf_numbers(node.element, 1)[0] if node and node.text else default


def sdf_triple(
    parent: Node, tag: str, default: tuple[float, float, float]
) -> tuple[float, float, float]:
    """Return the three numbers in a child element, a default if it is missing or empty."""
    node = parent.child(tag)
    if not node or not node.text:
        return default
    x, y, z = sdf_numbers(node.element, 3)
    return (x, y, z)


def node_pose(node: Node | None) -> RigidTransform:
    """Return the pose in a `<pose>`; a missing or empty one is the identity.

    Raises:
        WorkbenchError: naming the element, if its numbers or attributes are invalid.
    """
    return sdf_pose(node.element if node else None)

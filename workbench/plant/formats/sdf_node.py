"""An element of an SDF file, and where its words hold."""

import dataclasses
from collections.abc import Iterable
from dataclasses import dataclass
from difflib import get_close_matches
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import listed, shortened
from workbench.plant.formats.xml import Element, place

FRAME_SEMANTICS = (1, 7)
"""The version from which on poses name the frame they are given in."""
LONGEST_NAME = 200


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

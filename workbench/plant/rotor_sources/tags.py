"""Read the children of a plugin element as texts and numbers; errors have file and line."""

import math
import re
from collections.abc import Container
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import place
from workbench.plant.model import DeclaredPlugin
from workbench.plant.remarks import Remarks

SMALLEST = 1e-20
LARGEST = 1e6
"""Limits of the constants of a motor, in SI or per RPM."""

_NOT_PHYSICAL = re.compile(r"(?i)topic|namespace|node_?name|frame_?id|channel|pub_?rate")
"""Pattern of tags about Gazebo's communication."""
_MOST_NAMED = 10

TURNS = {"ccw": 1, "cw": -1}
MOST_ROTORS = 128


class Tags:
    """The children of one plugin.

    Args:
        plugin: as declared.
        kind: name of the plugin in messages.
    """

    def __init__(self, plugin: DeclaredPlugin, kind: str) -> None:
        self.file = plugin.file
        self._element = plugin.element
        self._kind = kind

    def has(self, tag: str) -> bool:
        """Return whether there is a child with a name, possibly empty."""
        return self._element.find(tag) is not None

    def where(self, tag: str = "") -> str:
        """Return file and line of a child, or of the plugin without such a child."""
        child = self._element.find(tag) if tag else None
        return place(self.file, self._element if child is None else child)

    def text(self, tag: str) -> str:
        """Return the text of a child.

        Raises:
            WorkbenchError: if it is missing or empty.
        """
        value = (self._element.findtext(tag) or "").strip()
        if not value:
            raise WorkbenchError(f"{self.where(tag)}: {self._kind} without <{tag}>: add it")
        return value

    def turn(self, tag: str) -> int:
        """Return the turning direction in a child, 1 for ccw and -1 for cw.

        Raises:
            WorkbenchError: if it is invalid.
        """
        value = self.text(tag)
        if value not in TURNS:
            raise self.fault(tag, "use cw or ccw")
        return TURNS[value]

    def positive(self, tag: str) -> float:
        """Return the positive number in a child.

        Raises:
            WorkbenchError: if it is missing or invalid.
        """
        if not self.has(tag):
            raise WorkbenchError(f"{self.where()}: {self._kind} without <{tag}>: add it")
        value = self._number(tag)
        if not SMALLEST <= value <= LARGEST:
            raise self.fault(tag, "give it a positive number")
        return value

    def not_negative(self, tag: str) -> float:
        """Return the number in a child, 0 or positive.

        Raises:
            WorkbenchError: if it is invalid.
        """
        value = self._number(tag)
        if not 0.0 <= value <= LARGEST:
            raise self.fault(tag, "give it a positive number, or 0")
        return value

    def numbers(self, tag: str) -> list[float]:
        """Return the numbers in a child.

        Raises:
            WorkbenchError: if one is invalid.
        """
        try:
            found = [float(word) for word in self.text(tag).split()]
        except ValueError:
            found = [math.nan]
        if not all(abs(value) <= LARGEST for value in found):
            raise self.fault(tag, "give it numbers")
        return found

    def _number(self, tag: str) -> float:
        """Return the number in a child, NaN if it is invalid."""
        try:
            return float(self._element.findtext(tag) or "")
        except ValueError:
            return math.nan

    def note_unused(self, used: Container[str], element: str, remarks: Remarks) -> None:
        """Add a remark on children that are neither used nor about Gazebo's communication.

        Args:
            used: names of the used ones.
            element: for the remark.
            remarks: receives the remark.
        """
        unused = [
            f"<{shortened(str(child.tag))}>{shortened(child.text or '')}"
            for child in self._element
            if isinstance(child.tag, str)
            and child.tag not in used
            and not _NOT_PHYSICAL.search(child.tag)
        ]
        if unused:
            text = f"{', '.join(unused[:_MOST_NAMED])}: not known here; not used"
            remarks.add("ignored", self.file, element, text)

    def fault(self, tag: str, advice: str) -> WorkbenchError:
        """Return the error for a child with an invalid text."""
        text = shortened(self._element.findtext(tag) or "")
        return WorkbenchError(
            f"{self.where(tag)}: {self._kind} has <{tag}>{text}</{tag}>: {advice}"
        )


def refuse_crowd(file: Path, number: int) -> None:
    """Reject more rotors than any multirotor has.

    Raises:
        WorkbenchError: for more than `MOST_ROTORS`.
    """
    if number > MOST_ROTORS:
        raise WorkbenchError(f"{file}: it declares {number} rotors: up to {MOST_ROTORS} are read")

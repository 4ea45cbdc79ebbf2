"""Read the children of an XML element of a plugin or sensor; errors name it with file and line."""

import math
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element, element_location

MAX_BLOCK_NUMBER = 1e9
"""Limit of numbers, in their units."""
MIN_POSITIVE_VALUE, MAX_POSITIVE_VALUE = 1e-20, 1e6
"""Limits of the positive constants of a motor, in SI or per RPM."""


class XmlBlock:
    """An element of a plugin or sensor; a missing one has no children.

    Args:
        what: name of the plugin or sensor in messages, such as "sensor 'imu'".
        element: the element, or if missing the nearest existing element around it.
        there: whether it exists.
    """

    def __init__(self, what: str, element: Element, there: bool = True) -> None:
        self.what = what
        self.element = element
        self.there = there

    @property
    def file(self) -> Path:
        """The file that contains it."""
        return self.element.file

    def block(self, *tags: str) -> "XmlBlock":
        """Return a nested block by the path of names to it."""
        element, there = self.element, self.there
        for tag in tags:
            child = element.find(tag) if there else None
            there = child is not None
            element = child if isinstance(child, Element) else element
        return XmlBlock(self.what, element, there)

    def first(self, *tags: str) -> "XmlBlock":
        """Return the first existing child with one of several names, or an empty block."""
        blocks = [self.block(tag) for tag in tags]
        return next((block for block in blocks if block.there), blocks[0])

    def has(self, tag: str) -> bool:
        """Return whether there is a child with a name, possibly empty."""
        return self.there and self.element.find(tag) is not None

    def where(self, tag: str = "") -> str:
        """Return file and line of a child, or of the element without such a child."""
        child = self.element.find(tag) if tag and self.there else None
        return element_location(self.element if child is None else child)

    def text(self, tag: str) -> str:
        """Return the text of a child, or ""."""
        return (self.element.findtext(tag) or "").strip() if self.there else ""

    def required(self, tag: str) -> str:
        """Return the text of a child.

        Raises:
            WorkbenchError: if it is missing or empty.
        """
        if not (text := self.text(tag)):
            raise WorkbenchError(f"{self.where(tag)}: {self.what} without <{tag}>: add it")
        return text

    def attribute(self, name: str) -> str:
        """Return an attribute, or ""."""
        return self.element.get(name, "").strip() if self.there else ""

    def number(self, tag: str, default: float) -> float:
        """Return the number in a child, or a default if there is no child.

        Raises:
            WorkbenchError: if it is not a finite number, or too large.
        """
        if not self.has(tag):
            return default
        value = self._value(tag)
        if not abs(value) <= MAX_BLOCK_NUMBER:
            raise self.fault(tag, "give it a number")
        return value

    def non_negative(self, tag: str, default: float) -> float:
        """Return the number in a child, zero or more, or a default if there is no child.

        Raises:
            WorkbenchError: if it is invalid.
        """
        value = self.number(tag, default)
        if value < 0.0:
            raise self.fault(tag, "give it a number that is not negative")
        return value

    def positive(self, tag: str) -> float:
        """Return the positive number in a child.

        Raises:
            WorkbenchError: if it is missing or invalid.
        """
        if not self.has(tag):
            raise self.fault(tag, "add it")
        value = self._value(tag)
        if not MIN_POSITIVE_VALUE <= value <= MAX_POSITIVE_VALUE:
            raise self.fault(tag, "give it a positive number")
        return value

    def numbers(self, tag: str) -> list[float]:
        """Return the numbers in a child.

        Raises:
            WorkbenchError: if it is missing or invalid.
        """
        try:
            found = [float(word) for word in self.required(tag).split()]
        except ValueError:
            found = [math.nan]
        if not all(abs(value) <= MAX_BLOCK_NUMBER for value in found):
            raise self.fault(tag, "give it numbers")
        return found

    def count(self, tag: str, default: int, most: int) -> int:
        """Return an integer of one or more; decimals are dropped.

        Raises:
            WorkbenchError: if it is invalid.
        """
        value = self.number(tag, default)
        if not 1.0 <= value < most + 1.0:
            raise self.fault(tag, f"give it a whole number from 1 to {most}")
        return int(value)

    def fault(self, tag: str, advice: str) -> WorkbenchError:
        """Return the error for a child with an invalid text, or for a missing child."""
        if not self.has(tag):
            return WorkbenchError(f"{self.where()}: {self.what} without <{tag}>: {advice}")
        text = shortened_text(self.element.findtext(tag) or "")
        return WorkbenchError(f"{self.where(tag)}: {self.what} has <{tag}>{text}</{tag}>: {advice}")

    def wrong(self, what: str) -> WorkbenchError:
        """Return the error for a block with contradicting numbers."""
        return WorkbenchError(f"{self.where()}: {self.what}: {what}")

    def _value(self, tag: str) -> float:
        """Return the number in a child, NaN if it is invalid."""
        try:
            return float(self.text(tag))
        except ValueError:
            return math.nan

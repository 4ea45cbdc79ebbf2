"""A part of a `<sensor>` element, there or not, with its numbers and the place of what is wrong."""

import math
from pathlib import Path
from xml.etree.ElementTree import Element

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import place

LARGEST = 1e9
"""No number of a sensor is as large as this in its unit."""


class Block:
    """An element inside a sensor; one that is not there has no children.

    Args:
        file: where the sensor is declared.
        sensor: its name, for messages.
        element: itself, or the nearest element around it that is there.
        there: whether it is there itself.
    """

    def __init__(self, file: Path, sensor: str, element: Element, there: bool = True) -> None:
        self.file = file
        self.sensor = sensor
        self.there = there
        self._element = element

    def block(self, *tags: str) -> "Block":
        """Return a block further down, by the names on the way to it."""
        element, there = self._element, self.there
        for tag in tags:
            child = element.find(tag) if there else None
            there = child is not None
            element = element if child is None else child
        return Block(self.file, self.sensor, element, there)

    def first(self, *tags: str) -> "Block":
        """Return the first child that is there of several names, or an empty block."""
        blocks = [self.block(tag) for tag in tags]
        return next((block for block in blocks if block.there), blocks[0])

    def has(self, tag: str) -> bool:
        """Return whether there is a child of a name."""
        return self.there and self._element.find(tag) is not None

    def text(self, tag: str) -> str:
        """Return the text of a child, "" where there is none."""
        return (self._element.findtext(tag) or "").strip() if self.there else ""

    def attribute(self, name: str) -> str:
        """Return an attribute, "" where there is none."""
        return self._element.get(name, "").strip() if self.there else ""

    def number(self, tag: str, default: float) -> float:
        """Return the number of a child, or a default where there is no child.

        Raises:
            WorkbenchError: if it is no finite number, or of absurd size.
        """
        if not self.has(tag):
            return default
        try:
            value = float(self.text(tag))
        except ValueError:
            value = math.nan
        if not abs(value) <= LARGEST:
            raise self.fault(tag, "give it a number")
        return value

    def non_negative(self, tag: str, default: float) -> float:
        """Return the number of a child, zero or more.

        Raises:
            WorkbenchError: if it is none.
        """
        value = self.number(tag, default)
        if value < 0.0:
            raise self.fault(tag, "give it a number that is not negative")
        return value

    def count(self, tag: str, default: int, most: int) -> int:
        """Return a whole number of one or more; what follows its decimal point does not count.

        Raises:
            WorkbenchError: if it is none.
        """
        value = self.number(tag, default)
        if not 1.0 <= value < most + 1.0:
            raise self.fault(tag, f"give it a whole number from 1 to {most}")
        return int(value)

    def fault(self, tag: str, advice: str) -> WorkbenchError:
        """Return the error for a child whose text cannot be, or for what is not there."""
        child = self._element.find(tag) if self.there else None
        if child is None:
            where = place(self.file, self._element)
            return WorkbenchError(f"{where}: sensor '{self.sensor}' without <{tag}>: {advice}")
        return WorkbenchError(
            f"{place(self.file, child)}: sensor '{self.sensor}' has "
            f"<{tag}>{shortened(child.text or '')}</{tag}>: {advice}"
        )

    def wrong(self, what: str) -> WorkbenchError:
        """Return the error for a block whose numbers do not go together."""
        where = place(self.file, self._element)
        return WorkbenchError(f"{where}: sensor '{self.sensor}': {what}")

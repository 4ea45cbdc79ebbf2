"""Rows of a table of numbers, apart from how it is painted."""

from dataclasses import dataclass
from enum import Enum

BEST = "best"
"""What marks a cell that is better than all others of its row."""


class State(Enum):
    """What a row says besides its numbers: a word, and a shape that stands for it."""

    NONE = ""
    GOOD = "ok"
    OVER = "over"
    LOW = "low"
    MISSED = "missed"
    BROKEN = "unstable"
    WAITING = "…"


@dataclass(frozen=True)
class Cell:
    """A number in a table.

    Attributes:
        text: the number that counts.
        was: what it is to be compared with, "" for nothing.
        over: whether it is beyond its limit.
        help: about it, for a tool tip.
        marked: what it is among those of its row, in a word; it is shown strong.
    """

    text: str
    was: str = ""
    over: bool = False
    help: str = ""
    marked: str = ""

    @property
    def spoken(self) -> str:
        """The number in words, for who hears it."""
        return f"{self.text} {self.marked}".rstrip()


@dataclass(frozen=True)
class Row:
    """A line of a table: a name, numbers and a word.

    Attributes:
        label: its name.
        cells: its numbers.
        state: what they come to.
        strong: whether it is named above the table.
    """

    label: str
    cells: tuple[Cell, ...]
    state: State = State.NONE
    strong: bool = False

    @property
    def blank(self) -> int:
        """How many cells are empty before the first number: its name may go on there."""
        texts = [cell.text for cell in self.cells]
        return next((index for index, text in enumerate(texts) if text), 0)

    @property
    def spoken(self) -> str:
        """The row in words, for who hears it."""
        numbers = ", ".join(cell.spoken for cell in self.cells[self.blank :])
        return f"{self.label}: {numbers} {self.state.value}"

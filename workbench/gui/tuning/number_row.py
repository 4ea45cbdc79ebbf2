"""A row of a table of numbers: its cells, and its state as a word and a shape."""

from dataclasses import dataclass
from enum import Enum


class RowState(Enum):
    """State of a row: its word, its tone, and the shape before it."""

    NONE = "", "muted", ""
    GOOD = "ok", "good", "✓"
    OVER = "over", "warning", "▲"
    LOW = "low", "warning", "▼"
    MISSED = "missed", "warning", "✕"
    BROKEN = "unstable", "bad", "✕"
    WAITING = "…", "muted", ""

    def __init__(self, word: str, tone: str, shape: str) -> None:
        self.word, self.tone, self.shape = word, tone, shape

    def with_shape(self, text: str) -> str:
        """Return a text after the shape, if there is one."""
        return f"{self.shape} {text}" if self.shape else text


@dataclass(frozen=True)
class Cell:
    """A number in a table.

    Attributes:
        text: the present number.
        was: the earlier number to compare with, "" for none.
        over: whether it violates its limit.
        help: its tool tip.
        marked: its rank in the row, as a word; it is shown in bold.
        state: its own state, if numbers of a row are judged apart: a shape beside it.
    """

    text: str
    was: str = ""
    over: bool = False
    help: str = ""
    marked: str = ""
    state: RowState = RowState.NONE

    @property
    def spoken(self) -> str:
        """The number in words, for screen readers."""
        return " ".join(filter(None, (self.text, self.marked, self.state.word)))


@dataclass(frozen=True)
class NumberRow:
    """A row of a table: a name, numbers and a word.

    Attributes:
        label: its name.
        cells: numbers of the row.
        state: state of the row.
        strong: whether the headline names it.
    """

    label: str
    cells: tuple[Cell, ...]
    state: RowState = RowState.NONE
    strong: bool = False

    @property
    def blank(self) -> int:
        """Number of empty cells before the first number, which its name may use."""
        texts = [cell.text for cell in self.cells]
        return next((index for index, text in enumerate(texts) if text), 0)

    @property
    def spoken(self) -> str:
        """The row in words, for screen readers."""
        numbers = ", ".join(cell.spoken for cell in self.cells[self.blank :])
        return f"{self.label}: {numbers} {'' if self.is_judged_apart else self.state.word}".rstrip()

    @property
    def is_judged_apart(self) -> bool:
        """Whether its numbers have states of their own."""
        return any(cell.state is not RowState.NONE for cell in self.cells)

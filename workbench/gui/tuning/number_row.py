"""A row of a table of numbers: its cells, and its state as a word and a shape."""

from dataclasses import dataclass
from enum import Enum


class RowState(Enum):
    """State of a row: a word, and its shape."""

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
        return " ".join(filter(None, (self.text, self.marked, self.state.value)))


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
        return (
            f"{self.label}: {numbers} {'' if self.is_judged_apart else self.state.value}".rstrip()
        )

    @property
    def is_judged_apart(self) -> bool:
        """Whether its numbers have states of their own."""
        return any(cell.state is not RowState.NONE for cell in self.cells)


STATE_TONES = {
    RowState.GOOD: "good",
    RowState.OVER: "warning",
    RowState.LOW: "warning",
    RowState.MISSED: "warning",
    RowState.BROKEN: "bad",
    RowState.WAITING: "muted",
    RowState.NONE: "muted",
}
STATE_SHAPES = {
    RowState.GOOD: "✓",
    RowState.OVER: "▲",
    RowState.LOW: "▼",
    RowState.MISSED: "✕",
    RowState.BROKEN: "✕",
}
"""Shape before the word of a state."""


def with_shape(state: RowState, text: str) -> str:
    """Return a text after the shape of its state, if it has one."""
    return f"{STATE_SHAPES[state]} {text}" if state in STATE_SHAPES else text

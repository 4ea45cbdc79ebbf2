"""A table of numbers: labels, aligned columns of digits, and units; and a hint in its place."""

from collections.abc import Sequence

from PyQt6.QtCore import QEvent, Qt
from PyQt6.QtWidgets import QGridLayout, QWidget

from workbench.common.plain_text import plain_name
from workbench.gui.labels import Label
from workbench.gui.layout import NO_MARGINS, label, vbox

UNKNOWN_VALUE_TEXT = "–"
"""Text for an unknown value."""
WIDEST_READOUT_NUMBERS = ("\N{MINUS SIGN}888.88",)
"""Text for which each column has room, without another one."""
READOUT_GAP_EM = 0.25
"""Space between columns, relative to plain text."""
ReadoutLine = tuple[str, str]
"""A row of a readout: name of the quantity, and the unit after the numbers, "" for none."""


class Readout(QWidget):
    """Rows of numbers.

    Args:
        name: name of the table, for a screen reader.
        lines: rows.
        columns: headings, empty for one column without a heading.
        widest: the widest text in each column; the last one is that of all further columns.
    """

    def __init__(
        self,
        name: str,
        lines: Sequence[ReadoutLine],
        columns: Sequence[str] = (),
        widest: tuple[str, ...] = WIDEST_READOUT_NUMBERS,
    ) -> None:
        super().__init__()
        self.setAccessibleName(name)
        self._columns, self._widest = tuple(columns), widest
        count = max(1, len(columns))
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(*NO_MARGINS)
        self._grid.setVerticalSpacing(0)
        self._grid.setColumnStretch(0, 1)
        for column, heading in enumerate(columns, 1):
            self._grid.addWidget(_right_label(heading, "muted"), 0, column)
        self._names = [label(kind="muted") for _ in lines]
        self._units = [label(kind="muted") for _ in lines]
        self._cells = [[_right_label(UNKNOWN_VALUE_TEXT) for _ in range(count)] for _ in lines]
        self._lines = [("", "")] * len(lines)
        for row, cells in enumerate(self._cells, 1):
            for column, part in enumerate((self._names[row - 1], *cells, self._units[row - 1])):
                self._grid.addWidget(part, row, column)
            self.set_line(row - 1, lines[row - 1])
        self._fit()

    @property
    def texts(self) -> tuple[tuple[str, ...], ...]:
        """Texts of the cells, row by row."""
        return tuple(tuple(cell.text() for cell in row) for row in self._cells)

    @property
    def spoken(self) -> str:
        """The table as a sentence."""
        parts = []
        for (name, _), cells, unit in zip(self._lines, self.texts, self._units, strict=True):
            pairs = zip(self._columns or ("",), cells, strict=True)
            numbers = ", ".join(f"{head} {cell}".strip() for head, cell in pairs)
            parts.append(f"{name} {numbers} {unit.text()}".strip())
        return "; ".join(parts)

    def set_line(self, index: int, line: ReadoutLine) -> None:
        """Change a row's label and unit."""
        self._lines[index] = line
        self._names[index].setText(line[0])
        self._units[index].setText(line[1])

    def show_row(self, index: int, *texts: str) -> None:
        """Show numbers in a row, or words, which have no unit."""
        measured = any(each.isdigit() or each == UNKNOWN_VALUE_TEXT for each in texts[-1])
        shown = (*texts, self._lines[index][1] if measured else "")
        for part, text in zip((*self._cells[index], self._units[index]), shown, strict=True):
            part.setText(text)

    def changeEvent(self, event: QEvent | None) -> None:
        """Adapt the columns to another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._fit()

    def _fit(self) -> None:
        """Reserve each column's width for its widest number and its heading, and space between."""
        self._grid.setHorizontalSpacing(round(READOUT_GAP_EM * self.fontInfo().pixelSize()))
        width = self.fontMetrics().horizontalAdvance
        for column in range(len(self._cells[0])):
            number = width(self._widest[min(column, len(self._widest) - 1)])
            # unlike numbers, headings fill their columns, so two of them need space between
            heading = width(f" {self._columns[column]}") if self._columns else 0
            self._grid.setColumnMinimumWidth(1 + column, max(number, heading))


class Hint(QWidget):
    """A word and a sentence in place of an instrument that has nothing to show; hidden at first."""

    def __init__(self, name: str) -> None:
        super().__init__()
        self.setAccessibleName(name)
        self._word, self._sentence = label(kind="heading"), label(kind="muted", wraps=True)
        for part in (self._word, self._sentence):
            part.setAlignment(Qt.AlignmentFlag.AlignHCenter)
        vbox(1, self._word, self._sentence, 1, of=self, margins=NO_MARGINS, spacing=2)
        self.hide()

    @property
    def sentence(self) -> str:
        """The remedy."""
        return self._sentence.text()

    def say(self, word: str, sentence: str) -> None:
        """Show a word, and a remedy."""
        self._word.setText(plain_name(word))
        self._sentence.setText(sentence)

    @property
    def spoken(self) -> str:
        """Both as a sentence."""
        return f"{self._word.text()}. {self.sentence}"


def _right_label(text: str, kind: str = "") -> Label:
    made = label(text, kind)
    made.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
    return made

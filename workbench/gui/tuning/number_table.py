"""A table of numbers with the state of each row, as a word and a shape."""

import math
from collections.abc import Iterable, Sequence

from PyQt6.QtCore import QEvent, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QFocusEvent, QFont, QKeyEvent, QResizeEvent
from PyQt6.QtWidgets import QHeaderView, QSizePolicy, QTableWidget
from PyQt6.QtWidgets import QTableWidgetItem as Item

from workbench.common.plain_text import plain_text
from workbench.gui.labels import set_tip
from workbench.gui.style import with_class
from workbench.gui.tables import table_heads, text_table
from workbench.gui.theme import Look
from workbench.gui.tuning.number_row import Cell, NumberRow, RowState

BEST_CELL = "best"
"""Marks a cell that is better than all others of its row."""
CELL_PADDING_PX = 10
"""Space that the style leaves around the text of a cell [px]."""
HEADING_PADDING_PX = 14
"""The same of a heading [px]."""
MIN_LABEL_SHARE = 0.6
"""Least width of the labels, as a share of their width in one line."""
MIN_PAIRED_TABLE_PX = 240
"""Least width of a table whose cells have an earlier number [px]."""
MAX_CELL_WIDTH_PX = 130
"""Largest width of a cell, for legibility [px]."""
MAX_ROW_HEIGHT_PX = 24
MAX_WRAPPED_ROW_LINES = 2.2
"""Largest height of a row with one line, and with more [heights of a line]."""
NUMBER_ALIGNMENT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


class NumberTable(QTableWidget):
    """Rows of numbers, most with a word at the end.

    Args:
        title: accessible name.
        head: headings of the columns of numbers.
        look: source of colours.
        paired: whether an earlier number stands before a cell's number if there is room for it;
            else only the tool tip has it.
        widest: the longest expected label.
        worded: whether rows have a word at the end.
        head_help: tool tip of each column.

    Attributes:
        rows: the shown rows.
    """

    row_chosen = pyqtSignal(int)
    """A row was clicked, or Enter was pressed on it."""

    def __init__(
        self,
        title: str,
        head: Sequence[str],
        look: Look,
        *,
        paired: bool,
        widest: str,
        worded: bool = True,
        head_help: Sequence[str] = (),
    ) -> None:
        super().__init__()
        self._look, self._paired, self._widest, self._worded = look, paired, widest, worded
        self.rows: tuple[NumberRow, ...] = ()
        self._head: tuple[str, ...] = ()
        self._expected = 1
        self._shape: tuple[object, ...] = ()
        self._wraps = self._stacks = self._shows_earlier = False
        text_table(with_class(self, "numbers"), title)
        self.setTextElideMode(Qt.TextElideMode.ElideNone)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setVerticalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        self._heads, self._sides = table_heads(self)
        self._heads.setSectionResizeMode(QHeaderView.ResizeMode.Fixed)
        self._heads.setDefaultAlignment(NUMBER_ALIGNMENT)
        self._heads.setMinimumSectionSize(0)
        self._sides.setMinimumSectionSize(0)
        self.cellClicked.connect(lambda row, _: self.row_chosen.emit(row))
        self.cellActivated.connect(lambda row, _: self.row_chosen.emit(row))
        look.changed.connect(self._write_all)
        self.set_head(head, head_help)

    def set_rows(self, rows: tuple[NumberRow, ...]) -> None:
        """Show rows; equal cells are not painted again."""
        if rows == self.rows:
            return
        before, self.rows = self.rows, rows
        self.setRowCount(len(rows))
        for number, row in enumerate(rows):
            old = before[number] if number < len(before) else None
            if row != old:
                self._write(number, row, old)
        self.setAccessibleDescription("; ".join(row.spoken for row in rows))
        longest = max((len(each.text) for row in rows for each in row.cells), default=0)
        shape = longest, [(row.label, row.blank, self._word(row)) for row in rows]
        if shape != self._shape:  # the same columns show other numbers
            self._shape = shape
            self._fit()
            self.updateGeometry()

    def set_head(self, head: Sequence[str], head_help: Sequence[str] = ()) -> None:
        """Set the columns."""
        if self._head != tuple(head) or not self.columnCount():
            self._head = tuple(head)
            self.setColumnCount(1 + len(head) + self._worded)
            self._write_all()
            self._fit()
            self.updateGeometry()
        for column, help in enumerate(head_help[: len(head)], 1):
            item = self.horizontalHeaderItem(column)
            assert item is not None
            set_tip(item, help)

    def expect(self, rows: int) -> None:
        """Reserve space for this many rows."""
        if rows != self._expected:
            self._expected = rows
            self._fit()
            self.updateGeometry()

    def sizeHint(self) -> QSize:
        """Return the size of all rows, with labels in one line."""
        return self._size_with(1.0, 5)

    def minimumSizeHint(self) -> QSize:
        """Return the least size without clipping, with labels in two lines."""
        return self._size_with(MIN_LABEL_SHARE, 1)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Divide the new size among columns and rows."""
        super().resizeEvent(event)
        self._fit()

    def changeEvent(self, event: QEvent | None) -> None:
        """Adapt to another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange and hasattr(self, "_sides"):
            self._fit()

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Mark a row only while the arrow keys move the mark."""
        super().focusOutEvent(event)
        self.clearSelection()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Leave letters, for which a table of Qt would search, to the charts beside it."""
        if event is not None and event.text().isprintable() and event.text():
            event.ignore()
        else:
            super().keyPressEvent(event)

    def _write_all(self) -> None:
        for column, text in enumerate(("", *self._head, "")[: self.columnCount()]):
            item = self.horizontalHeaderItem(column) or Item()
            item.setText(text.replace(" ", "\n") if self._stacks else text)
            self.setHorizontalHeaderItem(column, item)
        for number, row in enumerate(self.rows):
            self._write(number, row, None)

    def _write(self, number: int, row: NumberRow, before: NumberRow | None) -> None:
        """Write the cells of a row that differ from those before."""
        state = RowState.NONE if row.is_judged_apart else row.state
        broken = state is RowState.BROKEN and not self._worded
        label = state.with_shape(row.label) if broken else row.label
        tone = "bad" if broken else "ink" if row.strong else "muted"
        self._put(number, 0, label, tone, row.label, bold=row.strong)
        if self.columnSpan(number, 0) != 1 + row.blank:
            self.setSpan(number, 0, 1, 1 + row.blank)
        old = before.cells if before is not None else ()
        for column, cell in enumerate(row.cells):
            if column >= len(old) or old[column] != cell:
                self._write_cell(number, 1 + column, cell)
        if self._worded:
            last = self.columnCount() - 1
            self._put(number, last, state.with_shape(state.word), state.tone, "")

    def _write_cell(self, row: int, column: int, cell: Cell) -> None:
        tone = "good" if cell.marked == BEST_CELL else "ink"
        text = f"{cell.was}→{cell.text}" if cell.was and self._shows_earlier else cell.text
        self._put(
            row,
            column,
            cell.state.with_shape(text),
            "warning" if cell.over else tone,
            f"{cell.help} (flown: {cell.was})" if cell.was else cell.help,
            bold=bool(cell.marked),
            underlined=cell.over,  # a violated limit is seen in any colour
        )

    def _put(
        self,
        row: int,
        column: int,
        text: str,
        tone: str,
        help: str,
        *,
        bold: bool = False,
        underlined: bool = False,
    ) -> None:
        item = Item(plain_text(text))
        item.setForeground(self._look.colour(tone))
        if 0 < column <= len(self._head):
            item.setTextAlignment(NUMBER_ALIGNMENT)
        if bold or underlined:
            font = QFont(self.font())
            font.setWeight(QFont.Weight.DemiBold if bold else QFont.Weight.Normal)
            font.setUnderline(underlined)
            item.setFont(font)
        set_tip(item, help)
        self.setItem(row, column, item)

    def _size_with(self, share: float, gap: int) -> QSize:
        """Return the size with a share of the labels' width, and a gap in each line [px]."""
        label, cell, word = self._widths()
        width = MIN_PAIRED_TABLE_PX
        if not self._paired:
            width = math.ceil(share * label) + len(self._head) * cell + word
        lines = (2 if self._wraps else 1) * max(len(self.rows), self._expected)
        line = self.fontMetrics().height() + gap
        return QSize(width, self._heads.sizeHint().height() + lines * line + 2 * self.frameWidth())

    def _word(self, row: NumberRow) -> str:
        hidden = row.is_judged_apart or not self._worded
        return "" if hidden else row.state.with_shape(row.state.word)

    def _width(self, texts: Iterable[str]) -> int:
        """Return the width of a column that shows texts in one line [px]."""
        return max(map(self.fontMetrics().horizontalAdvance, texts), default=0) + CELL_PADDING_PX

    def _widths(self) -> tuple[int, int, int]:
        """Return the least widths of labels in one line, of numbers, and of words [px]."""
        label = self._width([self._widest, *(row.label for row in self.rows if not row.blank)])
        cells = [each for row in self.rows for each in row.cells]
        cell = self._width(each.state.with_shape(each.text) for each in cells)
        head = map(self._heads.sectionSizeHint, range(1, 1 + len(self._head)))
        over = RowState.OVER.with_shape(RowState.OVER.word)  # room for a word that often comes
        word = self._width([over, *map(self._word, self.rows)]) if self._worded else 0
        return label, max([cell, *head]), word

    def _fit(self) -> None:
        """Give the columns their widths and the rows their height; long labels wrap."""
        label, cell, word = self._widths()
        count, room = max(1, len(self._head)), self.contentsRect().width()
        pair = 2 * cell + self.fontMetrics().horizontalAdvance("→")
        heading = max(map(self._heads.fontMetrics().horizontalAdvance, self._head), default=0)
        stacks = label + word + count * (heading + HEADING_PADDING_PX) > room
        shows_earlier = self._paired and label + word + count * pair <= room
        if (stacks, shows_earlier) != (self._stacks, self._shows_earlier):
            self._stacks, self._shows_earlier = stacks, shows_earlier
            self._write_all()
            label, cell, word = self._widths()
        cell = max(cell, min((room - label - word) // count, MAX_CELL_WIDTH_PX))
        share = max(0, room - word - count * cell)
        wide = (min(label, share), *(cell,) * len(self._head), word)
        for column in range(self.columnCount()):
            self.setColumnWidth(column, wide[column])
        wraps = share < label
        if wraps is not self._wraps:
            self._wraps = wraps
            self.updateGeometry()
        line = self.fontMetrics().height()
        high = round(MAX_WRAPPED_ROW_LINES * line) if wraps else MAX_ROW_HEIGHT_PX
        below = self.contentsRect().height() - self._heads.sizeHint().height()
        rows = max(1, len(self.rows), self._expected)
        self._sides.setDefaultSectionSize(max(line, min(high, below // rows)))

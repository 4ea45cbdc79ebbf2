"""A table of numbers with the state of each row, as a word and a shape."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from PyQt6.QtCore import QEvent, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QColor,
    QFont,
    QFontMetricsF,
    QHelpEvent,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QRegion,
    QResizeEvent,
)
from PyQt6.QtWidgets import QSizePolicy, QToolTip, QWidget

from workbench.gui.icons import paint_picture
from workbench.gui.labels import tip_text
from workbench.gui.theme import Look

BEST = "best"
"""Marks a cell that is better than all others of its row."""
GAP = 8.0
MARK = 13.0
"""Space for the shape before a word [px]."""
PAIR = 2.0
"""Space to the right of a number [px]."""
RIGHT = int(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter | Qt.TextFlag.TextDontClip)
SMALLER = 0.8
"""Size of the earlier number, relative to the present one."""
WIDEST = 130.0
"""Largest width of a cell, for legibility [px]."""
FIRST = 0.54
"""Share of a cell's width for the first of two numbers side by side."""
LOWEST = 1.5
"""Least height of a row with one number below another, in heights of a line."""
ROOMIEST = 24.0
"""Largest height of a row [px]."""


class State(Enum):
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
    """

    text: str
    was: str = ""
    over: bool = False
    help: str = ""
    marked: str = ""

    @property
    def spoken(self) -> str:
        """The number in words, for screen readers."""
        return f"{self.text} {self.marked}".rstrip()


@dataclass(frozen=True)
class Row:
    """A row of a table: a name, numbers and a word.

    Attributes:
        label: its name.
        cells: numbers of the row.
        state: state of the row.
        strong: whether the headline names it.
    """

    label: str
    cells: tuple[Cell, ...]
    state: State = State.NONE
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
        return f"{self.label}: {numbers} {self.state.value}"


TONES = {
    State.GOOD: "good",
    State.OVER: "warning",
    State.LOW: "warning",
    State.MISSED: "warning",
    State.BROKEN: "bad",
    State.WAITING: "muted",
    State.NONE: "muted",
}
MARKS = {
    State.GOOD: "tick",
    State.OVER: "over",
    State.LOW: "low",
    State.MISSED: "cross",
    State.BROKEN: "cross",
}
"""Picture beside the word of a state."""


class NumberTable(QWidget):
    """Rows of numbers, most with a word at the end.

    Args:
        title: accessible name.
        head: headings of the columns of numbers.
        look: source of colours.
        paired: whether each cell has a second, muted number: the earlier one.
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
        self._head = tuple(head)
        self._head_help = tuple(head_help)
        self._look = look
        self._paired = paired
        self._widest = widest
        self._worded = worded
        self.rows: tuple[Row, ...] = ()
        self._wide = False
        self._chosen = -1
        self._expected = 1
        self._widths: tuple[float, float, float] | None = None
        self._measure()
        self.setAccessibleName(title)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        look.changed.connect(self.update)

    def set_rows(self, rows: tuple[Row, ...]) -> None:
        """Show rows; equal rows are not repainted."""
        if rows == self.rows:
            return
        if len(rows) != len(self.rows):
            self.updateGeometry()
        before, wide = self.rows, self._wide
        self.rows = rows
        self._wide = any(row.state is State.MISSED for row in rows)
        if wide is self._wide and [row.label for row in before] == [row.label for row in rows]:
            changed = [number for number, row in enumerate(rows) if row != before[number]]
        else:
            changed = []  # other columns change everything
            self._widths = None
        self._chosen = min(self._chosen, len(rows) - 1)
        self.setAccessibleDescription("; ".join(row.spoken for row in rows))
        for number in changed:
            self.update(self._row_box(number).toAlignedRect())
        if not changed:
            self.update()

    def set_head(self, head: Sequence[str], head_help: Sequence[str] = ()) -> None:
        """Set other columns."""
        self._head_help = tuple(head_help)
        if self._head != tuple(head):
            self._head = tuple(head)
            self._widths = None
            self.update()

    @property
    def full_width(self) -> int:
        """Width at which no label is elided [px]."""
        labels = [self._widest, *(row.label for row in self.rows)]
        label = max(map(self._metrics.horizontalAdvance, labels)) + GAP
        return math.ceil(label + len(self._head) * self._columns()[1])

    def column_at(self, x: float) -> int:
        """Return the column of numbers at a position in the widget; -1 for the labels."""
        label, cell, _ = self._columns()
        column = int((x - label) // cell)
        return column if 0 <= column < len(self._head) else -1

    def expect(self, rows: int) -> None:
        """Reserve space for this many rows."""
        self._expected = rows
        self.updateGeometry()

    def sizeHint(self) -> QSize:
        """Return the size of all rows."""
        line = self.fontMetrics().height()
        return QSize(320, (line + 5) * self._lines())

    def minimumSizeHint(self) -> QSize:
        """Return the least size without clipping."""
        line = self.fontMetrics().height()
        return QSize(240, (line + 1) * self._lines())

    def _lines(self) -> int:
        return 1 + max(len(self.rows), self._expected)

    def changeEvent(self, event: QEvent | None) -> None:
        """Measure again after a change of the font."""
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._measure()
        super().changeEvent(event)

    def _measure(self) -> None:
        """Make the fonts, and measure text with them, once."""
        self._metrics = QFontMetricsF(self.font())
        self._small, self._strong = QFont(self.font()), QFont(self.font())
        self._small.setPointSizeF(SMALLER * self.font().pointSizeF())
        self._strong.setWeight(QFont.Weight.DemiBold)
        self._widths = None

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Divide the new width."""
        self._widths = None
        super().resizeEvent(event)

    @property
    def _head_font(self) -> QFont:
        """Font of the head: small for many columns, for pairs, or without a word at the end."""
        return self._small if self._paired or not self._worded else self.font()

    def _row_height(self) -> float:
        roomiest = 2.2 * self._metrics.height() if self._is_stacked else ROOMIEST
        return min(roomiest, self.height() / self._lines())

    @property
    def _is_stacked(self) -> bool:
        """Whether the second number of a cell is below the first, for lack of width."""
        _, cell, _ = self._columns()
        return self._paired and FIRST * cell < self._metrics.horizontalAdvance("−00.0")

    def _row_box(self, number: int) -> QRectF:
        height = self._row_height()
        return QRectF(0.0, (number + 1) * height, self.width(), height)

    def _columns(self) -> tuple[float, float, float]:
        """Return the widths of the labels, of a cell, and of the word; they are cached."""
        if self._widths is None:
            self._widths = self._measure_columns()
        return self._widths

    def _measure_columns(self) -> tuple[float, float, float]:
        metrics = self._metrics
        labels = [self._widest, *(row.label for row in self.rows if not row.blank)]
        label = max(metrics.horizontalAdvance(each) for each in labels) + GAP
        longest = State.MISSED.value if self._wide else State.OVER.value
        word = metrics.horizontalAdvance(longest) + MARK + GAP if self._worded else 0.0
        columns = max(1, len(self._head))
        cell = min((self.width() - label - word) / columns, WIDEST)
        if not self._paired:  # numbers keep their width, and a long label is elided
            texts = [each.text for row in self.rows for each in row.cells]
            small = QFontMetricsF(self._head_font)
            widths = [*map(metrics.horizontalAdvance, texts)]
            widths += map(small.horizontalAdvance, self._head)
            cell = max(cell, max(widths, default=0.0) + GAP)
            label = min(label, max(0.0, self.width() - word - columns * cell))
        return label, cell, word

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the head, and the rows that have changed."""
        painter = QPainter(self)
        seen = event.region() if event is not None else QRegion(self.rect())
        label, cell, word = self._columns()
        height = self._row_height()
        colour = self._look.colour
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.setPen(colour("muted"))
        painter.setFont(self._head_font)
        for index, text in enumerate(self._head if seen.boundingRect().top() <= height else ()):
            words = text.replace(" ", "\n") if self._is_stacked else text
            painter.drawText(QRectF(label + index * cell, 0.0, cell - PAIR, height), RIGHT, words)
        painter.setFont(self.font())
        painter.setPen(colour("line"))
        painter.drawLine(0, round(height), self.width(), round(height))
        for number, row in enumerate(self.rows):
            if not seen.intersects(self._row_box(number).toAlignedRect()):
                continue
            top = (number + 1) * height
            if number == self._chosen and self.hasFocus():
                painter.fillRect(QRectF(0.0, top, self.width(), height), self._shade())
            painter.setFont(self._strong if row.strong else self.font())
            painter.setPen(colour("ink" if row.strong else "muted"))
            room = label + row.blank * cell
            name = self.fontMetrics().elidedText(
                row.label, Qt.TextElideMode.ElideRight, round(room - 0.5 * GAP)
            )
            painter.drawText(QRectF(0.0, top, room, height), left, name)
            painter.setFont(self.font())
            end = label + len(self._head) * cell + word
            for index, each in enumerate(row.cells):
                box = QRectF(label + index * cell, top, cell, height)
                if row.state is State.BROKEN and box.right() > end - self._state_width(row.state):
                    break  # its word needs the space of the last cells
                self._paint_cell(painter, box, each)
            self._paint_state(painter, QRectF(0.0, top, end, height), row.state)

    def _first_width(self, cell: float) -> float:
        """Return the distance of the first number's end from a cell's left edge."""
        return FIRST * cell if self._paired and not self._is_stacked else cell - PAIR

    def _paint_cell(self, painter: QPainter, box: QRectF, cell: Cell) -> None:
        number = QRectF(box.left(), box.top(), self._first_width(box.width()), box.height())
        second = QRectF(
            number.right(), box.top(), box.right() - number.right() - PAIR, box.height()
        )
        was = cell.was
        if self._is_stacked and was and box.height() < LOWEST * self._metrics.height():
            was = ""  # no room: the tool tip has it
        elif self._is_stacked and was:
            number.setHeight(0.55 * box.height())
            second = number.translated(0.0, 0.47 * box.height())
        tone = "good" if cell.marked == BEST else "ink"
        painter.setPen(self._look.colour("warning" if cell.over else tone))
        painter.setFont(self._strong if cell.marked else self.font())
        painter.drawText(number, RIGHT, cell.text)
        if cell.over:  # a line below marks a violated limit in any colour
            width = self._metrics.horizontalAdvance(cell.text)
            base = number.center().y() + self._metrics.ascent() / 2.0 + 1.5
            painter.drawLine(
                round(number.right() - width), round(base), round(number.right()), round(base)
            )
        if was:
            painter.setPen(self._look.colour("muted"))
            painter.setFont(self._small)
            painter.drawText(second, RIGHT, was)
            painter.setFont(self.font())

    def _state_width(self, state: State) -> float:
        return self._metrics.horizontalAdvance(state.value) + MARK

    def _paint_state(self, painter: QPainter, box: QRectF, state: State) -> None:
        if state is State.NONE:
            return
        colour = self._look.colour(TONES[state])
        # A long word extends to the left over the last numbers, which an unstable row lacks.
        left = box.right() - self._state_width(state)
        _, _, word = self._columns()
        left = min(left, box.right() - word + GAP)
        size = 8.0
        mark = QRectF(left, box.center().y() - size / 2.0, size, size)
        if state in MARKS:
            paint_picture(painter, mark, MARKS[state], colour)
        painter.setPen(colour)
        text = QRectF(left + MARK, box.top(), box.right() - left, box.height())
        painter.drawText(
            text, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter, state.value
        )

    def _shade(self) -> QColor:
        shade = self._look.colour("accent")
        shade.setAlpha(40)
        return shade

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Move from row to row, or select one."""
        assert event is not None
        if Qt.Key(event.key()) in (Qt.Key.Key_Return, Qt.Key.Key_Enter) and self._chosen >= 0:
            self.row_chosen.emit(self._chosen)
            return
        move = {Qt.Key.Key_Up: -1, Qt.Key.Key_Down: 1}.get(Qt.Key(event.key()), 0)
        if not move or not self.rows:
            super().keyPressEvent(event)
            return
        self._chosen = min(max(self._chosen + move, 0), len(self.rows) - 1)
        self.setAccessibleDescription(self.rows[self._chosen].spoken)
        self.update()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Select a row."""
        assert event is not None
        row = int(event.position().y() / self._row_height()) - 1
        if event.button() == Qt.MouseButton.LeftButton and 0 <= row < len(self.rows):
            self._chosen = row
            self.setAccessibleDescription(self.rows[row].spoken)
            self.row_chosen.emit(row)
            self.update()

    def event(self, event: QEvent | None) -> bool:
        """Show a tool tip for the number under the pointer."""
        if isinstance(event, QHelpEvent) and event.type() == QEvent.Type.ToolTip:
            said = self.help_at(event.pos().x(), event.pos().y())
            QToolTip.showText(event.globalPos(), tip_text(said))
            return True
        return super().event(event)

    def help_at(self, x: float, y: float) -> str:
        """Return the tool tip of the number, the label or the head at a position in the widget."""
        label, cell, _ = self._columns()
        number = int(y / self._row_height()) - 1
        column = int((x - label) // cell)
        if 0 <= number < len(self.rows) and x < label:
            return self.rows[number].label
        if 0 <= number < len(self.rows) and 0 <= column < len(self.rows[number].cells):
            said = self.rows[number].cells[column]
            return f"{said.help} (flown: {said.was})" if said.was else said.help
        if number < 0 <= column < len(self._head_help):
            return self._head_help[column]
        return ""

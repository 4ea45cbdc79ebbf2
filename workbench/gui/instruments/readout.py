"""A table of numbers: labels, aligned columns of digits, and units."""

from collections.abc import Sequence

from PyQt6.QtCore import QRectF
from PyQt6.QtGui import QFontMetricsF, QPainter, QResizeEvent
from PyQt6.QtWidgets import QWidget

from workbench.gui.instruments.instrument import LEFT, RIGHT, Instrument
from workbench.gui.theme import Look

NOTHING = "–"
"""Text for an unknown value."""
WIDEST = "\N{MINUS SIGN}888.88"
"""Text for which a column has room, without another one."""
DIGITS = 1.12
"""Size of digits relative to plain text."""
TALLEST_ROW = 2.1
"""Largest height of a row relative to plain text."""


Line = tuple[str, str]
"""A row of a readout: name of the quantity, and the unit after the numbers, "" for none."""


class Readout(Instrument):
    """Rows of numbers; a cell is repainted only when its text has changed.

    Args:
        look: source of colours.
        name: name of the table, for a screen reader.
        lines: rows.
        columns: headings, empty for one column without a heading.
        widest: the widest text of a cell.
        parent: the Qt parent.
    """

    def __init__(
        self,
        look: Look,
        name: str,
        lines: Sequence[Line],
        columns: Sequence[str] = (),
        widest: str = WIDEST,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(look, name, parent)
        self._lines = list(lines)
        self._columns = tuple(columns)
        self._widest = widest
        count = max(1, len(self._columns))
        self._cells = [[NOTHING] * count for _ in self._lines]
        self._measured = [True] * len(self._lines)
        self._places: list[list[QRectF]] = []
        self._digits = DIGITS

    @property
    def texts(self) -> tuple[tuple[str, ...], ...]:
        """Texts of the cells, row by row."""
        return tuple(tuple(row) for row in self._cells)

    @property
    def spoken(self) -> str:
        """The table as a sentence."""
        headings = self._columns or ("",)
        parts = []
        rows = zip(self._lines, self._cells, self._measured, strict=True)
        for (label, unit), cells, measured in rows:
            pairs = zip(headings, cells, strict=True)
            numbers = ", ".join(f"{head} {cell}".strip() for head, cell in pairs)
            parts.append(f"{label} {numbers} {unit if measured else ''}".strip())
        return "; ".join(parts)

    def set_line(self, index: int, line: Line) -> None:
        """Change a row's label and unit."""
        if line != self._lines[index]:
            self._lines[index] = line
            self._places = []
            self.renew()

    def show_row(self, index: int, *texts: str) -> None:
        """Show numbers in a row, or words, which have no unit."""
        cells = self._cells[index]
        measured = any(character.isdigit() or character == NOTHING for character in texts[-1])
        if measured != self._measured[index]:
            self._measured[index] = measured
            self.renew()
        for column, text in enumerate(texts):
            if cells[column] != text:
                cells[column] = text
                if self._places:
                    self.update(self._places[index][column].toAlignedRect())

    def renew(self) -> None:
        """Lay out again and repaint."""
        self._places = []
        super().renew()

    def paint_still(self, painter: QPainter) -> None:
        """Paint labels, headings and units."""
        self._lay_out()
        painter.setPen(self.colour("muted"))
        painter.setFont(self.face())
        rows = zip(self._lines, self._places, self._measured, strict=True)
        for (label, unit), places, measured in rows:
            first, last = places[0], places[-1]
            painter.drawText(first.adjusted(-first.left(), 0.0, 0.0, 0.0), LEFT, label)
            left = last.right() + (self._gap if unit != "°" else 1.0)
            beside = QRectF(left, last.top(), self.width() - left, last.height())
            painter.drawText(beside, LEFT, unit if measured else "")
        painter.setFont(self.face(0.92))
        for heading, place in zip(self._columns, self._places[0], strict=False):
            above = QRectF(place.left(), place.top() - place.height(), *_size(place))
            painter.drawText(above, RIGHT, heading)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the cells that overlap a rectangle."""
        if not self._places:
            self._lay_out()
        painter.setPen(self.colour("ink"))
        painter.setFont(self.face(self._digits))
        for cells, places in zip(self._cells, self._places, strict=True):
            for text, place in zip(cells, places, strict=True):
                if text and place.intersects(rect):
                    painter.drawText(place, RIGHT, text)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Lay out again."""
        self._places = []
        super().resizeEvent(event)

    @property
    def _gap(self) -> float:
        return 0.35 * self.text_size

    def _lay_out(self) -> None:
        """Compute the position of every cell, and the largest digits that fit."""
        plain = QFontMetricsF(self.face())
        label = max(plain.horizontalAdvance(name) for name, _ in self._lines)
        unit = max(plain.horizontalAdvance(symbol) for _, symbol in self._lines)
        unit += self._gap if unit else 0.0
        count = len(self._cells[0])
        free = max(1.0, self.width() - label - unit - 1.0)
        wanted = QFontMetricsF(self.face(DIGITS)).horizontalAdvance(self._widest) + 1.2 * self._gap
        width = min(free / count, 1.6 * wanted)
        self._digits = DIGITS if width >= wanted else max(0.6, DIGITS * width / wanted)
        headings = 1 if self._columns else 0
        height = min(self.height() / (len(self._lines) + headings), TALLEST_ROW * self.text_size)
        left = label + free - count * width
        words = [
            0.0 if count > 1 else left - plain.horizontalAdvance(name) - self._gap
            for name, _ in self._lines
        ]  # in a single column, a word may be wider than the numbers and extend to the label
        top = (self.height() - height * (len(self._lines) + headings)) / 2 + headings * height
        self._places = [
            [
                QRectF(left + column * width, top + row * height, width, height).adjusted(
                    -words[row], 0.0, 0.0, 0.0
                )
                for column in range(count)
            ]
            for row in range(len(self._lines))
        ]


def _size(place: QRectF) -> tuple[float, float]:
    return place.width(), place.height()

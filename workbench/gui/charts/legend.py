"""Names of a chart's curves and their values, now or under the cursor."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from PyQt6.QtCore import QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QFont,
    QFontMetricsF,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QResizeEvent,
    QShowEvent,
)
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.charts.curve_style import CurveStyle
from workbench.gui.charts.strokes import make_pen
from workbench.gui.theme import Look

SAMPLE = 16.0
"""Length of the stroke before a name [pixels]."""
GAP = 14.0
"""Between two names [pixels]."""

_LEFT = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
_RIGHT = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter


@dataclass(frozen=True)
class Entry:
    """A line of the legend.

    Attributes:
        label: of the curve.
        value: as text with its unit, "" for none.
        colour: number of its colour.
        style: of its stroke.
        number: at its end in the chart, 0 for none.
        visible: whether it is drawn.
    """

    label: str
    value: str
    colour: int
    style: CurveStyle
    number: int
    visible: bool


class Legend(QWidget):
    """Shows entries in rows, as many as there is room for; a click hides or shows a curve.

    Args:
        look: colours.
        parent: whose life it shares.
    """

    toggled = pyqtSignal(int)
    """Index of the entry that was clicked."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._entries: tuple[Entry, ...] = ()
        self._widths: list[float] = []
        self._title = ""
        self._free = 0.0
        self.setAccessibleName("Legend")
        policy = QSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Minimum)
        policy.setHeightForWidth(True)
        self.setSizePolicy(policy)
        self.setMinimumWidth(80)
        look.changed.connect(self.update)

    @property
    def entries(self) -> tuple[Entry, ...]:
        """What is shown."""
        return self._entries

    def show_entries(self, entries: Sequence[Entry]) -> None:
        """Show these; nothing is painted where nothing has changed."""
        if tuple(entries) == self._entries:
            return
        self._entries = tuple(entries)
        widths = [self._width(entry) for entry in self._entries]
        # Room that was once needed stays: the names do not jump as digits come and go.
        if len(widths) == len(self._widths):
            widths = [max(pair) for pair in zip(widths, self._widths, strict=True)]
        if widths != self._widths:
            self._widths = widths
            self._fit()
        self.update()

    @property
    def title(self) -> str:
        """Name of the chart."""
        return self._title

    def set_title(self, title: str) -> None:
        """Begin the first row with a name, "" for none."""
        self._title = title
        self._fit()
        self.update()

    def keep_free(self, width: float) -> None:
        """Keep so much free at the end of the first row [pixels]."""
        if width != self._free:
            self._free = width
            self._fit()

    def forget_widths(self) -> None:
        """Take only the room that is needed from now on."""
        self._widths = [self._width(entry) for entry in self._entries]
        self._fit()

    def sizeHint(self) -> QSize:
        """Return the room that one row takes."""
        return QSize(160, self.heightForWidth(max(160, self.width())))

    def heightForWidth(self, width: int) -> int:
        """Return the height of all rows."""
        rows = 1 + max((box.top() // self._row() for box in self._boxes(width)), default=0)
        return int(rows * self._row())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Break the rows anew."""
        self._fit()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Take the rows that are needed."""
        self._fit()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        if self._title:
            painter.setFont(self._bold())
            painter.setPen(self._look.colour("ink"))
            room = QRectF(0.0, 0.0, self.width() - self._free, self._row())
            painter.drawText(room, _LEFT, self._title)
            painter.setFont(self.font())
        ground = self._look.colour("card")
        for entry, box in zip(self._entries, self._boxes(self.width()), strict=True):
            colour = self._look.curve(entry.colour)
            if entry.colour < 0:
                colour = self._look.colour("command")
            ink = self._look.colour("ink" if entry.visible else "muted")
            pen = make_pen(colour, entry.style, ground)
            pen.setWidth(2)
            if entry.style is CurveStyle.DASHED:
                pen.setDashPattern([2.5, 1.5])
            y = box.center().y()
            if entry.visible:
                painter.setPen(pen)
                painter.drawLine(QPointF(box.left(), y), QPointF(box.left() + SAMPLE, y))
            left = box.left() + SAMPLE + 5.0
            if entry.number:
                painter.setPen(QPen(colour, 1))
                painter.drawText(box.adjusted(SAMPLE + 5.0, 0, 0, 0), int(_LEFT), f"{entry.number}")
                left += self._text_width(f"{entry.number}") + 5.0
            painter.setPen(ink)
            label = entry.label if entry.visible else f"{entry.label} (hidden)"
            painter.drawText(
                QRectF(left, box.top(), box.right() - left, box.height()), _LEFT, label
            )
            if entry.visible:
                painter.setPen(self._look.colour("muted"))
                painter.drawText(box, _RIGHT, entry.value)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Hide or show the curve whose name is clicked."""
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            super().mousePressEvent(event)
            return
        for index, box in enumerate(self._boxes(self.width())):
            if box.contains(event.position()):
                self.toggled.emit(index)

    def box_of(self, index: int) -> QRectF:
        """Return where an entry is."""
        return self._boxes(self.width())[index]

    def _boxes(self, width: int) -> list[QRectF]:
        boxes, top, end = [], 0.0, width - self._free
        left = QFontMetricsF(self._bold()).horizontalAdvance(self._title) + GAP
        left = left if self._title else 0.0
        for each in self._widths:
            if left > 0.0 and left + each > end:
                left, top, end = 0.0, top + self._row(), width
            boxes.append(QRectF(left, top, min(each, width), self._row()))
            left += each + GAP
        return boxes

    def _width(self, entry: Entry) -> float:
        width = SAMPLE + 5.0 + self._text_width(entry.label)
        if not entry.visible:
            width += self._text_width(" (hidden)")
        if entry.number:
            width += self._text_width(f"{entry.number}") + 5.0
        return math.ceil(width + (7.0 + self._text_width(entry.value) if entry.value else 0.0)) + 1

    def _text_width(self, text: str) -> float:
        return float(self.fontMetrics().horizontalAdvance(text))

    def _row(self) -> float:
        return float(self.fontMetrics().height() + 4)

    def _bold(self) -> QFont:
        font = QFont(self.font())
        font.setWeight(QFont.Weight.DemiBold)
        return font

    def _fit(self) -> None:
        # how wide it will be is known only once it is seen
        height = self.heightForWidth(self.width()) if self.isVisible() else int(self._row())
        if height != self.minimumHeight():
            self.setMinimumHeight(height)
            self.updateGeometry()

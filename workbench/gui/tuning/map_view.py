"""A map of a metric over two gains: colours, lines of equal value, and where one stands."""

import math
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QColor,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPixmap,
    QResizeEvent,
)
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.analysis.replies import Mapped
from workbench.gui.theme import Look
from workbench.gui.tuning.map_grid import MapGrid
from workbench.gui.tuning.map_picture import MapPicture


@dataclass(frozen=True)
class Spot:
    """A place on the map: values of the gains along x and y."""

    x: float
    y: float


class MapView(QWidget):
    """Paints a map; a click, or arrow keys and Enter, choose a place on it.

    Args:
        look: colours.
    """

    picked = pyqtSignal(float, float)
    """Values of the gains along x and y that were chosen."""
    read = pyqtSignal(str)
    """What is under the pointer, in words."""

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self._mapped: Mapped | None = None
        self._spot = Spot(math.nan, math.nan)
        self._cursor: tuple[int, int] | None = None
        self._picture: QPixmap | None = None
        self.setMinimumHeight(120)
        self.setMouseTracking(True)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setAccessibleName("Map over two gains: arrows move, Enter proposes")
        look.changed.connect(self._forget)

    @property
    def mapped(self) -> Mapped | None:
        """What is shown."""
        return self._mapped

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(320, 240)

    def show_map(self, mapped: Mapped | None) -> None:
        """Show a map, None for nothing."""
        self._mapped = mapped
        if mapped is None:
            self._cursor = None
        self._forget()

    def show_spot(self, x: float, y: float) -> None:
        """Mark the gains that are proposed."""
        self._spot = Spot(x, y)
        self.update()

    def point_at(self, place: QPointF) -> tuple[float, float] | None:
        """Return the gains at a place of the widget, None beside the map."""
        return self._grid.gains(place) if self._grid is not None else None

    def place_of(self, x: float, y: float) -> QPointF:
        """Return where gains stand in the widget."""
        assert self._grid is not None
        return self._grid.place(x, y)

    @property
    def _grid(self) -> MapGrid | None:
        if self._mapped is None:
            return None
        return MapGrid(self._box(), self._mapped.x, self._mapped.y)

    def _box(self) -> QRectF:
        metrics = self.fontMetrics()
        left = metrics.horizontalAdvance("0.0000") + 8.0
        bottom = metrics.height() + 4.0
        return QRectF(left, 4.0, self.width() - left - 6.0, self.height() - bottom - 4.0)

    def _forget(self) -> None:
        self._picture = None
        self.update()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Draw the map anew."""
        self._forget()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the map, which is kept as a picture, and what moves on it."""
        painter = QPainter(self)
        if self._mapped is None:
            painter.setPen(self._look.colour("muted"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "No map yet")
            return
        if self._picture is None:
            self._picture = self._draw()
        painter.drawPixmap(0, 0, self._picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if math.isfinite(self._spot.x):
            self._ring(painter, self.place_of(self._spot.x, self._spot.y), 6.0)
        if self._cursor is not None and self._grid is not None and self.hasFocus():
            at = self._grid.cell(*map(float, self._cursor))
            painter.setPen(QPen(QColor("white"), 1.5))
            painter.drawRect(QRectF(at.x() - 5.0, at.y() - 5.0, 10.0, 10.0))

    def _ring(self, painter: QPainter, at: QPointF, size: float) -> None:
        """Draw a ring with a cross, dark and light, to be seen on any colour."""
        for colour, width in ((QColor("black"), 3.5), (QColor("white"), 1.5)):
            painter.setPen(QPen(colour, width))
            painter.drawEllipse(at, size, size)
            painter.drawLine(at - QPointF(size + 5.0, 0.0), at - QPointF(size, 0.0))
            painter.drawLine(at + QPointF(size + 5.0, 0.0), at + QPointF(size, 0.0))
            painter.drawLine(at - QPointF(0.0, size + 5.0), at - QPointF(0.0, size))
            painter.drawLine(at + QPointF(0.0, size + 5.0), at + QPointF(0.0, size))

    def _draw(self) -> QPixmap:
        assert self._mapped is not None and self._grid is not None
        ratio = self.devicePixelRatioF()
        picture = QPixmap(self.size() * ratio)
        picture.setDevicePixelRatio(ratio)
        picture.fill(QColor(0, 0, 0, 0))
        painter = QPainter(picture)
        painter.setFont(self.font())
        MapPicture(self._mapped, self._grid, self._look, self.font()).paint(painter)
        painter.end()
        return picture

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Read the value under the pointer."""
        assert event is not None
        found = self.point_at(event.position())
        self.read.emit(self._text(*found) if found is not None else "")

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Choose the place under the pointer."""
        assert event is not None
        found = self.point_at(event.position())
        if found is not None and event.button() == Qt.MouseButton.LeftButton:
            self.setFocus()
            self.picked.emit(*found)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Move over the map, and choose."""
        assert event is not None
        moves = {
            Qt.Key.Key_Left: (-1, 0),
            Qt.Key.Key_Right: (1, 0),
            Qt.Key.Key_Up: (0, 1),
            Qt.Key.Key_Down: (0, -1),
        }
        key = Qt.Key(event.key())
        if self._mapped is None or (key not in moves and key not in _ENTER):
            super().keyPressEvent(event)
            return
        x, y = self._mapped.x, self._mapped.y
        column, row = self._cursor or (len(x) // 2, len(y) // 2)
        if key in _ENTER:
            self.picked.emit(float(x[column]), float(y[row]))
            return
        column = min(max(column + moves[key][0], 0), len(x) - 1)
        row = min(max(row + moves[key][1], 0), len(y) - 1)
        self._cursor = column, row
        said = self._text(float(x[column]), float(y[row]))
        self.setAccessibleDescription(said)
        self.read.emit(said)
        self.update()

    def _text(self, x: float, y: float) -> str:
        assert self._mapped is not None
        asked, values = self._mapped.asked, self._mapped.values
        column = int(np.abs(self._mapped.x - x).argmin())
        row = int(np.abs(self._mapped.y - y).argmin())
        value = float(values[row, column])
        share = self._mapped.unit == "1"
        unit = "%" if share else self._mapped.unit
        said = f"{100.0 * value if share else value:.3g} {unit}" if math.isfinite(value) else "lost"
        return f"{asked.x} {x:.3g}, {asked.y} {y:.3g}: {said}"


_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)

"""The card of the map: a metric over two gains around the proposed ones."""

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QBrush,
    QColor,
    QFont,
    QFontMetrics,
    QKeyEvent,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPixmap,
    QResizeEvent,
)
from PyQt6.QtWidgets import QComboBox, QSizePolicy, QWidget

from workbench.analysis.questions import DrawMap
from workbench.analysis.replies import Mapped
from workbench.gui.analysis import Follower
from workbench.gui.charts.colour_scale import colour_table, colours_of, image_of
from workbench.gui.charts.ticks import round_step
from workbench.gui.errands import single_shot
from workbench.gui.layout import fill
from workbench.gui.theme import Look
from workbench.gui.tuning.card import Card, Sentence, fields_beside
from workbench.gui.tuning.limits import STEP_LIMITS
from workbench.gui.tuning.trial import Trial
from workbench.gui.workspace import Workspace

Segment = tuple[float, float, float, float]
"""Coordinates x and y of both ends, in columns and rows of the grid."""
USUAL_SHARE = 0.8
"""Share of the grid that determines the colour range if the rest is far away."""
CONTOURS = 6
"""Approximate number of contour lines."""
NUMBERED_PIECES = 6
"""Least number of pieces of a line with a number."""
PAIRS = {
    "x": ("kp_velocity_x", "kp_pitch"),
    "y": ("kp_velocity_y", "kp_roll"),
    "z": ("kp_velocity_z", "kd_velocity_z"),
    "yaw": ("kp_yaw_rate", "kd_pitch"),
}
"""Gains with the largest effect on a response along an axis."""
REST = 120
"""Ask for a map when gains have not changed for this time [ms]: it takes hundreds of flights."""


@dataclass(frozen=True)
class MapGrid:
    """Positions of a map's points, each in the centre of its cell.

    Attributes:
        box: area of the map in the widget.
        x: values along the columns.
        y: values along the rows, increasing upwards.
    """

    box: QRectF
    x: np.ndarray
    y: np.ndarray

    def cell(self, column: float, row: float) -> QPointF:
        """Return the position of a column and a row, which need not be whole."""
        return QPointF(
            self.box.left() + (column + 0.5) / len(self.x) * self.box.width(),
            self.box.bottom() - (row + 0.5) / len(self.y) * self.box.height(),
        )

    def place(self, x: float, y: float) -> QPointF:
        """Return the position of gains, limited to the map."""
        column = np.interp(x, self.x, np.arange(len(self.x)))
        row = np.interp(y, self.y, np.arange(len(self.y)))
        return self.cell(float(column), float(row))

    def gains(self, place: QPointF) -> tuple[float, float] | None:
        """Return the gains at a position, None outside the map."""
        if not self.box.contains(place):
            return None
        column = (place.x() - self.box.left()) / self.box.width() * len(self.x) - 0.5
        row = (self.box.bottom() - place.y()) / self.box.height() * len(self.y) - 0.5
        return (
            float(np.interp(column, np.arange(len(self.x)), self.x)),
            float(np.interp(row, np.arange(len(self.y)), self.y)),
        )


def contour_segments(values: np.ndarray, level: float) -> list[Segment]:
    """Return pieces of the contour line of a grid; none beside a NaN.

    Args:
        values: (rows, columns).
        level: value of the line.
    """
    found: list[Segment] = []
    corners = np.stack([values[:-1, :-1], values[:-1, 1:], values[1:, 1:], values[1:, :-1]])
    above = corners >= level
    crossed = np.isfinite(corners).all(axis=0) & above.any(axis=0) & ~above.all(axis=0)
    for row, column in zip(*np.nonzero(crossed), strict=True):
        points = list(_crossings(corners[:, row, column].tolist(), level))
        for one, other in zip(points[::2], points[1::2], strict=True):
            found.append((column + one[0], row + one[1], column + other[0], row + other[1]))
    return found


def _crossings(corners: list[float], level: float) -> Iterator[tuple[float, float]]:
    """Yield the crossings of the line with the four sides of a cell, in order around it."""
    places = ((0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0))
    for index in range(4):
        one, other = corners[index], corners[(index + 1) % 4]
        if (one >= level) != (other >= level):
            share = (level - one) / (other - one)
            (x0, y0), (x1, y1) = places[index], places[(index + 1) % 4]
            yield x0 + share * (x1 - x0), y0 + share * (y1 - y0)


def value_range(values: np.ndarray) -> tuple[float, float]:
    """Return the range of a grid's values for the colours.

    A few flights that are nearly lost have such large numbers that all others would look alike, so
    the upper end is the value below which four fifths of the grid lie.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 0.0
    low, usual, high = np.quantile(finite, (0.0, USUAL_SHARE, 1.0)).tolist()
    return float(low), float(usual if high - low > 3.0 * (usual - low) > 0.0 else high)


def contour_levels(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return about this many round values between two."""
    if high <= low:
        return ()
    step = round_step(high - low, count)
    first = np.floor(low / step) + 1.0
    return tuple(float(each) for each in np.arange(first * step, high, step))


class MapPicture:
    """Paints a map, which the view keeps as a pixmap.

    Args:
        mapped: the map.
        grid: positions of its points.
        look: source of colours for the rest.
        font: font of its numbers.
    """

    def __init__(self, mapped: Mapped, grid: MapGrid, look: Look, font: QFont) -> None:
        self._mapped, self._grid, self._look, self._font = mapped, grid, look, font

    def paint(self, painter: QPainter) -> None:
        """Paint the map."""
        values = self._mapped.values
        low, high = value_range(values)
        known = np.where(np.isfinite(values), values, low)
        colours = colours_of(known, low, high, colour_table())
        painter.drawImage(self._grid.box, image_of(colours[::-1]))
        self._hatch(painter, self._grid.box)
        self._paint_lines(painter)
        self._paint_axes(painter, self._grid.box)

    def _hatch(self, painter: QPainter, box: QRectF) -> None:
        """Hatch flights that were lost, or lack the metric."""
        rows, columns = self._mapped.values.shape
        width, height = box.width() / columns, box.height() / rows
        lines = QBrush(self._look.colour("bad"), Qt.BrushStyle.BDiagPattern)
        for row, column in zip(*np.nonzero(~np.isfinite(self._mapped.values)), strict=True):
            cell = QRectF(
                box.left() + column * width, box.bottom() - (row + 1) * height, width, height
            )
            painter.fillRect(cell, self._look.colour("field"))
            painter.fillRect(cell, lines)

    def _paint_lines(self, painter: QPainter) -> None:
        values, factor = self._mapped.values, 100.0 if self._mapped.unit == "1" else 1.0
        small = QFont(self._font)
        small.setWeight(QFont.Weight.DemiBold)
        painter.setFont(small)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        taken: list[QPointF] = []
        for level in contour_levels(*value_range(values), CONTOURS):
            pieces = contour_segments(values, level)
            for pen in (QPen(QColor(0, 0, 0, 110), 2.0), QPen(QColor(255, 255, 255, 210), 1.0)):
                painter.setPen(pen)
                for x0, y0, x1, y1 in pieces:
                    painter.drawLine(self._grid.cell(x0, y0), self._grid.cell(x1, y1))
            if len(pieces) >= NUMBERED_PIECES:
                self._label(painter, f"{level * factor:.3g}", pieces, taken)

    def _label(
        self,
        painter: QPainter,
        text: str,
        pieces: list[Segment],
        taken: list[QPointF],
    ) -> None:
        """Write a value on its line, if no other value is there."""
        box = self._grid.box
        for x, y, *_ in sorted(pieces, key=lambda piece: abs(piece[0] - piece[1])):
            at = self._grid.cell(x, y)
            inside = box.adjusted(16.0, 8.0, -16.0, -8.0).contains(at)
            if inside and all((at - other).manhattanLength() > 34.0 for other in taken):
                taken.append(at)
                place = QRectF(at.x() - 24.0, at.y() - 9.0, 48.0, 18.0)
                painter.setPen(QColor(0, 0, 0, 170))
                for way in ((1, 1), (-1, 1), (1, -1), (-1, -1)):
                    shifted = place.translated(QPointF(*map(float, way)))
                    painter.drawText(shifted, Qt.AlignmentFlag.AlignCenter, text)
                painter.setPen(QColor("white"))
                painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)
                return

    def _paint_axes(self, painter: QPainter, box: QRectF) -> None:
        painter.setFont(self._font)
        painter.setPen(self._look.colour("muted"))
        line = QFontMetrics(self._font).height()
        for share in (0.0, 0.5, 1.0):
            x = self._mapped.x[round(share * (len(self._mapped.x) - 1))]
            y = self._mapped.y[round(share * (len(self._mapped.y) - 1))]
            wide = QRectF(box.left() + share * box.width() - 40.0, box.bottom() + 2.0, 80.0, line)
            wide.moveLeft(min(max(wide.left(), box.left() - 40.0 * share), box.right() - 40.0))
            side = (Qt.AlignmentFlag.AlignLeft, Qt.AlignmentFlag.AlignHCenter)[share > 0.0]
            if share == 1.0:
                wide.moveRight(box.right())
                side = Qt.AlignmentFlag.AlignRight
            elif share == 0.0:
                wide.moveLeft(box.left())
            painter.drawText(wide, side, f"{x:.3g}")
            top = box.bottom() - share * box.height()
            tall = QRectF(0.0, top - share * line, box.left() - 5.0, line)
            tall.moveTop(min(max(top - 0.5 * line, box.top()), box.bottom() - line))
            painter.drawText(tall, Qt.AlignmentFlag.AlignRight, f"{y:.3g}")


class MapView(QWidget):
    """Paints a map; a click, or arrow keys and Enter, select a point on it.

    Args:
        look: source of colours.
        words: returns a gain's name in words.
    """

    picked = pyqtSignal(float, float)
    """Selected values of the gains along x and y."""
    read = pyqtSignal(str)
    """The value under the pointer, in words."""

    def __init__(self, look: Look, words: Callable[[str], str]) -> None:
        super().__init__()
        self._look, self._words = look, words
        self._mapped: Mapped | None = None
        self._spot: tuple[float, float] | None = None
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
        """The shown map."""
        return self._mapped

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(320, 240)

    def show_map(self, mapped: Mapped | None) -> None:
        """Show a map, None for none."""
        self._mapped = mapped
        if mapped is None:
            self._cursor = None
        self._forget()

    def show_spot(self, x: float, y: float) -> None:
        """Mark the proposed gains."""
        self._spot = x, y
        self.update()

    def point_at(self, place: QPointF) -> tuple[float, float] | None:
        """Return the gains at a position in the widget, None outside the map."""
        return self._grid.gains(place) if self._grid is not None else None

    def place_of(self, x: float, y: float) -> QPointF:
        """Return the position of gains in the widget."""
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
        """Redraw the map."""
        self._forget()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the map, which is cached as a picture, and the marks on it."""
        painter = QPainter(self)
        if self._mapped is None:
            painter.setPen(self._look.colour("muted"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "No map yet")
            return
        if self._picture is None:
            self._picture = self._draw()
        painter.drawPixmap(0, 0, self._picture)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self._spot is not None:
            self._ring(painter, self.place_of(*self._spot), 6.0)
        if self._cursor is not None and self._grid is not None and self.hasFocus():
            at = self._grid.cell(*map(float, self._cursor))
            painter.setPen(QPen(QColor("white"), 1.5))
            painter.drawRect(QRectF(at.x() - 5.0, at.y() - 5.0, 10.0, 10.0))

    def _ring(self, painter: QPainter, at: QPointF, size: float) -> None:
        """Draw a ring with a cross, dark and light, which is visible on any colour."""
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
        """Report the value under the pointer."""
        assert event is not None
        found = self.point_at(event.position())
        self.read.emit(self._text(*found) if found is not None else "")

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Select the point under the pointer."""
        assert event is not None
        found = self.point_at(event.position())
        if found is not None and event.button() == Qt.MouseButton.LeftButton:
            self.setFocus()
            self.picked.emit(*found)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Move over the map, and select."""
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
        return f"{self._words(asked.x)} {x:.3g}, {self._words(asked.y)} {y:.3g}: {said}"


_ENTER = (Qt.Key.Key_Return, Qt.Key.Key_Enter)


class MapCard(Card):
    """Follows the proposed gains; a click on the map proposes others.

    Args:
        workspace: analysis and colours.
        trial: the gains that are being tried.
    """

    def __init__(self, workspace: Workspace, trial: Trial) -> None:
        super().__init__("Map")
        self._trial = trial
        self._axis = ""
        self._follower = Follower(workspace.analysis, DrawMap, self)
        self.across, self.upwards, self.number = QComboBox(), QComboBox(), QComboBox()
        for row in STEP_LIMITS:
            self.number.addItem(row.label, row.name)
        self.number.setCurrentIndex(1)
        self.view = MapView(workspace.look, trial.gains.words)
        self.reading = Sentence()
        fields = (("&Metric", self.number), ("A&cross", self.across), ("&Up", self.upwards))
        for _, box in fields:
            box.setSizeAdjustPolicy(
                QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
            )
            box.activated.connect(self._ask)
        fill(self.body, fields_beside(fields), (self.view, 1), self.reading)
        self._rest = single_shot(self._ask, self, REST)
        trial.changed.connect(self._follow)
        self._follower.answered.connect(self._show)
        self._follower.refused.connect(lambda said: self.said.say(said, "warning"))
        self._follower.preparing.connect(lambda said: self.said.say(f"Drawing … {said}"))
        self.view.picked.connect(self._propose)
        self.view.read.connect(self._read)
        self._read("")

    def begin(self) -> None:
        """Clear the map of another vehicle."""
        self._follower.forget()
        self.view.show_map(None)
        for box in (self.across, self.upwards):
            box.clear()
            for name in self._trial.names:
                box.addItem(self._trial.gains.words(name), name)
                box.setItemData(box.count() - 1, self._trial.gains.table.find(name).help, 3)
        self._axis = ""
        self._follow()

    def set_seen(self, seen: bool) -> None:
        """Ask only while the card is visible."""
        self._follower.set_seen(seen)
        self._say_waiting()

    def _follow(self) -> None:
        step = self._trial.step
        if step is not None and step.axis != self._axis and self.across.count():
            self._axis = step.axis
            law = self._trial.gains.table.controller
            names = {law.gain_of(name): name for name in self._trial.names}
            for box, name in zip((self.across, self.upwards), PAIRS[step.axis], strict=True):
                box.setCurrentIndex(max(0, box.findData(names.get(name))))
        self._show_spot()
        self._rest.start()

    def _ask(self) -> None:
        step, gains = self._trial.step, self._trial.judged
        x, y = self.across.currentData(), self.upwards.currentData()
        if step is None:
            self.said.say("Choose a step of a setpoint: a chirp or a load has none.")
        elif not gains or not x:
            self.said.say("Nothing flies yet.")
        elif x == y:
            self.said.say("Choose two gains that are not the same.", "warning")
        else:
            self.said.say("")
            self._follower.ask(DrawMap(gains, x, y, self.number.currentData(), step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._follower.is_waiting:
            self.said.say("Drawing …")

    def _show(self, mapped: Mapped) -> None:
        self.view.show_map(mapped)
        self.said.say("" if not self._follower.is_waiting else "Drawing …")
        self._show_spot()

    def _show_spot(self) -> None:
        gains, mapped = self._trial.judged, self.view.mapped
        if mapped is not None and mapped.asked.x in gains and mapped.asked.y in gains:
            self.view.show_spot(gains[mapped.asked.x], gains[mapped.asked.y])

    def _propose(self, x: float, y: float) -> None:
        mapped = self.view.mapped
        if mapped is not None:
            values = {mapped.asked.x: _rounded(x), mapped.asked.y: _rounded(y)}
            self._trial.gains.adopt(values, "a place on the map")

    def _read(self, said: str) -> None:
        self.reading.say(said or "Click to propose; hatched: lost")


def _rounded(value: float) -> float:
    """Return three significant digits, enough for a map."""
    return float(f"{value:.3g}")

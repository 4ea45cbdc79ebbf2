"""The map of a metric over two gains: colours, their scale, contour lines, a point to select."""

import math
from collections.abc import Callable

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QPointF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QBrush, QFocusEvent, QKeyEvent, QMouseEvent

from workbench.analysis.replies import Mapped
from workbench.common.plain_text import html_text
from workbench.gui.charts.ticks import round_step
from workbench.gui.instruments.plane_view import style_axis
from workbench.gui.theme import Look

ContourSegment = tuple[float, float, float, float]
"""Coordinates x and y of both ends, in columns and rows of the grid."""
COLOUR_RANGE_SHARE = 0.8
"""Share of the grid that determines the colour range if the rest is far away."""
CONTOUR_LINES = 6
"""Approximate number of contour lines."""
MIN_NUMBERED_PIECES = 6
"""Least number of pieces of a line with a number."""
MAP_NUMBER_OVERHANG_PX = 22
"""Space for the last number below the map beyond its right end [px]."""
COLOUR_BAR_WIDTH_PX = 10
MIN_NUMBER_DISTANCE = 0.12
"""Least distance between numbers: the sum of the shares of the map's width and height."""


def contour_segments(values: np.ndarray, level: float) -> list[ContourSegment]:
    """Return pieces of the contour line of a grid; none beside a NaN.

    Args:
        values: (rows, columns).
        level: value of the line.
    """
    pieces = np.reshape(pg.isocurve(values.T, level), (-1, 4)) - 0.5  # it has corners at halves
    lost = ~np.isfinite(values)
    beside = lost[:-1, :-1] | lost[:-1, 1:] | lost[1:, 1:] | lost[1:, :-1]
    pieces = pieces[np.isfinite(pieces).all(axis=1)]
    cells = ((pieces[:, :2] + pieces[:, 2:]) / 2.0).astype(int).T
    column, row = np.minimum(cells, np.array(beside.shape)[::-1, None] - 1)
    return [tuple(each) for each in pieces[~beside[row, column]].tolist()]


def value_range(values: np.ndarray) -> tuple[float, float]:
    """Return the range of a grid's values for the colours.

    A few flights that are nearly lost have such large numbers that all others would look alike, so
    the upper end is the value below which four fifths of the grid lie.
    """
    finite = values[np.isfinite(values)]
    if not len(finite):
        return 0.0, 0.0
    low, usual, high = np.quantile(finite, (0.0, COLOUR_RANGE_SHARE, 1.0)).tolist()
    return float(low), float(usual if high - low > 3.0 * (usual - low) > 0.0 else high)


def contour_levels(low: float, high: float, count: int) -> tuple[float, ...]:
    """Return about this many round values between two."""
    if high <= low:
        return ()
    step = round_step(high - low, count)
    first = np.floor(low / step) + 1.0
    return tuple(float(each) for each in np.arange(first * step, high, step))


class MapView(pg.PlotWidget):
    """Draws a map; a click, or arrow keys and Enter, select a point on it.

    The plot's coordinates are columns and rows of the map; the gains along them are seldom evenly
    spaced.

    Args:
        look: source of colours.
        words: returns a gain's name in words.

    Attributes:
        mapped: the shown map.
        names: names of the gains along x and y.
    """

    picked = pyqtSignal(float, float)
    """Selected values of the gains along x and y."""
    read = pyqtSignal(str)
    """The value under the pointer, in words."""

    def __init__(self, look: Look, words: Callable[[str], str]) -> None:
        super().__init__(enableMenu=False)
        self._look, self._words = look, words
        self.mapped: Mapped | None = None
        self.names = ("", "")
        self._cursor: tuple[int, int] | None = None
        self._image = pg.ImageItem(axisOrder="row-major", colorMap="viridis")
        self._contours = pg.PlotCurveItem(
            connect="pairs",
            antialias=True,
            pen="#ffffffd2",
            shadowPen=pg.mkPen("#0000006e", width=2),
        )
        self._numbers: list[pg.TextItem] = []
        self._spot = pg.ScatterPlotItem(symbol="crosshair", size=14.0, brush=None)
        self._square = pg.ScatterPlotItem(
            symbol="s", size=10.0, brush=None, pen=pg.mkPen("w", width=1.5)
        )
        self._none = pg.TextItem("No map yet", anchor=(0.5, 0.5))
        self._scale = pg.ColorBarItem(
            width=COLOUR_BAR_WIDTH_PX, interactive=False, colorMap="viridis", colorMapMenu=False
        )
        self._scale.setImageItem(self._image, insert_in=self.plotItem)
        for item in (self._image, self._contours, self._spot, self._square, self._none):
            self.addItem(item)
        self.hideButtons()
        self.setMouseEnabled(False, False)
        self.plotItem.setContentsMargins(0.0, 4.0, 0.0, 0.0)
        self.plotItem.layout.setColumnFixedWidth(4, MAP_NUMBER_OVERHANG_PX)
        self.setMinimumHeight(120)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Map over two gains: arrows move, Enter proposes")
        look.changed.connect(self._apply_colours)
        self._apply_colours()
        self.show_map(None)

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(320, 240)

    def show_map(
        self, mapped: Mapped | None, names: tuple[str, str] = ("", ""), metric: str = ""
    ) -> None:
        """Show a map over the gains with these names, None for none.

        Args:
            mapped: the map.
            names: names of the gains along x and y.
            metric: name of the mapped metric.
        """
        self.mapped, self.names = mapped, names
        while self._numbers:
            self.removeItem(self._numbers.pop())
        for item in (self._image, self._contours, self._spot, self._square):
            item.clear()
        self._none.setVisible(mapped is None)
        self._scale.setVisible(mapped is not None)
        self.showAxes((mapped is not None, False, False, mapped is not None))
        self.getViewBox().background.setVisible(mapped is not None)
        if mapped is None:
            self._cursor = None
            self.setRange(xRange=(-1.0, 1.0), yRange=(-1.0, 1.0))
            return
        rows, columns = mapped.values.shape
        self.setRange(xRange=(-0.5, columns - 0.5), yRange=(-0.5, rows - 0.5), padding=0.0)
        values = mapped.values * _shown_factor(mapped)
        low, high = value_range(values)
        self._image.setImage(values, autoLevels=False)
        self._scale.setLevels((low, max(high, low + 1e-9)))
        self._scale.getAxis("left").setLabel(html_text(f"{metric} {_shown_unit(mapped)}".strip()))
        self._image.setRect(-0.5, -0.5, columns, rows)
        for side, values in (("bottom", mapped.x), ("left", mapped.y)):
            places = (0, (len(values) - 1) // 2, len(values) - 1)
            self.getAxis(side).setTicks([[(each, f"{values[each]:.3g}") for each in places]])
        self._show_lines(mapped)
        self._show_cursor()

    def _show_lines(self, mapped: Mapped) -> None:
        """Draw contour lines, with numbers where no other number is."""
        values = mapped.values * _shown_factor(mapped)
        lines: list[ContourSegment] = []
        taken: list[np.ndarray] = []
        for level in contour_levels(*value_range(values), CONTOUR_LINES):
            pieces = contour_segments(values, level)
            lines += pieces
            for x, y, *_ in sorted(pieces, key=lambda piece: abs(piece[0] - piece[1])):
                share = np.array([x, y]) / values.shape[::-1]
                inside = (abs(share - 0.5) < 0.5 - MIN_NUMBER_DISTANCE / 2.0).all()
                if len(pieces) < MIN_NUMBERED_PIECES:
                    break
                if inside and all(
                    abs(share - other).sum() > MIN_NUMBER_DISTANCE for other in taken
                ):
                    taken.append(share)
                    number = pg.TextItem(f"{level:.3g}", "w", fill="#00000060")
                    number.setAnchor((0.5, 0.5))
                    number.setPos(x, y)
                    self.addItem(number)
                    self._numbers.append(number)
                    break
        self._contours.setData(*np.reshape(lines, (-1, 2)).T)

    def show_spot(self, x: float, y: float) -> None:
        """Mark the proposed gains if they are on the map, dark and light: visible on any colour."""
        if self.mapped is None:
            return
        sides = ((x, self.mapped.x), (y, self.mapped.y))
        if any(not side[0] <= value <= side[-1] for value, side in sides):
            self._spot.clear()
        else:
            column = np.interp(x, self.mapped.x, range(len(self.mapped.x)))
            row = np.interp(y, self.mapped.y, range(len(self.mapped.y)))
            pens = [pg.mkPen("k", width=3.5), pg.mkPen("w", width=1.5)]
            self._spot.setData([column] * 2, [row] * 2, pen=pens)

    def point_at(self, place: QPointF) -> tuple[float, float] | None:
        """Return the gains at a position in the widget, None outside the map."""
        if self.mapped is None or not self.getViewBox().sceneBoundingRect().contains(place):
            return None
        at, x, y = self.getViewBox().mapSceneToView(place), self.mapped.x, self.mapped.y
        return (
            float(np.interp(at.x(), range(len(x)), x)),
            float(np.interp(at.y(), range(len(y)), y)),
        )

    def _apply_colours(self) -> None:
        """Apply the colours of the look."""
        self.setBackground(self._look.colour("card"))
        self._none.setColor(self._look.colour("muted"))
        hatched = QBrush(self._look.colour("bad"), Qt.BrushStyle.BDiagPattern)
        self.getViewBox().setBackgroundColor(hatched)  # seen where the image has no value
        self.getViewBox().background.setVisible(self.mapped is not None)
        for axis in (*map(self.getAxis, ("left", "bottom")), self._scale.axis):
            axis.setStyle(tickLength=0, hideOverlappingLabels=MAP_NUMBER_OVERHANG_PX)
            style_axis(axis, self._look, self.font(), pen=None)
        name = self._scale.getAxis("left")
        name.setTextPen(self._look.colour("muted"))
        name.label.setFont(self.font())

    def _show_cursor(self) -> None:
        seen = [self._cursor] if self._cursor is not None and self.hasFocus() else []
        self._square.setData(pos=seen)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show the selected point."""
        super().focusInEvent(event)
        self._show_cursor()

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Hide the selected point."""
        super().focusOutEvent(event)
        self._show_cursor()

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
        if self.mapped is None or (key not in moves and key not in _ENTER_KEYS):
            super().keyPressEvent(event)
            return
        x, y = self.mapped.x, self.mapped.y
        column, row = self._cursor or (len(x) // 2, len(y) // 2)
        if key in _ENTER_KEYS:
            self.picked.emit(float(x[column]), float(y[row]))
            return
        column = min(max(column + moves[key][0], 0), len(x) - 1)
        row = min(max(row + moves[key][1], 0), len(y) - 1)
        self._cursor = column, row
        said = self._text(float(x[column]), float(y[row]))
        self.setAccessibleDescription(said)
        self.read.emit(said)
        self._show_cursor()

    def _text(self, x: float, y: float) -> str:
        assert self.mapped is not None
        values, (across, up) = self.mapped.values, map(self._words, self.names)
        column = int(np.abs(self.mapped.x - x).argmin())
        row = int(np.abs(self.mapped.y - y).argmin())
        value = float(values[row, column])
        shown = f"{value * _shown_factor(self.mapped):.3g} {_shown_unit(self.mapped)}"
        said = shown if math.isfinite(value) else "crashes"
        return f"{across} {x:.3g}, {up} {y:.3g}: {said}"


def _shown_factor(mapped: Mapped) -> float:
    """Return the factor from a map's values to shown ones: shares are shown in per cent."""
    return 100.0 if mapped.unit == "1" else 1.0


def _shown_unit(mapped: Mapped) -> str:
    return "%" if mapped.unit == "1" else mapped.unit


_ENTER_KEYS = (Qt.Key.Key_Return, Qt.Key.Key_Enter)

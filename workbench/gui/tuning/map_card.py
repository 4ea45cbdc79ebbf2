"""The card of the map: a metric over two gains around the proposed ones."""

import math
from collections.abc import Callable, Iterator

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QPointF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QBrush,
    QFocusEvent,
    QKeyEvent,
    QMouseEvent,
)
from PyQt6.QtWidgets import QComboBox

from workbench.analysis.questions import DrawMap
from workbench.analysis.replies import Mapped
from workbench.gui.analysis import Follower
from workbench.gui.charts.ticks import round_step
from workbench.gui.errands import single_shot
from workbench.gui.labels import tip_text
from workbench.gui.layout import fill
from workbench.gui.theme import Look
from workbench.gui.tuning.card import Card, Sentence, fields_beside, offer
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
OUTSIDE = 22
"""Space for the last number below the map beyond its right end [px]."""
NUMBER_SPACE = 0.12
"""Least distance between numbers: the sum of the shares of the map's width and height."""
PAIRS = {
    "x": ("kp_velocity_x", "kp_pitch"),
    "y": ("kp_velocity_y", "kp_roll"),
    "z": ("kp_velocity_z", "kd_velocity_z"),
    "yaw": ("kp_yaw_rate", "kd_pitch"),
}
"""Gains with the largest effect on a response along an axis."""
REST = 120
"""Ask for a map when gains have not changed for this time [ms]: it takes hundreds of flights."""


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
        for item in (self._image, self._contours, self._spot, self._square, self._none):
            self.addItem(item)
        self.hideButtons()
        self.setMouseEnabled(False, False)
        self.plotItem.setContentsMargins(0.0, 4.0, OUTSIDE, 0.0)
        self.setMinimumHeight(120)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Map over two gains: arrows move, Enter proposes")
        look.changed.connect(self._dress)
        self._dress()
        self.show_map(None)

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(320, 240)

    def show_map(self, mapped: Mapped | None, names: tuple[str, str] = ("", "")) -> None:
        """Show a map over the gains with these names, None for none."""
        self.mapped, self.names = mapped, names
        while self._numbers:
            self.removeItem(self._numbers.pop())
        for item in (self._image, self._contours, self._spot, self._square):
            item.clear()
        self._none.setVisible(mapped is None)
        self.showAxes((mapped is not None, False, False, mapped is not None))
        self.getViewBox().background.setVisible(mapped is not None)
        if mapped is None:
            self._cursor = None
            self.setRange(xRange=(-1.0, 1.0), yRange=(-1.0, 1.0))
            return
        rows, columns = mapped.values.shape
        self.setRange(xRange=(-0.5, columns - 0.5), yRange=(-0.5, rows - 0.5), padding=0.0)
        low, high = value_range(mapped.values)
        self._image.setImage(mapped.values, levels=(low, max(high, low + 1e-9)))
        self._image.setRect(-0.5, -0.5, columns, rows)
        for side, values in (("bottom", mapped.x), ("left", mapped.y)):
            places = (0, (len(values) - 1) // 2, len(values) - 1)
            self.getAxis(side).setTicks([[(each, f"{values[each]:.3g}") for each in places]])
        self._show_lines(mapped)
        self._show_cursor()

    def _show_lines(self, mapped: Mapped) -> None:
        """Draw contour lines, with numbers where no other number is."""
        values, factor = mapped.values, 100.0 if mapped.unit == "1" else 1.0
        lines: list[Segment] = []
        taken: list[np.ndarray] = []
        for level in contour_levels(*value_range(values), CONTOURS):
            pieces = contour_segments(values, level)
            lines += pieces
            for x, y, *_ in sorted(pieces, key=lambda piece: abs(piece[0] - piece[1])):
                share = np.array([x, y]) / values.shape[::-1]
                inside = (abs(share - 0.5) < 0.5 - NUMBER_SPACE / 2.0).all()
                if len(pieces) < NUMBERED_PIECES:
                    break
                if inside and all(abs(share - other).sum() > NUMBER_SPACE for other in taken):
                    taken.append(share)
                    number = pg.TextItem(f"{level * factor:.3g}", "w", fill="#00000060")
                    number.setAnchor((0.5, 0.5))
                    number.setPos(x, y)
                    self.addItem(number)
                    self._numbers.append(number)
                    break
        self._contours.setData(*np.reshape(lines, (-1, 2)).T)

    def show_spot(self, x: float, y: float) -> None:
        """Mark the proposed gains, dark and light, which is visible on any colour."""
        if self.mapped is not None:
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

    def _dress(self) -> None:
        """Apply the colours of the look."""
        self.setBackground(self._look.colour("card"))
        self._none.setColor(self._look.colour("muted"))
        hatched = QBrush(self._look.colour("bad"), Qt.BrushStyle.BDiagPattern)
        self.getViewBox().setBackgroundColor(hatched)  # seen where the image has no value
        for side in ("left", "bottom"):
            self.getAxis(side).setStyle(
                tickLength=0, tickFont=self.font(), hideOverlappingLabels=OUTSIDE
            )
            self.getAxis(side).setPen(None)
            self.getAxis(side).setTextPen(self._look.colour("muted"))

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
        if self.mapped is None or (key not in moves and key not in _ENTER):
            super().keyPressEvent(event)
            return
        x, y = self.mapped.x, self.mapped.y
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
        self._show_cursor()

    def _text(self, x: float, y: float) -> str:
        assert self.mapped is not None
        values, (across, up) = self.mapped.values, map(self._words, self.names)
        column = int(np.abs(self.mapped.x - x).argmin())
        row = int(np.abs(self.mapped.y - y).argmin())
        value = float(values[row, column])
        share = self.mapped.unit == "1"
        unit = "%" if share else self.mapped.unit
        said = f"{100.0 * value if share else value:.3g} {unit}" if math.isfinite(value) else "lost"
        return f"{across} {x:.3g}, {up} {y:.3g}: {said}"


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
        offer(self.number, {row.name: row.label for row in STEP_LIMITS})
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
                help = self._trial.gains.table.find(name).help
                box.setItemData(box.count() - 1, tip_text(help), Qt.ItemDataRole.ToolTipRole)
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
            self.said.say("Choose a step of a setpoint, not a chirp or a load.")
        elif not gains or not x:
            self.said.say("Nothing flies yet.")
        elif x == y:
            self.said.say("Choose two different gains.", "warning")
        else:
            self.said.say("")
            self._follower.ask(DrawMap(gains, x, y, self.number.currentData(), step))
            self._say_waiting()

    def _say_waiting(self) -> None:
        if self._follower.is_waiting:
            self.said.say("Drawing …")

    def _show(self, asked: DrawMap, mapped: Mapped) -> None:
        self.view.show_map(mapped, (asked.x, asked.y))
        self.said.say("" if not self._follower.is_waiting else "Drawing …")
        self._show_spot()

    def _show_spot(self) -> None:
        gains, (x, y) = self._trial.judged, self.view.names
        if x in gains and y in gains:
            self.view.show_spot(gains[x], gains[y])

    def _propose(self, x: float, y: float) -> None:
        across, up = self.view.names
        values = {across: _rounded(x), up: _rounded(y)}
        self._trial.gains.adopt(values, "a place on the map")

    def _read(self, said: str) -> None:
        self.reading.say(said or "Click to propose; hatched: lost")


def _rounded(value: float) -> float:
    """Return three significant digits, enough for a map."""
    return float(f"{value:.3g}")

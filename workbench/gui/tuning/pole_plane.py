"""The complex plane of poles, in which the proposed ones can be dragged."""

import math
from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QPointF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QColor, QKeyEvent, QMouseEvent, QWheelEvent

from workbench.control.loop import loop_label
from workbench.gui.charts.ticks import round_step
from workbench.gui.instruments.plane_view import style_plot
from workbench.gui.theme import Look
from workbench.gui.tuning.pole import Pole
from workbench.gui.wheel import zoom_notches

DAMPING_RAYS = (0.2, 0.4, 0.6, 0.8)
RIGHT_HALF_SHARE = 0.14
"""Share of the width to the right of the imaginary axis."""
POLE_HALF_SIZE_PX = 4.5
"""Half the size of a pole [px]."""
UNSTABLE_POLE_MARGIN_PX = 14.0
"""Least distance of an unstable pole from the edge of the picture [px]."""
POLE_STEP_SHARE = 0.02
"""Step of a pole per key, as a share of its magnitude."""
POLE_KEY_DIRECTIONS = {
    Qt.Key.Key_Left: -1.0,
    Qt.Key.Key_Right: 1.0,
    Qt.Key.Key_Up: 1.0j,
    Qt.Key.Key_Down: -1.0j,
}
"""Directions of the arrow keys."""
POLE_KEY_MODIFIER = Qt.KeyboardModifier.ShiftModifier
POLE_READING_RADIUS_PX = 14.0
"""Largest distance from the pointer at which a pole is read [px]."""
UNSTABLE_REGION_END_RAD_S = 1e6
"""Right end of the marked unstable half of the plane [1/s]."""
POLE_SPAN_LIMITS_RAD_S = (2.0, 2000.0)
"""Smallest and largest visible distance to the left [1/s]."""
UNIT_HALF_CIRCLE = np.append(np.exp(1j * np.linspace(0.0, np.pi, 120)), np.nan)
PoleMarker = dict[str, object]
"""A mark in the plane, as pyqtgraph takes it."""


class PolePlane(pg.PlotWidget):
    """Shows poles: hollow ones are flown, filled ones are proposed, crosses are unstable.

    An unstable pole outside the picture is at its edge, with an arrow towards its position.

    Args:
        look: source of colours.

    Attributes:
        span: visible distance to the left [1/s].
        poles: the shown poles.
        loop: of several poles at one place, that of this loop is read and moved.
    """

    read = pyqtSignal(str)
    """The pole under the pointer in words, "" for none."""
    taken = pyqtSignal(object)
    """A proposed `Pole` that is about to be moved, if poles can be moved."""
    wanted = pyqtSignal(object)
    """Requested place of the pole [1/s]."""
    released = pyqtSignal()
    """The pole is released."""
    given_up = pyqtSignal()
    """The pole returns to its original place."""

    def __init__(self, look: Look) -> None:
        super().__init__(enableMenu=False)
        self._look = look
        self.poles: tuple[Pole, ...] = ()
        self.span = 40.0
        self.loop = ""
        self._chosen: Pole | None = None
        self._movable = False
        self._place: complex | None = None
        self._view = self.getViewBox()
        self._unstable = pg.LinearRegionItem(
            (0.0, UNSTABLE_REGION_END_RAD_S), movable=False, pen=pg.mkPen(None)
        )
        self._axis = pg.InfiniteLine(0.0)
        self._dampings = [
            pg.InfiniteLine(
                (0.0, 0.0),
                math.degrees(math.acos(-each)),
                label=f"{each:g}",
                labelOpts={"position": 0.95},
            )
            for each in DAMPING_RAYS
        ]
        self._rings = pg.PlotCurveItem(antialias=True, connect="finite")
        self._spots = pg.ScatterPlotItem()
        for item in (self._unstable, self._axis, *self._dampings, self._rings, self._spots):
            self.addItem(item)
        self.hideButtons()
        self.getAxis("bottom").setLabel("Re 1/s")
        self.getAxis("left").setLabel("Im 1/s")
        self.plotItem.setContentsMargins(0.0, 4.0, 4.0, 0.0)
        self.setMinimumHeight(110)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName("Pole plane: left and right go from pole to pole, + and − zoom")
        self._view.sigResized.connect(self._fit)
        look.changed.connect(self._apply_colours)
        self._apply_colours()

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(320, 220)

    def show_poles(self, poles: Sequence[Pole]) -> None:
        """Show poles."""
        if tuple(poles) == self.poles:
            return
        self.poles = tuple(poles)
        if self._place is None and self._chosen not in self.poles:
            self._choose(None)
        self._show()

    @property
    def chosen(self) -> Pole | None:
        """The pole that is read."""
        return self._chosen

    def set_movable(self, movable: bool) -> None:
        """Set whether proposed poles can be moved: by the mouse, or by Shift and the arrow keys."""
        self._movable = movable
        if movable:
            self.setAccessibleName(
                "Pole plane: left and right go from pole to pole, with Shift the arrows move a "
                "proposed pole, + and − zoom"
            )

    def follow_pole(self, value: complex) -> None:
        """Read the proposed pole nearest to a value [1/s]: the one that is being moved."""
        _, pole = self._nearest(self.place(Pole(value, proposed=True)), proposed=True)
        if pole is not None:
            self._choose(pole)

    def zoom(self, factor: float) -> None:
        """Zoom out by a factor, or in if it is below 1."""
        self.span = min(
            max(self.span * factor, POLE_SPAN_LIMITS_RAD_S[0]), POLE_SPAN_LIMITS_RAD_S[1]
        )
        self._fit()

    def place(self, pole: Pole) -> QPointF:
        """Return a pole's position in the widget; an unstable one never leaves the picture."""
        return self._view.mapViewToScene(self._seen(pole))

    def is_beyond(self, pole: Pole) -> bool:
        """Return whether a pole is farther out than its position shows."""
        return self._seen(pole) != QPointF(pole.value.real, pole.value.imag)

    def _seen(self, pole: Pole) -> QPointF:
        """Return where in the plane a pole is drawn."""
        x, y = pole.value.real, pole.value.imag
        if pole.is_stable:
            return QPointF(x, y)
        (_, right), (_, top) = self._view.viewRange()
        edge = UNSTABLE_POLE_MARGIN_PX * self._view.viewPixelSize()[0]
        return QPointF(min(x, right - edge), min(y, top - edge))

    def _fit(self) -> None:
        """Show the span, with one scale along both axes: angles show the damping."""
        right = self.span * RIGHT_HALF_SHARE / (1.0 - RIGHT_HALF_SHARE)
        high = (self.span + right) * self._view.height() / max(self._view.width(), 1.0)
        self.setRange(xRange=(-self.span, right), yRange=(0.0, high), padding=0.0)
        step, reach = round_step(self.span, 4), math.hypot(self.span, high)
        rings = step * np.arange(1.0, reach / step)
        x, y = np.outer(rings, UNIT_HALF_CIRCLE.real), np.outer(rings, UNIT_HALF_CIRCLE.imag)
        self._rings.setData(x.ravel(), y.ravel())
        self.getAxis("bottom").setTicks([[(-ring, f"−{ring:g}") for ring in rings] + [(0.0, "0")]])
        self.getAxis("left").setTicks([[(0.0, "0")] + [(ring, f"{ring:g}") for ring in rings]])
        self._show()

    def _apply_colours(self) -> None:
        """Apply the colours of the look."""
        style_plot(self, self._look)
        colour = self._look.colour
        unstable = colour("bad")
        unstable.setAlpha(22)
        self._unstable.setBrush(unstable)
        self._axis.setPen(colour("muted"))
        self._rings.setPen(colour("line"))
        for line in self._dampings:
            line.setPen(colour("line"))
            line.label.setColor(colour("muted"))
        self._show()

    def _show(self) -> None:
        """Draw the poles."""
        spots = []
        for pole in self.poles:
            colour = self._look.colour("accent" if pole.proposed else "muted")
            if not pole.is_stable:
                colour = self._look.colour("bad")
            if pole.whose:
                colour = self._look.curve(pole.colour)
            at, fill = self._seen(pole), colour if pole.proposed else None
            if pole.is_stable:
                size = 1.5 * POLE_HALF_SIZE_PX if pole.proposed else 2.0 * POLE_HALF_SIZE_PX + 2.0
                spots.append(_pole_marker(at, "o", size, colour, fill))
            else:
                spots.append(_pole_marker(at, "x", 2.8 * POLE_HALF_SIZE_PX, colour, fill))
            if self.is_beyond(pole):
                spots.append(self._arrow(pole, at, colour))
            if pole == self._chosen:
                spots.append(
                    _pole_marker(at, "o", 4.4 * POLE_HALF_SIZE_PX, self._look.colour("ink"))
                )
        if self._place is not None:
            at = QPointF(self._place.real, self._place.imag)
            spots.append(
                _pole_marker(at, "crosshair", 4.4 * POLE_HALF_SIZE_PX, self._look.colour("ink"))
            )
        self._spots.setData(spots=spots)

    def _arrow(self, pole: Pole, at: QPointF, colour: QColor) -> PoleMarker:
        """Return an arrow towards a pole outside the picture."""
        way = (UNSTABLE_POLE_MARGIN_PX - 3.0) * self._view.viewPixelSize()[0]
        if pole.value.real > at.x():
            return _pole_marker(
                at + QPointF(way, 0.0), "t2", 1.5 * POLE_HALF_SIZE_PX, colour, colour
            )
        return _pole_marker(at + QPointF(0.0, way), "t1", 1.5 * POLE_HALF_SIZE_PX, colour, colour)

    def _choose(self, pole: Pole | None) -> None:
        if pole != self._chosen:
            self._chosen = pole
            said = f"{pole.text}{self._hidden_text(pole)}" if pole is not None else ""
            self.setAccessibleDescription(said)
            self.read.emit(said)
            self._show()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Read the pole under the pointer, or move the held one."""
        assert event is not None
        if self._place is not None:
            self._want(self._value(event.position()))
            return
        pole = self._under(event.position())
        self._choose(pole)
        can = self._can_move(pole)
        self.viewport().setCursor(
            Qt.CursorShape.OpenHandCursor if can else Qt.CursorShape.ArrowCursor
        )

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Grab the proposed pole under the pointer."""
        assert event is not None
        pole = self._under(event.position(), proposed=self._movable)
        if event.button() == Qt.MouseButton.LeftButton and self._can_move(pole):
            assert pole is not None
            self._choose(pole)
            self._take(pole)
            self.viewport().setCursor(Qt.CursorShape.ClosedHandCursor)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Release the pole."""
        self._let_go()

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        """Release a pole that was moved by keys."""
        assert event is not None
        if Qt.Key(event.key()) in POLE_KEY_DIRECTIONS and not event.isAutoRepeat():
            self._let_go()
        else:
            super().keyReleaseEvent(event)

    def _under(self, here: QPointF, *, proposed: bool = False) -> Pole | None:
        """Return the pole under the pointer; on request only among the proposed ones."""
        way, pole = self._nearest(here, proposed=proposed)
        return pole if way <= POLE_READING_RADIUS_PX else None

    def _nearest(self, here: QPointF, *, proposed: bool) -> tuple[float, Pole | None]:
        """Return the distance [px] to the nearest pole, and the pole that is in front there.

        In front are proposed poles, which can be moved, and of these that of `loop`.
        """
        ways = [
            (math.hypot(here.x() - at.x(), here.y() - at.y()), pole)
            for at, pole in ((self.place(pole), pole) for pole in self.poles)
            if pole.proposed or not proposed
        ]
        ways.sort(key=lambda each: each[0])
        way = ways[0][0] if ways else math.inf
        there = (pole for other, pole in ways if other <= way + POLE_HALF_SIZE_PX)
        return way, min(
            there,
            key=lambda pole: (not pole.proposed, not self.loop or pole.loop != self.loop),
            default=None,
        )

    def _hidden_text(self, pole: Pole) -> str:
        """Return which loops have a pole under a proposed one, "" for none."""
        here = self.place(pole)
        loops = {
            loop_label(other.loop): None
            for other in self.poles
            if pole.proposed and other.proposed and other.loop not in ("", pole.loop)
            if (self.place(other) - here).manhattanLength() < POLE_HALF_SIZE_PX
        }
        return f"; a pole of {' and '.join(loops)} lies under it" if loops else ""

    def _value(self, here: QPointF) -> complex:
        """Return the value at a position in the widget [1/s], in the upper half of the plane."""
        at, ((left, right), (low, high)) = self._view.mapSceneToView(here), self._view.viewRange()
        return complex(min(max(at.x(), left), right), min(max(at.y(), low), high))

    def _can_move(self, pole: Pole | None) -> bool:
        return self._movable and pole is not None and pole.proposed

    def _take(self, pole: Pole) -> None:
        self._place = pole.value
        self.taken.emit(pole)
        self._show()

    def _want(self, place: complex) -> None:
        self._place = place
        self.wanted.emit(place)
        self._show()

    def _let_go(self) -> None:
        if self._place is not None:
            self._place = None
            self.released.emit()
            self._show()

    def _step(self, way: complex) -> None:
        """Move the selected pole by one step."""
        pole = self._chosen
        if pole is None or not self._can_move(pole):
            return
        if self._place is None:
            self._take(pole)
        assert self._place is not None
        moved = self._place + POLE_STEP_SHARE * abs(pole.value) * way
        self._want(complex(moved.real, max(moved.imag, 0.0)))

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom while Ctrl is held."""
        if notches := zoom_notches(event):
            self.zoom(0.8 if notches > 0.0 else 1.25)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Select another pole, move one, or zoom."""
        assert event is not None
        key = Qt.Key(event.key())
        if self._movable and key in POLE_KEY_DIRECTIONS and event.modifiers() & POLE_KEY_MODIFIER:
            self._step(POLE_KEY_DIRECTIONS[key])
        elif key == Qt.Key.Key_Escape and self._place is not None:
            self._place = None
            self.given_up.emit()
            self._show()
        elif key in (Qt.Key.Key_Plus, Qt.Key.Key_Minus, Qt.Key.Key_Equal):
            self.zoom(1.25 if key is Qt.Key.Key_Minus else 0.8)
        elif key in (Qt.Key.Key_Left, Qt.Key.Key_Right) and self.poles:
            move = -1 if key is Qt.Key.Key_Left else 1
            order = sorted(self.poles, key=lambda pole: (pole.value.real, pole.value.imag))
            at = order.index(self._chosen) + move if self._chosen in order else len(order) - 1
            self._choose(order[at % len(order)])
        else:
            super().keyPressEvent(event)


def _pole_marker(
    at: QPointF, symbol: str, size: float, colour: QColor, fill: QColor | None = None
) -> PoleMarker:
    pen = pg.mkPen(colour, width=1.5)
    return {"pos": at, "symbol": symbol, "size": size, "pen": pen, "brush": fill}

"""The view of a point cloud around the drone, from any side."""

import dataclasses
import math

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import QFocusEvent, QKeyEvent, QMouseEvent, QPolygonF, QWheelEvent
from PyQt6.QtWidgets import QGraphicsPolygonItem

from workbench.gui.charts.colour_scale import colour_table, colours_of
from workbench.gui.charts.ticks import round_step
from workbench.gui.instruments.plane_view import UNIT_CIRCLE, PlaneView
from workbench.gui.poses import Viewpoint
from workbench.gui.theme import Look
from workbench.gui.wheel import zoom_notches

VIEW_TURN_STEP_RAD = math.radians(10.0)
"""Rotation per key press [rad]."""
POINTS_PER_WIDTH = 500.0
"""Number of points that would fill the width side by side, if there is much room."""
MIN_CLOUD_WIDTH_M, MAX_CLOUD_WIDTH_M = 2.0, 200.0
"""Smallest and largest visible width [m]."""
DRONE_SHAPE = np.array([[1.0, 0, 0], [-0.7, 0.6, 0], [-0.35, 0, 0], [-0.7, -0.6, 0]])
"""Corners of an arrow along x."""
TOP_VIEWPOINT = Viewpoint()
SIDE_VIEWPOINT = Viewpoint(turn=math.pi / 2, tilt=0.0)
SLANTED_VIEWPOINT = Viewpoint(turn=math.radians(25.0), tilt=math.radians(32.0))


def paint_points(
    seen: np.ndarray, colours: np.ndarray, width: int, height: int, size: int
) -> np.ndarray:
    """Return a picture (height, width, 4) of projected points, the nearest on top.

    Args:
        seen: pixels right and down, and distance (n, 3).
        colours: red, green and blue bytes of the points (n, 3).
        width: width of the picture [pixels].
        height: height of the picture [pixels].
        size: size of a point [pixels].
    """
    picture = np.zeros((height, width, 4), dtype=np.uint8)
    order = np.argsort(-seen[:, 2])
    u, v = seen[order, 0].astype(np.intp), seen[order, 1].astype(np.intp)
    inside = (u >= 0) & (u < width - size) & (v >= 0) & (v < height - size)
    u, v = u[inside], v[inside]
    ink = np.column_stack([colours[order][inside], np.full(len(u), 255, dtype=np.uint8)])
    for down in range(size):
        for right in range(size):
            picture[v + down, u + right] = ink
    return picture


class CloudView(PlaneView):
    """Shows points around the drone, which is in the centre.

    Drag, or arrow keys: rotate. Ctrl and wheel, or + and -: zoom. T, S, P: view from the top, the
    side, or obliquely.

    Args:
        look: source of colours.

    Attributes:
        points: positions relative to the drone (n, 3) [m].
        viewpoint: where the plane is seen from.
    """

    turned = pyqtSignal()
    """The viewpoint has changed."""

    def __init__(self, look: Look) -> None:
        super().__init__(look, "Lidar cloud")
        self.setAccessibleDescription("Arrows turn it, plus and minus change the distance")
        self.points = np.zeros((0, 3))
        self._values = np.zeros(0)
        self._heading = 0.0
        self._ends, self._name = (0.0, 1.0), "Height m"
        self._dragged: QPointF | None = None
        self.viewpoint = SLANTED_VIEWPOINT
        self._picture = pg.ImageItem(axisOrder="row-major")
        self._rings = pg.PlotCurveItem(antialias=True, connect="finite")
        self._drone = QGraphicsPolygonItem()
        self._metres = [pg.TextItem(anchor=(0.0, 1.0)) for _ in range(3)]
        self.add(self._picture, self._rings, self._drone, *self._metres)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumSize(200, 160)
        self.view.sigResized.connect(self._draw)
        self.apply_colours()

    def show_points(
        self, points: np.ndarray, values: np.ndarray, name: str, heading: float
    ) -> None:
        """Show points around the drone.

        Args:
            points: positions relative to the drone (n, 3) [m].
            values: values for the colours (n).
            name: name of the values, with unit.
            heading: heading of the drone in the frame of the points [rad].
        """
        self.points, self._values, self._name, self._heading = points, values, name, heading
        super().show_hint("")
        if len(values):
            low, high = np.percentile(values, (1.0, 99.0))
            step = round_step(max(high - low, 0.5), 8)
            # whole steps, so that the colours do not flicker between scans
            self._ends = step * math.floor(low / step), step * math.ceil(high / step)
        self._draw()

    def show_hint(self, hint: str) -> None:
        """Show why there are no points."""
        super().show_hint(hint)
        self.points, self._values = np.zeros((0, 3)), np.zeros(0)
        self._draw()

    def look_from(self, viewpoint: Viewpoint) -> None:
        """Change the viewpoint."""
        width = min(max(viewpoint.width, MIN_CLOUD_WIDTH_M), MAX_CLOUD_WIDTH_M)
        tilt = min(max(viewpoint.tilt, -math.pi / 2), math.pi / 2)
        self.viewpoint = dataclasses.replace(viewpoint, width=width, tilt=tilt)
        self.turned.emit()
        self._draw()

    def apply_colours(self) -> None:
        """Apply the colours of the look, and the font."""
        super().apply_colours()
        self.view.setBackgroundColor(self.look.colour("field"))
        self._show_focus()
        self._rings.setPen(self.pen("line"))
        self._drone.setPen(self.pen("field"))
        self._drone.setBrush(pg.mkBrush(self.look.colour("accent")))
        for text in self._metres:
            text.setColor(self.look.colour("muted"))
            text.setFont(self.font())
            text.fill = pg.mkBrush(self.look.colour("field"))
        self._draw()

    def _draw(self) -> None:
        """Draw the points as a picture in screen pixels, the rings, and the drone."""
        at, ratio = self.viewpoint, self.devicePixelRatioF()
        width, height = (max(1, int(ratio * each)) for each in self._size())
        tall = at.width * height / width
        area = QRectF(-0.5 * at.width, -0.5 * tall, at.width, tall)
        self.show_area(area)
        table = self._table()
        seen = at.project(self.points, width, height)
        colours = colours_of(self._values, *self._ends, table)
        size = round(max(2.0, width / ratio / POINTS_PER_WIDTH) * ratio)
        self._picture.setImage(paint_points(seen, colours, width, height, size)[::-1])
        self._picture.setRect(area)
        self.show_scale(table, *self._ends, self._name)
        step = round_step(0.5 * at.width, 3)
        rings = []
        for number, text in enumerate(self._metres, 1):
            circle = number * step * UNIT_CIRCLE
            level = np.column_stack([circle.real, circle.imag, np.zeros(len(circle))])
            ring = level @ at.axes().T
            nearest = int(np.argmin(ring[:-1, 2] + 1e-3 * ring[:-1, 1]))
            text.setText(f"{number * step:g} m")
            text.setPos(*ring[nearest, :2])
            rings.append(ring)
        x, y, _ = np.concatenate(rings).T
        self._rings.setData(x, y)
        c, s = math.cos(self._heading), math.sin(self._heading)
        shape = 0.035 * at.width * DRONE_SHAPE @ np.array([[c, s, 0], [-s, c, 0], [0, 0, 1]])
        corners = (shape @ at.axes().T)[:, :2].tolist()
        self._drone.setPolygon(QPolygonF([QPointF(*each) for each in corners]))

    def _size(self) -> tuple[float, float]:
        return self.view.width(), self.view.height()

    def _show_focus(self) -> None:
        self.view.setBorder(self.pen("accent", 2.0) if self.hasFocus() else None)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Start rotating."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self._dragged = event.position()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Rotate."""
        if event is not None and self._dragged is not None:
            way = event.position() - self._dragged
            self._dragged = event.position()
            self._turn(-way.x() * 0.008, way.y() * 0.008)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Stop rotating."""
        self._dragged = None

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom while Ctrl is held."""
        if notches := zoom_notches(event):
            self._zoom(0.85**notches)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        """Rotate by keys."""
        turns = {
            Qt.Key.Key_Left: (VIEW_TURN_STEP_RAD, 0.0),
            Qt.Key.Key_Right: (-VIEW_TURN_STEP_RAD, 0.0),
            Qt.Key.Key_Up: (0.0, VIEW_TURN_STEP_RAD),
            Qt.Key.Key_Down: (0.0, -VIEW_TURN_STEP_RAD),
        }
        zooms = {Qt.Key.Key_Plus: 0.8, Qt.Key.Key_Equal: 0.8, Qt.Key.Key_Minus: 1.25}
        views = {
            Qt.Key.Key_T: TOP_VIEWPOINT,
            Qt.Key.Key_S: SIDE_VIEWPOINT,
            Qt.Key.Key_P: SLANTED_VIEWPOINT,
        }
        key = event.key() if event is not None else 0
        if key in turns:
            self._turn(*turns[Qt.Key(key)])
        elif key in zooms:
            self._zoom(zooms[Qt.Key(key)])
        elif key in views:
            self.look_from(dataclasses.replace(views[Qt.Key(key)], width=self.viewpoint.width))
        else:
            super().keyPressEvent(event)

    def focusInEvent(self, event: QFocusEvent | None) -> None:
        """Show the keyboard focus."""
        self._show_focus()

    def focusOutEvent(self, event: QFocusEvent | None) -> None:
        """Hide the keyboard focus."""
        self._show_focus()

    def _turn(self, turn: float, tilt: float) -> None:
        at = self.viewpoint
        self.look_from(dataclasses.replace(at, turn=at.turn + turn, tilt=at.tilt + tilt))

    def _zoom(self, factor: float) -> None:
        self.look_from(dataclasses.replace(self.viewpoint, width=self.viewpoint.width * factor))

    def _table(self) -> np.ndarray:
        # leaves out the end close to the background's brightness
        return colour_table(0.2, 1.0) if self.look.is_dark else colour_table(0.0, 0.82)

"""A plain picture of the flight that Qt draws itself, for where no 3-D engine can."""

import math
import time
from collections import deque

import numpy as np
from PyQt6.QtCore import QPointF, QSize, Qt
from PyQt6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF, QWheelEvent
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.session.snapshot import Snapshot

PERIOD = 1 / 15
"""Between two pictures [s of wall]: the flight comes first."""
TRAIL_TIME = 30.0
"""Of the path that is drawn [s]."""
SPANS = (1.0, 100.0)
"""Smallest and largest height of what is shown [m]."""
GRID = 10
"""Lines of the ground on each side of the drone."""
ROUND = np.linspace(0.0, 2.0 * math.pi, 17)
RADIUS = 0.35
"""Of a rotor's disc, as a share of its way from the middle."""
STILL = 0.05
"""A slower wind has no arrow [m/s]."""
ARROW, HEAD = 0.25, 5.0
"""Length of an arrow for one m/s of wind [m], and of its head [px]."""
ELEVATION = math.radians(20.0)


class PlainView(QWidget):
    """Shows drone, ground, trail, thrusts and wind in parallel projection.

    Args:
        look: colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("Plain view of the flight")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(120)
        self._look = look
        self._way, self._span = "reset", 4.0
        self._trail_shown = True
        self._vehicle: Vehicle | None = None
        self._now: Snapshot | None = None
        self._trail: deque[tuple[float, tuple[float, float, float]]] = deque()
        self._drawn = 0.0
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(360, 300)

    def show_view(self, view: LiveView) -> None:
        """Take the present; it is drawn some fifteen times a second."""
        now = view.snapshot
        if now is None or view.vehicle is None:
            return
        if self._now is not None and now.time < self._now.time:
            self._trail.clear()
        self._vehicle, self._now = view.vehicle, now
        if not self._trail or now.time - self._trail[-1][0] >= PERIOD:
            self._trail.append((now.time, now.p_WB))
        while self._trail[0][0] < now.time - TRAIL_TIME:
            self._trail.popleft()
        wall = time.monotonic()
        if self.isVisible() and wall - self._drawn >= PERIOD:
            self._drawn = wall
            self.update()

    def look(self, way: str) -> None:
        """Look from behind the drone (follow), from the top, from the south (side), or askew."""
        self._way = way
        if way == "reset":
            self._span = 4.0
        self.update()

    def show_trail(self, shown: bool) -> None:
        """Show the path of the last half minute, or hide it."""
        self._trail_shown = shown
        self.update()

    def axes(self) -> np.ndarray:
        """Return what points to the right and up in the picture, as rows in W (2, 3)."""
        if self._way == "top":
            return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        azimuth, elevation = {
            "side": (0.5 * math.pi, 0.0),
            "follow": (self._now.roll_pitch_yaw[2] if self._now else 0.0, ELEVATION),
        }.get(self._way, (math.radians(50.0), ELEVATION))
        ahead = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        right = np.array([ahead[1], -ahead[0], 0.0])
        up = math.sin(elevation) * ahead + np.array([0.0, 0.0, math.cos(elevation)])
        return np.array([right, up])

    def points(self, p_W: np.ndarray) -> list[QPointF]:
        """Return where points in W (N, 3) stand in the widget."""
        assert self._now is not None
        scale = self.height() / self._span
        x, y = self.axes() @ (np.asarray(p_W, dtype=float) - self._now.p_WB).T * scale
        middle = QPointF(self.width() / 2.0, self.height() / 2.0)
        return [middle + QPointF(float(a), -float(b)) for a, b in zip(x, y, strict=True)]

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Come nearer, or go away."""
        assert event is not None
        factor = 0.8 if event.angleDelta().y() > 0 else 1.25
        self._span = min(max(self._span * factor, SPANS[0]), SPANS[1])
        self.update()
        event.accept()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint all."""
        painter = QPainter(self)
        painter.fillRect(self.rect(), self._look.colour("field"))
        if self._now is None or self._vehicle is None:
            return
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        self._paint_ground(painter, self._now)
        if self._trail_shown and len(self._trail) > 1:
            painter.setPen(QPen(self._look.curve(0), 1.5))
            painter.drawPolyline(QPolygonF(self.points(np.array([p for _, p in self._trail]))))
        self._paint_drone(painter, self._now, self._vehicle)
        self._paint_words(painter, self._now)

    def _paint_ground(self, painter: QPainter, now: Snapshot) -> None:
        """Draw lines on the ground, and how far the drone is above it."""
        painter.setPen(QPen(self._look.colour("line"), 1.0))
        step = 10.0 ** math.floor(math.log10(self._span))
        x, y = (step * round(each / step) for each in now.p_WB[:2])
        reach = GRID * step
        for index in range(-GRID, GRID + 1):
            way = index * step
            for ends in (
                ((x + way, y - reach, 0.0), (x + way, y + reach, 0.0)),
                ((x - reach, y + way, 0.0), (x + reach, y + way, 0.0)),
            ):
                painter.drawLine(*self.points(np.array(ends)))
        painter.setPen(QPen(self._look.colour("muted"), 1.0, Qt.PenStyle.DotLine))
        below = (now.p_WB[0], now.p_WB[1], 0.0)
        painter.drawLine(*self.points(np.array([now.p_WB, below])))

    def _paint_drone(self, painter: QPainter, now: Snapshot, vehicle: Vehicle) -> None:
        R_WB = rotation(now.q_WB)
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + now.p_WB
        centre = R_WB @ np.asarray(vehicle.p_BoBcm_B) + now.p_WB
        size = RADIUS * float(np.linalg.norm(hubs - centre, axis=1).mean())
        disc = size * np.column_stack([np.cos(ROUND), np.sin(ROUND), np.zeros_like(ROUND)]) @ R_WB.T
        ink = self._look.colour("ink")
        weight = vehicle.mass * GRAVITY / len(hubs)
        for hub, thrust in zip(hubs, now.thrusts, strict=True):
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(ink, 2.5))
            painter.drawLine(*self.points(np.array([centre, hub])))
            painter.setPen(QPen(self._look.colour("accent"), 1.5))
            painter.drawPolygon(QPolygonF(self.points(hub + disc)))
            up = R_WB[:, 2] * 2.0 * size * thrust / weight
            self._paint_arrow(painter, hub, hub + up, self._look.colour("good"))
        nose = centre + R_WB[:, 0] * 2.0 * size
        painter.setPen(QPen(self._look.colour("bad"), 2.5))
        painter.drawLine(*self.points(np.array([centre, nose])))
        wind = np.asarray(now.wind)
        if np.linalg.norm(wind) > STILL:
            self._paint_arrow(painter, centre - ARROW * wind, centre, self._look.colour("warning"))

    def _paint_arrow(
        self, painter: QPainter, tail: np.ndarray, tip: np.ndarray, colour: QColor
    ) -> None:
        start, end = self.points(np.array([tail, tip]))
        way = end - start
        length = math.hypot(way.x(), way.y())
        painter.setPen(QPen(colour, 1.8))
        painter.drawLine(start, end)
        if length > HEAD:
            along = way * (HEAD / length)
            for side in (-0.5, 0.5):
                across = QPointF(-along.y(), along.x()) * side
                painter.drawLine(end, end - along + across)

    def _paint_words(self, painter: QPainter, now: Snapshot) -> None:
        east, north, up = now.p_WB
        wind = float(np.linalg.norm(now.wind))
        said = f"east {east:.1f} m, north {north:.1f} m, height {up:.1f} m"
        if wind > STILL:
            said += f", wind {wind:.1f} m/s"
        painter.setPen(self._look.colour("muted"))
        box = self.rect().adjusted(8, 6, -8, -6)
        painter.drawText(box, Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignBottom, said)


def rotation(q: tuple[float, float, float, float]) -> np.ndarray:
    """Return the rotation matrix of a quaternion w, x, y, z of length 1."""
    w, x, y, z = q
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )

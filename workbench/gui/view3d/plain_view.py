"""A plain picture of the flight that Qt draws itself, for where no 3-D engine can."""

import math
import time
from collections import deque
from collections.abc import Set

import numpy as np
from PyQt6.QtCore import QPointF, QSize, Qt
from PyQt6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF, QWheelEvent
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.theme import Look
from workbench.gui.view3d.scene import Track
from workbench.gui.visualization.frame_tree import rotation_of
from workbench.live.arrows import STILL, arrows, disc_radius
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.outline import Outline
from workbench.session.snapshot import Snapshot

PERIOD = 1 / 15
"""Between two pictures [s of wall]: the flight comes first."""
TRAIL_TIME = 30.0
"""Of the path that is drawn [s]."""
SPANS = (1.0, 100.0)
"""Smallest and largest height of what is shown [m]."""
MOST_POINTS = 1000
"""Of a cloud or a path that are drawn."""
MOST_EDGES = 6
"""Upright ones of an obstacle."""
GRID = 10
"""Lines of the ground on each side of the drone."""
ROUND = np.linspace(0.0, 2.0 * math.pi, 17)
HEAD = 5.0
"""Length of an arrow's head [px]."""
ELEVATION = math.radians(20.0)


class PlainView(QWidget):
    """Shows drone, ground, obstacles, trail, thrusts, wind and lidar in parallel projection.

    And a log that is replayed beside it, which the picture follows then, and a predicted way.

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
        self._way = self._turn = "reset"
        self._span = 4.0
        self._parts = {"trail", "arrows", "lidar"}
        self._outlines: tuple[Outline, ...] = ()
        self._cloud: np.ndarray | None = None
        self._track: Track | None = None
        self._replayed: np.ndarray | None = None
        self._ahead, self._ahead_ends = np.empty((0, 3)), -math.inf
        self._middle, self._yaw = np.zeros(3), 0.0
        self._vehicle: Vehicle | None = None
        self._now: Snapshot | None = None
        self._trail: deque[tuple[float, tuple[float, float, float]]] = deque()
        self._drawn = 0.0
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return a comfortable size."""
        return QSize(360, 300)

    def show_view(self, view: LiveView, cloud: np.ndarray | None = None) -> None:
        """Take the present; it is drawn some fifteen times a second.

        Args:
            view: of the flight.
            cloud: what the lidar has met, in W (N, 3) [m]; None without.
        """
        now = view.snapshot
        if now is None or view.vehicle is None:
            return
        if self._now is not None and now.time < self._now.time:
            self._trail.clear()
        self._vehicle, self._now = view.vehicle, now
        self._outlines, self._cloud = view.outlines, cloud
        self._stand()
        if not self._trail or now.time - self._trail[-1][0] >= PERIOD:
            self._trail.append((now.time, now.p_WB))
        while self._trail[0][0] < now.time - TRAIL_TIME:
            self._trail.popleft()
        wall = time.monotonic()
        if self.isVisible() and wall - self._drawn >= PERIOD:
            self._drawn = wall
            self.update()

    def look(self, way: str) -> None:
        """Look from behind the drone (follow), from the top, from the south (side), or askew.

        With "free" the picture stays where it is, and with the wheel comes nearer.
        """
        self._turn = self._turn if way == "free" else way
        self._way = way
        self._stand()
        if way == "reset":
            self._span = 4.0
        self.update()

    def show_parts(self, parts: Set[str]) -> None:
        """Show these of trail, arrows and lidar."""
        self._parts = set(parts)
        self.update()

    def show_track(self, track: Track | None) -> None:
        """Show the path of a log, or of none."""
        self._track = track
        self.update()

    def show_replay(self, pose: np.ndarray | None) -> None:
        """Show the drone of a log at a pose in W (4, 4) [m], and follow it; None shows none."""
        self._replayed = pose
        self._stand()
        self.update()

    def foresee(self, ends: float, places: np.ndarray) -> None:
        """Show a predicted way (N, 3) [m], until its end [s]."""
        self._ahead_ends, self._ahead = ends, places
        self.update()

    def _stand(self) -> None:
        """Let the middle of the picture be the drone that is followed."""
        if self._way == "free":
            return
        if self._replayed is not None:
            self._middle = self._replayed[:3, 3]
            self._yaw = math.atan2(self._replayed[1, 0], self._replayed[0, 0])
        elif self._now is not None:
            self._middle = np.array(self._now.p_WB)
            self._yaw = self._now.roll_pitch_yaw[2]

    def axes(self) -> np.ndarray:
        """Return what points to the right and up in the picture, as rows in W (2, 3)."""
        if self._turn == "top":
            return np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0]])
        azimuth, elevation = {
            "side": (0.5 * math.pi, 0.0),
            "follow": (self._yaw, ELEVATION),
        }.get(self._turn, (math.radians(50.0), ELEVATION))
        ahead = np.array([math.cos(azimuth), math.sin(azimuth), 0.0])
        right = np.array([ahead[1], -ahead[0], 0.0])
        up = math.sin(elevation) * ahead + np.array([0.0, 0.0, math.cos(elevation)])
        return np.array([right, up])

    def points(self, p_W: np.ndarray) -> list[QPointF]:
        """Return where points in W (N, 3) stand in the widget."""
        scale = self.height() / self._span
        x, y = self.axes() @ (np.asarray(p_W, dtype=float) - self._middle).T * scale
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
        for outline in self._outlines:
            self._paint_obstacle(painter, outline.at(self._now.time))
        if "lidar" in self._parts and self._cloud is not None and len(self._cloud):
            painter.setPen(QPen(self._look.colour("bad"), 2.0))
            thinned = self._cloud[:: 1 + len(self._cloud) // MOST_POINTS]
            painter.drawPoints(QPolygonF(self.points(thinned)))
        if "trail" in self._parts:
            self._paint_way(painter, np.array([p for _, p in self._trail]), self._look.curve(0))
        if self._now.time <= self._ahead_ends:
            self._paint_way(painter, self._ahead, self._look.colour("command"))
        if self._replayed is not None and self._track is not None:
            self._paint_replayed(painter, self._replayed, self._track, self._vehicle)
        self._paint_drone(painter, self._now, self._vehicle)
        self._paint_words(painter, self._now)

    def _paint_way(self, painter: QPainter, places: np.ndarray, colour: QColor) -> None:
        if len(places) > 1:
            painter.setPen(QPen(colour, 1.5))
            painter.drawPolyline(QPolygonF(self.points(places)))

    def _paint_obstacle(self, painter: QPainter, outline: Outline) -> None:
        """Draw its upper and lower rim, and what stands between them."""
        corners = np.array(outline.corners)
        rims = [
            self.points(np.column_stack([corners, np.full(len(corners), height)]))
            for height in (outline.low, outline.high)
        ]
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(self._look.colour("muted"), 1.0))
        for rim in rims:
            painter.drawPolygon(QPolygonF(rim))
        step = 1 + len(corners) // MOST_EDGES
        for below, above in zip(rims[0][::step], rims[1][::step], strict=True):
            painter.drawLine(below, above)

    def _paint_replayed(
        self, painter: QPainter, pose: np.ndarray, track: Track, vehicle: Vehicle
    ) -> None:
        """Draw a log's path, and the discs of its drone's rotors."""
        colour = QColor(self._look.colour("warning"))
        self._paint_way(painter, track.p_WB[:: 1 + len(track.p_WB) // MOST_POINTS], colour)
        R_WB, p_WB = pose[:3, :3], pose[:3, 3]
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + p_WB
        for hub in hubs:
            painter.drawLine(*self.points(np.array([p_WB, hub])))
            painter.drawPolygon(QPolygonF(self.points(hub + _disc(vehicle) @ R_WB.T)))

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
        R_WB = rotation_of(now.q_WB)
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + now.p_WB
        centre = R_WB @ np.asarray(vehicle.p_BoBcm_B) + now.p_WB
        disc = _disc(vehicle) @ R_WB.T
        ink = self._look.colour("ink")
        for hub in hubs:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(ink, 2.5))
            painter.drawLine(*self.points(np.array([centre, hub])))
            painter.setPen(QPen(self._look.colour("accent"), 1.5))
            painter.drawPolygon(QPolygonF(self.points(hub + disc)))
        nose = centre + R_WB[:, 0] * 2.0 * disc_radius(vehicle)
        painter.setPen(QPen(self._look.colour("bad"), 2.5))
        painter.drawLine(*self.points(np.array([centre, nose])))
        if "arrows" in self._parts:
            *thrusts, wind = zip(*arrows(vehicle, now), strict=True)
            for ends in thrusts:
                self._paint_arrow(painter, *ends, self._look.colour("good"))
            self._paint_arrow(painter, *wind, self._look.colour("warning"))

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
        east, north, up = (round(each, 1) + 0.0 for each in now.p_WB)  # no minus before 0.0
        wind = float(np.linalg.norm(now.wind))
        said = f"east {east:.1f} m, north {north:.1f} m, height {up:.1f} m"
        if wind > STILL:
            said += f", wind {wind:.1f} m/s"
        box = self.rect().adjusted(8, 6, -8, -6)
        how = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignBottom | Qt.TextFlag.TextWordWrap
        plate = painter.boundingRect(box, int(how), said)
        painter.fillRect(plate.adjusted(-4, -2, 4, 2), self._look.colour("field"))
        painter.setPen(self._look.colour("muted"))
        painter.drawText(box, int(how), said)


def _disc(vehicle: Vehicle) -> np.ndarray:
    """Return the rim of a rotor's disc about its hub, in B (N, 3) [m]."""
    circle = np.column_stack([np.cos(ROUND), np.sin(ROUND), np.zeros_like(ROUND)])
    rim: np.ndarray = disc_radius(vehicle) * circle
    return rim

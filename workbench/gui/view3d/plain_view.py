"""The plain 3-D view, drawn by Qt where no 3-D engine works."""

import math
import time
from collections import deque
from collections.abc import Set

import numpy as np
from PyQt6.QtCore import QPointF, QSize, Qt
from PyQt6.QtGui import QColor, QPainter, QPaintEvent, QPen, QPolygonF, QWheelEvent
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.common.plain_text import plain_name
from workbench.gui.poses import Viewpoint, rotation_of
from workbench.gui.preferences import Preferences
from workbench.gui.theme import Look
from workbench.gui.units import LENGTH_UNIT, unit_for
from workbench.gui.view3d.scene import LogTrack
from workbench.live.arrows import MIN_ARROW_WIND_M_S, arrow_ends, drawn_disc_radius
from workbench.live.cable_lines import cable_line
from workbench.live.view import LiveView
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.outline import Outline
from workbench.session.snapshot import Snapshot

PLAIN_VIEW_PERIOD_S = 1 / 15
"""Period between pictures [s of wall]: the flight has priority."""
PLAIN_TRAIL_S = 30.0
"""Length of the drawn path [s]."""
PLAIN_VIEW_HEIGHT_LIMITS_M = (1.0, 100.0)
"""Smallest and largest visible height [m]."""
MAX_PLAIN_VIEW_POINTS = 1000
"""Largest number of drawn points of a cloud or a path."""
MAX_OBSTACLE_EDGES = 6
"""Largest number of drawn vertical edges of an obstacle."""
GRID_LINES = 10
"""Number of ground lines on each side of the drone."""
DISC_ANGLES_RAD = np.linspace(0.0, 2.0 * math.pi, 17)
ARROW_HEAD_PX = 5.0
"""Length of an arrow's head [px]."""
VIEW_ELEVATION_RAD = math.radians(20.0)


class PlainView(QWidget):
    """Shows drone, ground, obstacles, trail, thrusts, wind and lidar in parallel projection.

    It also shows a predicted path, and a replayed log beside the flight, which the picture then
    follows.

    Args:
        look: source of colours.
        preferences: units.
    """

    def __init__(self, look: Look, preferences: Preferences) -> None:
        super().__init__()
        self.setAccessibleName("Plain view of the flight")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumHeight(120)
        self._look, self._preferences = look, preferences
        self._way = self._turn = "reset"
        self._span = 4.0
        self._parts = {"trail", "arrows", "lidar"}
        self._outlines: tuple[Outline, ...] = ()
        self._cloud: np.ndarray | None = None
        self._track: LogTrack | None = None
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
        """Show a view; drawn about fifteen times a second.

        Args:
            view: view of the flight.
            cloud: points of the lidar's returns, in W (N, 3) [m]; None without a lidar.
        """
        now = view.snapshot
        if now is None or view.vehicle is None:
            return
        if self._now is not None and now.time < self._now.time:
            self._trail.clear()
        self._vehicle, self._now = view.vehicle, now
        self._outlines, self._cloud = view.outlines, cloud
        self._stand()
        if not self._trail or now.time - self._trail[-1][0] >= PLAIN_VIEW_PERIOD_S:
            self._trail.append((now.time, now.p_WB))
        while self._trail[0][0] < now.time - PLAIN_TRAIL_S:
            self._trail.popleft()
        wall = time.monotonic()
        if self.isVisible() and wall - self._drawn >= PLAIN_VIEW_PERIOD_S:
            self._drawn = wall
            self.update()

    def look(self, way: str) -> None:
        """Look from behind the drone (follow), from the top, from the south (side), or obliquely.

        With "free" the picture does not follow the drone; the wheel zooms.
        """
        self._turn = self._turn if way == "free" else way
        self._way = way
        self._stand()
        if way == "reset":
            self._span = 4.0
        self.update()

    def show_parts(self, parts: Set[str]) -> None:
        """Show some of trail, arrows and lidar."""
        self._parts = set(parts)
        self.update()

    def show_track(self, track: LogTrack | None) -> None:
        """Show the path of a log, or none."""
        self._track = track
        self.update()

    def show_replay(self, pose: np.ndarray | None) -> None:
        """Show the drone of a log at a pose in W (4, 4) [m], and follow it; None hides it."""
        self._replayed = pose
        self._stand()
        self.update()

    def foresee(self, ends: float, places: np.ndarray) -> None:
        """Show a predicted path (N, 3) [m], until its end [s]."""
        self._ahead_ends, self._ahead = ends, places
        self.update()

    def _stand(self) -> None:
        """Centre the picture on the followed drone."""
        if self._way == "free":
            return
        if self._replayed is not None:
            self._middle = self._replayed[:3, 3]
            self._yaw = math.atan2(self._replayed[1, 0], self._replayed[0, 0])
        elif self._now is not None:
            self._middle = np.array(self._now.p_WB)
            self._yaw = self._now.roll_pitch_yaw[2]

    def axes(self) -> np.ndarray:
        """Return the picture's right and up directions, as rows in W (2, 3)."""
        quarter = 0.5 * math.pi
        turn, tilt = {
            "top": (quarter, quarter),
            "side": (quarter, 0.0),
            "follow": (self._yaw, VIEW_ELEVATION_RAD),
        }.get(self._turn, (math.radians(50.0), VIEW_ELEVATION_RAD))
        return Viewpoint(turn, tilt).axes()[:2]

    def points(self, p_W: np.ndarray) -> list[QPointF]:
        """Return the positions of points in W (N, 3) in the widget."""
        scale = self.height() / self._span
        x, y = self.axes() @ (np.asarray(p_W, dtype=float) - self._middle).T * scale
        middle = QPointF(self.width() / 2.0, self.height() / 2.0)
        return [middle + QPointF(float(a), -float(b)) for a, b in zip(x, y, strict=True)]

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom in or out."""
        assert event is not None
        factor = 0.8 if event.angleDelta().y() > 0 else 1.25
        self._span = min(
            max(self._span * factor, PLAIN_VIEW_HEIGHT_LIMITS_M[0]), PLAIN_VIEW_HEIGHT_LIMITS_M[1]
        )
        self.update()
        event.accept()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint everything."""
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
            thinned = self._cloud[:: 1 + len(self._cloud) // MAX_PLAIN_VIEW_POINTS]
            painter.drawPoints(QPolygonF(self.points(thinned)))
        if "trail" in self._parts:
            self._paint_way(painter, np.array([p for _, p in self._trail]), self._look.curve(0))
        if self._now.time <= self._ahead_ends:
            self._paint_way(painter, self._ahead, self._look.colour("command"))
        if self._replayed is not None and self._track is not None:
            self._paint_replayed(painter, self._replayed, self._track, self._vehicle)
        self._paint_drone(painter, self._now, self._vehicle)
        for cable in self._now.cables:
            colour = self._look.colour("warning" if cable.slack else "ink")
            self._paint_way(painter, cable_line(cable), colour)
        self._paint_words(painter, self._now)

    def _paint_way(self, painter: QPainter, places: np.ndarray, colour: QColor) -> None:
        if len(places) > 1:
            painter.setPen(QPen(colour, 1.5))
            painter.drawPolyline(QPolygonF(self.points(places)))

    def _paint_obstacle(self, painter: QPainter, outline: Outline) -> None:
        """Draw its upper and lower edges, and the vertical edges between them."""
        corners = np.array(outline.corners)
        rims = [
            self.points(np.column_stack([corners, np.full(len(corners), height)]))
            for height in (outline.low, outline.high)
        ]
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(self._look.colour("muted"), 1.0))
        for rim in rims:
            painter.drawPolygon(QPolygonF(rim))
        step = 1 + len(corners) // MAX_OBSTACLE_EDGES
        for below, above in zip(rims[0][::step], rims[1][::step], strict=True):
            painter.drawLine(below, above)

    def _paint_replayed(
        self, painter: QPainter, pose: np.ndarray, track: LogTrack, vehicle: Vehicle
    ) -> None:
        """Draw a log's path, and the rotor discs of its drone."""
        colour = QColor(self._look.colour("warning"))
        self._paint_way(
            painter, track.p_WB[:: 1 + len(track.p_WB) // MAX_PLAIN_VIEW_POINTS], colour
        )
        R_WB, p_WB = pose[:3, :3], pose[:3, 3]
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + p_WB
        for hub in hubs:
            painter.drawLine(*self.points(np.array([p_WB, hub])))
            painter.drawPolygon(QPolygonF(self.points(hub + _rotor_disc_edge(vehicle) @ R_WB.T)))

    def _paint_ground(self, painter: QPainter, now: Snapshot) -> None:
        """Draw lines on the ground, and the drone's height above it."""
        painter.setPen(QPen(self._look.colour("line"), 1.0))
        step = 10.0 ** math.floor(math.log10(self._span))
        x, y = (step * round(each / step) for each in now.p_WB[:2])
        reach = GRID_LINES * step
        for index in range(-GRID_LINES, GRID_LINES + 1):
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
        disc = _rotor_disc_edge(vehicle) @ R_WB.T
        ink = self._look.colour("ink")
        for hub in hubs:
            painter.setBrush(Qt.BrushStyle.NoBrush)
            painter.setPen(QPen(ink, 2.5))
            painter.drawLine(*self.points(np.array([centre, hub])))
            painter.setPen(QPen(self._look.colour("accent"), 1.5))
            painter.drawPolygon(QPolygonF(self.points(hub + disc)))
        nose = centre + R_WB[:, 0] * 2.0 * drawn_disc_radius(vehicle)
        painter.setPen(QPen(self._look.colour("bad"), 2.5))
        painter.drawLine(*self.points(np.array([centre, nose])))
        if "arrows" in self._parts:
            *thrusts, wind = zip(*arrow_ends(vehicle, now), strict=True)
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
        if length > ARROW_HEAD_PX:
            along = way * (ARROW_HEAD_PX / length)
            for side in (-0.5, 0.5):
                across = QPointF(-along.y(), along.x()) * side
                painter.drawLine(end, end - along + across)

    def words(self, now: Snapshot) -> str:
        """Return place, wind and cables of the drone in words."""
        east, north, up = map(LENGTH_UNIT.text, now.p_WB)
        wind = float(np.linalg.norm(now.wind))
        said = f"east {east}, north {north}, height {up}"
        if wind > MIN_ARROW_WIND_M_S:
            said += f", wind {unit_for('m/s', self._preferences).text(wind)}"
        for cable in now.cables:
            state = "slack" if cable.slack else unit_for("N", self._preferences).text(cable.tension)
            said += f", {plain_name(cable.name)} {state}"
        return said

    def _paint_words(self, painter: QPainter, now: Snapshot) -> None:
        said = self.words(now)
        box = self.rect().adjusted(8, 6, -8, -6)
        how = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignBottom | Qt.TextFlag.TextWordWrap
        plate = painter.boundingRect(box, int(how), said)
        painter.fillRect(plate.adjusted(-4, -2, 4, 2), self._look.colour("field"))
        painter.setPen(self._look.colour("muted"))
        painter.drawText(box, int(how), said)


def _rotor_disc_edge(vehicle: Vehicle) -> np.ndarray:
    """Return the edge of a rotor's disc around its hub, in B (N, 3) [m]."""
    circle = np.column_stack(
        [np.cos(DISC_ANGLES_RAD), np.sin(DISC_ANGLES_RAD), np.zeros_like(DISC_ANGLES_RAD)]
    )
    rim: np.ndarray = drawn_disc_radius(vehicle) * circle
    return rim

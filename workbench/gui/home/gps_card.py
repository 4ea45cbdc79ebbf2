"""Satellite navigation: the position, and a map of the path; north is up."""

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPen, QPolygonF
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.card import Card, beside, put
from workbench.gui.home.sensor_state import sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.hint import Hint
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.map_frame import MapFrame, Place, SteadyFrame
from workbench.gui.instruments.readout import Line, Readout
from workbench.gui.signals import Signals
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

MOST_POINTS = 600
"""That are kept; then every other one goes, and points are taken half as densely."""
FINEST = 0.02
"""Points nearer to each other than this are one, at the start [m]."""

NEW, RECENT = 10.0, 60.0
"""Age under which the trail is thick, and under which it is a whole line [s]; else it is dotted."""

TRAIL_PERIOD = 0.1
"""Between places of the trail that are taken from what was flown [s]."""


@dataclass(frozen=True)
class TrailPoint:
    """Where it was.

    Attributes:
        time: when [s].
        east: in W [m].
        north: in W [m].
    """

    time: float
    east: float
    north: float


class Trail:
    """Points of a way, the newest last."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Forget all."""
        self.points: list[TrailPoint] = []
        self._spacing = FINEST

    def add(self, points: Iterable[TrailPoint]) -> bool:
        """Take points in the order of time, and return whether any was new enough to keep."""
        kept = False
        for point in points:
            if not (math.isfinite(point.east) and math.isfinite(point.north)):
                continue
            if self.points:
                last = self.points[-1]
                if math.hypot(point.east - last.east, point.north - last.north) < self._spacing:
                    continue
            self.points.append(point)
            kept = True
            if len(self.points) > MOST_POINTS:
                self.points = self.points[::2]
                self._spacing *= 2.0
        return kept

    def since(self, time: float) -> list[TrailPoint]:
        """Return the points from a time on, and the one before them."""
        first = next(
            (index for index, point in enumerate(self.points) if point.time >= time),
            len(self.points),
        )
        return self.points[max(0, first - 1) :]


@dataclass(frozen=True)
class Pose:
    """Where a drone is and where it points.

    Attributes:
        place: in W.
        yaw: [rad].
    """

    place: Place
    yaw: float


class PathMap(Instrument):
    """Shows home, the trail and the drone, with a scale bar."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Map of the path", parent)
        self.trail = Trail()
        self.home = Place(0.0, 0.0)
        self.pose: Pose | None = None
        self._time = 0.0
        self._frame = SteadyFrame()
        self._drawn = (0.0, 0.0, 0.0)

    @property
    def frame(self) -> MapFrame:
        """The part of the world that is shown."""
        return self._frame.frame

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        if self.pose is None:
            return "no position yet"
        east = self.pose.place.east - self.home.east
        north = self.pose.place.north - self.home.north
        return f"{math.hypot(east, north):.1f} metres from home: {east:.1f} east, {north:.1f} north"

    def begin(self, home: Place) -> None:
        """Forget the way: a flight begins at a place."""
        self.trail.clear()
        self.home, self.pose = home, None
        self._frame.reset(home)
        self.renew()

    def show_pose(self, pose: Pose, passed: list[TrailPoint], time: float) -> None:
        """Show where the drone is, and the way since the last call.

        Args:
            pose: now.
            passed: places on the way, in the order of time.
            time: simulated [s].
        """
        if not all(map(math.isfinite, (pose.place.east, pose.place.north, pose.yaw))):
            return
        self.trail.add(passed)
        self.pose, self._time = pose, time
        seen = [self.home, pose.place]
        seen += [Place(point.east, point.north) for point in self.trail.points]
        before = self.frame
        if self._frame.take(seen, time) != before:
            self.renew()
        x, y = self._pixels(pose.place)
        drawn = (round(2 * x) / 2, round(2 * y) / 2, round(pose.yaw, 2))
        if drawn != self._drawn:
            self._drawn = drawn
            self.update()

    def sizeHint(self) -> QSize:
        """Return a size at which all is readable."""
        return QSize(200, 160)

    def paint_still(self, painter: QPainter) -> None:
        """Paint the grid, the arrow to north and the scale bar."""
        area = self.area.adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("field"))
        painter.drawRoundedRect(area, 4.0, 4.0)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        self._paint_grid(painter)
        self._paint_bar(painter)
        self._paint_north(painter)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the trail, home and the drone."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        if self.pose is None:
            return
        accent = self.colour("accent")
        end = TrailPoint(self._time, self.pose.place.east, self.pose.place.north)
        points = [*self.trail.points, end]
        new = next((k for k, each in enumerate(points) if each.time >= self._time - NEW), 0)
        recent = next((k for k, each in enumerate(points) if each.time >= self._time - RECENT), 0)
        corners = [QPointF(*self._pixels(Place(each.east, each.north))) for each in points]
        width = max(1.0, self.text_size / 12.0)
        dotted = QPen(self.colour("muted"), 1.2 * width)
        dotted.setDashPattern([1.5, 3.5])
        pens = (
            dotted,
            QPen(accent, 1.2 * width),
            QPen(accent, 2.6 * width),
        )
        parts = (corners[: recent + 1], corners[recent : new + 1], corners[new:])
        for pen, part in zip(pens, parts, strict=True):
            if len(part) > 1:
                painter.setPen(pen)
                painter.drawPolyline(QPolygonF(part))
        self._paint_home(painter)
        self._paint_drone(painter, corners[-1], self.pose.yaw)

    def _pixels(self, place: Place) -> tuple[float, float]:
        return self.frame.pixels(place, self.width(), self.height())

    def _paint_grid(self, painter: QPainter) -> None:
        step = self.frame.reach / 2.0
        pixels = step * self.frame.scale(self.width(), self.height())
        painter.setPen(QPen(self.colour("line"), 1.0))
        middle_x, middle_y = self._pixels(self.frame.middle)
        columns, rows = int(self.width() / 2 / pixels), int(self.height() / 2 / pixels)
        lines = [
            QLineF(middle_x + k * pixels, 1.0, middle_x + k * pixels, self.height() - 1.0)
            for k in range(-columns, columns + 1)
        ]
        lines += [
            QLineF(1.0, middle_y + k * pixels, self.width() - 1.0, middle_y + k * pixels)
            for k in range(-rows, rows + 1)
        ]
        for line in lines:
            painter.drawLine(line)

    def _paint_bar(self, painter: QPainter) -> None:
        metres = self.frame.bar(self.width(), self.height())
        length = metres * self.frame.scale(self.width(), self.height())
        size = self.text_size
        left, bottom = 0.6 * size, self.height() - 0.6 * size
        painter.setPen(QPen(self.colour("ink"), 1.5))
        painter.drawPolyline(
            QPolygonF(
                [
                    QPointF(left, bottom - 0.35 * size),
                    QPointF(left, bottom),
                    QPointF(left + length, bottom),
                    QPointF(left + length, bottom - 0.35 * size),
                ]
            )
        )
        painter.setFont(self.face(0.85))
        painter.drawText(
            QPointF(left + 0.3 * size, bottom - 0.3 * size), f"{metres:g}\N{NO-BREAK SPACE}m"
        )

    def _paint_north(self, painter: QPainter) -> None:
        size = self.text_size
        x, top = self.width() - 1.1 * size, 0.5 * size
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.colour("ink"))
        painter.drawPolygon(
            QPolygonF(
                [
                    QPointF(x, top),
                    QPointF(x + 0.38 * size, top + size),
                    QPointF(x, top + 0.75 * size),
                    QPointF(x - 0.38 * size, top + size),
                ]
            )
        )
        painter.setPen(self.colour("ink"))
        painter.setFont(self.face(0.9, bold=True))
        painter.drawText(
            QRectF(x - size, top + size, 2 * size, 1.2 * size), Qt.AlignmentFlag.AlignCenter, "N"
        )

    def _paint_home(self, painter: QPainter) -> None:
        size = 0.62 * self.text_size
        middle = QPointF(*self._pixels(self.home))
        painter.setPen(QPen(self.colour("ink"), 1.3))
        painter.setBrush(self.colour("card"))
        painter.drawEllipse(middle, size, size)
        painter.setFont(self.face(0.8, bold=True))
        place = QRectF(middle.x() - size, middle.y() - size, 2 * size, 2 * size)
        painter.drawText(place, Qt.AlignmentFlag.AlignCenter, "H")

    def _paint_drone(self, painter: QPainter, middle: QPointF, yaw: float) -> None:
        size = 0.5 * self.text_size
        along, across = (math.cos(yaw), math.sin(yaw)), (math.sin(yaw), -math.cos(yaw))
        corners = []
        for ahead, aside in ((1.6, 0.0), (-1.1, 1.0), (-0.5, 0.0), (-1.1, -1.0)):
            east = ahead * along[0] + aside * across[0]
            north = ahead * along[1] + aside * across[1]
            corners.append(middle + size * QPointF(east, -north))
        painter.setPen(QPen(self.colour("card"), 1.0))
        painter.setBrush(self.colour("accent"))
        painter.drawPolygon(QPolygonF(corners))


class GpsCard(Card):
    """Latitude, longitude and altitude as measured; the map has the true way, from above."""

    name = "gps"
    title = "GPS, path"

    def __init__(
        self, look: Look, units: ShownUnits, signals: Signals, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._signals = signals
        self._seen = -math.inf
        self.map = PathMap(look, self)
        lines = [Line("Lat."), Line("Lon."), Line("Alt.", "m"), Line("Home", "m")]
        self.table = Readout(look, "GPS", lines, widest="188.8888888", parent=self)
        self.hint = Hint(look, "GPS", self)
        self.hint.hide()
        self.parts = [self.map, self.table, self.hint]
        self.use_units(units)

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.table.spoken
        return f"{self.note}; {said}; {self.map.spoken}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        symbol = units.place.unit.symbol
        self.table.set_line(0, Line("Latitude", symbol))
        self.table.set_line(1, Line("Longitude", symbol))
        self.table.set_line(2, Line("Altitude", "m"))
        self.table.set_line(3, Line("From home", "m"))

    def place_parts(self, body: QRectF) -> None:
        """Put the map on the left, or above."""
        picture, numbers = beside(body, 0.9 * self.text_size, 7.6 * self.text_size, share=0.48)
        put(self.map, picture)
        put(self.table, numbers)
        put(self.hint, numbers)

    def begin(self, view: LiveView) -> None:
        """Begin a new way where the flight begins."""
        assert view.snapshot is not None
        start = [p - d for p, d in zip(view.snapshot.p_WB, view.snapshot.displacement, strict=True)]
        self._seen = -math.inf
        self.map.begin(Place(start[0], start[1]))

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest reading and its age, and the way."""
        self._show_map(now)
        state = sensor_state(view, now, "gps")
        self.set_state(state)
        reading = now.gps
        self.table.setVisible(reading is not None)
        self.hint.setVisible(reading is None)
        if reading is None:
            self.hint.say(state.note, state.advice)
            return
        place = self.units.place
        self.table.show_row(0, place.text(reading.latitude))
        self.table.show_row(1, place.text(reading.longitude))
        self.table.show_row(2, number_text(reading.altitude, 2))
        self.table.show_row(3, number_text(math.hypot(*now.displacement[:2]), 2))

    def _show_map(self, now: Snapshot) -> None:
        east, north, _ = now.p_WB
        pose = Pose(Place(east, north), now.roll_pitch_yaw[2])
        self.map.show_pose(pose, self._passed(), now.time)

    def _passed(self) -> list[TrailPoint]:
        """Return where the drone was since the last look, also while nobody looked."""
        if "position_data.x" not in self._signals.units:
            return []
        times, east = self._signals.series("position_data.x", self._seen + TRAIL_PERIOD)
        _, north = self._signals.series("position_data.y", self._seen + TRAIL_PERIOD)
        if not len(times):
            return []
        taken = _spaced(times, TRAIL_PERIOD)
        self._seen = float(times[taken[-1]])
        rows = zip(times[taken].tolist(), east[taken].tolist(), north[taken].tolist(), strict=True)
        return [TrailPoint(*row) for row in rows]


def _spaced(times: np.ndarray, period: float) -> np.ndarray:
    """Return the indices of the first of each period of some times."""
    _, first = np.unique(np.floor((times - times[0]) / period), return_index=True)
    return first

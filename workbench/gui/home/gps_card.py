"""Satellite navigation: the position, and a map of path, obstacles and waypoints, north up."""

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
from PyQt6.QtCore import QEvent, QLineF, QPointF, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import (
    QColor,
    QFontMetricsF,
    QHideEvent,
    QMouseEvent,
    QPainter,
    QPen,
    QPolygonF,
    QShortcut,
    QWheelEvent,
)
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.cards import Card, beside, put
from workbench.gui.home.route import Route
from workbench.gui.home.sensor_state import sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.map_frame import (
    LEAST,
    MARGIN,
    MapFrame,
    Place,
    SteadyFrame,
    round_reach,
)
from workbench.gui.instruments.readout import Line
from workbench.gui.labels import set_tip
from workbench.gui.layout import tool_button
from workbench.gui.signals import Signals
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.plant.geodesy import geodetic
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.worlds.outline import Outline
from workbench.session.snapshot import Snapshot

MOST_POINTS = 600
"""Number of kept points; beyond it every other one is dropped, and the spacing doubles."""
FINEST = 0.02
"""Initial least distance between points [m]."""

NEW, RECENT = 10.0, 60.0
"""The trail is thick below the first age, solid below the second, and then dotted [s]."""

TRAIL_PERIOD = 0.1
"""Period between recorded points of the trail [s]."""


FARTHEST_SEEN = 20.0
"""Largest initial reach of the map for an obstacle to be in view [m]."""
MOST_LINES = 4
"""Largest number of lines about the place under the pointer."""
GO_TO = (
    "Click a place on the map to fly there at the present height. With Shift, further clicks set "
    "waypoints that are flown in turn. A right click removes one, Escape removes all. The wheel "
    "zooms."
)


TrailPoint = tuple[float, float, float]
"""A recorded position: its time [s], east and north in W [m]."""


class Trail:
    """Points of a path, the newest last."""

    def __init__(self) -> None:
        self.clear()

    def clear(self) -> None:
        """Remove all points."""
        self.points: list[TrailPoint] = []
        self._spacing = FINEST

    def add(self, points: Iterable[TrailPoint]) -> bool:
        """Add points in order of time, and return whether any was kept."""
        kept = False
        for point in points:
            if not (math.isfinite(point[1]) and math.isfinite(point[2])):
                continue
            if self.points and math.dist(point[1:], self.points[-1][1:]) < self._spacing:
                continue
            self.points.append(point)
            kept = True
            if len(self.points) > MOST_POINTS:
                self.points = self.points[::2]
                self._spacing *= 2.0
        return kept


class PathMap(Instrument):
    """Shows home, obstacles, trail, waypoints and drone, with a scale bar.

    The wheel zooms; the pointer shows what is under it.

    Args:
        look: source of colours.
        parent: the Qt parent.

    Attributes:
        trail: the flown path.
        home: where the flight began.
        place: position of the drone, None before the first.
        under: the place under the pointer, None if it is elsewhere.
        armed: whether a click sets a waypoint.
        say_place: returns the text about the pointer's place.
    """

    clicked = pyqtSignal(object, bool)
    """The `Place` of a click while it is armed, and whether Shift was held."""
    unwanted = pyqtSignal(int)
    """Index of a waypoint that was clicked with the right button."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Map of the path", parent)
        self.trail = Trail()
        self.home = Place(0.0, 0.0)
        self.place: Place | None = None
        self._yaw = 0.0
        self.under: Place | None = None
        self.armed = False
        self.say_place: Callable[[Place], Sequence[str]] = lambda place: ()
        self._outlines: tuple[Outline, ...] = ()
        self._points: tuple[Place, ...] = ()
        self._present = 0
        self._time = 0.0
        self._frame = SteadyFrame()
        self._drawn = (0.0, 0.0, 0.0)
        self.setMouseTracking(True)

    @property
    def frame(self) -> MapFrame:
        """The visible part of the world."""
        return self._frame.frame

    @property
    def spoken(self) -> str:
        """The map as a sentence."""
        if self.place is None:
            return "no position yet"
        east, north = self.place.east - self.home.east, self.place.north - self.home.north
        said = f"{math.hypot(east, north):.1f} metres from home: {east:.1f} east, {north:.1f} north"
        if self._points:
            said += f"; flies to waypoint {self._present + 1} of {len(self._points)}"
        return said

    def begin(self, home: Place, outlines: tuple[Outline, ...] = ()) -> None:
        """Clear the trail: a flight begins at a place, among obstacles."""
        self.trail.clear()
        self.home, self.place = home, None
        self._outlines, self._points = outlines, ()
        self._frame.reset(home, _least(home, outlines))
        self.renew()

    def show_points(self, points: Sequence[Place], present: int) -> None:
        """Show waypoints, and the one that is flown to."""
        self._points, self._present = tuple(points), present
        self.update()

    def arm(self, armed: bool) -> None:
        """Set whether a click sets a waypoint."""
        self.armed = armed
        self.setCursor(Qt.CursorShape.CrossCursor if armed else Qt.CursorShape.ArrowCursor)
        self.update()

    def show_pose(self, place: Place, yaw: float, passed: list[TrailPoint], time: float) -> None:
        """Show the drone, and its path since the last call.

        Args:
            place: present position in W.
            yaw: present yaw [rad].
            passed: positions on the path, in order of time.
            time: simulated time [s].
        """
        if not all(map(math.isfinite, (place.east, place.north, yaw))):
            return
        self.trail.add(passed)
        self.place, self._yaw, self._time = place, yaw, time
        seen = [self.home, place]
        seen += [Place(*place) for _, *place in self.trail.points]
        seen += self._points
        before = self.frame
        if self._frame.take(seen, time) != before:
            self.renew()
        if any(each.course for each in self._outlines):
            self.update()
        x, y = self._pixels(place)
        drawn = (round(2 * x) / 2, round(2 * y) / 2, round(yaw, 2))
        if drawn != self._drawn:
            self._drawn = drawn
            self.update()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Show what is under the pointer."""
        assert event is not None
        self._look_under(event.position())

    def leaveEvent(self, event: QEvent | None) -> None:
        """Clear the text about the pointer's place."""
        self.under = None
        self.update()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Set a waypoint if armed, or remove one with the right button."""
        assert event is not None
        self._look_under(event.position())
        if event.button() is Qt.MouseButton.LeftButton and self.armed:
            shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
            self.clicked.emit(self.under, shift)
        elif event.button() is Qt.MouseButton.RightButton:
            near = self._point_at(event.position())
            if near is not None:
                self.unwanted.emit(near)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom in or out."""
        assert event is not None
        if event.angleDelta().y():
            self._frame.zoom(-1 if event.angleDelta().y() > 0 else 1)
            seen = [self.home, *self._points, *([self.place] if self.place else [])]
            self._frame.take(seen, self._time)
            self.renew()
            self._look_under(event.position())
        event.accept()

    def _look_under(self, at: QPointF) -> None:
        self.under = self.frame.place(at.x(), at.y(), self.width(), self.height())
        self.update()

    def _point_at(self, at: QPointF) -> int | None:
        """Return the index of the waypoint at a pixel, None without one."""
        ways = [math.hypot(at.x() - x, at.y() - y) for x, y in map(self._pixels, self._points)] or [
            math.inf
        ]
        nearest = min(range(len(ways)), key=ways.__getitem__)
        return nearest if ways[nearest] <= self.text_size else None

    def paint_still(self, painter: QPainter) -> None:
        """Paint the grid, obstacles, north arrow and scale bar."""
        area = self.area.adjusted(0.5, 0.5, -0.5, -0.5)
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("field"))
        painter.drawRoundedRect(area, 4.0, 4.0)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        self._paint_grid(painter)
        painter.setClipRect(area)
        for each in self._outlines:
            if each.course is None:
                self._paint_outline(painter, each)
        painter.setClipping(False)
        self._paint_bar(painter)
        self._paint_north(painter)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint moving objects, the trail, home, waypoints and the drone."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        for each in self._outlines:
            if each.course is not None:
                self._paint_outline(painter, each.at(self._time))
        if self.place is not None:
            self._paint_flight(painter, self.place)
        if self.under is not None:
            self._paint_under(painter, self.under)

    def _paint_flight(self, painter: QPainter, place: Place) -> None:
        accent = self.colour("accent")
        end = self._time, place.east, place.north
        points = [*self.trail.points, end]
        new = next((k for k, each in enumerate(points) if each[0] >= self._time - NEW), 0)
        recent = next((k for k, each in enumerate(points) if each[0] >= self._time - RECENT), 0)
        corners = [QPointF(*self._pixels(Place(*each[1:]))) for each in points]
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
        self._paint_points(painter, corners[-1])
        self._paint_drone(painter, corners[-1], self._yaw)

    def _paint_outline(self, painter: QPainter, outline: Outline) -> None:
        fill = QColor(self.colour("muted"))
        fill.setAlphaF(0.25)
        painter.setBrush(fill)
        painter.setPen(QPen(self.colour("muted"), 1.0))
        corners = [QPointF(*self._pixels(Place(*each))) for each in outline.corners]
        painter.drawPolygon(QPolygonF(corners))

    def _paint_points(self, painter: QPainter, drone: QPointF) -> None:
        """Paint numbered waypoints, and the path to those ahead."""
        at = [QPointF(*self._pixels(each)) for each in self._points]
        ahead = at[self._present :]
        if ahead:
            painter.setPen(QPen(self.colour("command"), 1.2, Qt.PenStyle.DashLine))
            painter.drawPolyline(QPolygonF([drone, *ahead]))
        size = 0.62 * self.text_size
        painter.setFont(self.face(0.8, bold=True))
        for number, middle in enumerate(at, 1):
            colour = self.colour("command" if number > self._present else "muted")
            painter.setPen(QPen(colour, 1.3))
            painter.setBrush(self.colour("card"))
            place = QRectF(middle.x() - size, middle.y() - size, 2 * size, 2 * size)
            painter.drawRect(place)
            painter.drawText(place, Qt.AlignmentFlag.AlignCenter, f"{number}")

    def _paint_under(self, painter: QPainter, place: Place) -> None:
        """Write what is under the pointer at the top, on a background."""
        lines = list(self.say_place(place))
        if not lines:
            return
        painter.setFont(self.face(0.85))
        metrics = painter.fontMetrics()
        pad = 0.3 * self.text_size
        wide = min(max(map(metrics.horizontalAdvance, lines)) + 2, int(self.width() - 4 * pad))
        plate = QRectF(pad, pad, wide + 2 * pad, len(lines) * metrics.height() + pad)
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("card"))
        painter.drawRoundedRect(plate, 3.0, 3.0)
        painter.setPen(self.colour("ink"))
        for row, line in enumerate(lines):
            text = metrics.elidedText(line, Qt.TextElideMode.ElideRight, wide)
            top = plate.top() + 0.5 * pad + row * metrics.height()
            painter.drawText(QPointF(plate.left() + pad, top + metrics.ascent()), text)

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
    """Latitude, longitude and altitude as measured; the map shows the true path from above."""

    name = "gps"
    title = "GPS, path"

    def __init__(
        self,
        look: Look,
        units: ShownUnits,
        signals: Signals,
        route: Route,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(look, units, parent)
        self._signals, self._route = signals, route
        self._seen = -math.inf
        self._now: Snapshot | None = None
        self._home = DEFAULT_HOME
        self._outlines: tuple[Outline, ...] = ()
        self.map = PathMap(look, self)
        self.map.say_place = self._say_place
        self.go_to = tool_button("Go to", kind="tight")
        self.go_to.setParent(self)
        self.go_to.setCheckable(True)
        self.go_to.setFocusPolicy(Qt.FocusPolicy.TabFocus)
        self._escape = QShortcut(Qt.Key.Key_Escape, self, lambda: self.go_to.setChecked(False))
        self._escape.setEnabled(False)
        self.go_to.toggled.connect(self.map.arm)
        self.go_to.toggled.connect(self._escape.setEnabled)
        self.map.clicked.connect(self._set_point)
        self.map.unwanted.connect(route.remove)
        route.changed.connect(self._show_points)
        self._bar(route.barred)
        self.table = self.make_table("GPS", widest="188.8888888")
        self.hint = self.make_hint("GPS")
        self.parts = [self.map, self.table, self.hint]

    @property
    def spoken(self) -> str:
        """The position as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.table.spoken
        return f"{self.note}; {said}; {self.map.spoken}"

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return a line for each coordinate."""
        place = [(label, units.place.symbol) for label in ("Latitude", "Longitude")]
        return *place, ("Altitude", "m"), ("From home", "m")

    def place_parts(self, body: QRectF) -> None:
        """Place the map on the left, or above."""
        picture, numbers = beside(body, 0.9 * self.text_size, 7.6 * self.text_size, share=0.48)
        put(self.map, picture)
        put(self.table, numbers)
        put(self.hint, numbers)
        line = self._title_line
        self.go_to.setFont(self.face())
        wanted = self.go_to.sizeHint()
        words = QFontMetricsF(self.face(1.0, bold=True)).horizontalAdvance(self.title)
        left = line.left() + words + self.text_size
        height = min(float(wanted.height()), line.height() - 1.0)
        put(self.go_to, QRectF(left, line.center().y() - height / 2, wanted.width(), height))

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Disarm the map while hidden."""
        self.go_to.setChecked(False)
        super().hideEvent(event)

    def begin(self, view: LiveView) -> None:
        """Start a new trail where the flight begins."""
        assert view.snapshot is not None
        start = [p - d for p, d in zip(view.snapshot.p_WB, view.snapshot.displacement, strict=True)]
        self._seen = -math.inf
        self._home, self._outlines = view.home, view.outlines
        self.map.begin(Place(start[0], start[1]), view.outlines)
        self._route.begin()

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest reading and its age, and the path."""
        self._now = now
        self._bar(self._route.barred)
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

    def _bar(self, barred: str) -> None:
        """Enable the button while a waypoint can be flown."""
        tip = barred or GO_TO
        if self.go_to.toolTip() != tip:
            set_tip(self.go_to, tip)
            self.go_to.setEnabled(not barred)
            if barred:
                self.go_to.setChecked(False)

    def _set_point(self, place: Place, more: bool) -> None:
        self._route.add(place, more=more)
        if not more:
            self.go_to.setChecked(False)

    def _show_points(self) -> None:
        points = [Place(east, north) for east, north, _ in self._route.places]
        self.map.show_points(points, self._route.present)

    def _say_place(self, place: Place) -> list[str]:
        """Return latitude and longitude of a place, and what is there."""
        shown, height, time = self.units.place, 0.0, 0.0
        if self._now is not None:
            height, time = self._now.p_WB[2], self._now.time
        at = geodetic((place.east, place.north, height), self._home)
        symbol = shown.unit.symbol
        lines = [f"{shown.text(each)}{symbol}" for each in (at.latitude, at.longitude)]
        for outline in self._outlines:
            present = outline.at(time)
            if present.holds(place.east, place.north):
                heights = f"{number_text(present.low, 1)} to {number_text(present.high, 1)}"
                lines.append(f"{outline.name}, {heights}\N{NO-BREAK SPACE}m")
        return lines[:MOST_LINES]

    def _show_map(self, now: Snapshot) -> None:
        east, north, _ = now.p_WB
        self.map.show_pose(Place(east, north), now.roll_pitch_yaw[2], self._passed(), now.time)

    def _passed(self) -> list[TrailPoint]:
        """Return the positions since the last call, also while the map was hidden."""
        if "position_data.x" not in self._signals.units:
            return []
        times, east = self._signals.series("position_data.x", self._seen + TRAIL_PERIOD)
        _, north = self._signals.series("position_data.y", self._seen + TRAIL_PERIOD)
        if not len(times):
            return []
        taken = _spaced(times, TRAIL_PERIOD)
        self._seen = float(times[taken[-1]])
        rows = (times[taken].tolist(), east[taken].tolist(), north[taken].tolist())
        return list(zip(*rows, strict=True))


def _least(home: Place, outlines: Iterable[Outline]) -> float:
    """Return the least reach that shows the nearest obstacle, within `FARTHEST_SEEN`."""
    ways = [
        math.hypot(east - home.east, north - home.north)
        for each in outlines
        if each.course is None
        for east, north in each.corners
    ]
    return min(max(LEAST, round_reach(MARGIN * min(ways, default=LEAST / MARGIN))), FARTHEST_SEEN)


def _spaced(times: np.ndarray, period: float) -> np.ndarray:
    """Return the indices of the first of some times in each period."""
    _, first = np.unique(np.floor((times - times[0]) / period), return_index=True)
    return first

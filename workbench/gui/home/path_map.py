"""The map of a flight: home, obstacles, trail, waypoints and drone, north up."""

import math
from collections.abc import Callable, Iterable, Sequence

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QEvent, QPointF, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QPolygonF, QResizeEvent, QWheelEvent
from PyQt6.QtWidgets import QGraphicsPolygonItem

from workbench.common.plain_text import plain_name
from workbench.gui.charts.ticks import round_step
from workbench.gui.home.trail import Trail, TrailPoint
from workbench.gui.instruments.map_frame import (
    MAP_MARGIN_FACTOR,
    MIN_MAP_REACH_M,
    MapFrame,
    MapPlace,
    SteadyFrame,
    round_bar,
)
from workbench.gui.instruments.plane_view import PlaneView
from workbench.gui.theme import Look
from workbench.gui.wheel import zoom_notches
from workbench.plant.worlds.outline import Outline

NEW_TRAIL_AGE_S, RECENT_TRAIL_AGE_S = 10.0, 60.0
"""The trail is thick below the first age, solid below the second, and then dotted [s]."""
MAX_INITIAL_REACH_M = 20.0
"""Largest initial reach of the map for an obstacle to be in view [m]."""
MAX_SCALE_BAR_SHARE = 0.4
"""Largest share of the map's width for the scale bar."""
WAYPOINT_RADIUS_PX = 12.0
"""Largest distance of a click from the waypoint that it means [px]."""


class PathMap(PlaneView):
    """Shows home, obstacles, trail, waypoints and drone, with a scale bar.

    Ctrl and the wheel zoom; the pointer shows what is under it.

    Args:
        look: source of colours.

    Attributes:
        trail: the flown path.
        home: where the flight began.
        place: position of the drone, None before the first.
        under: the place under the pointer, None if it is elsewhere.
        armed: whether a click sets a waypoint.
        say_place: returns the text about the pointer's place.
    """

    clicked = pyqtSignal(object, bool)
    """The `MapPlace` of a click while it is armed, and whether Shift was held."""
    unwanted = pyqtSignal(int)
    """Index of a waypoint that was clicked with the right button."""

    def __init__(self, look: Look) -> None:
        super().__init__(look, "Map of the path")
        self.trail = Trail()
        self.home = MapPlace(0.0, 0.0)
        self.place: MapPlace | None = None
        self.under: MapPlace | None = None
        self.armed = False
        self.say_place: Callable[[MapPlace], Sequence[str]] = lambda place: ()
        self._yaw = self._time = 0.0
        self._outlines: tuple[Outline, ...] = ()
        self._points: tuple[MapPlace, ...] = ()
        self._present = 0
        self._frame = SteadyFrame()
        self._drawn = (0.0, 0.0, 0.0)
        self._grid = pg.GridItem(textPen=None)
        self._ways = [pg.PlotCurveItem(antialias=True) for _ in range(3)]
        self._ahead = pg.PlotCurveItem(antialias=True)
        self._home = pg.TextItem("H", anchor=(0.5, 0.5))
        self._drone = pg.ArrowItem(headLen=16, headWidth=10, baseAngle=20)
        self._shapes: list[QGraphicsPolygonItem] = []
        self._numbers: list[pg.TextItem] = []
        self._north = pg.TextItem("▲\nN", anchor=(1.0, 0.0))
        self._said = pg.TextItem(anchor=(0.0, 0.0))
        self._bar = pg.ScaleBar(1.0, width=3, offset=(-8, -8))
        self.add(self._grid, *self._ways, self._ahead, self._home, self._drone)
        for item in (self._north, self._said, self._bar):
            item.setParentItem(self.view)
            item.setZValue(10)
        self._said.hide()
        self.setMouseTracking(True)
        self.apply_colours()
        self._show_frame()

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

    def begin(self, home: MapPlace, outlines: tuple[Outline, ...] = ()) -> None:
        """Clear the trail: a flight begins at a place, among obstacles."""
        self.trail.clear()
        self.home, self.place = home, None
        self._outlines, self._points = outlines, ()
        self._frame.reset(home, _initial_reach(home, outlines))
        for shape in self._shapes:
            self.view.removeItem(shape)
        self._shapes = [QGraphicsPolygonItem() for _ in outlines]
        for shape, outline in zip(self._shapes, outlines, strict=True):
            shape.setZValue(-1)
            shape.setPolygon(_polygon(outline))
        self.add(*self._shapes)
        self.apply_colours()
        self._show_frame()
        self._show_flight()
        self.show_points((), 0)

    def show_points(self, points: Sequence[MapPlace], present: int) -> None:
        """Show waypoints, and the one that is flown to."""
        self._points, self._present = tuple(points), present
        while self._numbers:
            self.view.removeItem(self._numbers.pop())
        for number, place in enumerate(self._points, 1):
            colour = self.look.colour("command" if number > present else "muted")
            made = pg.TextItem(f"{number}", colour, anchor=(0.5, 0.5), border=colour)
            made.fill = pg.mkBrush(self.look.colour("card"))
            made.setFont(self.font())
            made.setPos(place.east, place.north)
            self._numbers.append(made)
        self.add(*self._numbers)
        self._show_ahead()

    def arm(self, armed: bool) -> None:
        """Set whether a click sets a waypoint."""
        self.armed = armed
        self.setCursor(Qt.CursorShape.CrossCursor if armed else Qt.CursorShape.ArrowCursor)

    def show_pose(self, place: MapPlace, yaw: float, passed: list[TrailPoint], time: float) -> None:
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
        seen = [self.home, place, *self._points]
        seen += [MapPlace(*place) for _, *place in self.trail.points]
        before = self.frame
        if self._frame.take(seen, time) != before:
            self._show_frame()
        for shape, outline in zip(self._shapes, self._outlines, strict=True):
            if outline.course is not None:
                shape.setPolygon(_polygon(outline.at(time)))
        at = self.position_of(place.east, place.north)
        drawn = (round(2 * at.x()) / 2, round(2 * at.y()) / 2, round(yaw, 2))
        if drawn != self._drawn or passed:
            self._drawn = drawn
            self._show_flight()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Show what is under the pointer."""
        assert event is not None
        self._look_under(event.position())

    def leaveEvent(self, event: QEvent | None) -> None:
        """Clear the text about the pointer's place."""
        self.under = None
        self._said.hide()

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
        """Zoom in or out while Ctrl is held."""
        notches = zoom_notches(event)
        if event is not None and notches:
            self._frame.zoom(-1 if notches > 0.0 else 1)
            seen = [self.home, *self._points, *([self.place] if self.place else [])]
            self._frame.take(seen, self._time)
            self._show_frame()
            self._look_under(event.position())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Fit the scale bar, and place the arrow to the north."""
        super().resizeEvent(event)
        if hasattr(self, "_bar"):
            self._show_frame()

    def apply_colours(self) -> None:
        """Apply the colours of the look, and the font."""
        super().apply_colours()
        colour, font = self.look.colour, self.font()
        self.view.setBackgroundColor(colour("field"))
        self.view.setBorder(self.pen("line"))
        self._grid.setPen(self.pen("line"))
        accent, muted = self.pen("accent", 1.2), pg.mkPen(colour("muted"), width=1.2)
        muted.setDashPattern([1.5, 3.5])
        for item, pen in zip(self._ways, (muted, accent, self.pen("accent", 2.6)), strict=True):
            item.setPen(pen)
        self._ahead.setPen(self.pen("command", 1.2, Qt.PenStyle.DashLine))
        self._drone.setStyle(pen=self.pen("card"), brush=pg.mkBrush(colour("accent")))
        for text in (self._home, self._north, self._said, self._bar.text):
            text.setColor(colour("ink"))
            text.setFont(font)
        for text in (self._home, self._said):
            text.fill, text.border = pg.mkBrush(colour("card")), self.pen("ink")
        self._bar.bar.setBrush(pg.mkBrush(colour("ink")))
        shade = colour("muted")
        shade.setAlphaF(0.25)
        for shape in self._shapes:
            shape.setBrush(pg.mkBrush(shade))
            shape.setPen(self.pen("muted"))

    def _show_frame(self) -> None:
        """Show the present part of the world."""
        frame, reach = self.frame, self.frame.reach
        corner = QPointF(frame.middle.east - reach, frame.middle.north - reach)
        self.show_area(QRectF(corner, QPointF(corner.x() + 2 * reach, corner.y() + 2 * reach)))
        self._grid.setTickSpacing(x=[reach / 2.0], y=[reach / 2.0])
        self._bar.size = round_bar(MAX_SCALE_BAR_SHARE * self.view.viewRect().width())
        self._bar.text.setText(f"{self._bar.size:g}\N{NO-BREAK SPACE}m")
        self._bar.updateBar()
        self._north.setPos(self.view.width() - 4.0, 2.0)
        self._said.setPos(4.0, 4.0)

    def _show_flight(self) -> None:
        """Show the trail by its age, and the drone at its end."""
        self._home.setPos(self.home.east, self.home.north)
        self._drone.setVisible(self.place is not None)
        points = np.array(self.trail.points).reshape(-1, 3)
        if self.place is not None:
            points = np.vstack([points, (self._time, self.place.east, self.place.north)])
            self._drone.setPos(self.place.east, self.place.north)
            self._drone.setStyle(angle=180.0 - math.degrees(self._yaw))
        ages = self._time - np.array([RECENT_TRAIL_AGE_S, NEW_TRAIL_AGE_S])
        recent, new = np.searchsorted(points[:, 0], ages).tolist()
        parts = (points[: recent + 1], points[recent : new + 1], points[new:])
        for item, part in zip(self._ways, parts, strict=True):
            item.setData(part[:, 1], part[:, 2])
        self._show_ahead()

    def _show_ahead(self) -> None:
        ahead = self._points[self._present :] if self.place is not None else ()
        way = [self.place, *ahead] if ahead and self.place is not None else []
        self._ahead.setData([each.east for each in way], [each.north for each in way])

    def _look_under(self, at: QPointF) -> None:
        place = self.place_at(at)
        self.under = MapPlace(place.x(), place.y())
        lines = self.say_place(self.under)
        self._said.setVisible(bool(lines))
        self._said.setTextWidth(-1)
        self._said.setPlainText("\n".join(map(plain_name, lines)))
        if self._said.boundingRect().width() > self.view.width() - 8.0:
            self._said.setTextWidth(self.view.width() - 8.0)

    def _point_at(self, at: QPointF) -> int | None:
        """Return the index of the waypoint at a position in the widget, None without one."""
        ways = []
        for index, each in enumerate(self._points):
            way = self.position_of(each.east, each.north) - at
            ways.append((math.hypot(way.x(), way.y()), index))
        nearest, index = min(ways, default=(math.inf, 0))
        return index if nearest <= WAYPOINT_RADIUS_PX else None


def _polygon(outline: Outline) -> QPolygonF:
    return QPolygonF([QPointF(*each) for each in outline.corners])


def _initial_reach(home: MapPlace, outlines: Iterable[Outline]) -> float:
    """Return the least reach that shows the nearest obstacle, within `MAX_INITIAL_REACH_M`."""
    ways = [
        math.hypot(east - home.east, north - home.north)
        for each in outlines
        if each.course is None
        for east, north in each.corners
    ]
    return min(
        max(
            MIN_MAP_REACH_M,
            round_step(
                MAP_MARGIN_FACTOR * min(ways, default=MIN_MAP_REACH_M / MAP_MARGIN_FACTOR), 1
            ),
        ),
        MAX_INITIAL_REACH_M,
    )

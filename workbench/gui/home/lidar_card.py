"""The lidar's scan: the nearest obstacles around the drone, seen from above."""

import math
from collections.abc import Sequence

import numpy as np
from PyQt6.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPainterPath, QPen, QPolygonF
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.cards import Card, beside, put
from workbench.gui.home.sensor_state import SensorState, sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import Instrument, Sign
from workbench.gui.instruments.map_frame import SteadyScale
from workbench.gui.instruments.readout import Line
from workbench.gui.instruments.ring_scan import (
    NOTHING,
    SECTORS,
    Ring,
    down_of,
    sector_bearings,
    side_of,
)
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Clearance, Snapshot

LEAST, MOST = 5.0, 100.0
"""Limits of the shown range [m]."""
AROUND = 2.0
"""Shown range as a multiple of the nearest obstacle's distance."""
BREAK = 0.25
"""Neighbours whose ranges differ by more than this share belong to different walls."""


class LidarRing(Instrument):
    """Shows a ring: arcs at obstacles, and a line to the nearest one."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Lidar ring", parent)
        self.ring = NOTHING
        self.warning = False
        self._scale = SteadyScale(LEAST, MOST)
        half = math.pi / SECTORS
        ends = np.stack([sector_bearings() - half, sector_bearings() + half])
        self._aside, self._ahead = -np.sin(ends), np.cos(ends)

    @property
    def reach(self) -> float:
        """The shown range [m]."""
        return self._scale.reach

    @property
    def spoken(self) -> str:
        """The scan as a sentence."""
        if not math.isfinite(self.ring.nearest):
            return "nothing within range"
        near = ", near" if self.warning else ""
        return f"nearest {self.ring.nearest:.1f} metres {side_of(self.ring.bearing)}{near}"

    def clear(self) -> None:
        """Clear the scan."""
        self._scale.reset()
        self.ring, self.warning = NOTHING, False
        self.renew()

    def show_ring(self, ring: Ring, warning: bool, time: float) -> None:
        """Show a scan.

        Args:
            ring: nearest returns by bearing.
            warning: whether something is too near.
            time: present time [s].
        """
        if ring is self.ring and warning == self.warning:
            return
        before = self.reach
        self.ring, self.warning = ring, warning
        wanted = AROUND * ring.nearest if math.isfinite(ring.nearest) else self.reach
        if self._scale.take(wanted, time) != before:
            self.renew()
        self.update()

    def sizeHint(self) -> QSize:
        """Return a legible size."""
        return QSize(200, 200)

    def paint_still(self, painter: QPainter) -> None:
        """Paint circles of equal distance with numbers, and the eight bearings."""
        middle, radius = self.area.center(), self._radius
        painter.setBrush(self.colour("field"))
        painter.setPen(QPen(self.colour("muted"), 1.0))
        painter.drawEllipse(middle, radius, radius)
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.setPen(QPen(self.colour("line"), 1.0))
        for turn in range(8):
            angle = turn * math.pi / 4.0
            inner = 0.12 * radius
            way = QPointF(math.sin(angle), math.cos(angle))
            painter.drawLine(middle + inner * way, middle + radius * way)
        parts = self._parts
        for part in range(1, parts):
            painter.drawEllipse(middle, part / parts * radius, part / parts * radius)
        painter.setFont(self.face(0.85))
        for part in range(1, parts + 1):
            self._paint_metres(painter, part / parts)
        self._paint_drone(painter, middle, max(4.0, 0.055 * radius))

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the scan."""
        if not math.isfinite(self.ring.nearest):
            return
        middle, pixels = self.area.center(), self._radius / self.reach
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        width = max(2.0, self._radius / 45)
        flat = Qt.PenCapStyle.FlatCap
        painter.setPen(QPen(self.colour("ink"), width, Qt.PenStyle.SolidLine, flat))
        strokes = self._strokes(middle, pixels, width)
        if strokes:
            painter.drawLines(*strokes)
        self._paint_nearest(painter, middle, pixels)

    @property
    def _radius(self) -> float:
        return max(4.0, min(self.width(), self.height()) / 2 - 1.5)

    @property
    def _parts(self) -> int:
        """Number of circles within the range, each a round number of metres."""
        leading = round(self.reach / 10.0 ** math.floor(math.log10(self.reach) + 1e-9))
        return {1: 2, 2: 2, 5: 5}[leading] if self._radius > 90 else {1: 2, 2: 2, 5: 1}[leading]

    def _paint_metres(self, painter: QPainter, share: float) -> None:
        """Paint the metres of a circle, to the right of straight ahead."""
        text = f"{share * self.reach:g}"
        text += "\N{NO-BREAK SPACE}m" if share == 1.0 else ""
        size = 1.15 * self.text_size
        width = painter.fontMetrics().horizontalAdvance(text) + 4.0
        middle = self.area.center()
        angle = math.radians(22.5)
        inset = 0.75 * size if share == 1.0 else 0.0
        radius = share * self._radius - inset
        place = QRectF(0.0, 0.0, width, size)
        place.moveCenter(middle + radius * QPointF(math.sin(angle), -math.cos(angle)))
        painter.fillRect(place, self.colour("field"))
        painter.setPen(self.colour("muted"))
        painter.drawText(place, Qt.AlignmentFlag.AlignCenter, text)

    def _paint_drone(self, painter: QPainter, middle: QPointF, size: float) -> None:
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self.colour("accent"))
        corners = ((0.0, -1.5), (1.0, 1.1), (0.0, 0.55), (-1.0, 1.1))
        painter.drawPolygon(QPolygonF([middle + size * QPointF(x, y) for x, y in corners]))

    def _strokes(self, middle: QPointF, pixels: float, width: float) -> list[QLineF]:
        """Return an arc for each sector with an obstacle within range.

        Each is longer than its sector by its width, so that narrow obstacles are visible, too.
        """
        seen = self.ring.distances <= self.reach
        radii = self._joined(pixels * self.ring.distances)[:, seen]
        x = middle.x() + radii * self._aside[:, seen]
        y = middle.y() - radii * self._ahead[:, seen]
        along_x, along_y = x[1] - x[0], y[1] - y[0]
        longer = 0.5 * width / np.maximum(np.hypot(along_x, along_y), 1e-9)
        ends = (
            x[0] - longer * along_x,
            y[0] - longer * along_y,
            x[1] + longer * along_x,
            y[1] + longer * along_y,
        )
        return [QLineF(*row) for row in np.transpose(ends).tolist()]

    def _joined(self, radii: np.ndarray) -> np.ndarray:
        """Return the radii at both ends of each arc, so that arcs of one wall join."""
        joined = np.empty((2, SECTORS))
        for row, neighbour in enumerate((np.roll(radii, 1), np.roll(radii, -1))):
            both = np.isfinite(neighbour) & np.isfinite(radii)
            gap = np.full(SECTORS, np.inf)
            np.subtract(neighbour, radii, out=gap, where=both)
            near = np.abs(gap) <= BREAK * np.minimum(radii, neighbour)
            joined[row] = np.where(near, 0.5 * (np.where(near, neighbour, 0.0) + radii), radii)
        return joined

    def _paint_nearest(self, painter: QPainter, middle: QPointF, pixels: float) -> None:
        """Paint a line to the nearest obstacle, with a symbol: a ring, or a warning triangle."""
        ring = self.ring
        level = min(self.reach, ring.nearest * math.cos(ring.elevation)) * pixels
        way = QPointF(-math.sin(ring.bearing), -math.cos(ring.bearing))
        end = middle + level * way
        name = "bad" if self.warning else "accent"
        painter.setPen(QPen(self.colour(name), 1.5, Qt.PenStyle.DashLine))
        painter.drawLine(middle + min(level, 0.08 * self._radius) * way, end)
        size = 0.42 * self.text_size
        if self.warning:
            place = QRectF(0.0, 0.0, 3.0 * size, 3.0 * size)
            place.moveCenter(end)
            Sign.WARNING.paint(painter, place, self.colour("bad"))
            return
        mark = QPainterPath()
        mark.addEllipse(end, size, size)
        painter.setBrush(self.colour("card"))
        painter.setPen(QPen(self.colour("accent"), 2.0))
        painter.drawPath(mark)


class LidarCard(Card):
    """The ring of the newest scan, and the nearest obstacle."""

    name = "lidar"
    title = "Lidar, obstacles"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self._cloud = b""
        self.ring = LidarRing(look, self)
        self.table = self.make_table("Nearest obstacle")
        self.hint = self.make_hint("Lidar")
        self.parts = [self.ring, self.table, self.hint]

    @property
    def spoken(self) -> str:
        """The card as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.ring.spoken
        return f"{self.note}; {said}; {self.table.spoken}"

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return where the nearest obstacle is, and the free distance ahead."""
        bearing = ("To the left", units.angle.symbol)
        return ("Nearest", "m"), bearing, ("Side", ""), ("Free way", "m")

    def place_parts(self, body: QRectF) -> None:
        """Place the ring on the left, or above."""
        picture, numbers = beside(body, 1.0 * self.text_size, 7.0 * self.text_size)
        put(self.ring, picture)
        put(self.hint, picture if self.table.isVisibleTo(self) else body)
        put(self.table, numbers)

    def begin(self, view: LiveView) -> None:
        """Clear the last flight's scan."""
        self._cloud = b""
        self.ring.clear()
        for row in range(4):
            self.table.show_row(row, "")

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest scan, and the distance to the nearest obstacle."""
        state = sensor_state(view, now, "lidar")
        near = now.clearance is not None and now.clearance.warning
        self._show_note(state, near)
        self.ring.setVisible(now.lidar is not None)
        self.hint.setVisible(now.lidar is None)
        known = now.lidar is not None or now.clearance is not None
        if known != self.table.isVisibleTo(self):
            self.table.setVisible(known)
            self.place_parts(self.body)
        if now.lidar is None:
            self.hint.say(state.note, state.advice)
            for row in range(3):
                self.table.show_row(row, "–")
        else:
            self._show_scan(now, near)
        self.table.show_row(3, _free_way(now.clearance))

    def _show_note(self, state: SensorState, near: bool) -> None:
        """Show a warning in preference to the lidar's own state."""
        if near:
            self.set_note("obstacle near", Sign.WARNING)
        else:
            self.set_state(state)

    def _show_scan(self, now: Snapshot, near: bool) -> None:
        watch = self._watch
        ring = self.ring.ring
        if watch.scan is not None and watch.cloud and watch.cloud is not self._cloud:
            self._cloud = watch.cloud
            ring = watch.scan.ring(watch.cloud, now.p_WB[2], down_of(now.q_WB))
        self.ring.show_ring(ring, near, now.time)
        if math.isfinite(ring.nearest):
            self.table.show_row(0, number_text(ring.nearest, 2))
            self.table.show_row(1, self.units.angle.text(ring.bearing))
            self.table.show_row(2, side_of(ring.bearing))
        else:
            for row in range(3):
                self.table.show_row(row, "all free" if row == 2 else "–")


def _free_way(clearance: Clearance | None) -> str:
    """Return the distance to the nearest obstacle, from the world and not from the lidar."""
    if clearance is None:
        return "–"
    return number_text(clearance.distance, 2) if math.isfinite(clearance.distance) else "free"

"""The lidar's view from above: the nose is up, and what is near stands around the drone."""

import math

import numpy as np
from PyQt6.QtCore import QLineF, QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QPainter, QPainterPath, QPen, QPolygonF
from PyQt6.QtWidgets import QWidget

from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.ring_scan import NOTHING, SECTORS, Ring, sector_bearings, side_of
from workbench.gui.instruments.sign import Sign, paint_sign
from workbench.gui.instruments.steady_scale import SteadyScale
from workbench.gui.theme import Look

LEAST, MOST = 5.0, 100.0
"""Bounds of how far it shows [m]."""
AROUND = 2.0
"""It reaches so many times as far as the nearest obstacle is."""
BREAK = 0.25
"""Neighbours that differ by more than this share are not of one wall."""


class LidarRing(Instrument):
    """Shows a ring: strokes where something is, and a line to the nearest."""

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
        """How far it shows [m]."""
        return self._scale.reach

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        if not math.isfinite(self.ring.nearest):
            return "nothing within range"
        near = ", near" if self.warning else ""
        return f"nearest {self.ring.nearest:.1f} metres {side_of(self.ring.bearing)}{near}"

    def clear(self) -> None:
        """Forget what was seen."""
        self._scale.reset()
        self.ring, self.warning = NOTHING, False
        self.renew()

    def show_ring(self, ring: Ring, warning: bool, time: float) -> None:
        """Show what was seen.

        Args:
            ring: nearest returns by bearing.
            warning: whether something is too near.
            time: now [s].
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
        """Return a size at which all is readable."""
        return QSize(200, 200)

    def paint_still(self, painter: QPainter) -> None:
        """Paint lines of equal distance with their metres, and the eight bearings."""
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
        """Paint what was seen."""
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
        """Into how many rings the reach is divided, each a round number of metres."""
        leading = round(self.reach / 10.0 ** math.floor(math.log10(self.reach) + 1e-9))
        return {1: 2, 2: 2, 5: 5}[leading] if self._radius > 90 else {1: 2, 2: 2, 5: 1}[leading]

    def _paint_metres(self, painter: QPainter, share: float) -> None:
        """Paint the metres of a ring, right of straight ahead."""
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
        """Return a stroke for each sector where something is within reach.

        Each is longer than its sector by its width, so that what is narrow is seen, too.
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
        """Return the radii of both ends of each stroke, so that those of one wall join."""
        joined = np.empty((2, SECTORS))
        for row, neighbour in enumerate((np.roll(radii, 1), np.roll(radii, -1))):
            both = np.isfinite(neighbour) & np.isfinite(radii)
            gap = np.full(SECTORS, np.inf)
            np.subtract(neighbour, radii, out=gap, where=both)
            near = np.abs(gap) <= BREAK * np.minimum(radii, neighbour)
            joined[row] = np.where(near, 0.5 * (np.where(near, neighbour, 0.0) + radii), radii)
        return joined

    def _paint_nearest(self, painter: QPainter, middle: QPointF, pixels: float) -> None:
        """Paint a line to what is nearest, and its sign: a ring, or a triangle that warns."""
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
            paint_sign(painter, place, Sign.WARNING, self.colour("bad"), self.colour("card"))
            return
        mark = QPainterPath()
        mark.addEllipse(end, size, size)
        painter.setBrush(self.colour("card"))
        painter.setPen(QPen(self.colour("accent"), 2.0))
        painter.drawPath(mark)

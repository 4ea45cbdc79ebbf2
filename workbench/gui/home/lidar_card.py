"""The lidar's scan: the nearest obstacles around the drone, seen from above."""

import math
from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QRectF, QSize, Qt
from PyQt6.QtWidgets import QWidget

from workbench.common.quantity import DisplayUnit
from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.sensor_state import SensorState, sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import Sign
from workbench.gui.instruments.map_frame import SteadyScale
from workbench.gui.instruments.plane_view import UNIT_CIRCLE, PlaneView
from workbench.gui.instruments.readout import Hint, ReadoutLine
from workbench.gui.instruments.ring_scan import (
    EMPTY_RING,
    RING_SECTORS,
    BearingRing,
    sector_bearings,
    side_of,
)
from workbench.gui.layout import CardPair, column, fill
from workbench.gui.poses import rotation_of
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import NearestClearance, Snapshot

MIN_RING_RANGE_M, MAX_RING_RANGE_M = 5.0, 100.0
"""Limits of the shown range [m]."""
RING_RANGE_FACTOR = 2.0
"""Shown range as a multiple of the nearest obstacle's distance."""
WALL_GAP_SHARE = 0.25
"""Neighbours whose ranges differ by more than this share belong to different walls."""
RANGE_CIRCLES = {1: 2, 2: 2, 5: 5}
"""Number of circles of a range, each a round number of metres, by the range's first digit."""
METRES_BEARING_RAD = math.radians(22.5)
"""Bearing of the numbers of metres, to the right of straight ahead [rad]."""


class LidarRing(PlaneView):
    """Shows a ring: arcs at obstacles, and a line to the nearest one; ahead is up.

    Attributes:
        ring: the shown scan.
        warning: whether something is too near.
    """

    def __init__(self, look: Look) -> None:
        super().__init__(look, "Lidar ring")
        self.ring = EMPTY_RING
        self.warning = False
        self._scale = SteadyScale(MIN_RING_RANGE_M, MAX_RING_RANGE_M)
        half = math.pi / RING_SECTORS
        ends = np.stack([sector_bearings() - half, sector_bearings() + half])
        self._directions = np.stack([-np.sin(ends), np.cos(ends)])
        self._rings = pg.PlotCurveItem(antialias=True, connect="finite")
        self._walls = pg.PlotCurveItem(antialias=True, connect="pairs")
        self._way = pg.PlotCurveItem(antialias=True)
        self._nearest = pg.ScatterPlotItem()
        self._drone = pg.ScatterPlotItem(symbol="t1", size=11, pen=None)
        self._metres: list[pg.TextItem] = []
        self.add(self._rings, self._walls, self._way, self._nearest, self._drone)
        self._drone.setData([0.0], [0.0])
        self._show_range()

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
        self.ring, self.warning = EMPTY_RING, False
        self._show_range()

    def show_ring(self, ring: BearingRing, warning: bool, time: float) -> None:
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
        wanted = RING_RANGE_FACTOR * ring.nearest if math.isfinite(ring.nearest) else self.reach
        if self._scale.take(wanted, time) != before:
            self._show_range()
        else:
            self._show_scan()

    def sizeHint(self) -> QSize:
        """Return a legible size."""
        return QSize(200, 200)

    def apply_colours(self) -> None:
        """Apply the colours of the look, and the font."""
        super().apply_colours()
        self._rings.setPen(self.pen("line"))
        self._walls.setPen(self.pen("ink", 2.5))
        self._drone.setBrush(self.look.colour("accent"))
        for text in self._metres:
            text.setColor(self.look.colour("muted"))
            text.setFont(self.font())
            text.fill = pg.mkBrush(self.look.colour("card"))
        self._show_scan()

    def _show_range(self) -> None:
        """Show circles of equal distance with numbers, and the eight bearings."""
        reach = self.reach
        leading = round(reach / 10.0 ** math.floor(math.log10(reach) + 1e-9))
        circles = np.arange(1, 1 + RANGE_CIRCLES[leading]) * reach / RANGE_CIRCLES[leading]
        rays = np.exp(0.25j * np.pi * np.arange(8))[:, None] * [0.12 * reach, reach, np.nan]
        lines = np.append(np.outer(circles, UNIT_CIRCLE).ravel(), rays.ravel())
        self._rings.setData(lines.real, lines.imag)
        while self._metres:
            self.view.removeItem(self._metres.pop())
        for metres in circles:
            text = f"{metres:g}" + ("\N{NO-BREAK SPACE}m" if metres == reach else "")
            made = pg.TextItem(text, anchor=(0.5, 0.5))
            at = 0.93 * metres if metres == reach else metres
            made.setPos(at * math.sin(METRES_BEARING_RAD), at * math.cos(METRES_BEARING_RAD))
            self._metres.append(made)
        self.add(*self._metres)
        self.show_area(QRectF(-1.02 * reach, -1.02 * reach, 2.04 * reach, 2.04 * reach))
        self.apply_colours()

    def _show_scan(self) -> None:
        """Show an arc for each sector with an obstacle within range, and the nearest one."""
        ring, seen = self.ring, self.ring.distances <= self.reach
        x, y = self._directions[:, :, seen] * _joined(ring.distances)[:, seen]
        self._walls.setData(x.T.ravel(), y.T.ravel())
        known = math.isfinite(ring.nearest)
        self._way.setVisible(known)
        self._nearest.setVisible(known)
        if known:
            level = min(self.reach, ring.nearest * math.cos(ring.elevation))
            end = -level * math.sin(ring.bearing), level * math.cos(ring.bearing)
            name, symbol = ("bad", "t1") if self.warning else ("accent", "o")
            self._way.setPen(self.pen(name, 1.5, Qt.PenStyle.DashLine))
            self._way.setData([0.0, end[0]], [0.0, end[1]])
            fill = self.look.colour("bad" if self.warning else "card")
            size = 14 if self.warning else 10
            self._nearest.setData(
                [end[0]], [end[1]], symbol=symbol, size=size, pen=self.pen(name, 2.0), brush=fill
            )


def _joined(radii: np.ndarray) -> np.ndarray:
    """Return the radii (2, SECTORS) at both ends of each arc, so that arcs of one wall join."""
    joined = np.empty((2, RING_SECTORS))
    for row, neighbour in enumerate((np.roll(radii, 1), np.roll(radii, -1))):
        both = np.isfinite(neighbour) & np.isfinite(radii)
        gap = np.full(RING_SECTORS, np.inf)
        np.subtract(neighbour, radii, out=gap, where=both)
        near = np.abs(gap) <= WALL_GAP_SHARE * np.minimum(radii, neighbour)
        joined[row] = np.where(near, 0.5 * (np.where(near, neighbour, 0.0) + radii), radii)
    return joined


class LidarCard(HomeCard):
    """The ring of the newest scan, and the nearest obstacle."""

    name = "lidar"
    title = "Lidar, obstacles"
    sensors = ("lidar",)

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self._cloud = b""
        self.ring = LidarRing(look)
        self.table = self.make_table("Nearest obstacle")
        self.hint = Hint("Lidar")
        numbers = column(1, self.table, (self.hint, 2), 1)
        fill(self.body, (CardPair(self.ring, numbers, (3, 2), 8), 1))

    @property
    def spoken(self) -> str:
        """The card as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.ring.spoken
        return f"{self.note}; {said}; {self.table.spoken}"

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return where the nearest obstacle is, and the free distance ahead."""
        bearing = ("To the left", units.angle.symbol)
        return ("Nearest", "m"), bearing, ("Side", ""), ("Free way", "m")

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
        self.table.setVisible(now.lidar is not None or now.clearance is not None)
        if now.lidar is None:
            self.hint.say(state.note, state.advice)
            for row in range(3):
                self.table.show_row(row, "–")
        else:
            self._show_scan(now, near)
        self.table.show_row(3, _obstacle_distance(now.clearance, self.units.length))

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
            ring = watch.scan.ring(watch.cloud, now.p_WB[2], -rotation_of(now.q_WB)[2])
        self.ring.show_ring(ring, near, now.time)
        if math.isfinite(ring.nearest):
            self.table.show_row(0, self.units.length.number(ring.nearest))
            self.table.show_row(1, self.units.angle.number(ring.bearing))
            self.table.show_row(2, side_of(ring.bearing))
        else:
            for row in range(3):
                self.table.show_row(row, "all free" if row == 2 else "–")


def _obstacle_distance(clearance: NearestClearance | None, length: DisplayUnit) -> str:
    """Return the distance to the nearest obstacle, from the world and not from the lidar."""
    if clearance is None:
        return "–"
    return length.number(clearance.distance) if math.isfinite(clearance.distance) else "free"

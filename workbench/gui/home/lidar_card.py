"""What is around the drone."""

import math

from PyQt6.QtCore import QRectF
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.beside import beside
from workbench.gui.home.card import SIGNS, Card, put
from workbench.gui.home.sensor_state import Health, SensorState, sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.hint import Hint
from workbench.gui.instruments.lidar_ring import LidarRing
from workbench.gui.instruments.readout import Line, Readout
from workbench.gui.instruments.ring_scan import down_of, side_of
from workbench.gui.instruments.sign import Sign
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Clearance, Snapshot


class LidarCard(Card):
    """The ring of the newest scan, and what is nearest."""

    name = "lidar"
    title = "Lidar, obstacles"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self._cloud = b""
        self.ring = LidarRing(look, self)
        lines = [Line("Nearest", "m"), Line("To the left"), Line("Side"), Line("Free way", "m")]
        self.table = Readout(
            look, "Nearest obstacle", lines, widest="\N{MINUS SIGN}888.88", parent=self
        )
        self.hint = Hint(look, "Lidar", self)
        self.hint.hide()
        self.parts = [self.ring, self.table, self.hint]
        self.use_units(units)

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.ring.spoken
        return f"{self.note}; {said}; {self.table.spoken}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        self.table.set_line(1, Line("To the left", units.angle.unit.symbol))

    def place_parts(self, body: QRectF) -> None:
        """Put the ring on the left, or above."""
        places = beside(body, 1.0 * self.text_size, 7.0 * self.text_size)
        put(self.ring, places.picture)
        put(self.hint, places.picture if self.table.isVisibleTo(self) else body)
        put(self.table, places.numbers)

    def begin(self, view: LiveView) -> None:
        """Forget what was around the last flight."""
        self._cloud = b""
        self.ring.clear()
        for row in range(4):
            self.table.show_row(row, "")

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest scan, and what is known of obstacles besides."""
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
        """Let a warning go before the lidar's own state."""
        if near:
            self.set_note("obstacle near", Sign.WARNING)
        elif state.health is Health.FAULTY:
            self.set_note(state.note, Sign.BAD)
        else:
            self.set_note(state.note, SIGNS[state.health])

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
    """Return the way to the nearest obstacle, from the world and not from the lidar."""
    if clearance is None:
        return "–"
    return number_text(clearance.distance, 2) if math.isfinite(clearance.distance) else "free"

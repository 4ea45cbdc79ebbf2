"""Satellite navigation, and a map of the way."""

import math

import numpy as np
from PyQt6.QtCore import QRectF
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.beside import beside
from workbench.gui.home.card import Card, put
from workbench.gui.home.sensor_state import sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.hint import Hint
from workbench.gui.instruments.map_frame import Place
from workbench.gui.instruments.path_map import PathMap, Pose
from workbench.gui.instruments.readout import Line, Readout
from workbench.gui.instruments.trail import TrailPoint
from workbench.gui.signals import Signals
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

TRAIL_PERIOD = 0.1
"""Between places of the trail that are taken from what was flown [s]."""


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
        places = beside(body, 0.9 * self.text_size, 7.6 * self.text_size, share=0.48)
        put(self.map, places.picture)
        put(self.table, places.numbers)
        put(self.hint, places.numbers)

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

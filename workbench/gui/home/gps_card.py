"""The card of satellite navigation: the measured position, and the map of the flight."""

import math
from collections.abc import Sequence

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtGui import (
    QHideEvent,
    QShortcut,
)
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.path_map import PathMap
from workbench.gui.home.route import Route
from workbench.gui.home.sensor_state import sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.trail import TrailPoint
from workbench.gui.instruments.map_frame import (
    MapPlace,
)
from workbench.gui.instruments.readout import Hint, ReadoutLine
from workbench.gui.labels import set_tip
from workbench.gui.layout import CardPair, column, fill, tool_button
from workbench.gui.signals import Signals
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.plant.geodesy import geodetic
from workbench.plant.home import DEFAULT_HOME
from workbench.plant.worlds.outline import Outline
from workbench.session.snapshot import Snapshot

MAP_TRAIL_PERIOD_S = 0.1
"""Period between recorded points of the trail [s]."""
MAX_POINTER_LINES = 4
"""Largest number of lines about the place under the pointer."""
MAP_HELP_TEXT = (
    "Click a place on the map to fly there at the present height. With Shift, further clicks set "
    "waypoints that are flown in turn. A right click removes one, Escape removes all. The wheel "
    "zooms."
)


class GpsCard(HomeCard):
    """Latitude, longitude and altitude as measured; the map shows the true path from above."""

    name = "gps"
    title = "GPS, path"
    sensors = ("gps",)

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
        self.map = PathMap(look)
        self.map.say_place = self._say_place
        self.go_to = tool_button("Go to", kind="tight")
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
        self.table = self.make_table("GPS", widest=("188.8888888",))
        self.hint = Hint("GPS")
        self.put_in_head(self.go_to)
        numbers = column(1, self.table, (self.hint, 2), 1)
        fill(self.body, (CardPair(self.map, numbers, (1, 1), 8), 1))

    @property
    def spoken(self) -> str:
        """The position as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.table.spoken
        return f"{self.note}; {said}; {self.map.spoken}"

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return a line for each coordinate."""
        place = [(label, units.place.symbol) for label in ("Latitude", "Longitude")]
        return *place, ("Altitude", "m"), ("From home", "m")

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
        self.map.begin(MapPlace(start[0], start[1]), view.outlines)
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
        self.table.show_row(0, place.number(reading.latitude))
        self.table.show_row(1, place.number(reading.longitude))
        self.table.show_row(2, self.units.length.number(reading.altitude))
        self.table.show_row(3, self.units.length.number(math.hypot(*now.displacement[:2])))

    def _bar(self, barred: str) -> None:
        """Enable the button while a waypoint can be flown."""
        tip = barred or MAP_HELP_TEXT
        if self.go_to.toolTip() != tip:
            set_tip(self.go_to, tip)
            self.go_to.setEnabled(not barred)
            if barred:
                self.go_to.setChecked(False)

    def _set_point(self, place: MapPlace, more: bool) -> None:
        self._route.add(place, more=more)
        if not more:
            self.go_to.setChecked(False)

    def _show_points(self) -> None:
        points = [MapPlace(east, north) for east, north, _ in self._route.places]
        self.map.show_points(points, self._route.present)

    def _say_place(self, place: MapPlace) -> list[str]:
        """Return latitude and longitude of a place, and what is there."""
        shown, height, time = self.units.place, 0.0, 0.0
        if self._now is not None:
            height, time = self._now.p_WB[2], self._now.time
        at = geodetic((place.east, place.north, height), self._home)
        lines = [shown.text(each) for each in (at.latitude, at.longitude)]
        for outline in self._outlines:
            present = outline.at(time)
            if present.holds(place.east, place.north):
                length = self.units.length
                heights = f"{length.number(present.low)} to {length.text(present.high)}"
                lines.append(f"{outline.name}, {heights}")
        return lines[:MAX_POINTER_LINES]

    def _show_map(self, now: Snapshot) -> None:
        east, north, _ = now.p_WB
        self.map.show_pose(MapPlace(east, north), now.roll_pitch_yaw[2], self._passed(), now.time)

    def _passed(self) -> list[TrailPoint]:
        """Return the positions since the last call, also while the map was hidden."""
        if "position_data.x" not in self._signals.units:
            return []
        times, east = self._signals.series("position_data.x", self._seen + MAP_TRAIL_PERIOD_S)
        _, north = self._signals.series("position_data.y", self._seen + MAP_TRAIL_PERIOD_S)
        if not len(times):
            return []
        taken = _spaced(times, MAP_TRAIL_PERIOD_S)
        self._seen = float(times[taken[-1]])
        rows = (times[taken].tolist(), east[taken].tolist(), north[taken].tolist())
        return list(zip(*rows, strict=True))


def _spaced(times: np.ndarray, period: float) -> np.ndarray:
    """Return the indices of the first of some times in each period."""
    _, first = np.unique(np.floor((times - times[0]) / period), return_index=True)
    return first

"""What barometer and range finder measure."""

import math

from PyQt6.QtCore import QRectF

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.card import Card, put
from workbench.gui.home.sensor_state import Health, SensorState, sensor_state
from workbench.gui.instruments.hint import Hint
from workbench.gui.instruments.readout import Line, Readout
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

PASCALS = 100.0
"""In a hectopascal."""
SILENT = "Neither measures in this flight. Switch them on in Settings, Sensors."


def range_text(height: float) -> str:
    """Return what a range finder read [m], in words where it is out of range."""
    if math.isinf(height):
        return "too far" if height > 0.0 else "too near"
    return number_text(height, 2)


class HeightCard(Card):
    """How high it is, in two ways."""

    name = "height"
    title = "Barometer, range finder"

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        lines = [Line("Altitude", "m"), Line("Pressure", "hPa"), Line("Range finder", "m")]
        self.table = Readout(self.look, "Heights", lines, widest="88888.88", parent=self)
        self.hint = Hint(self.look, "Heights", self)
        self.hint.hide()
        self.parts = [self.table, self.hint]

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.table.spoken
        return f"{self.note}; {said}"

    def place_parts(self, body: QRectF) -> None:
        """Let either fill it."""
        put(self.table, body)
        put(self.hint, body)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest readings, and the one that does worse beside the title."""
        air = sensor_state(view, now, "barometer")
        way = sensor_state(view, now, "range_finder")
        silent = now.barometer is None and now.height is None
        self.table.setVisible(not silent)
        self.hint.setVisible(silent)
        self.set_state(max(air, way, key=_concern))
        if silent:
            self.hint.say(air.note, SILENT if Health.OFF in (air.health, way.health) else "")
            return
        if now.barometer is not None:
            self.table.show_row(0, number_text(now.barometer.altitude, 2))
            self.table.show_row(1, number_text(now.barometer.pressure / PASCALS, 2))
        else:
            self.table.show_row(0, air.word)
            self.table.show_row(1, air.word)
        self.table.show_row(2, way.word if now.height is None else range_text(now.height))


def _concern(state: SensorState) -> int:
    """Return how much a state has to be told."""
    return list(Health).index(state.health) if state.measures else 0

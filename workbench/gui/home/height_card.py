"""The card of the height from barometer and range finder."""

import math
from collections.abc import Sequence
from typing import Any

from workbench.common.quantity import DisplayUnit
from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.sensor_state import SensorHealth, sensor_state, worst_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.readout import Hint, ReadoutLine
from workbench.gui.layout import fill
from workbench.gui.units import HECTOPASCAL_UNIT
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

HEIGHT_SENSORS_OFF_TEXT = "Neither is on in this flight. Fly with them here or from Settings."


def range_text(height: float, length: DisplayUnit) -> str:
    """Return a range finder's reading [m] as text in a unit, in words if it is out of range."""
    if math.isinf(height):
        return "too far" if height > 0.0 else "too near"
    return length.number(height)


class HeightCard(HomeCard):
    """The height from two sensors."""

    name = "height"
    title = "Barometer, range finder"
    sensors = ("barometer", "range_finder")

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.table = self.make_table("Heights", widest=("88888.88",))
        self.hint = Hint("Heights")
        self.parts = [self.table, self.hint]
        fill(self.body, (self.table, 1), (self.hint, 1))

    @property
    def spoken(self) -> str:
        """The heights as a sentence."""
        return f"{self.note}; {super().spoken}"

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return a line for each reading."""
        length = units.length.symbol
        return (
            ("Altitude", length),
            ("Pressure", HECTOPASCAL_UNIT.symbol),
            ("Range finder", length),
        )

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest readings, and the worse of the two states beside the title."""
        air = sensor_state(view, now, "barometer")
        way = sensor_state(view, now, "range_finder")
        silent = now.barometer is None and now.height is None
        self.table.setVisible(not silent)
        self.hint.setVisible(silent)
        self.set_state(worst_state(view, now, self.sensors))
        if silent:
            off = [each.advice for each in (air, way) if each.health is SensorHealth.OFF]
            self.hint.say(air.note, HEIGHT_SENSORS_OFF_TEXT if len(off) > 1 else "".join(off))
            return
        if now.barometer is not None:
            self.table.show_row(0, self.units.length.number(now.barometer.altitude))
            self.table.show_row(1, HECTOPASCAL_UNIT.number(now.barometer.pressure))
        else:
            self.table.show_row(0, air.note)
            self.table.show_row(1, air.note)
        reading = None if now.height is None else range_text(now.height, self.units.length)
        self.table.show_row(2, reading or way.note)

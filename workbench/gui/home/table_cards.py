"""Cards that are a table alone: motion, IMU, and the two instruments that measure height."""

import math

from workbench.gui.charts.ticks import number_text
from workbench.gui.home.card import Card
from workbench.gui.home.sensor_state import Health, SensorState, sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.hint import Hint
from workbench.gui.instruments.readout import Line, Readout
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

PASCALS = 100.0
"""In a hectopascal."""
SILENT = "Neither measures in this flight. Switch them on in Settings, Sensors."


class MotionCard(Card):
    """A table: along x, y, z of the world, and how much in all."""

    name = "motion"
    title = "Motion"

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        lines = [Line("Displacement"), Line("Velocity"), Line("Acceleration")]
        headings = ("x east", "y north", "z up", "total")
        self.table = Readout(self.look, "Motion in W", lines, headings, parent=self)
        self.parts = [self.table]
        self.use_units(self.units)

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"in the world frame: {self.table.spoken}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        self._rows = (units.length, units.speed, units.acceleration)
        labels = ("Displacement", "Velocity", "Acceleration")
        for index, (label, shown) in enumerate(zip(labels, self._rows, strict=True)):
            self.table.set_line(index, Line(label, shown.unit.symbol))

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show all three."""
        vectors = (now.displacement, now.v_WB, now.vdot_WB)
        for index, (vector, shown) in enumerate(zip(vectors, self._rows, strict=True)):
            self.table.show_row(index, *shown.texts(*vector, math.hypot(*vector)))
        self.set_note("world frame W")


class ImuCard(Card):
    """Turning rates and specific force along the sensor's axes."""

    name = "imu"
    title = "IMU"

    def __init__(self, *args: object) -> None:
        super().__init__(*args)  # type: ignore[arg-type]
        lines = [Line("Turn rate"), Line("Specific force")]
        self.table = Readout(self.look, "IMU", lines, ("x", "y", "z"), parent=self)
        self.hint = Hint(self.look, "IMU", self)
        self.hint.hide()
        self.parts = [self.table, self.hint]
        self.use_units(self.units)

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return f"{self.note}; {super().spoken}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        self.table.set_line(0, Line("Turn rate", units.rate.unit.symbol))
        self.table.set_line(1, Line("Specific force", units.acceleration.unit.symbol))

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest reading and its age."""
        state = sensor_state(view, now, "imu")
        self.set_state(state)
        reading = now.imu
        self.table.setVisible(reading is not None)
        self.hint.setVisible(reading is None)
        if reading is None:
            self.hint.say(state.note, state.advice)
            return
        self.table.show_row(0, *self.units.rate.texts(*reading.angular_velocity))
        self.table.show_row(1, *self.units.acceleration.texts(*reading.specific_force))


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
        return f"{self.note}; {super().spoken}"

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

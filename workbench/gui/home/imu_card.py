"""The card of the IMU and the magnetometer."""

from collections.abc import Sequence
from typing import Any

from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.sensor_state import SensorHealth, SensorState, sensor_state, worst_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.readout import UNKNOWN_VALUE_TEXT, Hint, ReadoutLine
from workbench.gui.labels import set_tip
from workbench.gui.layout import fill
from workbench.gui.units import MICROTESLA_UNIT
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


class ImuCard(HomeCard):
    """Angular velocity, specific force and magnetic field along the sensors' axes."""

    name = "imu"
    title = "IMU, magnetometer"
    sensors = ("imu", "magnetometer")

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.table = self.make_table("IMU", ("x", "y", "z"))
        self.hint = Hint("IMU")
        self.parts = [self.table, self.hint]
        fill(self.body, (self.table, 1), (self.hint, 1))

    @property
    def spoken(self) -> str:
        """The readings as a sentence."""
        return f"{self.note}; {super().spoken}"

    def lines(self, units: ShownUnits) -> Sequence[ReadoutLine]:
        """Return a line for each reading."""
        return (
            ("Turn rate", units.rate.symbol),
            ("Specific force", units.acceleration.symbol),
            ("Magnetic field", MICROTESLA_UNIT.symbol),
        )

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the newest readings, and the worse of the two states beside the title."""
        state = sensor_state(view, now, "imu")
        compass = sensor_state(view, now, "magnetometer")
        silent = now.imu is None and now.magnetometer is None
        self.table.setVisible(not silent)
        self.hint.setVisible(silent)
        self.set_state(worst_state(view, now, self.sensors))
        set_tip(self.table, state.advice)
        if silent:
            self.hint.say(state.note, state.advice)
            return
        rate = force = _unmeasured(state)
        field = _unmeasured(compass)
        if now.imu is not None:
            rate = tuple(map(self.units.rate.number, now.imu.angular_velocity))
            force = tuple(map(self.units.acceleration.number, now.imu.specific_force))
        if now.magnetometer is not None:
            field = tuple(map(MICROTESLA_UNIT.number, now.magnetometer.magnetic_field))
        self.table.show_row(0, *rate)
        self.table.show_row(1, *force)
        self.table.show_row(2, *field)


def _unmeasured(state: SensorState) -> tuple[str, ...]:
    """Return the text instead of x, y, z for a sensor without a reading."""
    waits = state.health is SensorHealth.WAITING
    return ("", "", UNKNOWN_VALUE_TEXT if waits else state.health.word)

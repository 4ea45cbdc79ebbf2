"""What the IMU measures."""

from PyQt6.QtCore import QRectF

from workbench.gui.home.card import Card, put
from workbench.gui.home.sensor_state import sensor_state
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.instruments.hint import Hint
from workbench.gui.instruments.readout import Line, Readout
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot


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
        said = self.hint.spoken if self.hint.isVisibleTo(self) else self.table.spoken
        return f"{self.note}; {said}"

    def use_units(self, units: ShownUnits) -> None:
        """Show units and numbers."""
        super().use_units(units)
        self.table.set_line(0, Line("Turn rate", units.rate.unit.symbol))
        self.table.set_line(1, Line("Specific force", units.acceleration.unit.symbol))

    def place_parts(self, body: QRectF) -> None:
        """Let either fill it."""
        put(self.table, body)
        put(self.hint, body)

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

"""The form of the wind of a flight: speed, direction and turbulence."""

import math

from PyQt6.QtWidgets import QComboBox, QWidget

from workbench.common.quantity import DisplayUnit
from workbench.gui.labels import set_tip
from workbench.gui.layout import button, choice
from workbench.gui.number_field import NumberField
from workbench.gui.tuning.card import fields_beside
from workbench.gui.units import unit_for
from workbench.gui.workspace import Workspace
from workbench.scenario.faults import TURBULENCES
from workbench.scenario.scenario import Action

MAX_WIND_M_S = 25.0
"""Largest wind speed [m/s]."""
FULL_TURN_RAD = math.tau
FIELD_LABEL_GAP_PX = 4
"""Between a label and its field [px]."""
ELIDING_SIZE_POLICY = QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
MIN_WIND_FIELD_PX = 100
"""Least width of a field [px]."""
WIND_SPEED_KEY, WIND_DIRECTION_KEY, WIND_TURBULENCE_KEY = (
    f"tuning/wind/{name}" for name in ("speed", "direction", "turbulence")
)
"""Settings keys of the last values."""


class WindForm(QWidget):
    """Sets the wind of a flight, or calm air.

    Args:
        workspace: its flight gets the wind, and its preferences store the values.

    Attributes:
        buttons: set the wind, and calm the air; the form's user places them.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight, self._preferences = workspace.flight, workspace.preferences
        self.speed = NumberField("Wind", 1, 1.0)
        self.direction = NumberField("Blows towards, from east on to north", 0, 15.0)
        self.direction.set_range(DisplayUnit("°", 180.0 / math.pi), -FULL_TURN_RAD, FULL_TURN_RAD)
        set_tip(self.direction, "Where the wind blows towards: 0° is east, 90° is north")
        self.turbulence = choice(
            "Turbulence", TURBULENCES, "Dryden's, by the wind speed at 20 ft that makes it"
        )
        self.turbulence.setSizeAdjustPolicy(ELIDING_SIZE_POLICY)
        self.button = button("Set wind", self.blow, "primary")
        self.still = button(
            "Still air",
            lambda: self._set(0.0, 0.0, TURBULENCES["still"]),
            help="No wind and no turbulence",
        )
        self.buttons = (self.still, self.button)
        store = self._preferences.store
        self._take_kept(store.value(WIND_SPEED_KEY, 4.0), store.value(WIND_DIRECTION_KEY, 0.0))
        kept = str(store.value(WIND_TURBULENCE_KEY, "still"))
        self.turbulence.setCurrentIndex(max(0, self.turbulence.findText(kept)))
        fields = (
            ("&Wind", self.speed),
            ("Blows t&owards", self.direction),
            ("&Turbulence", self.turbulence),
        )
        fields_beside(fields, MIN_WIND_FIELD_PX, of=self, gap=FIELD_LABEL_GAP_PX)
        self._preferences.changed.connect(lambda _: self._show_unit())

    def blow(self) -> None:
        """Set the wind from now on."""
        store, name = self._preferences.store, self.turbulence.currentText()
        for key, value in (
            (WIND_SPEED_KEY, self.speed.si),
            (WIND_DIRECTION_KEY, self.direction.si),
        ):
            store.setValue(key, value)
        store.setValue(WIND_TURBULENCE_KEY, name)
        speed = TURBULENCES[name]
        self._set(self.speed.si, self.direction.si, speed)

    def set_enabled(self, flies: bool) -> None:
        """Enable the buttons while there is a flight."""
        self.button.setEnabled(flies and not self.speed.fault and not self.direction.fault)
        self.still.setEnabled(flies)

    def _set(self, speed: float, direction: float, turbulence: float) -> None:
        values = {
            "wind_x": speed * math.cos(direction),
            "wind_y": speed * math.sin(direction),
            "wind_z": 0.0,
            "turbulence": turbulence,
        }
        self._flight.do(Action(set=values))

    def _take_kept(self, speed: object, direction: object) -> None:
        self._show_unit()
        for field, value, most in (
            (self.speed, speed, MAX_WIND_M_S),
            (self.direction, direction, FULL_TURN_RAD),
        ):
            try:
                number = float(str(value))
            except ValueError:  # written by another version or an editor
                number = 0.0
            field.show_si(number if abs(number) <= most else 0.0)

    def _show_unit(self) -> None:
        speed = self.speed.si if self.speed.text() else 0.0
        self.speed.set_range(unit_for("m/s", self._preferences), 0.0, MAX_WIND_M_S)
        self.speed.show_si(speed)

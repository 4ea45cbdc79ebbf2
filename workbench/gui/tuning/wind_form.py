"""Fields for the wind and its turbulence, which act until they are changed."""

import math

from PyQt6.QtWidgets import QComboBox, QGridLayout, QPushButton, QWidget

from workbench.common.errors import find_row
from workbench.gui.number_field import NumberField, buddy
from workbench.gui.style import dressed
from workbench.gui.tuning.card import SPACING
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.scenario.faults import TURBULENCES

MOST = 25.0
"""Of the wind [m/s]."""
TURN = math.tau
NARROWEST = 100
"""Of a field [px]."""
WIND, DIRECTION, TURBULENCE = (
    f"tuning/wind/{name}" for name in ("speed", "direction", "turbulence")
)
"""Where the last ones are kept."""


class WindForm(QWidget):
    """Lets a wind blow over a flight, or stills the air.

    Args:
        workspace: whose flight is blown at, and whose preferences keep the choice.

    Attributes:
        buttons: set the wind, and still the air; who shows the form places them.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight, self._preferences = workspace.flight, workspace.preferences
        self.speed = NumberField("Wind", 1, 1.0)
        self.direction = NumberField("To, from east on to north", 0, 15.0)
        self.direction.set_range(Unit("°", 180.0 / math.pi), -TURN, TURN)
        self.direction.setToolTip("Where the wind blows to: 0° is east, 90° is north")
        self.turbulence = QComboBox()
        self.turbulence.setAccessibleName("Turbulence")
        self.turbulence.addItems([row.name for row in TURBULENCES])
        self.turbulence.setToolTip("Dryden's, by the wind speed at 20 ft that makes it")
        self.button = dressed(QPushButton("Set wind"), "primary")
        self.still = QPushButton("Still air")
        self.still.setToolTip("No wind and no turbulence")
        self.buttons = (self.still, self.button)
        store = self._preferences.store
        self._take_kept(store.value(WIND, 4.0), store.value(DIRECTION, 0.0))
        kept = str(store.value(TURBULENCE, TURBULENCES[0].name))
        self.turbulence.setCurrentIndex(max(0, self.turbulence.findText(kept)))
        self._lay_out()
        self.button.clicked.connect(self.blow)
        self.still.clicked.connect(lambda: self._set(0.0, 0.0, TURBULENCES[0].speed))
        self._preferences.changed.connect(lambda _: self._show_unit())

    def blow(self) -> None:
        """Let the wind blow from now on."""
        store, name = self._preferences.store, self.turbulence.currentText()
        for key, value in ((WIND, self.speed.si), (DIRECTION, self.direction.si)):
            store.setValue(key, value)
        store.setValue(TURBULENCE, name)
        speed = find_row("turbulence", name, TURBULENCES).speed
        self._set(self.speed.si, self.direction.si, speed)

    def set_enabled(self, flies: bool) -> None:
        """Let it be pressed while there is a flight."""
        self.button.setEnabled(flies and not self.speed.fault and not self.direction.fault)
        self.still.setEnabled(flies)

    def _set(self, speed: float, direction: float, turbulence: float) -> None:
        values = {
            "wind_x": speed * math.cos(direction),
            "wind_y": speed * math.sin(direction),
            "wind_z": 0.0,
            "turbulence": turbulence,
        }
        self._flight.order(lambda live: live.set_all(values))

    def _take_kept(self, speed: object, direction: object) -> None:
        self._show_unit()
        for field, value, most in ((self.speed, speed, MOST), (self.direction, direction, TURN)):
            try:
                number = float(str(value))
            except ValueError:  # another version wrote it, or an editor
                number = 0.0
            field.show_si(number if abs(number) <= most else 0.0)

    def _show_unit(self) -> None:
        speed = self.speed.si if self.speed.text() else 0.0
        self.speed.set_range(unit_for("m/s", self._preferences), 0.0, MOST)
        self.speed.show_si(speed)

    def _lay_out(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(SPACING)
        grid.setVerticalSpacing(4)
        for column, (text, field) in enumerate(
            (("&Wind", self.speed), ("T&o", self.direction), ("&Turbulence", self.turbulence))
        ):
            grid.addWidget(buddy(text, field), 0, column)
            grid.addWidget(field, 1, column)
            grid.setColumnStretch(column, 1)
            field.setMinimumWidth(NARROWEST)
        self.turbulence.setSizeAdjustPolicy(
            QComboBox.SizeAdjustPolicy.AdjustToMinimumContentsLengthWithIcon
        )

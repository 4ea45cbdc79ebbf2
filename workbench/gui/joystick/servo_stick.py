"""The setpoints of servos beside the sticks: one servo at a time, by a slider and by keys."""

from PyQt6.QtCore import QSignalBlocker, Qt
from PyQt6.QtWidgets import QComboBox, QSlider, QWidget

from workbench.common.parameter import Parameter
from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default
from workbench.gui.command_action import make_actions
from workbench.gui.gains.flown_gains import FlownGains
from workbench.gui.gains.gain_rows import gain_label
from workbench.gui.key_table import SERVO_KEYS
from workbench.gui.layout import hbox, label, named
from workbench.gui.tuning.card import set_items
from workbench.gui.units import unit_for
from workbench.gui.wheel import ComboBox
from workbench.gui.workspace import Workspace
from workbench.live.view import LiveView

SLIDER_STEPS = 100
"""Steps of the slider over the range of a setpoint."""
KEY_STEPS = 2
"""Steps of the slider by which a key moves it; a key that is held repeats."""


class ServoStick(QWidget):
    """Moves the setpoint of a servo; hidden where the flight has none to command.

    Args:
        workspace: the flight, units and keys.

    Attributes:
        servos: selects the servo.
        slider: its setpoint, as a share of its range.
        reading: its setpoint in words.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight, self._preferences = workspace.flight, workspace.preferences
        self._keys = workspace.keys
        self._controller: Controller | None = None
        self._rows: dict[str, Parameter] = {}
        self._flown = FlownGains(workspace.flight, self)
        self.servos = named(ComboBox(), "Servo")
        # another drone's names may be longer
        self.servos.setSizeAdjustPolicy(QComboBox.SizeAdjustPolicy.AdjustToContents)
        self.slider = named(QSlider(Qt.Orientation.Horizontal), "Setpoint of the servo")
        self.slider.setRange(0, SLIDER_STEPS)
        self.reading, self._hint = label(), label("", "muted")
        hbox(self.servos, (self.slider, 1), self.reading, self._hint, of=self, spacing=8)
        handlers = {
            "servo_raise": lambda: self.move_by(KEY_STEPS),
            "servo_lower": lambda: self.move_by(-KEY_STEPS),
            "servo_next": self.choose_next,
        }
        window = Qt.ShortcutContext.WindowShortcut
        self.actions_by_name = make_actions(self, handlers, workspace.keys, SERVO_KEYS, window)
        self.servos.currentIndexChanged.connect(self._show)
        self.slider.valueChanged.connect(self._order_step)
        self._flown.changed.connect(self._show)
        self._flown.refused.connect(lambda _, said: workspace.notices.warn(said))
        self._flown.refused.connect(self._show)
        workspace.preferences.changed.connect(self._show)
        workspace.keys.changed.connect(self._show)
        self.setVisible(False)

    @property
    def chosen(self) -> Parameter | None:
        """The setpoint that is moved, None without servos."""
        return self._rows.get(self.servos.currentData() or "")

    def show_view(self, view: LiveView) -> None:
        """Take the servos of a flight, or of another controller of it."""
        if view.controller is self._controller:
            return
        self.begin(view)

    def begin(self, view: LiveView) -> None:
        """Take the servos of a flight that has begun."""
        self._controller = view.controller
        self._rows = {row.name: row for row in controller_or_default(view.controller).setpoints}
        self._flown.begin(view)
        set_items(self.servos, {name: gain_label(row).text for name, row in self._rows.items()})
        self.setVisible(bool(self._rows))
        self._show()

    def choose_next(self) -> None:
        """Choose the next servo, after the last one the first."""
        if self._rows:
            self.servos.setCurrentIndex((self.servos.currentIndex() + 1) % self.servos.count())

    def move_by(self, steps: int) -> None:
        """Move the setpoint by steps of the slider, within its range."""
        self.slider.setValue(self.slider.value() + steps)

    def _order_step(self, step: int) -> None:
        row = self.chosen
        if row is None:
            return
        value = row.minimum + (row.maximum - row.minimum) * step / SLIDER_STEPS
        if self._flight.live is not None:
            self._flown.order({row.name: value})
        self._show()

    def _show(self, *_: object) -> None:
        row = self.chosen
        if row is None:
            return
        value, unit = self._flown.ordered(row.name), unit_for(row.unit, self._preferences)
        share = (value - row.minimum) / (row.maximum - row.minimum)
        with QSignalBlocker(self.slider):
            self.slider.setValue(round(SLIDER_STEPS * share))
        text = unit.text(value)
        self.reading.setText(text)
        self.slider.setAccessibleDescription(text)
        raise_key, lower_key, next_key = (self._keys.key(each.name) for each in SERVO_KEYS)
        self._hint.setText(f"{raise_key} up, {lower_key} down, {next_key} the next")

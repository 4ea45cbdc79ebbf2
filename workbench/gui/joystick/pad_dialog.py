"""The dialog of the game pads: mapping of the axes, calibration, and which pad flies."""

from dataclasses import replace

from PyQt6.QtCore import QSignalBlocker, Qt, QTimer
from PyQt6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QSlider,
    QSpinBox,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.gui.joystick.game_pad import PadReading
from workbench.gui.joystick.pad_mapping import (
    DEFAULT_PAD_MAPPING,
    PAD_AXIS_NAMES,
    PAD_FUNCTIONS,
    PadAxis,
    PadMapping,
    RawPadAxes,
    calibrated_mapping,
    name_axis,
)
from workbench.gui.joystick.pilot import StickPilot
from workbench.gui.labels import Label
from workbench.gui.layout import button, choice, grid, hbox, label, named, vbox

PAD_DIALOG_PERIOD_MS = 33
"""Period between readings [ms]."""
CALIBRATION_TEXT = "Move each stick to all its stops, release them, then press Done."
PAD_DIALOG_HELP = (
    "No pad flies while this page is in front. Each row is one command of the sticks; the feel of "
    "the sticks applies afterwards."
)
PAD_GONE_TEXT = "No game pad is plugged in."
PAD_DIALOG_HEADINGS = ("", "Moved by", "", "Dead band", "Expo", "Pad says", "Asked for")


AXIS_SLIDER_STEPS = 100
"""Number of steps from the middle of an axis to its end."""


def _axis_slider(name: str, parent: QWidget) -> QSlider:
    """Return a slider that shows a value from -1 to 1, and cannot be moved."""
    made = named(QSlider(Qt.Orientation.Horizontal, parent), name)
    made.setRange(-AXIS_SLIDER_STEPS, AXIS_SLIDER_STEPS)
    made.setAttribute(Qt.WidgetAttribute.WA_TransparentForMouseEvents)
    made.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    made.setMinimumWidth(90)
    return made


class AxisRow:
    """The widgets of one function: its axis, shaping, and result."""

    def __init__(self, function: str, parent: QWidget) -> None:
        self.axis = choice(f"{function}: moved by", PAD_AXIS_NAMES)
        self.inverted = named(QCheckBox("inverted", parent), f"{function}: inverted")
        self.dead_band, self.expo = QSpinBox(parent), QSpinBox(parent)
        for box, most, what in ((self.dead_band, 50, "dead band"), (self.expo, 100, "expo")):
            box.setRange(0, most)
            box.setSuffix(" %")
            box.setAccessibleName(f"{function}: {what}, percent")
        self.raw = _axis_slider(f"{function}: what the pad says", parent)
        self.shaped = _axis_slider(f"{function}: the command", parent)
        self.widgets: tuple[QWidget, ...] = (
            Label(function, parent),
            self.axis,
            self.inverted,
            self.dead_band,
            self.expo,
            self.raw,
            self.shaped,
        )


class PadDialog(QDialog):
    """Maps and calibrates the plugged-in pads.

    Args:
        pilot: pilot with the pads.
        parent: the Qt parent.

    Attributes:
        pads: selects the shown pad.
        rows: one row for each of `PAD_FUNCTIONS`.
        calibrate: starts and ends the calibration.
        fly: lets the selected pad fly.
        said: instructions, or an error.
    """

    def __init__(self, pilot: StickPilot, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Game pads")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._pilot = pilot
        self._calibration: list[RawPadAxes] = []  # readings since it began
        self._shown: tuple[tuple[int, str], ...] = ()
        self.pads = choice("Game pad")
        self.fly = button("Let it fly", self._let_fly, "compact")
        self.flies = label(kind="value")
        self.rows = tuple(AxisRow(function, self) for function in PAD_FUNCTIONS)
        self.moved = label(kind="muted")
        self.said = label(PAD_DIALOG_HELP, wraps=True)
        self.calibrate = button("Calibrate")
        self.calibrate.setCheckable(True)
        self.defaults = button("Defaults", lambda: self._keep(DEFAULT_PAD_MAPPING), "quiet")
        self._lay_out()
        self.pads.currentIndexChanged.connect(self._choose)
        self.calibrate.toggled.connect(self._calibrate)
        for index, row in enumerate(self.rows):
            row.axis.activated.connect(lambda _, at=index: self._change(at))
            row.inverted.clicked.connect(lambda _, at=index: self._change(at))
            row.dead_band.valueChanged.connect(lambda _, at=index: self._change(at))
            row.expo.valueChanged.connect(lambda _, at=index: self._change(at))
        self._timer = QTimer(self)
        self._timer.timeout.connect(self.look_at_pads)
        self._timer.start(PAD_DIALOG_PERIOD_MS)
        self.look_at_pads()

    @property
    def reading(self) -> PadReading | None:
        """The shown pad."""
        number = self.pads.currentData()
        return next((each for each in self._pilot.pads.readings if each.number == number), None)

    def look_at_pads(self) -> None:
        """Show the existing pads, and the axes of the selected one."""
        pads = tuple((each.number, each.name) for each in self._pilot.pads.readings)
        if pads != self._shown:
            self._list(pads)
        reading = self.reading
        if reading is None:
            self.flies.setText(PAD_GONE_TEXT)
            return
        if self.calibrate.isChecked():
            self._calibration.append(reading.raw)
        flies = reading.number == self._pilot.pads.flying
        self.flies.setText("It flies." if flies else "It waits.")
        self.fly.setVisible(not flies)
        self.moved.setText(f"Moves now: {name_axis(reading.raw)}")
        for row, axis in zip(self.rows, self._pilot.mapping(reading.guid), strict=True):
            row.raw.setValue(round(AXIS_SLIDER_STEPS * reading.raw[axis.axis]))
            row.shaped.setValue(round(AXIS_SLIDER_STEPS * axis.shaped(reading.raw)))

    def _list(self, pads: tuple[tuple[int, str], ...]) -> None:
        chosen = self.pads.currentData()
        self._shown = pads
        with QSignalBlocker(self.pads):
            self.pads.clear()
            for number, name in pads:
                self.pads.addItem(plain_name(name), number)
            at = self.pads.findData(self._pilot.pads.flying if chosen is None else chosen)
            self.pads.setCurrentIndex(max(at, 0))
        self._choose()

    def _choose(self) -> None:
        """Show another pad's mapping; an unfinished calibration is dropped."""
        with QSignalBlocker(self.calibrate):
            self.calibrate.setChecked(False)
        self.calibrate.setText("Calibrate")
        self.said.setText(PAD_DIALOG_HELP)
        reading = self.reading
        for widget in (self.calibrate, self.defaults, self.fly):
            widget.setEnabled(reading is not None)
        for row in self.rows:
            for each in row.widgets:
                each.setEnabled(reading is not None)
        if reading is not None:
            self._show_mapping(self._pilot.mapping(reading.guid))

    def _show_mapping(self, mapping: PadMapping) -> None:
        for row, axis in zip(self.rows, mapping, strict=True):
            fields = (row.axis, row.inverted, row.dead_band, row.expo)
            for each in fields:
                each.blockSignals(True)
            row.axis.setCurrentIndex(axis.axis)
            row.inverted.setChecked(axis.inverted)
            row.dead_band.setValue(round(100 * axis.dead_band))
            row.expo.setValue(round(100 * axis.expo))
            for each in fields:
                each.blockSignals(False)

    def _change(self, function: int) -> None:
        """Apply a row's settings; a different axis has default ends until it is calibrated."""
        reading = self.reading
        if reading is None:
            return
        row, mapping = self.rows[function], [*self._pilot.mapping(reading.guid)]
        axis = row.axis.currentIndex()
        before = mapping[function] if axis == mapping[function].axis else PadAxis(axis)
        mapping[function] = replace(
            before,
            inverted=row.inverted.isChecked(),
            dead_band=row.dead_band.value() / 100,
            expo=row.expo.value() / 100,
        )
        self._keep(tuple(mapping))

    def _calibrate(self, begins: bool) -> None:
        reading = self.reading
        if reading is None:
            return
        self.calibrate.setText("Done" if begins else "Calibrate")
        if begins:
            self._calibration = [reading.raw]
            self.said.setText(CALIBRATION_TEXT)
            return
        readings = [*self._calibration, reading.raw]
        mapping, short = calibrated_mapping(self._pilot.mapping(reading.guid), readings)
        if short:
            names = "; ".join(short)
            self.said.setText(f"Nothing is changed. These did not go to both stops: {names}.")
        else:
            self._keep(mapping)
            self.said.setText("The stops are found, and saved for this kind of pad.")

    def _keep(self, mapping: PadMapping) -> None:
        reading = self.reading
        if reading is not None:
            self._pilot.map_pad(reading.guid, mapping)
            self._show_mapping(mapping)

    def _let_fly(self) -> None:
        reading = self.reading
        if reading is not None:
            self._pilot.hand_to(reading.number)
            self.said.setText(self._pilot.hand_over or PAD_DIALOG_HELP)

    def _lay_out(self) -> None:
        top = hbox((self.pads, 1), self.flies, self.fly)
        headings = [label(heading, "muted") for heading in PAD_DIALOG_HEADINGS]
        table = grid(headings, *(row.widgets for row in self.rows))
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        buttons.rejected.connect(self.reject)
        foot = hbox(self.calibrate, self.defaults, 1, buttons)
        vbox(top, table, self.moved, self.said, foot, of=self)

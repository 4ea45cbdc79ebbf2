"""The dialog of the game pads: mapping of the axes, calibration, and which pad flies."""

from PyQt6.QtCore import QRectF, QSignalBlocker, Qt, QTimer
from PyQt6.QtGui import QPainter
from PyQt6.QtWidgets import (
    QCheckBox,
    QDialog,
    QDialogButtonBox,
    QSpinBox,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.joystick.game_pad import PadReading
from workbench.gui.joystick.pad_mapping import AXES, FUNCTIONS, Ends, PadMapping, name_axis
from workbench.gui.joystick.pilot import Pilot
from workbench.gui.labels import Label
from workbench.gui.layout import button, choice, grid, hbox, label, named, vbox
from workbench.gui.theme import Look

PERIOD = 33
"""Period between readings [ms]."""
CALIBRATING = "Move each stick to all its stops, release them, then press Done."
HELP = (
    "No pad flies while this page is in front. Each row is one command of the sticks; the feel of "
    "the sticks applies afterwards."
)
GONE = "No game pad is plugged in."
HEADINGS = ("", "Moved by", "", "Dead band", "Expo", "Pad says", "Asked for")


class AxisBar(Instrument):
    """A value from -1 to 1 as a bar from the centre.

    Args:
        look: source of colours.
        name: name of the value.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, name: str, parent: QWidget | None = None) -> None:
        super().__init__(look, name, parent)
        self.value = 0.0
        self.setMinimumSize(90, 14)

    def show_value(self, value: float) -> None:
        """Show a value."""
        if value != self.value:
            self.value = value
            self.update()

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the bar, and a line at its centre."""
        middle, height = self.width() / 2, float(self.height())
        end = middle * (1.0 + max(-1.0, min(1.0, self.value)))
        painter.fillRect(self.area, self.colour("line"))
        bar = QRectF(min(middle, end), 0.0, abs(end - middle), height)
        painter.fillRect(bar, self.colour("accent"))
        painter.fillRect(QRectF(middle - 0.5, 0.0, 1.0, height), self.colour("ink"))


class AxisRow:
    """The widgets of one function: its axis, shaping, and result."""

    def __init__(self, function: str, look: Look, parent: QWidget) -> None:
        self.axis = choice(f"{function}: moved by", AXES)
        self.inverted = named(QCheckBox("inverted", parent), f"{function}: inverted")
        self.dead_band, self.expo = QSpinBox(parent), QSpinBox(parent)
        for box, most, what in ((self.dead_band, 50, "dead band"), (self.expo, 100, "expo")):
            box.setRange(0, most)
            box.setSuffix(" %")
            box.setAccessibleName(f"{function}: {what}, percent")
        self.raw = AxisBar(look, f"{function}: what the pad says", parent)
        self.shaped = AxisBar(look, f"{function}: the command", parent)
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
        look: source of colours.
        parent: the Qt parent.

    Attributes:
        pads: selects the shown pad.
        rows: one row for each of `FUNCTIONS`.
        calibrate: starts and ends the calibration.
        fly: lets the selected pad fly.
        said: instructions, or an error.
    """

    def __init__(self, pilot: Pilot, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Game pads")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._pilot = pilot
        self._ends: Ends | None = None
        self._shown: tuple[tuple[int, str], ...] = ()
        self.pads = choice("Game pad")
        self.fly = button("Let it fly", self._let_fly, "compact")
        self.flies = label(kind="value")
        self.rows = tuple(AxisRow(function, look, self) for function in FUNCTIONS)
        self.moved = label(kind="muted")
        self.said = label(HELP, wraps=True)
        self.calibrate = button("Calibrate")
        self.calibrate.setCheckable(True)
        self.defaults = button("Defaults", lambda: self._keep(PadMapping()), "quiet")
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
        self._timer.start(PERIOD)
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
            self.flies.setText(GONE)
            return
        if self._ends is not None:
            self._ends = self._ends.after(reading.raw)
        flies = reading.number == self._pilot.pads.flying
        self.flies.setText("It flies." if flies else "It waits.")
        self.fly.setVisible(not flies)
        self.moved.setText(f"Moves now: {name_axis(reading.raw)}")
        for row, axis in zip(self.rows, self._pilot.mapping(reading.guid).axes, strict=True):
            row.raw.show_value(reading.raw[axis.axis])
            row.shaped.show_value(axis.shaped(reading.raw))

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
        self._ends = None
        with QSignalBlocker(self.calibrate):
            self.calibrate.setChecked(False)
        self.calibrate.setText("Calibrate")
        self.said.setText(HELP)
        reading = self.reading
        for widget in (self.calibrate, self.defaults, self.fly):
            widget.setEnabled(reading is not None)
        for row in self.rows:
            for each in row.widgets:
                each.setEnabled(reading is not None)
        if reading is not None:
            self._show_mapping(self._pilot.mapping(reading.guid))

    def _show_mapping(self, mapping: PadMapping) -> None:
        for row, axis in zip(self.rows, mapping.axes, strict=True):
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
        row, before = self.rows[function], self._pilot.mapping(reading.guid)
        mapping = before.with_axis(
            function,
            axis=row.axis.currentIndex(),
            inverted=row.inverted.isChecked(),
            dead_band=row.dead_band.value() / 100,
            expo=row.expo.value() / 100,
        )
        if mapping.axes[function].axis != before.axes[function].axis:
            mapping = mapping.with_axis(function, low=-1.0, middle=0.0, high=1.0)
        self._keep(mapping)

    def _calibrate(self, begins: bool) -> None:
        reading = self.reading
        if reading is None:
            return
        self.calibrate.setText("Done" if begins else "Calibrate")
        if begins:
            self._ends = Ends(reading.raw, reading.raw)
            self.said.setText(CALIBRATING)
            return
        ends, self._ends = self._ends, None
        assert ends is not None
        mapping = self._pilot.mapping(reading.guid)
        short = ends.short(mapping, reading.raw)
        if short:
            names = "; ".join(short)
            self.said.setText(f"Nothing is changed. These did not go to both stops: {names}.")
        else:
            self._keep(ends.put_into(mapping, reading.raw))
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
            self.said.setText(self._pilot.hand_over or HELP)

    def _lay_out(self) -> None:
        top = hbox((self.pads, 1), self.flies, self.fly)
        headings = [label(heading, "muted") for heading in HEADINGS]
        table = grid(headings, *(row.widgets for row in self.rows))
        buttons = QDialogButtonBox(QDialogButtonBox.StandardButton.Close, self)
        buttons.rejected.connect(self.reject)
        foot = hbox(self.calibrate, self.defaults, 1, buttons)
        vbox(top, table, self.moved, self.said, foot, of=self)

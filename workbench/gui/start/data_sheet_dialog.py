"""The form that makes a drone from its data sheet."""

from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import TypeVar

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtGui import QCloseEvent
from PyQt6.QtWidgets import QDialog, QFormLayout, QLineEdit, QWidget

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_in_folder
from workbench.gui.errands import BackgroundTasks, FutureCallbacks
from workbench.gui.layout import buddy, button, choice, hbox, label, named, vbox
from workbench.gui.style import set_class
from workbench.plant.data_sheet import ROTOR_COUNTS_BY_LAYOUT, DataSheet, Propeller
from workbench.plant.quantity_input import (
    DIAGONAL_INPUT,
    DRONE_FILE_ENDING,
    MASS_INPUT,
    MAX_THRUST_INPUT,
    MOTOR_KV_INPUT,
    is_drone_name,
    parse_battery,
    parse_propeller,
)
from workbench.plant.sensor_blocks import sensor_blocks
from workbench.plant.sheet_figures import check_lift, sheet_figures
from workbench.plant.sheet_xacro import write_xacro

SENSOR_CHOICES = {"IMU and GPS": ["imu", "gps"], "none": [], "all kinds": ["all"]}
Number = TypeVar("Number")
SHEET_FIELDS = (
    ("name", "&Name", "my_quad", "Name of the drone and of its file"),
    ("mass", "&Mass, all-up", "1.4kg", "With the battery"),
    ("diagonal", "&Diagonal", "450mm", "From a rotor to the opposite one"),
    ("propeller", "&Propeller", "10x4.5", "Diameter x pitch in inches"),
    ("max_thrust", "Max. motor &thrust", "850g", "Of one motor with this propeller; or else KV"),
    ("motor_kv", "Motor &KV", "920KV", "Speed over voltage; needs the battery"),
    ("battery", "&Battery", "4S 5000mAh", "Cells or voltage, and capacity"),
)
"""Fields: name, label, example and explanation."""
NEEDED_FIELDS = ("name", "mass", "diagonal", "propeller")


def drone_file(folder: Path, name: str) -> Path:
    """Return the file of a new drone.

    Raises:
        WorkbenchError: if the name is invalid, or the file exists.
    """
    if not is_drone_name(name):
        raise WorkbenchError(f"'{name}' is no name of a file: use letters, digits, - and _.")
    path = folder / f"{name}{DRONE_FILE_ENDING}"
    if path.exists():
        raise WorkbenchError(f"{path} exists already: choose another name.")
    return path


def write_drone(path: Path, sheet: DataSheet) -> Path:
    """Write the description of a drone, and return its path.

    Raises:
        WorkbenchError: if it cannot fly, or the file cannot be written.
    """
    figures = sheet_figures(sheet)
    check_lift(sheet, figures)
    return write_in_folder(path, write_xacro(sheet, figures))


class DataSheetDialog(QDialog):
    """A line for each number of the data sheet; the flight keeps going meanwhile.

    Args:
        folder: folder for the description.
        parent: the Qt parent.

    Attributes:
        lines: the fields by name.
        fault: what is wrong, as a sentence.
    """

    written = pyqtSignal(object)
    """Path of the new description."""

    def __init__(self, folder: Path, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("New drone from a data sheet")
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self._folder = folder
        self._tasks = BackgroundTasks()
        self._answers = FutureCallbacks(self._show_fault, self)
        self.lines: dict[str, QLineEdit] = {}
        form = QFormLayout()
        form.setFieldGrowthPolicy(QFormLayout.FieldGrowthPolicy.ExpandingFieldsGrow)
        for name, text, example, help in SHEET_FIELDS:
            line = self.lines[name] = named(QLineEdit(), text.replace("&", ""), help)
            line.setPlaceholderText(f"as {example}")
            form.addRow(buddy(f"{text} ✱" if name in NEEDED_FIELDS else text, line, kind=""), line)
        self.rotors = choice("Number of rotors", map(str, ROTOR_COUNTS_BY_LAYOUT["x"]))
        self.layouts = choice("Layout of the rotors", ROTOR_COUNTS_BY_LAYOUT)
        self.sensors = choice("Sensors, with usual numbers", SENSOR_CHOICES)
        for text, box in (
            ("&Rotors", self.rotors),
            ("&Layout", self.layouts),
            ("&Sensors", self.sensors),
        ):
            form.addRow(buddy(text, box, kind=""), box)
        self.layouts.currentTextChanged.connect(self._show_counts)
        self.fault = label(kind="bad", wraps=True)
        self.fault.hide()
        said = f"Written to {folder}; what the sheet lacks is estimated."
        where = label(said, "muted", wraps=True)
        self.make = button("&Make and fly", self._write, "primary")
        self.make.setDefault(True)
        ends = hbox(1, button("&Cancel", self.close), self.make)
        vbox(form, where, self.fault, 1, ends, of=self, margins=(18, 14, 18, 12), spacing=8)
        self.resize(460, 0)

    def sheet(self) -> DataSheet:
        """Return the data sheet.

        Raises:
            WorkbenchError: if a number is missing or invalid; the field is marked.
        """
        thrust = self._read("max_thrust", MAX_THRUST_INPUT.read)
        kv = self._read("motor_kv", MOTOR_KV_INPUT.read)
        voltage, capacity = self._read("battery", parse_battery) or (None, None)
        if thrust is None and (kv is None or voltage is None):
            raise WorkbenchError(
                "How strong are the motors? Give the largest thrust, or KV and the battery."
            )
        diagonal = self._read("diagonal", DIAGONAL_INPUT.read)
        mass = self._read("mass", MASS_INPUT.read)
        propeller = self._read("propeller", parse_propeller)
        assert mass is not None and diagonal is not None and propeller is not None
        sheet = DataSheet(
            name=self.lines["name"].text().strip(),
            mass=mass,
            arm=diagonal / 2.0,
            propeller=Propeller(*propeller),
            rotors=int(self.rotors.currentText()),
            layout=self.layouts.currentText(),
            max_thrust=thrust,
            motor_kv=kv,
            voltage=voltage,
            capacity=capacity,
            sensors=sensor_blocks(SENSOR_CHOICES[self.sensors.currentText()]),
        )
        sheet.check()
        return sheet

    def closeEvent(self, event: QCloseEvent | None) -> None:
        """Wait for a file that is being written."""
        self._answers.close()
        self._tasks.close()
        super().closeEvent(event)

    def _read(self, name: str, read: Callable[[str], Number]) -> Number | None:
        """Return the number in a field, None if it is empty and may be."""
        line = self.lines[name]
        text = line.text().strip()
        try:
            if not text and name in NEEDED_FIELDS:
                raise WorkbenchError(f"{line.accessibleName()} is missing.")
            return read(text) if text else None
        except WorkbenchError:
            set_class(line, "bad")
            line.setFocus()
            raise

    def _show_counts(self, layout: str) -> None:
        """Offer the numbers of rotors of a layout."""
        self.rotors.clear()
        self.rotors.addItems([*map(str, ROTOR_COUNTS_BY_LAYOUT[layout])])

    def _write(self) -> None:
        for line in self.lines.values():
            set_class(line, "")
        try:
            path = drone_file(self._folder, self.lines["name"].text().strip())
            sheet = self.sheet()
        except WorkbenchError as error:
            self._show_fault(str(error))
            return
        self._answers.expect(self._tasks.run(partial(write_drone, path, sheet)), self._end)

    def _end(self, path: Path) -> None:
        self.written.emit(path)
        self.close()

    def _show_fault(self, said: str) -> None:
        self.fault.setText(said)
        self.fault.show()

"""The dialog that maps the columns of a table of an unknown kind to signals with units."""

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtWidgets import (
    QComboBox,
    QDialog,
    QDialogButtonBox,
    QHeaderView,
    QLineEdit,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from workbench.common.plain_text import plain_name
from workbench.gui.layout import buddy, choice, hbox, label, named, vbox
from workbench.logs.logged_signal import SIGNAL_NAME, component_names, standard_unit
from workbench.logs.readers.table_head import ColumnChoice, TableHead, own_signal
from workbench.plant.sensors import free_name

COLUMN_DIALOG_SIZE_PX = (760, 480)
TABLE_ROW_PX = 38
TIME_UNITS = ("s", "ms", "us", "ns")
NOT_READ = "not read"
_ANGLES, _QUATERNION = ("roll", "pitch", "yaw"), "wxyz"
OFFERED_SIGNALS = (
    *component_names("position_data."),
    *component_names("position_data.", _ANGLES),
    *component_names("velocity_data.v_"),
    *component_names("attitude.q_", _QUATERNION),
    *component_names("attitude.w_"),
    *component_names("estimate."),
    *component_names("estimate.", _ANGLES),
    *component_names("estimate.q_", _QUATERNION),
    *component_names("estimate.v_"),
    *component_names("estimate.w_"),
    *component_names("imu.linear_acceleration."),
    *component_names("imu.angular_velocity."),
    *component_names("motors.command_", "12345678"),
    *component_names("rotors.speed.", "01234567"),
    "battery.voltage",
    "battery.current",
    *component_names("setpoint."),
    *component_names("setpoint.v_"),
    "setpoint.yaw",
    *component_names("attitude_setpoint.", (*_ANGLES, "thrust")),
    *component_names("rate_setpoint.w_"),
    *component_names("torque_setpoint."),
)
"""Standard names of signals."""


class ColumnDialog(QDialog):
    """Asks which signals the columns of a table are, and in which units.

    Columns keep names of their own unless the user chooses a standard one.

    Args:
        head: of the table.
        said: why an earlier choice could not be read; "" for none.
        earlier: an earlier choice, by column.
        parent: the Qt parent.
    """

    given = pyqtSignal(str, str, object)
    """Column and unit of the time, and a `ColumnChoice` by column."""

    def __init__(
        self,
        head: TableHead,
        said: str = "",
        earlier: "dict[str, ColumnChoice] | None" = None,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self.setWindowTitle("Columns of a table")
        self.resize(*COLUMN_DIALOG_SIZE_PX)
        self._head = head
        self.time = choice("Column of the time", [plain_name(name) for name in head.columns])
        self.time.setCurrentIndex(head.time_column)
        self.time_unit = choice("Unit of the time", TIME_UNITS)
        stated = head.time_unit
        self.time_unit.setCurrentIndex(TIME_UNITS.index(stated) if stated in TIME_UNITS else 0)
        self.table = QTableWidget(len(head.columns), 4)
        named(self.table, "Columns, the signals that they become, and their units")
        self.signals: list[QComboBox] = []
        self.units: list[QLineEdit] = []
        self.said = label(said, "bad", wraps=True)
        self.buttons = QDialogButtonBox(
            QDialogButtonBox.StandardButton.Open | QDialogButtonBox.StandardButton.Cancel
        )
        self._fill(earlier or {})
        self._lay_out()
        self.time.currentIndexChanged.connect(self._check)
        for box in self.signals:
            box.currentTextChanged.connect(self._check)
        self.buttons.accepted.connect(self.accept)
        self.buttons.rejected.connect(self.reject)
        self.accepted.connect(self._give)
        self.finished.connect(self.deleteLater)
        self._check()
        self._show_fault(said)

    @property
    def choices(self) -> dict[str, ColumnChoice]:
        """What the columns become, by column, without the time and those that are not read."""
        time = self.time.currentIndex()
        return {
            name: ColumnChoice(box.currentText().strip(), unit.text().strip())
            for index, (name, box, unit) in enumerate(
                zip(self._head.columns, self.signals, self.units, strict=True)
            )
            if index != time and name and box.currentText().strip() not in ("", NOT_READ)
        }

    @property
    def fault(self) -> str:
        """What prevents the choice, as a sentence; "" if it is complete."""
        names = [each.signal for each in self.choices.values()]
        for name in names:
            if not SIGNAL_NAME.fullmatch(name):
                return (
                    f"“{plain_name(name)}” is no name of a signal: write TOPIC.FIELD in lower case."
                )
        twice = next((name for name in names if names.count(name) > 1), "")
        if twice:
            return f"Two columns become {twice}: give one of them another name."
        return "" if names else "Choose at least one signal."

    def _check(self) -> None:
        self._show_fault(self.fault)
        button = self.buttons.button(QDialogButtonBox.StandardButton.Open)
        if button is not None:
            button.setEnabled(not self.fault)
        for index, box in enumerate(self.signals):
            for widget in (box, self.units[index]):
                widget.setEnabled(index != self.time.currentIndex())

    def _show_fault(self, said: str) -> None:
        self.said.setText(said)
        self.said.setVisible(bool(said))

    def _give(self) -> None:
        time = self._head.columns[self.time.currentIndex()]
        self.given.emit(time, self.time_unit.currentText(), self.choices)

    def _fill(self, earlier: "dict[str, ColumnChoice]") -> None:
        self.table.setHorizontalHeaderLabels(["Column", "First value", "Signal", "Unit"])
        taken: list[str] = []
        for row, column in enumerate(self._head.columns):
            first = self._head.rows[0][row] if self._head.rows else ""
            for place, text in enumerate((column, first)):
                item = QTableWidgetItem(plain_name(text))
                item.setFlags(Qt.ItemFlag.ItemIsEnabled)
                self.table.setItem(row, place, item)
            before = earlier.get(column)
            name = before.signal if before else free_name(taken, own_signal(column))
            taken.append(name)
            box = choice(f"Signal of {plain_name(column)}", (NOT_READ, *OFFERED_SIGNALS))
            box.setEditable(True)
            box.setCurrentText(name)
            unit = named(QLineEdit(), f"Unit of {plain_name(column)}")
            unit.setText(before.unit if before else self._head.unit_of(row))
            unit.setPlaceholderText(standard_unit(name))
            box.currentTextChanged.connect(
                lambda text, unit=unit: unit.setPlaceholderText(standard_unit(text))
            )
            self.table.setCellWidget(row, 2, box)
            self.table.setCellWidget(row, 3, unit)
            self.signals.append(box)
            self.units.append(unit)

    def _lay_out(self) -> None:
        head = self.table.horizontalHeader()
        if head is not None:
            head.setSectionResizeMode(QHeaderView.ResizeMode.Stretch)
        side = self.table.verticalHeader()
        if side is not None:
            side.hide()
            side.setDefaultSectionSize(TABLE_ROW_PX)
        intro = label(
            f"{plain_name(self._head.path.name)} is a table of an unknown kind. Choose the column "
            "of the time, and what the other columns are; an empty unit is that of the signal. The "
            f"choice is kept in {plain_name(self._head.mapping.name)} beside it.",
            wraps=True,
        )
        time = hbox(buddy("&Time", self.time, kind=""), self.time, self.time_unit, 1)
        vbox(intro, time, (self.table, 1), self.said, self.buttons, of=self)

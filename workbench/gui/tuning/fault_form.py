"""Fields for a fault of a rotor or a sensor, and its repair."""

from collections.abc import Mapping

from PyQt6.QtCore import QSignalBlocker, pyqtSignal
from PyQt6.QtWidgets import QComboBox, QGridLayout, QPushButton, QStackedWidget, QWidget

from workbench.gui.number_field import NumberField, buddy
from workbench.gui.style import dressed
from workbench.gui.tuning.card import SPACING
from workbench.gui.units import Unit
from workbench.gui.workspace import Workspace
from workbench.scenario.faults import PARTS, SENSOR_MODES, Part

SHARE = 0.8
"""Of its thrust that a rotor gives, at first."""


class FaultForm(QWidget):
    """Lets a part of the drone fail, and repairs it.

    Args:
        workspace: whose flight it is.

    Attributes:
        faults: values of the parameters of parts that have failed.
        buttons: repair, and let fail; who shows the form places them.
    """

    changed = pyqtSignal()
    """Something else has failed, or was repaired."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight = workspace.flight
        self._parts: tuple[Part, ...] = ()
        self.faults: dict[str, float] = {}
        self.part = QComboBox()
        self.part.setAccessibleName("Part that fails")
        self.mode = QComboBox()
        self.mode.setAccessibleName("How it fails")
        self.mode.addItems([mode.name for mode in SENSOR_MODES])
        self.share = NumberField("Thrust that the rotor still gives", 0, 5.0)
        self.share.set_range(Unit("%", 100.0), 0.0, 1.0)
        self.share.show_si(SHARE)
        self.how = QStackedWidget()
        self.how.addWidget(self.mode)
        self.how.addWidget(self.share)
        self.button = dressed(QPushButton("Fail now"), "danger")
        self.repair = QPushButton("Repair")
        self.repair.setToolTip("Let this part work as before")
        self.buttons = (self.repair, self.button)
        self._lay_out()
        self.part.currentIndexChanged.connect(self._show)
        self.button.clicked.connect(self.fail)
        self.repair.clicked.connect(self._repair)

    def begin(self, values: Mapping[str, float]) -> None:
        """Take the parts of another flight.

        Args:
            values: of its parameters at its start, by name.
        """
        parts = tuple(part for part in PARTS if part.parameter in values)
        self.faults = {
            part.parameter: values[part.parameter]
            for part in parts
            if values[part.parameter] != part.whole
        }
        if parts != self._parts:
            self._parts = parts
            with QSignalBlocker(self.part):
                self.part.clear()
                self.part.addItems([part.name for part in parts])
        self._show()

    def fail(self) -> None:
        """Let the chosen part fail now."""
        part = self._part
        if part is None:
            return
        value = SENSOR_MODES[self.mode.currentIndex()].value if part.modes else self.share.si
        self._set(part, value)

    @property
    def said(self) -> str:
        """What has failed, in words; "" if nothing has."""
        parts = (part for part in self._parts if part.parameter in self.faults)
        return ", ".join(part.fault(self.faults[part.parameter]) for part in parts)

    @property
    def _part(self) -> Part | None:
        place = self.part.currentIndex()
        return self._parts[place] if 0 <= place < len(self._parts) else None

    def _repair(self) -> None:
        part = self._part
        if part is not None:
            self._set(part, part.whole)

    def _set(self, part: Part, value: float) -> None:
        def done(_: object) -> None:
            self.faults.pop(part.parameter, None)
            if value != part.whole:
                self.faults[part.parameter] = value
            self._show()

        self._flight.order(lambda live: live.set_all({part.parameter: value}), done)

    def _show(self) -> None:
        part = self._part
        self.how.setCurrentWidget(self.mode if part is not None and part.modes else self.share)
        self.button.setEnabled(part is not None)
        self.repair.setEnabled(part is not None and part.parameter in self.faults)
        self.changed.emit()

    def _lay_out(self) -> None:
        grid = QGridLayout(self)
        grid.setContentsMargins(0, 0, 0, 0)
        grid.setHorizontalSpacing(SPACING)
        grid.setVerticalSpacing(4)
        grid.addWidget(buddy("&Part", self.part), 0, 0)
        grid.addWidget(self.part, 1, 0)
        grid.addWidget(buddy("&Fault", self.how), 0, 1)
        grid.addWidget(self.how, 1, 1)
        for column in range(2):
            grid.setColumnStretch(column, 1)

"""The form that makes a part of the drone fail, and repairs it."""

from collections.abc import Mapping

from PyQt6.QtCore import QSignalBlocker, pyqtSignal
from PyQt6.QtWidgets import QStackedWidget, QWidget

from workbench.common.quantity import DisplayUnit
from workbench.gui.layout import NO_MARGINS, buddy, button, choice, grid
from workbench.gui.number_field import NumberField
from workbench.gui.tuning.card import CARD_SPACING_PX
from workbench.gui.tuning.wind_form import FIELD_LABEL_GAP_PX
from workbench.gui.workspace import Workspace
from workbench.scenario.faults import SENSOR_MODES, FailingPart, failing_parts
from workbench.scenario.scenario import Action

SENSOR_FAULT_LABEL, ROTOR_FAULT_LABEL = "Fa&ult", "Thr&ust left"
INITIAL_THRUST_SHARE = 0.8
"""Initial share of a failed rotor's thrust that remains."""


class FaultForm(QWidget):
    """Makes a part of the drone fail, and repairs it.

    Args:
        workspace: has the flight.

    Attributes:
        faults: parameter values of the failed parts.
        buttons: repair, and make fail; the form's user places them.
    """

    changed = pyqtSignal()
    """A part failed or was repaired."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._flight = workspace.flight
        self._parts: tuple[FailingPart, ...] = ()
        self.faults: dict[str, float] = {}
        self.part = choice("Part that fails")
        self.mode = choice("How it fails", SENSOR_MODES)
        self.share = NumberField("Thrust left", 0, 5.0)
        self.share.set_range(DisplayUnit("%", 100.0), 0.0, 1.0)
        self.share.show_si(INITIAL_THRUST_SHARE)
        self.how = QStackedWidget()
        self.how.addWidget(self.mode)
        self.how.addWidget(self.share)
        self.button = button("Fail now", self.fail, "danger")
        self.repair = button("Repair", self._repair, help="Repair this part")
        self.buttons = (self.repair, self.button)
        self._how_label = buddy(SENSOR_FAULT_LABEL, self.how)
        grid(
            (buddy("&Part", self.part), self._how_label),
            (self.part, self.how),
            of=self,
            margins=NO_MARGINS,
            spacing=(CARD_SPACING_PX, FIELD_LABEL_GAP_PX),
            stretches=(1, 1),
        )
        self.part.currentIndexChanged.connect(self._show)

    def begin(self, values: Mapping[str, float]) -> None:
        """Show the parts of another flight.

        Args:
            values: its initial parameter values, by name.
        """
        parts = tuple(part for part in failing_parts() if part.parameter in values)
        self.faults.clear()
        if parts != self._parts:
            self._parts = parts
            with QSignalBlocker(self.part):
                self.part.clear()
                self.part.addItems([part.name for part in parts])
        self.follow(values)

    def follow(self, values: Mapping[str, float]) -> None:
        """Show what has failed or was repaired, whoever ordered it.

        Args:
            values: new parameter values in the flight, by name.
        """
        for part in self._parts:
            value = values.get(part.parameter, self.faults.get(part.parameter, part.whole))
            self.faults[part.parameter] = value
            if value == part.whole:
                del self.faults[part.parameter]
        self._show()

    def fail(self) -> None:
        """Make the selected part fail now."""
        part = self._part
        if part is None:
            return
        value = SENSOR_MODES[self.mode.currentText()] if part.modes else self.share.si
        self._set(part, value)

    @property
    def said(self) -> str:
        """The failed parts, in words; "" without any."""
        parts = (part for part in self._parts if part.parameter in self.faults)
        return ", ".join(part.fault(self.faults[part.parameter]) for part in parts)

    @property
    def _part(self) -> FailingPart | None:
        place = self.part.currentIndex()
        return self._parts[place] if 0 <= place < len(self._parts) else None

    def _repair(self) -> None:
        part = self._part
        if part is not None:
            self._set(part, part.whole)

    def _set(self, part: FailingPart, value: float) -> None:
        self._flight.do(Action(set={part.parameter: value}))  # shown once the flight publishes it

    def _show(self) -> None:
        part = self._part
        of_sensor = part is not None and part.modes
        self.how.setCurrentWidget(self.mode if of_sensor else self.share)
        self._how_label.setText(SENSOR_FAULT_LABEL if of_sensor else ROTOR_FAULT_LABEL)
        self.button.setEnabled(part is not None)
        self.repair.setEnabled(part is not None and part.parameter in self.faults)
        self.changed.emit()

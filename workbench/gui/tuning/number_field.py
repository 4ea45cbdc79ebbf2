"""A number in SI that is shown in a unit, with its label."""

from PyQt6.QtCore import Qt, pyqtSignal
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtWidgets import QDoubleSpinBox, QLabel, QWidget

from workbench.gui.style import dressed
from workbench.gui.units import Unit


class NumberField(QDoubleSpinBox):
    """A spin box that knows SI.

    Args:
        label: what the number is, for its accessible name.
        decimals: as shown.
        step: of an arrow, as shown.
    """

    edited = pyqtSignal(float)
    """The new value in SI; the user has changed it."""

    def __init__(self, label: str, decimals: int, step: float) -> None:
        super().__init__()
        self._label = label
        self._unit = Unit("")
        self.setDecimals(decimals)
        self.setSingleStep(step)
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.valueChanged.connect(lambda _: self.edited.emit(self.si))

    @property
    def si(self) -> float:
        """The value in SI."""
        return self._unit.read(self.value())

    def set_range(self, unit: Unit, minimum: float, maximum: float) -> None:
        """Show the value in a unit, within limits in SI; tells nobody."""
        kept = self.si
        self._unit = unit
        low, high = unit.shown(minimum), unit.shown(maximum)
        self.blockSignals(True)
        self.setRange(low, high)
        glue = "" if unit.symbol in ("", "°", "%") else " "
        self.setSuffix(f"{glue}{unit.symbol}")
        self.setValue(unit.shown(kept))
        self.blockSignals(False)
        name = f"{self._label}, {low:.4g} to {high:.4g} {unit.symbol}".rstrip()
        if name != self.accessibleName():
            self.setAccessibleName(name)
            self.setToolTip(name)

    def show_si(self, value: float) -> None:
        """Show a value, and tell nobody."""
        self.blockSignals(True)
        self.setValue(self._unit.shown(value))
        self.blockSignals(False)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Change nothing unless the field has been chosen."""
        if event is not None and not self.hasFocus():
            event.ignore()
        else:
            super().wheelEvent(event)


def buddy(text: str, widget: QWidget, help: str = "") -> QLabel:
    """Return a label with a mnemonic that leads to a widget; name the widget where it has none."""
    label = dressed(QLabel(text), "muted")
    label.setBuddy(widget)
    if not widget.accessibleName():
        widget.setAccessibleName(text.replace("&", ""))
    if help:
        widget.setToolTip(help)
        widget.setAccessibleDescription(help)
    return label

"""Controls of settings: a number with its unit, a switch, a choice, a folder."""

import math
from collections.abc import Callable, Sequence
from functools import partial

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QDoubleSpinBox,
    QFileDialog,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from workbench.gui.units import Unit

MOST_DECIMALS = 6


class NumberBox(QDoubleSpinBox):
    """A number in SI, shown in another unit.

    Args:
        unit: how it is shown.
        minimum: in SI.
        maximum: in SI.
        label: for the accessible name.
        changed: hears the new value in SI, once it is typed or stepped.
    """

    def __init__(
        self,
        unit: Unit,
        minimum: float,
        maximum: float,
        label: str,
        changed: Callable[[float], None],
    ) -> None:
        super().__init__()
        self._unit = unit
        low, high = unit.shown(minimum), unit.shown(maximum)
        self.setDecimals(decimals_of(high - low))
        self.setRange(low, high)
        self.setSingleStep(10.0 ** (math.floor(math.log10(high - low)) - 2))
        self.setSuffix(f" {unit.symbol}" if unit.symbol else "")
        self.setKeyboardTracking(False)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setAccessibleName(f"{label}, {low:g} to {high:g} {unit.symbol}".rstrip())
        self.valueChanged.connect(lambda shown: changed(unit.read(shown)))

    def show_value(self, value: float) -> None:
        """Show a value in SI, and tell nobody."""
        self.blockSignals(True)
        self.setValue(self._unit.shown(value))
        self.blockSignals(False)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Change nothing while the page is scrolled over it."""
        if event is not None and not self.hasFocus():
            event.ignore()
        else:
            super().wheelEvent(event)


class Choices(QComboBox):
    """One of several texts."""

    def __init__(self, texts: Sequence[str], changed: Callable[[str], None]) -> None:
        super().__init__()
        self.addItems(list(texts))
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.textActivated.connect(changed)

    def show_value(self, text: str) -> None:
        """Show a text; one that is not among the choices, a file's path, is added."""
        if self.findText(text) < 0:
            self.addItem(text)
        self.setCurrentText(text)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Change nothing while the page is scrolled over it."""
        if event is not None and not self.hasFocus():
            event.ignore()
        else:
            super().wheelEvent(event)


class Switch(QCheckBox):
    """On or off, in words besides the tick."""

    def __init__(self, changed: Callable[[bool], None]) -> None:
        super().__init__("off")
        self.toggled.connect(self._say)
        self.toggled.connect(changed)

    def show_value(self, on: bool) -> None:
        """Show whether it is on, and tell nobody."""
        self.blockSignals(True)
        self.setChecked(on)
        self.blockSignals(False)
        self._say(on)

    def _say(self, on: bool) -> None:
        self.setText("on" if on else "off")


class Folder(QWidget):
    """The path of a folder, typed or chosen."""

    def __init__(self, label: str, empty: str, changed: Callable[[str], None]) -> None:
        super().__init__()
        self._changed = changed
        self.line = QLineEdit(self)
        self.line.setPlaceholderText(empty)
        self.line.setAccessibleName(label)
        self.line.editingFinished.connect(lambda: changed(self.line.text().strip()))
        button = QPushButton("Choose…", self)
        button.setAccessibleName(f"Choose the {label.lower()}")
        button.clicked.connect(self._choose)
        layout = QHBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.addWidget(self.line, 1)
        layout.addWidget(button)
        self.setFocusProxy(self.line)

    def show_value(self, path: str) -> None:
        """Show a path."""
        if self.line.text() != path:
            self.line.setText(path)

    def _choose(self) -> None:
        dialog = QFileDialog(self, "Choose a folder", self.line.text())
        dialog.setFileMode(QFileDialog.FileMode.Directory)
        dialog.setOption(QFileDialog.Option.ShowDirsOnly)
        dialog.fileSelected.connect(partial(self._take))
        dialog.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        dialog.open()

    def _take(self, path: str) -> None:
        self.show_value(path)
        self._changed(path)


def decimals_of(span: float) -> int:
    """Return how many decimals show a thousandth of a range."""
    return min(MOST_DECIMALS, max(1, 2 - math.floor(math.log10(span))))

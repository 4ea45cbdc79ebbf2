"""Controls of settings: a number with its unit, a switch, a choice, a folder."""

import math
from collections.abc import Callable, Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QWheelEvent
from PyQt6.QtWidgets import (
    QCheckBox,
    QComboBox,
    QFileDialog,
    QHBoxLayout,
    QLineEdit,
    QPushButton,
    QWidget,
)

from workbench.gui.file_dialogs import show_file_dialog
from workbench.gui.number_field import NumberField
from workbench.gui.preferences import Preferences
from workbench.gui.units import unit_for

MOST_DECIMALS = 6


class NumberBox(NumberField):
    """A number in SI, shown in the unit that the user prefers now.

    Args:
        preferences: say which unit that is.
        si: the number's own unit, as the tables have it.
        minimum: in SI.
        maximum: in SI.
        label: for the accessible name.
        changed: hears the new value in SI, once it is typed or stepped.
    """

    def __init__(
        self,
        preferences: Preferences,
        si: str,
        minimum: float,
        maximum: float,
        label: str,
        changed: Callable[[float], None],
    ) -> None:
        super().__init__(label)
        self._preferences, self._si_unit = preferences, si
        self._ends = minimum, maximum
        self._show_unit()
        self.edited.connect(changed)
        preferences.changed.connect(lambda _: self._show_unit())

    def show_value(self, value: float) -> None:
        """Show a value in SI, and tell nobody."""
        self.show_si(value)

    def _show_unit(self) -> None:
        """Show value and range in the unit that is preferred now, and tell nobody."""
        unit = unit_for(self._si_unit, self._preferences)
        low, high = map(unit.shown, self._ends)
        self.show_decimals(decimals_of(high - low))
        self.setSingleStep(10.0 ** (math.floor(math.log10(high - low)) - 2))
        self.set_range(unit, *self._ends)


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
        show_file_dialog(dialog, self._take)

    def _take(self, path: str) -> None:
        self.show_value(path)
        self._changed(path)


def decimals_of(span: float) -> int:
    """Return how many decimals show a thousandth of a range."""
    return min(MOST_DECIMALS, max(1, 2 - math.floor(math.log10(span))))

"""The fields of settings: number, choice, switch and folder."""

import math
from collections.abc import Callable, Sequence

from PyQt6.QtCore import QSignalBlocker, Qt
from PyQt6.QtWidgets import QCheckBox, QLineEdit, QWidget

from workbench.common.plain_text import plain_text
from workbench.common.quantity import Quantity
from workbench.gui.file_dialogs import choose_folder
from workbench.gui.layout import NO_MARGINS, button, hbox, named
from workbench.gui.number_field import NumberField
from workbench.gui.preferences import Preferences
from workbench.gui.units import quantity_unit
from workbench.gui.wheel import ComboBox


class NumberBox(NumberField):
    """A quantity in SI, shown in the user's preferred unit.

    Args:
        preferences: source of the unit.
        quantity: its limits are finite.
        changed: called with the new value in SI, once it is typed or stepped.
        label: accessible name.
    """

    def __init__(
        self,
        preferences: Preferences,
        quantity: Quantity,
        changed: Callable[[float], None],
        label: str,
    ) -> None:
        super().__init__(label)
        self._preferences, self._quantity = preferences, quantity
        self._show_unit()
        self.edited.connect(changed)
        preferences.changed.connect(lambda _: self._show_unit())

    def show_value(self, value: float) -> None:
        """Show a value in SI, without a signal."""
        self.show_si(value)

    def _show_unit(self) -> None:
        """Show value and range in the preferred unit, without a signal."""
        ends = self._quantity.minimum, self._quantity.maximum
        unit = quantity_unit(self._quantity, self._preferences)
        low, high = map(unit.shown, ends)
        self.show_decimals(unit.decimals)
        self.setSingleStep(10.0 ** (math.floor(math.log10(high - low)) - 2))
        self.set_range(unit, *ends)


class ChoiceBox(ComboBox):
    """A choice of several texts."""

    def __init__(self, texts: Sequence[str], changed: Callable[[str], None]) -> None:
        super().__init__()
        for text in texts:
            self.addItem(plain_text(text), text)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.activated.connect(lambda index: changed(str(self.itemData(index))))

    def show_value(self, text: str) -> None:
        """Show a text; if it is not among the choices, as a file's path, it is added."""
        if self.findData(text) < 0:
            self.addItem(plain_text(text), text)
        self.setCurrentIndex(self.findData(text))


class Switch(QCheckBox):
    """A switch, with its state as text beside the tick."""

    def __init__(self, changed: Callable[[bool], None]) -> None:
        super().__init__("off")
        self.toggled.connect(self._say)
        self.toggled.connect(changed)

    def show_value(self, on: bool) -> None:
        """Show whether it is on, without a signal."""
        with QSignalBlocker(self):
            self.setChecked(on)
        self._say(on)

    def _say(self, on: bool) -> None:
        self.setText("on" if on else "off")


class FolderField(QWidget):
    """A folder's path, typed or selected."""

    def __init__(self, label: str, empty: str, changed: Callable[[str], None]) -> None:
        super().__init__()
        self._changed = changed
        self.line = QLineEdit(self)
        self.line.setPlaceholderText(empty)
        self.line.setAccessibleName(label)
        self.line.editingFinished.connect(lambda: changed(self.line.text().strip()))
        browse = named(button("Choose…", self._choose), f"Choose the {label.lower()}")
        hbox((self.line, 1), browse, of=self, margins=NO_MARGINS)
        self.setFocusProxy(self.line)

    def show_value(self, path: str) -> None:
        """Show a path."""
        if self.line.text() != path:
            self.line.setText(path)

    def _choose(self) -> None:
        choose_folder(self, "Choose a folder", self._take, self.line.text())

    def _take(self, path: str) -> None:
        self.show_value(path)
        self._changed(path)

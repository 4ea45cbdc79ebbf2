"""The row of one setting: its name, field and explanation, and a reset."""

import math
from pathlib import Path
from typing import Any

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.common.errors import WorkbenchError
from workbench.gui.labels import Label
from workbench.gui.layout import buddy, button, hbox, label, named, vbox
from workbench.gui.preferences import Preference, PreferenceValue
from workbench.gui.settings.setting_field import ChoiceBox, FolderField, NumberBox, Switch
from workbench.gui.workspace import Workspace


class SettingRow(QWidget):
    """One setting.

    Args:
        text: text, and accessible name of the control.
        help: what it does, as a sentence.
        control: the control.

    Attributes:
        reset: restores the default.
    """

    def __init__(self, text: str, help: str, control: QWidget) -> None:
        super().__init__()
        self._words = f"{text} {help}".lower()
        self._mark = Label()
        self.reset = named(button("Default"), f"{text}: restore the default")
        control.setMinimumWidth(190)
        said = label(help, "muted", wraps=True)
        words = vbox(buddy(text, control, help, kind=""), said, spacing=1)
        hbox(
            (words, 1),
            (self._mark, Qt.AlignmentFlag.AlignVCenter),
            (control, Qt.AlignmentFlag.AlignVCenter),
            (self.reset, Qt.AlignmentFlag.AlignVCenter),
            of=self,
            margins=(0, 4, 0, 4),
            spacing=12,
        )
        self._mark.setFixedWidth(self.fontMetrics().horizontalAdvance("changed  "))
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Preferred)

    def mark(self, changed: bool) -> None:
        """Show whether it differs from the default."""
        self._mark.setText("changed" if changed else "")
        self.reset.setEnabled(changed)

    def matches(self, wanted: str) -> bool:
        """Return whether it contains all words of a search."""
        return all(word in self._words for word in wanted.lower().split())


class PreferenceRow(SettingRow):
    """One preference, with its present value.

    Args:
        workspace: has the preferences.
        preference: the preference's row of the table.
    """

    def __init__(self, workspace: Workspace, preference: Preference) -> None:
        self.preference = preference
        self._preferences, self._notices = workspace.preferences, workspace.notices
        self._control = self._make(workspace)
        super().__init__(preference.label, preference.help, self._control)
        self.reset.clicked.connect(lambda: self._preferences.reset(preference.name))
        self._preferences.changed.connect(self._hear)
        self.show_present()

    def show_present(self) -> None:
        """Show the present value."""
        value: Any = self._preferences.value(self.preference.name)
        self._control.show_value(value)
        self.mark(value != self.preference.default)

    def _hear(self, name: str) -> None:
        if name == self.preference.name:
            self.show_present()

    def _make(self, workspace: Workspace) -> Switch | NumberBox | ChoiceBox | FolderField:
        row, change = self.preference, self._set
        if isinstance(row.default, bool):
            return Switch(change)
        if isinstance(row.default, float):
            assert math.isfinite(row.maximum - row.minimum)
            return NumberBox(workspace.preferences, row, change, row.label)
        if row.choices:
            return ChoiceBox(row.choices, change)
        return FolderField(row.label, str(Path.cwd()), change)

    def _set(self, value: PreferenceValue) -> None:
        if self.preference.folder and value and not Path(str(value)).is_dir():
            self._notices.warn(f"There is no folder {value}.", "Choose an existing one.")
            self.show_present()
            return
        try:
            self._preferences.set(self.preference.name, value)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            self.show_present()

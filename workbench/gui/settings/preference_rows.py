"""A row of the Settings screen for each row of the table of preferences."""

import math
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.gui.preference_table import Preference, PreferenceValue
from workbench.gui.settings.controls import Choices, Folder, NumberBox, Switch
from workbench.gui.settings.row import Row
from workbench.gui.workspace import Workspace


class PreferenceRow(Row):
    """One preference, and what it is now.

    Args:
        workspace: where it is kept.
        preference: its row of the table.
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
        """Show what is preferred now."""
        name, default = self.preference.name, self.preference.default
        value: PreferenceValue
        if isinstance(self._control, Switch):
            value = self._preferences.switch(name)
            self._control.show_value(value)
        elif isinstance(self._control, NumberBox):
            value = self._preferences.number(name)
            self._control.show_value(value)
        else:
            value = self._preferences.text(name)
            self._control.show_value(value)
        self.mark(value != default)

    def _hear(self, name: str) -> None:
        if name == self.preference.name:
            self.show_present()

    def _make(self, workspace: Workspace) -> Switch | NumberBox | Choices | Folder:
        row, change = self.preference, self._set
        if isinstance(row.default, bool):
            return Switch(change)
        if isinstance(row.default, float):
            assert math.isfinite(row.maximum - row.minimum)
            preferences = workspace.preferences
            return NumberBox(preferences, row.unit, row.minimum, row.maximum, row.label, change)
        if row.choices:
            return Choices(row.choices, change)
        return Folder(row.label, str(Path.cwd()), change)

    def _set(self, value: PreferenceValue) -> None:
        if self.preference.folder and value and not Path(str(value)).is_dir():
            self._notices.warn(f"There is no folder {value}.", "Choose one that is there.")
            self.show_present()
            return
        try:
            self._preferences.set(self.preference.name, value)
        except WorkbenchError as error:
            self._notices.warn(str(error))
            self.show_present()

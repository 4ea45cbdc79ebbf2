"""What the user prefers, kept between starts."""

from pathlib import Path

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.gui.preference_table import Preference, PreferenceValue, find_preference

GROUP = "preferences"


class Preferences(QObject):
    """Values of the table of preferences.

    Args:
        store: where they are kept.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal(str)
    """Name of a preference that has another value now."""

    def __init__(self, store: QSettings | None = None, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self.store = store or QSettings()
        self._values: dict[str, PreferenceValue] = {}

    def number(self, name: str) -> float:
        """Return a preference that is a number, in SI units."""
        value = self._get(find_preference(name))
        assert isinstance(value, int | float)
        return float(value)

    def text(self, name: str) -> str:
        """Return a preference that is a text or a choice."""
        return str(self._get(find_preference(name)))

    def switch(self, name: str) -> bool:
        """Return whether a preference is on."""
        return bool(self._get(find_preference(name)))

    def set(self, name: str, value: PreferenceValue) -> None:
        """Give a preference a value.

        Raises:
            WorkbenchError: if it may not have that one.
        """
        row = find_preference(name)
        value = row.check(value)
        if value != self._get(row):
            self.store.setValue(f"{GROUP}/{name}", value)
            self._values[name] = value
            self.changed.emit(name)

    def reset(self, name: str) -> None:
        """Give a preference its default."""
        self.set(name, find_preference(name).default)

    def _get(self, row: Preference) -> PreferenceValue:
        """Return what is kept; the store is asked once, as that takes a while."""
        if row.name not in self._values:
            self._values[row.name] = self._read(row)
        return self._values[row.name]

    def _read(self, row: Preference) -> PreferenceValue:
        """Return what the store has, or the default where that is nothing sensible."""
        kept = self.store.value(f"{GROUP}/{row.name}", row.default)
        try:
            return row.read(kept)
        except WorkbenchError:  # another version wrote it, or an editor
            return row.default


def log_folder(preferences: Preferences) -> Path:
    """Return the folder that the user prefers, or where the app was started."""
    chosen = preferences.text("log_folder")
    return Path(chosen).expanduser() if chosen else Path.cwd()

"""The limits that the user has set, kept between starts."""

import math

from PyQt6.QtCore import QObject, QSettings, pyqtSignal

from workbench.common.errors import WorkbenchError
from workbench.gui.tuning.limit_table import find_limit

GROUP = "tuning/limits"


class Limits(QObject):
    """Values of the table of limits, as shown.

    Args:
        store: where they are kept.
        parent: the Qt parent; this object is deleted with it.
    """

    changed = pyqtSignal(str)
    """Name of a limit that has another value now."""

    def __init__(self, store: QSettings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._store = store

    def value(self, name: str) -> float:
        """Return a limit as shown; its default where nothing sensible is kept."""
        row = find_limit(name)
        try:
            kept = float(str(self._store.value(f"{GROUP}/{name}", row.default)))
        except ValueError:  # another version wrote it, or an editor
            return row.default
        return kept if row.minimum <= kept <= row.maximum else row.default

    def set(self, name: str, value: float) -> None:
        """Give a limit a value, as shown.

        Raises:
            WorkbenchError: if it may not have that one.
        """
        row = find_limit(name)
        if not (math.isfinite(value) and row.minimum <= value <= row.maximum):
            raise WorkbenchError(
                f"{row.label} is {value:g} {row.unit}: keep it within "
                f"{row.minimum:g} .. {row.maximum:g}"
            )
        if value != self.value(name):
            self._store.setValue(f"{GROUP}/{name}", value)
            self.changed.emit(name)

"""The keys of all actions: the defaults of the table, or those that the user has chosen."""

import re

from PyQt6.QtCore import QObject, QSettings, pyqtSignal
from PyQt6.QtGui import QKeySequence

from workbench.common.errors import WorkbenchError
from workbench.gui.key_table import CHART_KEYS, KEY_ROWS, STICK_KEYS, TIME_KEYS

KEYS_SETTINGS_GROUP = "keys"
NAVIGATION_KEYS = ("Tab", "Backtab", "Shift+Tab", "Return", "Enter", "Esc")
"""Keys that move the focus, confirm or cancel everywhere."""
MOVEMENT_KEYS = ("Left", "Right", "Up", "Down", "Home", "End", "PgUp", "PgDown", "Del", "Backspace")
"""Keys that move and delete within lists, fields and charts."""
EDITING_KEYS = ("Ctrl+A", "Ctrl+C", "Ctrl+V", "Ctrl+X", "Ctrl+Y", "Ctrl+Z", "Ctrl+Shift+Z")
"""Keys that edit text in every field; those of undo and redo are shared with the gains."""
PRESS_KEY = "Space"
"""Key that presses a button which Tab has chosen."""
_UNDO_ROWS = ("undo", "redo")
_STOP_ROW, _PLAY_ROW = "stop", "play"
_PLAIN_KEY_NAMES = frozenset(row.name for row in (*TIME_KEYS, *CHART_KEYS, *STICK_KEYS))
"""Names of the rows whose key is pressed without another one."""
_STICK_NAMES = frozenset(row.name for row in STICK_KEYS)
_CHART_NAMES = frozenset(row.name for row in CHART_KEYS)


def sequence_of(key: str) -> QKeySequence:
    """Return a key, as Qt writes it in files, for Qt."""
    return QKeySequence(key, QKeySequence.SequenceFormat.PortableText)


def key_name(key: str) -> str:
    """Return a key as Qt writes it in files, "" for what is none."""
    return sequence_of(key).toString(QKeySequence.SequenceFormat.PortableText)


class KeyMap(QObject):
    """The present key of each row of the table.

    Args:
        store: storage of the changed keys.
        parent: the Qt parent.
    """

    changed = pyqtSignal(str)
    """Name of a row whose key has changed."""

    def __init__(self, store: QSettings, parent: QObject | None = None) -> None:
        super().__init__(parent)
        self._store = store
        self._rows = {row.name: row for row in KEY_ROWS}
        self._keys = {row.name: key_name(row.shortcut) for row in KEY_ROWS}
        kept = {name: store.value(f"{KEYS_SETTINGS_GROUP}/{name}") for name in self._rows}
        defaults = dict(self._keys)
        self._keys |= {name: key_name(str(key)) for name, key in kept.items() if key is not None}
        if any(self.fault(name, key) for name, key in self._keys.items()):
            self._keys = defaults  # written by another version or an editor

    def key(self, name: str) -> str:
        """Return the key of a row as Qt writes it, "" for none."""
        return self._keys[name]

    def sequence(self, name: str) -> QKeySequence:
        """Return the key of a row for Qt, empty for none."""
        return sequence_of(self._keys[name])

    def is_default(self, name: str) -> bool:
        """Return whether a row has the key of the table."""
        return self._keys[name] == key_name(self._rows[name].shortcut)

    def with_key(self, name: str, help: str) -> str:
        """Return the help of a row with its key in brackets."""
        return f"{help} ({self._keys[name]})" if self._keys[name] else help

    def in_text(self, text: str) -> str:
        """Return a text that names keys of the table, with the present ones in their place."""
        changed = {
            row.shortcut: self._keys[row.name] or f"{row.label}, which has no key"
            for row in KEY_ROWS
            if not self.is_default(row.name) and row.name not in _PLAIN_KEY_NAMES
        }
        changed.pop("", None)
        if not changed:
            return text
        names = "|".join(map(re.escape, changed))
        return re.sub(rf"(?<![\w+])({names})(?![\w+])", lambda key: changed[key[0]], text)

    def fault(self, name: str, key: str) -> str:
        """Return why a row cannot have a key, as a sentence; "" if it can."""
        row, key = self._rows[name], key_name(key)
        if not key:
            return "STOP needs a key." if name == _STOP_ROW else ""
        if sequence_of(key).count() > 1:
            return "Choose one key, not several one after the other."
        is_plain = name in _PLAIN_KEY_NAMES
        moves = key in MOVEMENT_KEYS and not is_plain
        if moves or key in NAVIGATION_KEYS or (key == PRESS_KEY and name != _PLAY_ROW):
            return f"{key} is needed to use buttons and fields."
        if key in EDITING_KEYS and name not in _UNDO_ROWS:
            return f"{key} edits the text of fields."
        if is_plain and re.match(r"(Ctrl|Alt|Meta)\+", key):
            return f"{row.label} needs a single key, without Ctrl or Alt."
        for other, used in self._keys.items():
            if used == key and other != name and _work_together(name, other):
                return f"{key} is the key of '{self._rows[other].label}': change that one first."
        return ""

    def set_key(self, name: str, key: str) -> None:
        """Give a row another key, "" for none.

        Raises:
            WorkbenchError: if it cannot have that key.
        """
        fault = self.fault(name, key)
        if fault:
            raise WorkbenchError(fault)
        if key_name(key) != self._keys[name]:
            self._keys[name] = key_name(key)
            self._keep(name)

    def reset(self) -> None:
        """Give all rows the keys of the table."""
        changed = [name for name in self._rows if not self.is_default(name)]
        for name in changed:
            self._keys[name] = key_name(self._rows[name].shortcut)
        for name in changed:
            self._keep(name)

    def _keep(self, name: str) -> None:
        at = f"{KEYS_SETTINGS_GROUP}/{name}"
        if self.is_default(name):
            self._store.remove(at)
        else:
            self._store.setValue(at, self._keys[name])
        self.changed.emit(name)


def _work_together(name: str, other: str) -> bool:
    """Return whether two rows can have an effect at once: no chart is beside the sticks."""
    return not any(
        one in _STICK_NAMES and two in _CHART_NAMES for one, two in ((name, other), (other, name))
    )

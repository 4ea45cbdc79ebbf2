"""The actions of the app, made from their tables, with the keys that the user has chosen."""

from collections.abc import Callable, Iterable, Mapping

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import QAbstractButton, QWidget

from workbench.gui.actions import ACTION_TABLE, ActionRow
from workbench.gui.key_map import KeyMap
from workbench.gui.labels import set_tip

AUTO_REPEATED_ACTIONS = ("step", "undo", "redo", "servo_raise", "servo_lower")
"""Actions that a held key repeats."""


class CommandAction(QAction):
    """An action of a table; its key and its tool tip follow the user's keys.

    Args:
        row: row of the table.
        keys: keys of all rows.
        do: the function to call.
        parent: widget that gets the action.
        context: where its key works; by default in the window, while the parent is visible.
    """

    def __init__(
        self,
        row: ActionRow,
        keys: KeyMap,
        do: Callable[[], object],
        parent: QWidget,
        context: Qt.ShortcutContext = Qt.ShortcutContext.WindowShortcut,
    ) -> None:
        super().__init__(row.text, parent)
        self._row, self._keys = row, keys
        self.setObjectName(row.name)
        self.setIconText(row.button or row.label)
        self.setCheckable(row.checkable)
        self.setStatusTip(row.help)
        self.setShortcutContext(context)
        self.setAutoRepeat(row.name in AUTO_REPEATED_ACTIONS)
        self.triggered.connect(lambda _checked: do())
        keys.changed.connect(self._follow)
        self._show_key()
        parent.addAction(self)

    def _follow(self, name: str) -> None:
        if name == self._row.name:
            self._show_key()

    def _show_key(self) -> None:
        self.setShortcut(self._keys.sequence(self._row.name))
        set_tip(self, self._keys.with_key(self._row.name, self._row.help))


def show_tip(button: QAbstractButton, action: QAction) -> None:
    """Show the tool tip of an action, which names its key, on a button that does the same."""
    set_tip(button, action.toolTip())
    action.changed.connect(lambda: set_tip(button, action.toolTip()))


def make_actions(
    parent: QWidget,
    handlers: Mapping[str, Callable[[], object]],
    keys: KeyMap,
    rows: Iterable[ActionRow] = ACTION_TABLE,
    context: Qt.ShortcutContext = Qt.ShortcutContext.ApplicationShortcut,
) -> dict[str, QAction]:
    """Return an action for each row of a table, by name.

    Args:
        parent: widget that gets the actions.
        handlers: what each action calls, by name.
        keys: keys of all rows.
        rows: the table.
        context: where the keys work.
    """
    return {row.name: CommandAction(row, keys, handlers[row.name], parent, context) for row in rows}

"""The menu bar, made of the table of actions."""

from collections.abc import Callable, Mapping

from PyQt6.QtGui import QAction
from PyQt6.QtWidgets import QMenu, QMenuBar

from workbench.gui.actions import FILE, MENUS, rows_of
from workbench.gui.recent import Recent, RecentFiles

RECENT = "Recent &files"
AFTER = "open_log"
"""The action below which the recent files stand."""


def fill_menus(bar: QMenuBar, actions: Mapping[str, QAction]) -> dict[str, QMenu]:
    """Fill the menu bar, and return all menus by their text."""
    made = {}
    for text in MENUS:
        menu = QMenu(text, bar)
        bar.addMenu(menu)
        made[text] = menu
        for row in rows_of(text):
            if not row.in_menu:
                continue
            if row.after_line:
                menu.addSeparator()
            if row.submenu and row.submenu not in made:
                made[row.submenu] = QMenu(row.submenu, menu)
                menu.addMenu(made[row.submenu])
            made.get(row.submenu, menu).addAction(actions[row.name])
            if row.name == AFTER:
                made[RECENT] = QMenu(RECENT, made[FILE])
                menu.addMenu(made[RECENT])
    return made


class RecentMenu:
    """Keeps the menu of recent files up to date.

    Args:
        menu: to fill.
        files: which there are.
        opens: told which is chosen.
    """

    def __init__(self, menu: QMenu, files: RecentFiles, opens: Callable[[Recent], None]) -> None:
        self._menu, self._files, self._opens = menu, files, opens
        menu.aboutToShow.connect(self.fill)
        files.changed.connect(self.fill)
        self.fill()

    def fill(self) -> None:
        """List the files that are still there."""
        self._menu.clear()
        files = self._files.files()
        self._menu.setEnabled(bool(files))
        for number, each in enumerate(files, start=1):
            path = each.path.replace("&", "&&")
            action = QAction(f"&{number}  {path}  ({each.kind.value})", self._menu)
            action.triggered.connect(lambda _checked, each=each: self._opens(each))
            self._menu.addAction(action)

"""The pages of the Help menu: all keys, and what this is."""

from html import escape

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.actions import FILE, FLIGHT, HELP, MENUS, VIEW, ActionRow, rows_of

LONGEST_KEY = "Ctrl+Shift+W  "
COLUMNS = ((FILE, VIEW), (FLIGHT, HELP))
ABOUT = (
    "<b>Drake drone workbench</b><br>Design a multirotor and its controller on Drake: fly it, "
    "watch it, and tune it while it flies.<br><br>Free software under the GNU General Public "
    "License, version 3 or later, without any warranty."
)


class KeysPage(QDialog):
    """All shortcuts, made of the table of actions.

    Args:
        parent: above which it opens.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("Keys")
        columns = QHBoxLayout()
        columns.setSpacing(36)
        for menus in COLUMNS:
            column = QVBoxLayout()
            for menu in (menu for menu in MENUS if menu in menus):
                column.addLayout(_table(menu))
                column.addSpacing(12)
            column.addStretch(1)
            columns.addLayout(column)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(22, 18, 22, 14)
        layout.addLayout(columns)
        layout.addWidget(_close_button(self))


class AboutPage(QDialog):
    """What this is, and its licence.

    Args:
        parent: above which it opens.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setWindowTitle("About")
        words = QLabel(ABOUT)
        words.setTextFormat(Qt.TextFormat.RichText)
        words.setWordWrap(True)
        words.setMinimumWidth(380)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(22, 18, 22, 14)
        layout.addWidget(words)
        layout.addWidget(_close_button(self))


def _table(menu: str) -> QGridLayout:
    """Return the keys of a menu in two columns."""
    grid = QGridLayout()
    grid.setHorizontalSpacing(16)
    grid.setVerticalSpacing(3)
    heading = QLabel(menu.replace("&", ""))
    heading.setProperty("class", "heading")
    grid.addWidget(heading, 0, 0, 1, 2)
    keyed = [row for row in rows_of(menu) if row.shortcut]
    for at, row in enumerate(keyed, start=1):
        grid.addWidget(_key(row), at, 0)
        words = QLabel(row.help)
        grid.addWidget(words, at, 1)
    key = QLabel(LONGEST_KEY)
    grid.setColumnMinimumWidth(0, key.sizeHint().width())
    grid.setColumnStretch(1, 1)
    return grid


def _key(row: ActionRow) -> QLabel:
    key = QLabel(f"<b>{escape(row.shortcut)}</b>")
    key.setTextFormat(Qt.TextFormat.RichText)
    return key


def _close_button(dialog: QDialog) -> QDialogButtonBox:
    box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    box.rejected.connect(dialog.close)
    return box

"""The pages of the Help menu: all keys, and what this is."""

from collections.abc import Iterable
from html import escape

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QGridLayout,
    QHBoxLayout,
    QLabel,
    QScrollArea,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.actions import MENUS, rows_of
from workbench.gui.gains.profile_bar import PROFILE_ACTIONS
from workbench.gui.style import dressed

LONGEST_KEY = "Ctrl+Shift+W  "
WORDS = 268
"""Width of what a key does: two columns fit into the smallest window [px]."""
MARGIN = 40
"""Of the page to the edges of the window [px]."""
TUNING_KEYS = (
    ("Ctrl+E", "Start or stop the excitation."),
    ("Ctrl+F", "Search the parameters."),
    ("Arrows", "Move the slider; with Shift in large steps, with Ctrl in small ones."),
    ("Enter", "Fly what is proposed, where gains fly on Enter."),
    ("Ctrl+Return", "Fly what was doubted, all the same."),
    ("Esc", "Put back what is proposed and does not fly."),
)
ABOUT = (
    "<b>Drake drone workbench</b><br>Design a multirotor and its controller on Drake: fly it, "
    "watch it, and tune it while it flies.<br><br>Free software under the GNU General Public "
    "License, version 3 or later, without any warranty."
)


def keys_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog of all shortcuts, made of the table of actions.

    Args:
        parent: above which it opens.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("Keys")
    page = QWidget()
    columns = QHBoxLayout(page)
    columns.setSpacing(24)
    for tables in (
        [(menu.replace("&", ""), _keys_of(menu)) for menu in MENUS],
        [("Tuning", _tuning_keys())],
    ):
        column = QVBoxLayout()
        for heading, keys in tables:
            if keys:
                column.addLayout(_table(heading, keys))
                column.addSpacing(12)
        column.addStretch(1)
        columns.addLayout(column)
    scrolling = QScrollArea()
    scrolling.setWidgetResizable(True)
    scrolling.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    scrolling.setWidget(page)
    bar = scrolling.verticalScrollBar()
    assert bar is not None
    scrolling.setMinimumWidth(page.sizeHint().width() + bar.sizeHint().width())
    layout = QVBoxLayout(dialog)
    layout.setContentsMargins(22, 18, 22, 14)
    layout.addWidget(scrolling)
    layout.addWidget(_close_button(dialog))
    above = parent.window() if parent is not None else None
    room = above.height() - MARGIN if above is not None else page.sizeHint().height()
    rest = layout.minimumSize().height() - scrolling.minimumSizeHint().height()
    dialog.resize(0, min(room, page.sizeHint().height() + rest + MARGIN // 2))
    return dialog


def about_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog that says what this is, and its licence.

    Args:
        parent: above which it opens.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("About")
    words = QLabel(ABOUT)
    words.setTextFormat(Qt.TextFormat.RichText)
    words.setWordWrap(True)
    words.setMinimumWidth(380)
    layout = QVBoxLayout(dialog)
    layout.setContentsMargins(22, 18, 22, 14)
    layout.addWidget(words)
    layout.addWidget(_close_button(dialog))
    return dialog


def _table(heading: str, keys: Iterable[tuple[str, str]]) -> QGridLayout:
    """Return keys and what they do in two columns."""
    grid = QGridLayout()
    grid.setHorizontalSpacing(16)
    grid.setVerticalSpacing(3)
    title = dressed(QLabel(heading), "heading")
    grid.addWidget(title, 0, 0, 1, 2)
    for at, (shortcut, help) in enumerate(keys, start=1):
        grid.addWidget(_key(shortcut), at, 0, Qt.AlignmentFlag.AlignTop)
        words = QLabel(help)
        words.setWordWrap(True)
        words.setFixedWidth(WORDS)
        words.setMinimumHeight(words.heightForWidth(WORDS))
        grid.addWidget(words, at, 1)
    grid.setColumnMinimumWidth(0, QLabel(LONGEST_KEY).sizeHint().width())
    grid.setColumnStretch(1, 1)
    return grid


def _keys_of(menu: str) -> list[tuple[str, str]]:
    return [(row.shortcut, row.help) for row in rows_of(menu) if row.shortcut]


def _tuning_keys() -> list[tuple[str, str]]:
    return [(row.shortcut, row.help) for row in PROFILE_ACTIONS] + list(TUNING_KEYS)


def _key(shortcut: str) -> QLabel:
    key = QLabel(f"<b>{escape(shortcut)}</b>")
    key.setTextFormat(Qt.TextFormat.RichText)
    return key


def _close_button(dialog: QDialog) -> QDialogButtonBox:
    box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    box.rejected.connect(dialog.close)
    return box

"""Help in the app: about each card of the screens, pages of the docs, all keys, and "about"."""

import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QEvent, QObject, Qt, QUrl
from PyQt6.QtGui import QDesktopServices, QImage, QTextCursor, QTextDocument, QWhatsThisClickedEvent
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QGridLayout,
    QScrollArea,
    QTextBrowser,
    QWidget,
)

from workbench.common.plain_text import html_text
from workbench.common.resources import docs_dir
from workbench.gui.actions import MENUS, rows_of
from workbench.gui.gains.gain_bar import GAIN_ACTIONS
from workbench.gui.layout import NO_MARGINS, Margins, Part, grid, hbox, label, vbox
from workbench.gui.style import dressed

SIZE = (860, 640)
"""Size of the window [px]."""
WIDEST = 800
"""Width limit of pictures [px]."""


def anchor(heading: str) -> str:
    """Return the anchor of a heading, as GitHub forms it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


class DocsBrowser(QTextBrowser):
    """Shows a page at a heading; links to other pages open here, external ones in the browser."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("A page of the docs")
        self.setOpenLinks(False)
        self.anchorClicked.connect(self._follow)
        self._page = ""

    def open(self, link: str) -> None:
        """Show a page, as `linear.md#the-judgement`; without a name, the present one."""
        name, _, heading = link.partition("#")
        if name and name != self._page:
            path = docs_dir() / name
            if path.suffix != ".md" or not path.is_file():
                self.setPlainText(f"{name} is not among the docs in {docs_dir()}.")
                return
            self._page = name
            self.setMarkdown(path.read_text(encoding="utf-8"))
        self.show_heading(heading)

    def show_heading(self, wanted: str) -> None:
        """Scroll to the heading with an anchor, or to the top."""
        document = self.document()
        assert document is not None
        block = document.begin()
        while block.isValid() and not (
            block.blockFormat().headingLevel() and anchor(block.text()) == wanted
        ):
            block = block.next()
        found = block if block.isValid() else document.begin()
        self.setTextCursor(QTextCursor(found))
        layout, bar = document.documentLayout(), self.verticalScrollBar()
        assert layout is not None and bar is not None
        bar.setValue(round(layout.blockBoundingRect(found).top()))

    def loadResource(self, kind: int, name: QUrl) -> Any:
        """Return a picture of the docs, no wider than the page."""
        if kind != QTextDocument.ResourceType.ImageResource.value:
            return super().loadResource(kind, name)
        picture = QImage(str(docs_dir() / name.toString()))
        smooth = Qt.TransformationMode.SmoothTransformation
        return picture.scaledToWidth(WIDEST, smooth) if picture.width() > WIDEST else picture

    def _follow(self, url: QUrl) -> None:
        if url.scheme() in ("http", "https"):
            QDesktopServices.openUrl(url)
        else:
            self.open(url.toString())


def show_docs(link: str, parent: QWidget | None = None) -> QDialog:
    """Open a window with a page of the docs, and return it.

    Args:
        link: page and heading, as `linear.md#the-judgement`.
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("Docs")
    browser = DocsBrowser(dialog)
    vbox(browser, of=dialog, margins=NO_MARGINS)
    dialog.resize(*SIZE)
    dialog.show()  # first, because positions follow from the width
    browser.open(link)
    return dialog


def read_cards(path: Path) -> dict[str, tuple[str, str, str]]:
    """Return the help about each card, by its title.

    Args:
        path: page with a heading for each card, and below it three paragraphs.

    Returns:
        What it shows, how to read or use it, and its page and heading in the docs.
    """
    cards = {}
    for card in path.read_text(encoding="utf-8").split("\n## ")[1:]:
        title, means, read, link = card.strip().split("\n\n")
        page = link.removesuffix(")").rpartition("/")[2]
        cards[title] = means.replace("\n", " "), read.replace("\n", " "), page
    return cards


CARDS = read_cards(Path(__file__).with_name("cards.md"))


def card_text(title: str) -> str:
    """Return the complete help about a card as rich text; a KeyError is a programming error."""
    means, read, page = CARDS[title]
    return (
        f"<b>{html_text(title)}</b><p>{html_text(means)} {html_text(read)}</p>"
        f'<p><a href="{page}">More in the docs: {page.partition("#")[0]}</a></p>'
    )


def explain(card: QWidget, title: str) -> None:
    """Give a card its help, shown by *What is this?* (Shift+F1).

    Args:
        card: the card; the help appears anywhere on it.
        title: its heading in `cards.md`.
    """
    card.setWhatsThis(card_text(title))
    card.installEventFilter(_Links(card))


def explained(
    title: str, *parts: Part, margins: Margins = (16, 12, 16, 12), spacing: int | None = None
) -> QFrame:
    """Return a card with parts in it and the help of its title; arguments as for `vbox`."""
    card = dressed(QFrame(), "card")
    explain(card, title)
    vbox(*parts, of=card, margins=margins, spacing=spacing)
    return card


class _Links(QObject):
    """Opens the docs when a link in a card's help is clicked."""

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Handle the click; other events pass."""
        if isinstance(event, QWhatsThisClickedEvent) and isinstance(watched, QWidget):
            show_docs(event.href(), watched.window())
            return True
        return False


LONGEST_KEY = "Ctrl+Shift+W  "
WORDS = 268
"""Width of an action's description: two columns fit into the smallest window [px]."""
MARGIN = 40
"""Margin between page and window [px]."""
TUNING_KEYS = (
    ("Ctrl+E", "Start or stop the excitation."),
    ("Ctrl+F", "Search the parameters."),
    ("Arrows", "Move the slider; with Shift in large steps, with Ctrl in small ones."),
    ("Enter", "Fly the proposed gains, if gains fly on Enter."),
    ("Ctrl+Return", "Fly the proposed gains in spite of a warning."),
    ("Esc", "Discard proposed gains that do not fly."),
)
ABOUT = (
    "Design a multirotor and its controller on Drake: fly it, watch it, and tune it while it "
    "flies.\n\nFree software under the GNU General Public License, version 3 or later, without any "
    "warranty."
)


def keys_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog with all shortcuts, from the table of actions.

    Args:
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("Keys")
    page = QWidget()
    columns = hbox(of=page, spacing=24)
    for tables in (
        [(menu.replace("&", ""), _keys_of(menu)) for menu in MENUS],
        [("Tuning", _tuning_keys())],
    ):
        column = vbox()
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
    layout = vbox(scrolling, _close_button(dialog), of=dialog, margins=(22, 18, 22, 14))
    above = parent.window() if parent is not None else None
    room = above.height() - MARGIN if above is not None else page.sizeHint().height()
    rest = layout.minimumSize().height() - scrolling.minimumSizeHint().height()
    dialog.resize(0, min(room, page.sizeHint().height() + rest + MARGIN // 2))
    return dialog


def about_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog about the app and its licence.

    Args:
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("About")
    words = label(ABOUT, wraps=True)
    words.setMinimumWidth(380)
    heading = label("Drake drone workbench", "heading")
    vbox(heading, words, _close_button(dialog), of=dialog, margins=(22, 18, 22, 14))
    return dialog


def _table(heading: str, keys: Iterable[tuple[str, str]]) -> QGridLayout:
    """Return keys and their actions in two columns."""
    made = grid(spacing=(16, 3), stretches=(0, 1))
    made.addWidget(label(heading, "heading"), 0, 0, 1, 2)
    for at, (shortcut, help) in enumerate(keys, start=1):
        made.addWidget(label(shortcut, "heading"), at, 0, Qt.AlignmentFlag.AlignTop)
        words = label(help, wraps=True)
        words.setFixedWidth(WORDS)
        words.setMinimumHeight(words.heightForWidth(WORDS))
        made.addWidget(words, at, 1)
    made.setColumnMinimumWidth(0, label(LONGEST_KEY, "heading").sizeHint().width())
    return made


def _keys_of(menu: str) -> list[tuple[str, str]]:
    return [(row.shortcut, row.help) for row in rows_of(menu) if row.shortcut]


def _tuning_keys() -> list[tuple[str, str]]:
    return [(row.shortcut, row.help) for row in GAIN_ACTIONS] + list(TUNING_KEYS)


def _close_button(dialog: QDialog) -> QDialogButtonBox:
    box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    box.rejected.connect(dialog.close)
    return box

"""Help in the app: about each card of the screens, pages of the docs, and "about"."""

import re
from pathlib import Path
from typing import Any

from PyQt6.QtCore import QEvent, QObject, Qt, QUrl
from PyQt6.QtGui import QDesktopServices, QImage, QTextCursor, QTextDocument, QWhatsThisClickedEvent
from PyQt6.QtWidgets import (
    QDialog,
    QDialogButtonBox,
    QFrame,
    QTextBrowser,
    QWidget,
)

from workbench.common.plain_text import html_text
from workbench.common.resources import docs_dir
from workbench.gui.layout import NO_MARGINS, BoxMargins, LayoutPart, label, vbox
from workbench.gui.style import with_class

DOCS_WINDOW_SIZE_PX = (860, 640)
"""Size of the window [px]."""
MAX_PICTURE_WIDTH_PX = 800
"""Width limit of pictures [px]."""


def heading_anchor(heading: str) -> str:
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
            block.blockFormat().headingLevel() and heading_anchor(block.text()) == wanted
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
        return (
            picture.scaledToWidth(MAX_PICTURE_WIDTH_PX, smooth)
            if picture.width() > MAX_PICTURE_WIDTH_PX
            else picture
        )

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
    dialog.resize(*DOCS_WINDOW_SIZE_PX)
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


CARD_HELP = read_cards(Path(__file__).with_name("cards.md"))


def add_card_help(title: str, means: str, read: str, page: str) -> None:
    """Add the help about a card of another package.

    Args:
        title: its heading.
        means: what it shows, in a sentence.
        read: how to read or use it, in a sentence.
        page: page of the docs and heading, as "app.md#tuning".
    """
    CARD_HELP[title] = means, read, page


def card_text(title: str) -> str:
    """Return the complete help about a card as rich text; a KeyError is a programming error."""
    means, read, page = CARD_HELP[title]
    return (
        f"<b>{html_text(title)}</b><p>{html_text(means)} {html_text(read)}</p>"
        f'<p><a href="{page}">More in the docs: {page.partition("#")[0]}</a></p>'
    )


def set_card_help(card: QWidget, title: str) -> None:
    """Give a card its help, shown by *What is this?* (Shift+F1).

    Args:
        card: the card; the help appears anywhere on it.
        title: its heading in `cards.md`.
    """
    card.setWhatsThis(card_text(title))
    card.installEventFilter(_HelpLinkOpener(card))


def help_card(
    title: str,
    *parts: LayoutPart,
    margins: BoxMargins | None = (16, 12, 16, 12),
    spacing: int | None = None,
) -> QFrame:
    """Return a card with parts in it and the help of its title; arguments as for `vbox`."""
    card = with_class(QFrame(), "card")
    set_card_help(card, title)
    vbox(*parts, of=card, margins=margins, spacing=spacing)
    return card


class _HelpLinkOpener(QObject):
    """Opens the docs when a link in a card's help is clicked."""

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Handle the click; other events pass."""
        if isinstance(event, QWhatsThisClickedEvent) and isinstance(watched, QWidget):
            show_docs(event.href(), watched.window())
            return True
        return False


ABOUT_TEXT = (
    "Design a multirotor and its controller on Drake: fly it, watch it, and tune it while it "
    "flies.\n\nFree software under the GNU General Public License, version 3 or later, without any "
    "warranty."
)


def about_page(parent: QWidget | None = None) -> QDialog:
    """Return a dialog about the app and its licence.

    Args:
        parent: the Qt parent.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("About")
    words = label(ABOUT_TEXT, wraps=True)
    words.setMinimumWidth(380)
    heading = label("Drake drone workbench", "heading")
    vbox(heading, words, _close_button(dialog), of=dialog, margins=(22, 18, 22, 14))
    return dialog


def _close_button(dialog: QDialog) -> QDialogButtonBox:
    box = QDialogButtonBox(QDialogButtonBox.StandardButton.Close)
    box.rejected.connect(dialog.close)
    return box

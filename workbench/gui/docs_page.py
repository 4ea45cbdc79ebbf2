"""The pages of the docs in a window of the app, as they are shipped with it."""

import re
from typing import Any

from PyQt6.QtCore import Qt, QUrl
from PyQt6.QtGui import QDesktopServices, QImage, QTextCursor, QTextDocument
from PyQt6.QtWidgets import QDialog, QTextBrowser, QVBoxLayout, QWidget

from workbench.common.resources import docs_dir

SIZE = (860, 640)
"""Of the window [px]."""
WIDEST = 800
"""Picture [px]."""


def anchor(heading: str) -> str:
    """Return the anchor of a heading, as GitHub makes it."""
    return re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")


class DocsBrowser(QTextBrowser):
    """Shows a page at a heading; its links to other pages open here, all others in the browser."""

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self.setAccessibleName("A page of the docs")
        self.setOpenLinks(False)
        self.anchorClicked.connect(self._follow)
        self._page = ""

    def open(self, link: str) -> None:
        """Show a page, as `linear.md#the-judgement`; without a name, this one."""
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
        """Scroll to the heading of an anchor, or to the top."""
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
        link: of the page and its heading, as `linear.md#the-judgement`.
        parent: above which it opens.
    """
    dialog = QDialog(parent)
    dialog.setWindowTitle("Docs")
    browser = DocsBrowser(dialog)
    box = QVBoxLayout(dialog)
    box.setContentsMargins(0, 0, 0, 0)
    box.addWidget(browser)
    dialog.resize(*SIZE)
    dialog.show()  # first, as what stands where follows from the width
    browser.open(link)
    return dialog

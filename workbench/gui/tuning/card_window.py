"""A window of its own for a card of the tuning screen."""

from collections.abc import Iterable

from PyQt6.QtCore import QSize, Qt, pyqtSignal
from PyQt6.QtGui import QAction, QCloseEvent, QKeySequence, QShortcut
from PyQt6.QtWidgets import QStackedWidget, QTabWidget, QWidget

from workbench.gui.layout import button, label, vbox
from workbench.gui.tuning.card import CARD_WINDOW_SHORTCUT, TuningCard

CARD_WINDOW_SIZE_PX = (720, 560)
"""Least first size of the window [px]."""


class CardWindow(QWidget):
    """Shows a card; when it is closed, the card goes back to its place.

    Args:
        card: the card, in a tab or a layout.
        parent: the Qt parent.
        actions: actions whose keys work in the window, too.
    """

    closed = pyqtSignal()
    """The card is back in its place."""

    def __init__(self, card: TuningCard, parent: QWidget, actions: Iterable[QAction]) -> None:
        super().__init__(parent, Qt.WindowType.Window)
        self.setAttribute(Qt.WidgetAttribute.WA_DeleteOnClose)
        self.setWindowTitle(card.accessibleName())
        self._card = card
        size = card.size().expandedTo(QSize(*CARD_WINDOW_SIZE_PX))
        self._place = QWidget()
        said = label(f"{card.accessibleName()} has a window of its own.", "muted", wraps=True)
        said.setAlignment(Qt.AlignmentFlag.AlignCenter)
        help = f"Close that window ({CARD_WINDOW_SHORTCUT})"
        back = button("Bring it &back", self.close, help=help)
        vbox(1, said, (back, Qt.AlignmentFlag.AlignHCenter), 1, of=self._place)
        replace_part(card, self._place)
        vbox(card, of=self)
        card.has_window = True
        card.show()
        self.addActions([*actions])
        QShortcut(QKeySequence(CARD_WINDOW_SHORTCUT), self).activated.connect(self.close)
        self.resize(size)

    def closeEvent(self, event: QCloseEvent | None) -> None:
        """Put the card back."""
        replace_part(self._place, self._card)
        self._place.deleteLater()
        self._card.has_window = False
        self._card.show()
        self.closed.emit()
        super().closeEvent(event)


def replace_part(part: QWidget, other: QWidget) -> None:
    """Put a widget into the place of another one, which is in a tab or in a layout."""
    above = part.parentWidget()
    tabs = above.parentWidget() if isinstance(above, QStackedWidget) else None
    if isinstance(tabs, QTabWidget):
        index, chosen = tabs.indexOf(part), tabs.currentIndex()
        title = tabs.tabText(index)
        tabs.removeTab(index)
        tabs.insertTab(index, other, title)
        tabs.setCurrentIndex(chosen)
    elif above is not None and (layout := above.layout()) is not None:
        layout.replaceWidget(part, other)
        other.show()

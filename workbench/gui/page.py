"""Lays out a screen as a page: not wider than the eye follows, and scrolled where it must be."""

from PyQt6.QtCore import QEvent, QObject, QSize, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QBoxLayout, QFrame, QLayout, QScrollArea, QVBoxLayout, QWidget

WIDEST = 1500
TALLEST = 1000
"""Of a page [px]; beyond that its parts would only drift apart."""

BAR = 11
"""Width of a scroll bar in our style; it would lie on what is scrolled [px]."""


def fit_page(screen: QWidget, layout: QLayout) -> None:
    """Fill a screen with a layout, in the middle of a large one.

    Args:
        screen: that has no layout yet.
        layout: of the page.
    """
    area = QScrollArea(screen)
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setWidget(_Ground(layout))
    outer = QVBoxLayout(screen)
    outer.setContentsMargins(0, 0, 0, 0)
    outer.addWidget(area)


def scrolled(part: QWidget) -> QScrollArea:
    """Return an area in which a part has all the width, and is scrolled where it is too high."""
    area = QScrollArea()
    area.setWidgetResizable(True)
    area.setFrameShape(QFrame.Shape.NoFrame)
    area.setFocusPolicy(Qt.FocusPolicy.NoFocus)
    area.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAlwaysOff)
    area.setMinimumWidth(part.minimumSizeHint().width() + BAR)
    area.setWidget(part)
    return area


class Pair(QWidget):
    """Two cards beside each other, or one below the other where that would cut them.

    Args:
        left: or above.
        right: or below.
        shares: of the width that both take [ratio].
        spacing: between them [px].
    """

    def __init__(
        self, left: QWidget, right: QWidget, shares: tuple[int, int], spacing: int
    ) -> None:
        super().__init__()
        self._parts = (left, right)
        self._box = QBoxLayout(QBoxLayout.Direction.LeftToRight, self)
        self._box.setContentsMargins(0, 0, 0, 0)
        self._box.setSpacing(spacing)
        for part, share in zip(self._parts, shares, strict=True):
            self._box.addWidget(part, share)

    def minimumSizeHint(self) -> QSize:
        """Return the width of the wider one, and the height of both as they stand."""
        widest = max(part.minimumSizeHint().width() for part in self._parts)
        return QSize(widest, self._box.minimumSize().height())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Stand as the width allows."""
        needed = sum(part.minimumSizeHint().width() for part in self._parts)
        across = self.width() >= needed + self._box.spacing()
        directions = QBoxLayout.Direction
        self._box.setDirection(directions.LeftToRight if across else directions.TopToBottom)
        super().resizeEvent(event)


class _Ground(QWidget):
    """Holds a page, and asks for as little height as the page can do with at its width.

    A scroll area by itself would ask for the height that the page likes best.
    """

    def __init__(self, layout: QLayout) -> None:
        super().__init__()
        self._page = QWidget(self)
        self._layout = layout
        self._page.setLayout(layout)
        self._page.installEventFilter(self)

    def minimumSizeHint(self) -> QSize:
        """Return the least that cuts nothing."""
        least = self._layout.minimumSize()
        if not self._layout.hasHeightForWidth():
            return least
        width = min(max(self.width(), least.width()), WIDEST)
        return QSize(least.width(), self._layout.minimumHeightForWidth(width))

    def sizeHint(self) -> QSize:
        """Return the same: the rest is room."""
        return self.minimumSizeHint()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Put the page in the middle."""
        super().resizeEvent(event)
        width, height = min(self.width(), WIDEST), min(self.height(), TALLEST)
        self._page.setGeometry((self.width() - width) // 2, 0, width, height)
        if event is not None and event.size().width() != event.oldSize().width():
            self.updateGeometry()

    def eventFilter(self, watched: QObject | None, event: QEvent | None) -> bool:
        """Ask anew when something on the page needs another room."""
        if event is not None and event.type() is QEvent.Type.LayoutRequest:
            self.updateGeometry()
        return False

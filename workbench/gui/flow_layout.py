"""A layout that places widgets side by side and wraps lines."""

from PyQt6.QtCore import QPoint, QRect, QSize, Qt
from PyQt6.QtWidgets import QLayout, QLayoutItem, QWidget


class FlowLayout(QLayout):
    """Places widgets side by side and wraps lines; hidden ones take no space.

    Args:
        parent: widget that gets the layout, if it exists yet.
        spacing: space between widgets, in both directions [px].
    """

    def __init__(self, parent: QWidget | None = None, spacing: int = 8) -> None:
        super().__init__(parent)
        self.setContentsMargins(0, 0, 0, 0)
        self.setSpacing(spacing)
        self._items: list[QLayoutItem] = []

    def addItem(self, item: QLayoutItem | None) -> None:
        """Add an item; Qt's name, like the following ones."""
        if item is not None:
            self._items.append(item)
            self.invalidate()

    def count(self) -> int:
        """Return the number of items."""
        return len(self._items)

    def itemAt(self, index: int) -> QLayoutItem | None:
        """Return an item, None beyond the last one."""
        return self._items[index] if 0 <= index < len(self._items) else None

    def takeAt(self, index: int) -> QLayoutItem | None:
        """Remove and return an item."""
        return self._items.pop(index) if 0 <= index < len(self._items) else None

    def expandingDirections(self) -> Qt.Orientation:
        """Request no additional space."""
        return Qt.Orientation(0)

    def hasHeightForWidth(self) -> bool:
        """Tell Qt that its height depends on its width."""
        return True

    def heightForWidth(self, width: int) -> int:
        """Return the height of all lines at a width [px]."""
        return self._place(QRect(0, 0, width, 0), move=False)

    def sizeHint(self) -> QSize:
        """Return the size of all items in one line."""
        hints = [item.sizeHint() for item in self._shown()]
        width = sum(each.width() for each in hints) + self.spacing() * max(0, len(hints) - 1)
        return self._around(QSize(width, max((each.height() for each in hints), default=0)))

    def minimumSize(self) -> QSize:
        """Return the width of the widest item and the height of the highest one."""
        hints = [item.sizeHint() for item in self._shown()]
        widest = max((each.width() for each in hints), default=0)
        return self._around(QSize(widest, max((each.height() for each in hints), default=0)))

    def setGeometry(self, rect: QRect) -> None:
        """Place all items within a rectangle."""
        super().setGeometry(rect)
        self._place(rect, move=True)

    def _shown(self) -> list[QLayoutItem]:
        return [item for item in self._items if not item.isEmpty()]

    def _around(self, size: QSize) -> QSize:
        margins = self.contentsMargins()
        more = QSize(margins.left() + margins.right(), margins.top() + margins.bottom())
        return size + more

    def _place(self, rect: QRect, *, move: bool) -> int:
        """Return the height of all items at a rectangle's width, and place them if requested."""
        room = rect.marginsRemoved(self.contentsMargins())
        x, y, high = room.left(), room.top(), 0
        line: list[tuple[QLayoutItem, QRect]] = []

        def end_line() -> None:
            for item, place in line if move else ():
                item.setGeometry(place.translated(0, (high - place.height()) // 2))

        for item in self._shown():
            size = item.sizeHint()
            if line and x + size.width() > room.left() + room.width():
                end_line()
                x, y, high, line = room.left(), y + high + self.spacing(), 0, []
            line.append((item, QRect(QPoint(x, y), size)))
            x, high = x + size.width() + self.spacing(), max(high, size.height())
        end_line()
        return y + high - rect.top() + self.contentsMargins().bottom()

"""Where the parts of the tuning screen stand: side by side where there is room, else in tabs."""

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QHBoxLayout, QLayout, QSplitter, QTabWidget, QVBoxLayout, QWidget

WIDE = 1150
"""From this width on there are three columns [px]."""
GAP = 8
GAINS, MIDDLE = 364, 364
"""Widths at first; the rest is for margins and tabs [px]."""
CLOSE = "QTabBar::tab { padding: 6px 5px; margin-right: 0; }"
"""For eight tabs side by side in half of a narrow screen."""
LEAST, SHORTEST = 360, 520
"""Width of the tabs, and height of all, in which nothing is cut [px]."""


class Arrangement(QWidget):
    """Gains left, the response beside them, margins and tabs right or in tabs.

    Args:
        gains: left.
        response: what is excited, and what comes of it.
        margins: of all loops.
        tabs: everything else, each with its name.
    """

    def __init__(
        self, gains: QWidget, response: QWidget, margins: QWidget, tabs: QTabWidget
    ) -> None:
        super().__init__()
        self._response, self._margins, self._tabs = response, margins, tabs
        self._is_wide: bool | None = None
        tabs.setDocumentMode(True)
        tabs.setUsesScrollButtons(True)
        tabs.setElideMode(Qt.TextElideMode.ElideNone)
        self._middle = _column()
        self._right = _column()
        self.splitter = QSplitter(Qt.Orientation.Horizontal)
        self.splitter.setHandleWidth(GAP)
        self.splitter.setChildrenCollapsible(False)
        for part in (gains, self._middle, self._right):
            self.splitter.addWidget(part)
        for index, share in enumerate((0, 3, 2)):
            self.splitter.setStretchFactor(index, share)
        box = QHBoxLayout(self)
        box.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)
        box.setContentsMargins(GAP, GAP, GAP, GAP)
        box.addWidget(self.splitter)

    @property
    def is_wide(self) -> bool:
        """Whether all columns are side by side."""
        return bool(self._is_wide)

    def minimumSizeHint(self) -> QSize:
        """Return the room that is enough in tabs."""
        narrow = self.splitter.widget(0)
        assert narrow is not None
        return QSize(narrow.minimumSizeHint().width() + LEAST + 3 * GAP, SHORTEST)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Stand as the width allows."""
        super().resizeEvent(event)
        self.arrange(self.width() >= WIDE)

    def arrange(self, wide: bool) -> None:
        """Stand side by side, or in tabs."""
        if wide == self._is_wide:
            return
        self._is_wide = wide
        self._tabs.setStyleSheet("" if wide else CLOSE)
        chosen = self._tabs.currentWidget()
        middle, right = self._middle.layout(), self._right.layout()
        assert isinstance(middle, QVBoxLayout) and isinstance(right, QVBoxLayout)
        if wide:
            for part in (self._response, self._margins):
                if self._tabs.indexOf(part) >= 0:
                    self._tabs.removeTab(self._tabs.indexOf(part))
            middle.addWidget(self._response)
            right.addWidget(self._margins)
            right.addWidget(self._tabs)
            right.setStretch(1, 1)
            self._right.show()
            for part in (self._response, self._margins):
                part.show()
            self.splitter.setSizes([GAINS, MIDDLE, self.width() - GAINS - MIDDLE - 4 * GAP])
        else:
            middle.addWidget(self._tabs)
            self._tabs.insertTab(0, self._response, "Step")
            self._tabs.insertTab(1, self._margins, "Margins")
            self._right.hide()
            self._tabs.setCurrentIndex(0)
        self._tabs.show()  # what changes its parent is hidden until the next turn of events
        if chosen is not None and self._tabs.indexOf(chosen) >= 0 and wide:
            self._tabs.setCurrentWidget(chosen)


def _column() -> QWidget:
    column = QWidget()
    box = QVBoxLayout(column)
    box.setContentsMargins(0, 0, 0, 0)
    box.setSpacing(GAP)
    return column

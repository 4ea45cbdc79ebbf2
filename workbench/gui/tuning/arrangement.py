"""Where the parts of the tuning screen stand: side by side where there is room, else in tabs."""

from enum import Enum

from PyQt6.QtCore import QSize, Qt
from PyQt6.QtGui import QResizeEvent
from PyQt6.QtWidgets import QHBoxLayout, QLayout, QSplitter, QTabWidget, QVBoxLayout, QWidget

WIDE = 1150
"""From this width on there are three columns [px]."""
GAP = 8
GAINS, MIDDLE = 448, 364
"""Least widths at first, where all stand side by side [px]."""
SHARES = (0.3, 0.3)
"""Of a wide screen, for gains and response; the rest is for margins and tabs."""
CLOSE = "QTabBar::tab { padding: 6px 5px; margin-right: 0; }"
"""For eight tabs side by side in half of a narrow screen, six in a third of a usual one."""
WIDEST_CLOSE = 1400
"""From this width on tabs stand apart [px]."""
LEAST, SHORTEST = 372, 520
"""Width of the tabs, and height of all, in which nothing is cut [px]."""


class Columns(Enum):
    """What stands side by side; the rest is in tabs."""

    ALL = 3
    """Gains, response, and margins with the tabs."""
    GAINS = 2
    """Gains, and tabs."""
    NONE = 1
    """Tabs alone."""


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
        self._gains, self._response = gains, response
        self._margins, self._tabs = margins, tabs
        self._columns: Columns | None = None
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
        for index, share in enumerate((2, 3, 3)):
            self.splitter.setStretchFactor(index, share)
        box = QHBoxLayout(self)
        box.setSizeConstraint(QLayout.SizeConstraint.SetNoConstraint)
        box.setContentsMargins(GAP, GAP, GAP, GAP)
        box.addWidget(self.splitter)

    def minimumSizeHint(self) -> QSize:
        """Return the room that is enough in tabs."""
        return QSize(LEAST + 2 * GAP, SHORTEST)

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Stand as the width allows."""
        super().resizeEvent(event)
        both = self._gains.minimumSizeHint().width() + LEAST + 3 * GAP
        columns = Columns.GAINS if self.width() >= both else Columns.NONE
        self.arrange(Columns.ALL if self.width() >= WIDE else columns)
        style = "" if self.width() >= WIDEST_CLOSE else CLOSE
        if style != self._tabs.styleSheet():
            self._tabs.setStyleSheet(style)

    def arrange(self, columns: Columns) -> None:
        """Stand side by side, or in tabs."""
        if columns is self._columns:
            return
        self._columns = columns
        wide = columns is Columns.ALL
        chosen = self._tabs.currentWidget()
        middle, right = self._middle.layout(), self._right.layout()
        assert isinstance(middle, QVBoxLayout) and isinstance(right, QVBoxLayout)
        if wide:
            for part in (self._gains, self._response, self._margins):
                if self._tabs.indexOf(part) >= 0:
                    self._tabs.removeTab(self._tabs.indexOf(part))
            middle.addWidget(self._response)
            right.addWidget(self._margins)
            right.addWidget(self._tabs)
            right.setStretch(1, 1)
            self._right.show()
            self.splitter.insertWidget(0, self._gains)
            for part in (self._gains, self._response, self._margins):
                part.show()
            gains = max(GAINS, round(SHARES[0] * self.width()))
            response = max(MIDDLE, round(SHARES[1] * self.width()))
            rest = self.width() - gains - response - 4 * GAP
            self.splitter.setSizes([gains, response, rest])
        else:
            middle.addWidget(self._tabs)
            self._tabs.insertTab(0, self._response, "Step")
            self._tabs.insertTab(1, self._margins, "Margins")
            self._right.hide()
            if columns is Columns.GAINS:
                self._tabs.removeTab(self._tabs.indexOf(self._gains))
                self.splitter.insertWidget(0, self._gains)
                self._gains.show()
                gains = min(GAINS, self.width() - LEAST - 3 * GAP)
                self.splitter.setSizes([gains, self.width() - gains - 3 * GAP, 0])
            else:
                self._tabs.insertTab(0, self._gains, "Gains")
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

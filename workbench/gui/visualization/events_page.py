"""What happened, as a table with times."""

from collections.abc import Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QShowEvent
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QLabel,
    QTableWidget,
    QTableWidgetItem,
    QVBoxLayout,
    QWidget,
)

from workbench.gui.charts.ticks import number_text
from workbench.gui.visualization.event_list import MOST, Event, EventList
from workbench.gui.workspace import Workspace
from workbench.link.backplane import Published
from workbench.link.topics import Topic


class EventsPage(QWidget):
    """Table of events, the newest below.

    Args:
        workspace: colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, workspace: Workspace, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = workspace.look
        self._list = EventList()
        self._at_end = True
        self.hint = QLabel(
            "Nothing has happened yet: take-off, landing, warnings and changed "
            "parameters will stand here."
        )
        self.hint.setWordWrap(True)
        self.table = QTableWidget(0, 3)
        self.table.setAccessibleName("Events with their times in s")
        self.table.setHorizontalHeaderLabels(["Time s", "Kind", "What happened"])
        self.table.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.table.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.table.setTabKeyNavigation(False)
        self.table.setShowGrid(False)
        self.table.setWordWrap(False)
        upright, head = self.table.verticalHeader(), self.table.horizontalHeader()
        if upright is not None and head is not None:
            upright.hide()
            head.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
            head.setSectionResizeMode(2, QHeaderView.ResizeMode.Stretch)
            head.setDefaultAlignment(Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter)
        box = QVBoxLayout(self)
        box.setContentsMargins(0, 8, 0, 0)
        box.addWidget(self.hint)
        box.addWidget(self.table, 1)

    def begin(self, topics: Sequence[Topic]) -> None:
        """Forget all: a flight begins."""
        self._list.begin(topics)
        self.table.setRowCount(0)
        self.hint.show()

    def add(self, published: Sequence[Published]) -> None:
        """Show the events of what was published."""
        found = self._list.add(published)
        if not found:
            return
        self.hint.hide()
        bar = self.table.verticalScrollBar()
        if self.isVisible():
            self._at_end = bar is not None and bar.value() >= bar.maximum()
        for event in found:
            self._append(event)
        self._follow()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Show the newest, which were not scrolled to while nobody looked: that lays out all."""
        super().showEvent(event)
        self._follow()

    def _follow(self) -> None:
        if self._at_end and self.isVisible():
            self.table.scrollToBottom()

    @property
    def events(self) -> tuple[Event, ...]:
        """What is shown."""
        return tuple(self._list.events)

    def _append(self, event: Event) -> None:
        if self.table.rowCount() >= MOST:
            self.table.removeRow(0)
        row = self.table.rowCount()
        self.table.insertRow(row)
        for column, text in enumerate((number_text(event.time, 2), event.kind, event.said)):
            item = QTableWidgetItem(text)
            item.setToolTip(text)
            if column == 0:
                item.setTextAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
            self.table.setItem(row, column, item)

"""The page of events: a table with the newest at the bottom."""

from collections import deque
from collections.abc import Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QShowEvent
from PyQt6.QtWidgets import QTableWidget, QWidget

from workbench.common.plain_text import plain_name
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import vbox
from workbench.gui.signals import FlightEvent, events_in
from workbench.gui.tables import text_table, write_cell
from workbench.gui.units import LOG_TIME_UNIT
from workbench.gui.workspace import Workspace
from workbench.link.backplane import Published

MAX_KEPT_EVENTS = 2000
"""Limit of kept events; beyond it the oldest are dropped."""
MAX_EVENT_CHARACTERS = 300
"""Largest number of characters of an event in the table; its tool tip has the rest."""


class EventsPage(QWidget):
    """Table of events, the newest at the bottom.

    Args:
        workspace: colours.

    Attributes:
        events: the shown events.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__()
        self._look = workspace.look
        self.events: deque[FlightEvent] = deque(maxlen=MAX_KEPT_EVENTS)
        self._at_end = True
        self.hint = Label(
            "Nothing has happened yet: take-off, landing, warnings and changed parameters will "
            "appear here."
        )
        self.hint.setWordWrap(True)
        self.table = text_table(QTableWidget(0, 3), "Events with their times in s", wide=2)
        self.table.setHorizontalHeaderLabels(["Time s", "Kind", "What happened"])
        self.table.setWordWrap(False)
        vbox(self.hint, (self.table, 1), of=self, margins=(0, 8, 0, 0))

    def begin(self) -> None:
        """Clear all: a flight begins."""
        self.events.clear()
        self.table.setRowCount(0)
        self.hint.show()

    def add(self, published: Sequence[Published]) -> None:
        """Show the events in published data."""
        found = events_in(published)
        if not found:
            return
        self.events += found
        self.hint.hide()
        bar = self.table.verticalScrollBar()
        if self.isVisible():
            self._at_end = bar is not None and bar.value() >= bar.maximum()
        for event in found:
            self._append(event)
        self._follow()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Scroll to the newest: on a hidden page that would lay out all rows."""
        super().showEvent(event)
        self._follow()

    def _follow(self) -> None:
        if self._at_end and self.isVisible():
            self.table.scrollToBottom()

    def _append(self, event: FlightEvent) -> None:
        if self.table.rowCount() >= MAX_KEPT_EVENTS:
            self.table.removeRow(0)
        row = self.table.rowCount()
        self.table.insertRow(row)
        time, *words = event
        sides = (Qt.AlignmentFlag.AlignRight, *2 * (Qt.AlignmentFlag.AlignLeft,))
        texts = (LOG_TIME_UNIT.number(time), *words)
        for column, (text, side) in enumerate(zip(texts, sides, strict=True)):
            shown = plain_name(text, MAX_EVENT_CHARACTERS)
            set_tip(write_cell(self.table, row, column, shown, side), text)

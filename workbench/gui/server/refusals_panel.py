"""What was refused: how often, and the last ones in words."""

from PyQt6.QtCore import QTime
from PyQt6.QtWidgets import QHBoxLayout, QLabel, QPlainTextEdit, QVBoxLayout, QWidget

from workbench.gui.elided_label import ElidedLabel
from workbench.gui.server.refusal_log import LONGEST, RefusalLog, say_counts
from workbench.gui.style import dressed
from workbench.link.backplane import ServerStatus


class RefusalsPanel(QWidget):
    """A line that counts, and a list that does not grow without bound.

    Attributes:
        counts: the line.
        list: the last refusals, newest below.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._log = RefusalLog()
        self._served = False
        heading = dressed(QLabel("Refusals", self), "heading")
        self.counts = ElidedLabel(say_counts({}), self)
        self.counts.setProperty("class", "muted")
        self.list = QPlainTextEdit(self)
        self.list.setReadOnly(True)
        self.list.setMaximumBlockCount(LONGEST)
        self.list.setLineWrapMode(QPlainTextEdit.LineWrapMode.WidgetWidth)
        self.list.setTabChangesFocus(True)
        self.list.setAccessibleName("What was refused, newest last")
        self.list.setMinimumHeight(46)
        heading.setBuddy(self.list)
        layout = QVBoxLayout(self)
        layout.setContentsMargins(0, 0, 0, 0)
        layout.setSpacing(6)
        top = QHBoxLayout()
        top.setSpacing(16)
        top.addWidget(heading)
        top.addWidget(self.counts, 1)
        layout.addLayout(top)
        layout.addWidget(self.list, 1)

    def show_server(self, server: ServerStatus | None) -> None:
        """Show what a server tells; what earlier ones told stays in the list."""
        if server is None:
            self._served = False
            return
        if not self._served:
            self._served = True
            self._log.begin()
        clock = QTime.currentTime().toString("HH:mm:ss")
        for line in self._log.hear(server.log, server.refusals, clock):
            self.list.appendPlainText(line)
        said = say_counts(server.refusals)
        if said != self.counts.text():
            self.counts.setText(said)

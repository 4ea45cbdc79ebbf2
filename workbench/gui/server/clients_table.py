"""The table of clients, which says so where there is none."""

from PyQt6.QtCore import Qt
from PyQt6.QtGui import QPainter, QPaintEvent
from PyQt6.QtWidgets import QTableView

NOBODY = "No client is connected."


class ClientsTable(QTableView):
    """A table that is not simply blank when it is empty."""

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint the rows, or that there are none."""
        super().paintEvent(event)
        model, port = self.model(), self.viewport()
        if model is None or port is None or event is None or model.rowCount() > 0:
            return
        painter = QPainter(port)
        painter.setPen(self.palette().placeholderText().color())
        painter.drawText(port.rect(), Qt.AlignmentFlag.AlignCenter, NOBODY)

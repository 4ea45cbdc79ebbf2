"""The curves of a chart in numbers, below it."""

from collections.abc import Mapping, Sequence

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import (
    QAbstractItemView,
    QHeaderView,
    QSizePolicy,
    QTableWidget,
    QTableWidgetItem,
    QWidget,
)

from workbench.gui.charts.chart_picture import StatisticsRow
from workbench.gui.charts.ticks import number_text

NAMES = ("Signal", "Unit", "Last", "Min", "Max", "Mean", "RMS", "Std dev")
HELP = (
    "Name of the signal",
    "Unit that is shown",
    "Newest value that is seen",
    "Least value that is seen",
    "Largest value that is seen",
    "Mean of the samples that are seen",
    "Root of the mean square of the samples",
    "Standard deviation of the samples",
)
MOST_ROWS = 6
"""That are seen without a scroll bar."""


class StatisticsTable(QTableWidget):
    """Shows rows; only the cells that have changed are written.

    Args:
        parent: whose life it shares.
    """

    def __init__(self, parent: QWidget | None = None) -> None:
        super().__init__(0, 0, parent)
        self._heads: list[str] = []
        self.setAccessibleName("Statistics of what the chart shows")
        self.setEditTriggers(QAbstractItemView.EditTrigger.NoEditTriggers)
        self.setSelectionBehavior(QAbstractItemView.SelectionBehavior.SelectRows)
        self.setTabKeyNavigation(False)
        self.setShowGrid(False)
        self.setFrameShape(self.Shape.NoFrame)
        self.setHorizontalScrollBarPolicy(Qt.ScrollBarPolicy.ScrollBarAsNeeded)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        upright = self.verticalHeader()
        if upright is not None:
            upright.hide()
            upright.setDefaultSectionSize(self.fontMetrics().height() + 6)
        head = self.horizontalHeader()
        if head is not None:
            head.setSectionResizeMode(QHeaderView.ResizeMode.ResizeToContents)
            head.setHighlightSections(False)
            head.setStretchLastSection(False)

    def show_rows(self, rows: Sequence[StatisticsRow], marks: Mapping[str, float]) -> None:
        """Show statistics, and values at the cursors with these names and times [s]."""
        self._show_heads(marks)
        if self.rowCount() != len(rows):
            self.setRowCount(len(rows))
            self._fit()
        for index, row in enumerate(rows):
            for column, text in enumerate(_texts(row)):
                self._write(index, column, text)

    def text_at(self, row: int, column: str) -> str:
        """Return what stands in the column that begins with a name."""
        index = next(i for i, head in enumerate(self._heads) if head.startswith(column))
        item = self.item(row, index)
        return item.text() if item is not None else ""

    def _show_heads(self, marks: Mapping[str, float]) -> None:
        heads = [*NAMES, *(f"{name} at {number_text(marks[name], 3)} s" for name in sorted(marks))]
        if len(marks) == 2:
            way = marks["B"] - marks["A"]
            heads.append(f"B − A over {number_text(way, 3)} s")
        if heads == self._heads:
            return
        self._heads = heads
        self.setColumnCount(len(heads))
        self.setHorizontalHeaderLabels(heads)
        for column, name in enumerate(heads):
            item = self.horizontalHeaderItem(column)
            if item is not None:
                item.setToolTip(HELP[column] if column < len(HELP) else name)
        self._fit()

    def _write(self, row: int, column: int, text: str) -> None:
        item = self.item(row, column)
        if item is None:
            item = QTableWidgetItem()
            side = Qt.AlignmentFlag.AlignLeft if column < 2 else Qt.AlignmentFlag.AlignRight
            item.setTextAlignment(side | Qt.AlignmentFlag.AlignVCenter)
            self.setItem(row, column, item)
        if item.text() != text:
            item.setText(text)

    def _fit(self) -> None:
        head, upright = self.horizontalHeader(), self.verticalHeader()
        if head is not None and upright is not None:
            rows = min(MOST_ROWS, max(1, self.rowCount()))
            self.setFixedHeight(head.sizeHint().height() + rows * upright.defaultSectionSize() + 4)


def _texts(row: StatisticsRow) -> list[str]:
    found = row.statistics
    numbers = [found.last, found.least, found.largest, found.mean, found.rms, found.deviation]
    numbers += row.marks
    if len(row.marks) == 2:
        numbers.append(row.marks[1] - row.marks[0])
    shown = [number_text(row.unit.shown(value), row.decimals + 1) for value in numbers]
    return [row.label, row.unit.symbol or "–", *shown]

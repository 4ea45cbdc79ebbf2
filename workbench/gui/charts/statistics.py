"""Statistics of a chart's curves within the visible window, and their table."""

import math
from collections.abc import Mapping, Sequence

import numpy as np
from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QSizePolicy, QTableWidget

from workbench.common.plain_text import plain_name
from workbench.gui.labels import set_tip
from workbench.gui.tables import table_heads, text_table, write_cell

STATISTICS_COLUMNS = {
    "Signal": "Name of the signal",
    "Unit": "Unit that is shown",
    "Last": "Newest value in view",
    "Min": "Least value in view",
    "Max": "Largest value in view",
    "Mean": "Mean of the samples in view",
    "RMS": "Root of the mean square of the samples",
    "Std dev": "Standard deviation of the samples",
}
"""Meaning of the columns, by heading."""
MAX_STATISTICS_ROWS = 6
"""Number of rows visible without a scroll bar."""


def window_statistics(
    time: np.ndarray, values: np.ndarray, left: float, right: float
) -> tuple[float, ...]:
    """Return the numbers of a row of the table, from last to deviation; NaN without samples.

    They are of the finite samples between two times [s].

    Args:
        time: times of the samples (n), increasing [s].
        values: (n).
        left: start of the window [s].
        right: end of the window [s].
    """
    seen = values[np.searchsorted(time, left) : np.searchsorted(time, right, side="right")]
    seen = np.asarray(seen[np.isfinite(seen)], dtype=float)
    if len(seen) == 0:
        return (math.nan,) * 6
    rms = math.sqrt(float(np.dot(seen, seen)) / len(seen))
    return tuple(map(float, (seen[-1], seen.min(), seen.max(), seen.mean(), rms, seen.std())))


def value_at(time: np.ndarray, values: np.ndarray, when: float) -> float:
    """Return the value of the sample nearest to a time [s]; NaN outside the samples."""
    if len(time) == 0:
        return math.nan
    step = (time[-1] - time[0]) / max(1, len(time) - 1)
    if not time[0] - step <= when <= time[-1] + step:
        return math.nan
    after = min(int(np.searchsorted(time, when)), len(time) - 1)
    before = max(after - 1, 0)
    nearest = before if when - time[before] < time[after] - when else after
    return float(values[nearest])


class StatisticsTable(QTableWidget):
    """Shows rows."""

    def __init__(self) -> None:
        super().__init__(0, 0)
        self._heads: list[str] = []
        text_table(self, "Statistics of the curves in view")
        self.setFrameShape(self.Shape.NoFrame)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Fixed)
        table_heads(self)[1].setDefaultSectionSize(self.fontMetrics().height() + 6)

    def show_table(self, heads: Mapping[str, str], rows: Sequence[Sequence[str]]) -> None:
        """Show texts under headings with explanations."""
        if list(heads) != self._heads or self.rowCount() != len(rows):
            self._show_heads(heads)
            self.setRowCount(len(rows))
            self._fit()
        for index, row in enumerate(rows):
            for column, text in enumerate(row):
                side = Qt.AlignmentFlag.AlignLeft if column < 2 else Qt.AlignmentFlag.AlignRight
                write_cell(self, index, column, plain_name(text), side)

    def _show_heads(self, heads: Mapping[str, str]) -> None:
        if list(heads) == self._heads:
            return
        self._heads = list(heads)
        self.setColumnCount(len(heads))
        self.setHorizontalHeaderLabels(self._heads)
        for column, help in enumerate(heads.values()):
            item = self.horizontalHeaderItem(column)
            if item is not None:
                set_tip(item, help)

    def _fit(self) -> None:
        """Fit the height to the rows, up to `MAX_STATISTICS_ROWS`."""
        head, upright = table_heads(self)
        rows = min(MAX_STATISTICS_ROWS, max(1, self.rowCount()))
        self.setFixedHeight(head.sizeHint().height() + rows * upright.defaultSectionSize() + 4)

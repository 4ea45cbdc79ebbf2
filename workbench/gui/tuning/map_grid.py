"""Where the values of two gains stand on a map."""

from dataclasses import dataclass

import numpy as np
from PyQt6.QtCore import QPointF, QRectF


@dataclass(frozen=True)
class MapGrid:
    """Places of a map's points, each in the middle of its cell.

    Attributes:
        box: of the map, in the widget.
        x: values along the columns.
        y: values along the rows, upwards.
    """

    box: QRectF
    x: np.ndarray
    y: np.ndarray

    def cell(self, column: float, row: float) -> QPointF:
        """Return where a column and a row stand, whole ones or between."""
        return QPointF(
            self.box.left() + (column + 0.5) / len(self.x) * self.box.width(),
            self.box.bottom() - (row + 0.5) / len(self.y) * self.box.height(),
        )

    def place(self, x: float, y: float) -> QPointF:
        """Return where gains stand; at the edge those beyond it."""
        column = np.interp(x, self.x, np.arange(len(self.x)))
        row = np.interp(y, self.y, np.arange(len(self.y)))
        return self.cell(float(column), float(row))

    def gains(self, place: QPointF) -> tuple[float, float] | None:
        """Return the gains at a place, None beside the map."""
        if not self.box.contains(place):
            return None
        column = (place.x() - self.box.left()) / self.box.width() * len(self.x) - 0.5
        row = (self.box.bottom() - place.y()) / self.box.height() * len(self.y) - 0.5
        return (
            float(np.interp(column, np.arange(len(self.x)), self.x)),
            float(np.interp(row, np.arange(len(self.y)), self.y)),
        )

"""The scale beside a depth image."""

import numpy as np
from PyQt6.QtCore import QRectF
from PyQt6.QtGui import QPainter, QPaintEvent
from PyQt6.QtWidgets import QWidget

from workbench.gui.charts.colour_scale import paint_scale
from workbench.gui.theme import Look
from workbench.gui.visualization.depth_picture import DepthScale


class ScaleBar(QWidget):
    """Shows which colour is how far.

    Args:
        look: colours.
        table: from near to far.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, table: np.ndarray, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look, self._table = look, table
        self._scale = DepthScale(0.0, 1.0)
        self.setFixedWidth(74)
        self.setAccessibleName("Scale of the depth in m")
        look.changed.connect(self.update)

    def show_scale(self, scale: DepthScale) -> None:
        """Show another scale."""
        if scale != self._scale:
            self._scale = scale
            self.setAccessibleDescription(f"from {scale.low:g} to {scale.high:g} m")
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        painter = QPainter(self)
        box = QRectF(self.rect()).adjusted(8, 0, 0, 0)
        ends = self._scale.low, self._scale.high
        paint_scale(painter, box, *ends, self._table, self._look.colour("ink"), "Depth m")

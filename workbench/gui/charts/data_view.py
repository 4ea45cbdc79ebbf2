"""The area of a chart's curves, which reports a dragged box or a sideways drag."""

import pyqtgraph as pg
from PyQt6.QtCore import QPointF, QRectF, Qt, pyqtSignal
from pyqtgraph.GraphicsScene.mouseEvents import MouseDragEvent

MIN_ZOOM_BOX_PX = 8.0
"""Least size of a dragged box that zooms [pixels]."""


class DataView(pg.ViewBox):
    """The area of the curves; it reports a dragged box, and leaves the zooming to others."""

    boxed = pyqtSignal(QRectF)
    """Dragged box in pixels of the view, y downwards."""
    slid = pyqtSignal(float)
    """Dragged sideways with Shift, by this much since the last signal [s]."""

    def __init__(self) -> None:
        super().__init__(enableMenu=False, defaultPadding=0.0)
        self.disableAutoRange()

    def mouseDragEvent(self, event: MouseDragEvent, axis: int | None = None) -> None:
        """Draw a box; a flat one takes the full height."""
        if axis is not None or event.button() != Qt.MouseButton.LeftButton:
            event.ignore()
            return
        event.accept()
        if event.modifiers() & Qt.KeyboardModifier.ShiftModifier:
            now, before = self.mapToView(event.pos()), self.mapToView(event.lastPos())
            self.slid.emit(now.x() - before.x())
            return
        start = event.buttonDownPos()
        if not event.isFinish():
            self.updateScaleBox(start, event.pos())
            return
        self.rbScaleBox.hide()
        box = QRectF(QPointF(start), QPointF(event.pos())).normalized()
        if box.height() < MIN_ZOOM_BOX_PX:
            box.setTop(0.0)
            box.setHeight(self.height())
        box &= self.rect()
        if box.width() >= MIN_ZOOM_BOX_PX:
            self.boxed.emit(box)

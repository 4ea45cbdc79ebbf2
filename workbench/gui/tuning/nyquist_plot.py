"""The Nyquist plot of open loops, with the disk that a disk margin keeps free."""

from collections.abc import Sequence

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QEvent, QPointF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QShowEvent, QWheelEvent

from workbench.gui.charts.curve import CurveStyle, make_pen
from workbench.gui.charts.numbered_curve import MEASURED_POINT_PX
from workbench.gui.instruments.plane_view import UNIT_CIRCLE, style_plot
from workbench.gui.tuning.drawn_loop import DrawnLoop, loop_with_margins
from workbench.gui.tuning.limits import find_limit
from workbench.gui.wheel import zoom_notches
from workbench.gui.workspace import Workspace

NYQUIST_RANGE = {"xRange": (-3.2, 1.6), "yRange": (-2.4, 2.4)}
"""Initially visible part of the plane, as in `workbench judge`."""
NYQUIST_HEIGHT_LIMITS = (0.04, 400.0)
"""Smallest and largest visible height."""
MAX_DISK_EXTENT = 60.0
"""Largest extent of a drawn disk; its edge is then almost straight."""
CRITICAL_POINT_PX, CURSOR_DOT_PX = 12.0, 8.0
"""Sizes of the mark at -1, and of a point at the cursor [px]."""
NYQUIST_READING_SHARE = 0.08
"""Largest distance from the mouse at which a curve is read, as a share of the height."""
NYQUIST_DISK_LIMIT = find_limit("disk_margin")
MIN_NYQUIST_SIZE_PX = (200, 200)
NYQUIST_HINT = "Not known yet: the analyst is computing it"


class NyquistPlot(pg.PlotWidget):
    """Draws open loops in the complex plane.

    Ctrl and wheel: zoom around the mouse. Drag: zoom to a box. Double click: all.

    Args:
        workspace: source of colours.

    Attributes:
        caption: the disk margin, or why nothing is drawn.
        dots: (N) points of the curves at the cursor.
    """

    pointed = pyqtSignal(object)
    """Frequency of the curve under the mouse [rad/s], None without one."""

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(enableMenu=False)
        self._look = workspace.look
        self._loops: tuple[DrawnLoop, ...] = ()
        self._cursor: float | None = None
        self.caption = NYQUIST_HINT
        self.dots = np.empty(0, dtype=complex)
        self._curves: list[pg.PlotCurveItem | pg.ScatterPlotItem] = []
        self._real_axis = pg.InfiniteLine(0.0, 0.0)
        circle = UNIT_CIRCLE[:-1]  # without the gap
        self._circle = pg.PlotCurveItem(circle.real, circle.imag, antialias=True)
        self._disk = pg.PlotCurveItem(antialias=True)
        self._critical = pg.ScatterPlotItem([-1.0], [0.0], symbol="x", size=CRITICAL_POINT_PX)
        self._dots = pg.ScatterPlotItem(size=CURSOR_DOT_PX)
        for item in (self._real_axis, self._circle, self._disk, self._critical, self._dots):
            self.addItem(item, ignoreBounds=True)
        self._dots.setZValue(1)
        self.hideButtons()
        self.setLabel("bottom", "Re")
        self.setLabel("left", "Im")
        view = self.plotItem.vb
        view.setAspectLocked(True)
        view.setLeftButtonAction("rect")
        low, high = NYQUIST_HEIGHT_LIMITS
        view.setLimits(minYRange=low, maxYRange=high)
        self.setAccessibleName("Nyquist curve of the loop, with the disk of the disk margin")
        self.scene().sigMouseMoved.connect(self._hover)
        workspace.look.changed.connect(self._apply_colours)
        self._apply_colours()
        self.reset()

    def show_loops(self, loops: Sequence[DrawnLoop]) -> None:
        """Draw loops."""
        self._loops = tuple(loops)
        self._draw()

    def show_window(self, left: float, right: float) -> None:
        """Do nothing: the plane has no frequency axis."""

    def set_cursor(self, frequency: float | None) -> None:
        """Mark a frequency [rad/s] on all curves, or none."""
        if frequency != self._cursor:
            self._cursor = frequency
            self._show_dots()

    def reset(self) -> None:
        """Show the surroundings of -1."""
        self.setRange(padding=0.0, **NYQUIST_RANGE)

    def minimumSizeHint(self) -> QSize:
        """Return the least legible size."""
        return QSize(*MIN_NYQUIST_SIZE_PX)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom around the mouse while Ctrl is held."""
        if zoom_notches(event):
            super().wheelEvent(event)

    def mouseDoubleClickEvent(self, event: QMouseEvent | None) -> None:
        """Undo all zooming."""
        self.reset()

    def leaveEvent(self, event: QEvent | None) -> None:
        """Report that the mouse has left."""
        super().leaveEvent(event)
        self.pointed.emit(None)

    def showEvent(self, event: QShowEvent | None) -> None:
        """Draw changes made while it was hidden."""
        super().showEvent(event)
        self._draw()

    def point(self, place: complex | None) -> None:
        """Report the frequency of the curve nearest to a place, if it is near."""
        _, (low, high) = self.viewRange()
        found: tuple[float, float | None] = (NYQUIST_READING_SHARE * (high - low), None)
        for loop in self._loops if place is not None else ():
            way = np.abs(loop.open_loop - place)
            if np.isfinite(way).any():
                nearest = int(np.nanargmin(way))
                if way[nearest] < found[0]:
                    found = float(way[nearest]), float(loop.frequency[nearest])
        self.pointed.emit(found[1])

    def _hover(self, at: QPointF) -> None:
        inside = self.plotItem.vb.sceneBoundingRect().contains(at)
        place = self.plotItem.vb.mapSceneToView(at)
        self.point(complex(place.x(), place.y()) if inside else None)

    def _draw(self) -> None:
        if not self.isVisible():
            return
        while self._curves:
            self.removeItem(self._curves.pop())
        for loop in self._loops:
            self._draw_loop(loop)
        judged = loop_with_margins(self._loops)
        margins = judged.margins if judged is not None else None
        margin = margins.disk_margin if margins is not None else 0.0  # 0 if unstable
        self._disk.setData(*disk_edge(margin) if margin else ([], []))
        self.caption = NYQUIST_HINT
        if self._loops:
            said = f"disk {NYQUIST_DISK_LIMIT.number_text(margin)}" if margin else "unstable"
            self.caption = said if judged is not None else ""
        size = f"{self.font().pointSizeF():g}pt"
        self.setTitle(self.caption or None, color=self._look.colour("muted"), size=size)
        self._show_dots()

    def _draw_loop(self, loop: DrawnLoop) -> None:
        """Draw a loop, and faintly its mirror image; a measurement as points."""
        response, colour = loop.open_loop, self._look.curve(loop.colour)
        if loop.style is CurveStyle.POINTS:
            points = response[np.isfinite(response)]
            self._add(pg.ScatterPlotItem(size=MEASURED_POINT_PX, pen=None, brush=colour), points)
            return
        ground, ratio = self._look.colour("field"), self.devicePixelRatioF()
        for values, style in ((response.conj(), CurveStyle.FAINT), (response, loop.style)):
            pen = make_pen(colour, style, ground, ratio)
            self._add(pg.PlotCurveItem(pen=pen, antialias=True, connect="finite"), values)

    def _add(self, item: pg.PlotCurveItem | pg.ScatterPlotItem, values: np.ndarray) -> None:
        item.setData(values.real, values.imag)
        self.addItem(item, ignoreBounds=True)
        self._curves.append(item)

    def _show_dots(self) -> None:
        """Mark the points of the curves at the cursor."""
        at, loops = self._cursor, self._loops
        marked = [(loop, loop.at(at, loop.open_loop)) for loop in loops if at is not None]
        self.dots = np.array([dot for _, dot in marked])
        brushes = [pg.mkBrush(self._look.curve(loop.colour)) for loop, _ in marked]
        self._dots.setData(self.dots.real, self.dots.imag, brush=brushes)

    def _apply_colours(self) -> None:
        """Apply the colours of the look."""
        style_plot(self, self._look)
        colour = self._look.colour
        self._real_axis.setPen(colour("line"))
        self._circle.setPen(pg.mkPen(colour("muted"), style=Qt.PenStyle.DashLine))
        self._disk.setPen(pg.mkPen(colour("bad"), width=1.5))
        self._critical.setPen(pg.mkPen(colour("bad"), width=2.0))
        self._dots.setPen(colour("field"))
        self._draw()


def disk_edge(margin: float) -> tuple[np.ndarray, np.ndarray]:
    """Return the edge of the disk that a loop with a disk margin alpha (skew 0) avoids.

    Its diameter is on the real axis, from -(2 + alpha) / (2 - alpha) to the inverse of that.
    """
    share = min(0.5 * margin, 1.0 - 1.0 / MAX_DISK_EXTENT)
    near, far = (1.0 - share) / (1.0 + share), (1.0 + share) / (1.0 - share)
    radius = 0.5 * (far - near)
    edge = radius * UNIT_CIRCLE[:-1] - 0.5 * (near + far)  # without the gap
    return edge.real, edge.imag

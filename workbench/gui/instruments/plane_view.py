"""A plane with one scale along both axes, as of a map: pyqtgraph's view in colours of the look."""

import numpy as np
import pyqtgraph as pg
from PyQt6.QtCore import QEvent, QPointF, QRectF, Qt
from PyQt6.QtGui import QFont, QPen, QResizeEvent
from PyQt6.QtWidgets import QGraphicsItem

from workbench.common.plain_text import html_text
from workbench.gui.theme import Look

UNIT_CIRCLE = np.append(np.exp(1j * np.linspace(0.0, 2.0 * np.pi, 181)), np.nan)
"""Points of a circle, and a gap."""


def style_plot(plot: pg.PlotWidget, look: Look) -> None:
    """Give a plot and its axes the colours of the look, and the font."""
    plot.setBackground(look.colour("card"))
    plot.getViewBox().setBackgroundColor(look.colour("field"))
    for axis in map(plot.getAxis, ("bottom", "left")):
        axis.setStyle(tickLength=0)
        style_axis(axis, look, plot.font())


def style_axis(
    axis: pg.AxisItem, look: Look, font: QFont, pen: str | None = "muted", text: str = "muted"
) -> None:
    """Give an axis a font and colours of the look.

    Args:
        axis: the axis.
        look: source of colours.
        font: font of its name and its numbers.
        pen: colour of its lines, None for no lines.
        text: colour of its name and its numbers.
    """
    axis.setTickFont(font)
    axis.label.setFont(font)
    axis.setPen(look.colour(pen) if pen is not None else None)
    axis.setTextPen(look.colour(text))


class PlaneView(pg.GraphicsView):
    """Items in a plane; subclasses colour them in `apply_colours`.

    Args:
        look: source of colours.
        name: what it shows, for a screen reader.

    Attributes:
        look: source of colours.
        view: pyqtgraph's view of the plane.
        scale: scale of the colours beside it, None without one.
    """

    def __init__(self, look: Look, name: str) -> None:
        super().__init__(background=look.colour("card"))
        self.look = look
        self.view = pg.ViewBox(
            lockAspect=True, enableMenu=False, enableMouse=False, defaultPadding=0.0
        )
        self._layout = pg.GraphicsLayout()
        self._layout.setContentsMargins(0.0, 0.0, 0.0, 0.0)
        self._layout.addItem(self.view, 0, 0)
        self._hint = pg.TextItem(anchor=(0.5, 0.5))
        self._hint.setParentItem(self.view)
        self.scale: pg.ColorBarItem | None = None
        self._scaled: tuple[object, ...] = ()
        self.setCentralItem(self._layout)
        self.setAccessibleName(name)
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)
        self.setMinimumSize(80, 80)
        look.changed.connect(self.apply_colours)

    def apply_colours(self) -> None:
        """Apply the colours of the look, and the font."""
        self.setBackground(self.look.colour("card"))
        self._hint.setColor(self.look.colour("muted"))
        if self.scale is not None:
            for axis in (self.scale.axis, self.scale.getAxis("left")):
                style_axis(axis, self.look, self.font(), pen="line")

    @property
    def hint(self) -> str:
        """Why there is nothing to show, "" if there is something."""
        return str(self._hint.toPlainText())

    def show_hint(self, hint: str) -> None:
        """Show why there is nothing to show; "" for nothing."""
        if hint != self.hint:
            self._hint.setPlainText(hint)
            self._place_hint()

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Place the hint in the middle."""
        super().resizeEvent(event)
        if hasattr(self, "_hint"):
            self._place_hint()

    def _place_hint(self) -> None:
        self._hint.setTextWidth(max(60.0, 0.9 * self.view.width()))
        self._hint.setPos(0.5 * self.view.width(), 0.5 * self.view.height())

    def show_scale(self, table: np.ndarray, low: float, high: float, name: str) -> None:
        """Show a scale beside the plane.

        Args:
            table: colours (N, 3) from low to high.
            low: value at the lower end.
            high: value at the upper end.
            name: name of the values, with the unit.
        """
        shown = (table.tobytes(), low, high, name)
        if shown == self._scaled:  # a new colour map lays everything out again
            return
        self._scaled = shown
        if self.scale is None:
            self.scale = pg.ColorBarItem(width=12, interactive=False, colorMapMenu=False)
            self._layout.addItem(self.scale, 0, 1)
            self._layout.setContentsMargins(0.0, 8.0, 0.0, 8.0)  # for the numbers at its ends
            self.apply_colours()
        self.scale.setColorMap(pg.ColorMap(None, table))
        self.scale.setLevels((low, high))
        self.scale.getAxis("left").setLabel(html_text(name))

    def add(self, *items: QGraphicsItem | pg.PlotCurveItem) -> None:
        """Add items to the plane."""
        for item in items:
            self.view.addItem(item, ignoreBounds=True)

    def pen(
        self, name: str, width: float = 1.0, style: Qt.PenStyle = Qt.PenStyle.SolidLine
    ) -> QPen:
        """Return a pen in a colour of the look, with a width in layout pixels."""
        width *= self.devicePixelRatioF()  # Qt takes it in screen pixels
        return pg.mkPen(self.look.colour(name), width=width, style=style)

    def show_area(self, area: QRectF) -> None:
        """Show an area of the plane completely."""
        self.view.setRange(area, padding=0.0)

    def place_at(self, at: QPointF) -> QPointF:
        """Return the place in the plane at a position in the widget."""
        return QPointF(self.view.mapSceneToView(self.mapToScene(at.toPoint())))

    def position_of(self, x: float, y: float) -> QPointF:
        """Return the position in the widget of a place in the plane."""
        return QPointF(self.mapFromScene(self.view.mapViewToScene(QPointF(x, y))))

    def changeEvent(self, event: QEvent | None) -> None:
        """Adapt to another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange and hasattr(self, "view"):
            self.apply_colours()

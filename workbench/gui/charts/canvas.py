"""The drawing area of a chart and its mouse input, made of views and axes of pyqtgraph."""

import dataclasses
import math
from functools import partial

import pyqtgraph as pg
from PyQt6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QFontMetricsF, QMouseEvent, QPainter, QPen, QTransform, QWheelEvent
from PyQt6.QtWidgets import QSizePolicy

from workbench.common.plain_text import html_text, plain_name
from workbench.gui.charts.content import ChartAxis, ChartContent, CurveDot
from workbench.gui.charts.data_view import DataView
from workbench.gui.charts.number_axis import WIDEST_AXIS_NUMBER, NumberAxis
from workbench.gui.charts.numbered_curve import NumberedCurve, end_texts, spread_positions
from workbench.gui.charts.statistics import value_at
from workbench.gui.charts.ticks import Scale
from workbench.gui.instruments.plane_view import style_axis
from workbench.gui.theme import Look
from workbench.gui.wheel import zoom_notches

MIN_CANVAS_HEIGHT_PX = 120
"""Least height at which a curve is readable [pixels]; a board with more charts scrolls."""
CROSSHAIR_DOT_PX = 7
"""Diameter of the dots at the crosshair [pixels]."""
AXIS_OVERHANG_PX = 40
"""Space for the numbers at the ends of an axis beyond those ends [pixels]."""
MAX_CAPTION_CHARACTERS = 300
"""Largest number of characters in the caption of a chart."""


class Canvas(pg.GraphicsLayoutWidget):
    """Draws the content of a chart.

    Args:
        look: source of colours.

    Attributes:
        view: the area of the curves.
        cursor_time: position of the crosshair [s], None without one.
        content: the shown content.
    """

    hovered = pyqtSignal(object)
    """Time under the mouse [s], None when it has left."""
    turned = pyqtSignal(float, float, float, bool)
    """Ctrl and wheel: time and share of height under the mouse, factor, whether over an axis."""
    boxed = pyqtSignal(float, float, float, float)
    """A box was dragged: its first and last time, lower and upper share of the height."""
    reset_wanted = pyqtSignal()
    """Double click."""
    mark_moved = pyqtSignal(str, float)
    """Cursor A or B was dragged to a time [s]."""
    resized = pyqtSignal()
    """The size has changed, so the content must be made again."""

    def __init__(self, look: Look) -> None:
        super().__init__()
        self._look = look
        self.content = ChartContent()
        self._mouse: float | None = None
        self._focus_shown = False
        self.cursor_time: float | None = None
        self.view = DataView()
        self.setFocusPolicy(Qt.FocusPolicy.NoFocus)  # keys go to the chart
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(160, MIN_CANVAS_HEIGHT_PX)
        self.scene().setItemIndexMethod(self.scene().ItemIndexMethod.NoIndex)
        self._grid = self.ci.layout  # columns: axis, curves, their names, further axes
        self._grid.setSpacing(0.0)
        self.addItem(self.view, 0, 1)
        self._bottom = self._make_axis("bottom", 1, 1)
        self._axes = [self._make_axis("left", 0, 0)]
        for axis in (self._bottom, self._axes[0]):
            axis.linkToView(self.view)
            axis.setGrid(255)
        self._groups: list[pg.ItemGroup] = []
        self._curves: list[NumberedCurve] = []
        self._guides: list[pg.PlotCurveItem] = []
        self._marks: list[pg.InfiniteLine] = []
        self._marks_key: tuple[object, ...] = ()
        self._named: tuple[object, ...] = ()
        self._zero = pg.InfiniteLine(0.0, angle=0)
        self._cross = pg.InfiniteLine(angle=90, label="", labelOpts={"position": 0.93})
        self._dots = pg.ScatterPlotItem(size=CROSSHAIR_DOT_PX, pxMode=True)
        for item in (self._zero, self._cross, self._dots):
            self.view.addItem(item, ignoreBounds=True)
        self._cross.hide()
        self._cross.setZValue(10)
        self._dots.setZValue(11)
        self._state = pg.TextItem(anchor=(0.0, 0.0))
        self._hint = pg.TextItem(anchor=(0.5, 0.5))
        for item in (self._state, self._hint):
            item.setParentItem(self.view)
            item.setZValue(12)
        self.view.sigResized.connect(self._resize)
        self.view.boxed.connect(self._box)
        look.changed.connect(self._apply_colours)
        self._apply_colours()

    def sizeHint(self) -> QSize:
        """Return a suitable size for a chart."""
        return QSize(420, 200)

    @property
    def columns(self) -> int:
        """Number of columns for curves: one for two pixels of the screen."""
        return max(50, int(0.5 * self.view.width() * self.devicePixelRatioF()))

    def show_content(self, content: ChartContent) -> None:
        """Show a content."""
        if content.caption != self.content.caption:
            self.resetCachedContent()
        self.content = content
        self._show_axes()
        self._show_curves()
        self._show_guides()
        self._show_marks()
        self._show_words()
        self._follow_mouse()

    def move_on(self, left: float, right: float) -> None:
        """Show the same curves in a window that has moved, between two times [s]."""
        follows = self.content.origin == self.content.right
        origin = right if follows else self.content.origin
        self.content = dataclasses.replace(self.content, left=left, right=right, origin=origin)
        self._place()
        self._follow_mouse()

    def forget_mouse(self) -> None:
        """Stop moving the crosshair with the mouse."""
        self._mouse = None

    def set_cursor(self, time: float | None) -> None:
        """Set the crosshair to a time [s], or remove it."""
        if time != self.cursor_time:
            self.cursor_time = time
            self._show_cursor()

    def set_focus_shown(self, shown: bool) -> None:
        """Frame the curves while this chart has the keyboard focus."""
        self._focus_shown = shown
        colour = self._look.colour("accent" if shown else "line")
        self.view.setBorder(pg.mkPen(colour, width=2 if shown else 1))

    def drawBackground(self, painter: QPainter | None, rect: QRectF) -> None:
        """Paint grid and numbers once for many frames, as they take most of the time."""
        super().drawBackground(painter, rect)
        if painter is None:
            return
        painter.fillRect(self.view.sceneBoundingRect(), self._look.colour("field"))
        for axis in (self._bottom, *self._axes):
            if axis.isVisible():
                painter.save()
                painter.translate(axis.scenePos())
                axis.paint(painter, None, None)
                painter.restore()
                painter.save()
                painter.translate(axis.label.scenePos())
                axis.label.document().drawContents(painter)
                painter.restore()
        self._paint_caption(painter)

    def _paint_caption(self, painter: QPainter) -> None:
        """Paint the caption above the picture if it does not overlap the name of the first axis."""
        box, name = self.view.sceneBoundingRect(), self._axes[0].label
        end = box.width() + self._grid.columnMaximumWidth(2)
        room = QRectF(box.left(), 0.0, end, box.top() - 3.0)
        room.setLeft(name.mapRectToScene(name.boundingRect()).right())
        painter.setFont(self.font())
        caption = plain_name(self.content.caption, MAX_CAPTION_CHARACTERS)
        if painter.fontMetrics().horizontalAdvance(caption) > room.width():
            return
        painter.setPen(self._look.colour("ink"))
        side = Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignBottom
        painter.drawText(room, int(side), caption)

    def changeEvent(self, event: QEvent | None) -> None:
        """Adapt to another font."""
        super().changeEvent(event)
        if event is not None and event.type() == QEvent.Type.FontChange and hasattr(self, "_hint"):
            self._apply_colours()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom around the mouse while Ctrl is held, else let the page scroll."""
        notches = zoom_notches(event)
        if event is None or not notches:
            return
        place = self._scene_point(event.position())
        box = self.view.sceneBoundingRect()
        shift = bool(event.modifiers() & Qt.KeyboardModifier.ShiftModifier)
        over_axis = shift or not box.left() <= place.x() <= box.right()
        share = (box.bottom() - place.y()) / max(box.height(), 1.0)
        self.turned.emit(self._time_at(place.x()), share, 0.85**notches, over_axis)

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Follow the mouse."""
        super().mouseMoveEvent(event)
        if event is None:
            return
        place = self._scene_point(event.position())
        inside = self.view.sceneBoundingRect().contains(place)
        self._mouse = place.x() if inside else None
        self.hovered.emit(self._time_at(place.x()) if inside else None)

    def mouseDoubleClickEvent(self, event: QMouseEvent | None) -> None:
        """Undo all zooming."""
        self.reset_wanted.emit()

    def leaveEvent(self, event: QEvent | None) -> None:
        """Report that the mouse has left."""
        super().leaveEvent(event)
        self._mouse = None
        self.hovered.emit(None)

    def _scene_point(self, place: QPointF) -> QPointF:
        return self.mapToScene(place.toPoint())

    def _time_at(self, x: float) -> float:
        """Return the time at a pixel of the graphics scene [s]."""
        place = self.view.mapSceneToView(QPointF(x, 0.0)).x() + self.content.origin
        return self.content.x_scale.value_of(place)

    def _place_at(self, time: float) -> float:
        """Return the position of a time [s] along the view's axis."""
        return self.content.x_scale.place(time) - self.content.origin

    def _said_at(self, time: float) -> str:
        """Return a time [s] as the axis writes it, with its unit."""
        content = self.content
        said = content.x_scale.text(time - content.origin, 3)
        return f"{said}\N{NO-BREAK SPACE}{content.x_unit}".strip()

    def _follow_mouse(self) -> None:
        """Keep the crosshair under the mouse while the picture moves."""
        if self._mouse is not None:
            self.cursor_time = self._time_at(self._mouse)
        self._show_cursor()

    def _resize(self) -> None:
        self.resetCachedContent()
        self.resized.emit()

    def _box(self, box: QRectF) -> None:
        corner = self.view.mapToScene(box.topLeft())
        self.boxed.emit(
            self._time_at(corner.x()),
            self._time_at(corner.x() + box.width()),
            1.0 - box.bottom() / self.view.height(),
            1.0 - box.top() / self.view.height(),
        )

    def _make_axis(self, side: str, row: int, column: int) -> NumberAxis:
        axis = NumberAxis(side, maxTickLength=0)
        axis.enableAutoSIPrefix(False)
        axis.setStyle(maxTickLevel=1, hideOverlappingLabels=AXIS_OVERHANG_PX)
        axis.setOpacity(0.0)  # part of the background, which is painted once
        axis.redrawn.connect(self.resetCachedContent)
        self.addItem(axis, row, column)
        return axis

    def _apply_colours(self) -> None:
        """Apply the colours of the look, and the font."""
        colour = self._look.colour
        self.setBackground(colour("card"))
        self.set_focus_shown(self._focus_shown)
        for axis in (self._bottom, *self._axes):
            self._style_axis(axis)
        self._grid.setContentsMargins(0.0, 1.4 * self.fontMetrics().height() + 8.0, 0.0, 0.0)
        for curve in self._curves:
            curve.end.setFont(self.font())
        self._zero.setPen(pg.mkPen(colour("command")))
        self._cross.setPen(QPen(colour("ink"), 0, Qt.PenStyle.DotLine))
        self._cross.label.fill = pg.mkBrush(colour("ink"))
        self._cross.label.setColor(colour("card"))
        self._dots.setPen(pg.mkPen(colour("field")))
        self._state.fill = pg.mkBrush(colour("accent"))
        self._state.setColor(colour("on_accent"))
        self._hint.fill = pg.mkBrush(colour("field"))
        self._hint.setColor(colour("muted"))
        self.resized.emit()

    def _style_axis(self, axis: NumberAxis) -> None:
        style_axis(axis, self._look, self.font(), pen="line")
        if axis is self._bottom:
            axis.setHeight(2 * self.fontMetrics().height() + 4)
        else:
            axis.setWidth(self.fontMetrics().horizontalAdvance(WIDEST_AXIS_NUMBER) + 6)

    def _show_axes(self) -> None:
        content, axes = self.content, self.content.axes
        while len(self._axes) < len(axes):
            self._axes.append(self._make_axis("right", 0, 2 + len(self._axes)))
            self._style_axis(self._axes[-1])
        for index, item in enumerate(self._axes):
            if item.isVisible() is not (index < len(axes)):
                item.setVisible(index < len(axes))
                self._style_axis(item)
        for item, axis in zip(self._axes, axes, strict=False):
            item.show_name(" ".join(part for part in (axis.label, axis.unit.symbol) if part))
            item.show_scale(content.y_scale)
            if item is not self._axes[0]:
                item.setRange(*self._ends(axis))
        self._bottom.show_name(content.x_label)
        self._bottom.show_scale(content.x_scale)
        self._zero.setVisible(content.y_scale is Scale.LINEAR)
        self.view.setRange(
            xRange=(self._place_at(content.left), self._place_at(content.right)),
            yRange=self._ends(axes[0]),
            padding=0.0,
            disableAutoRange=False,
        )
        self._place()

    def _ends(self, axis: ChartAxis) -> tuple[float, float]:
        """Return the positions of an axis' ends."""
        scale = self.content.y_scale
        return scale.place(axis.low), scale.place(axis.high)

    def _to_view(self, axis: ChartAxis) -> tuple[float, float]:
        """Return scale and offset from positions of an axis to those of the first, the view's."""
        (least, largest), (low, high) = self._ends(self.content.axes[0]), self._ends(axis)
        factor = (largest - least) / max(high - low, 1e-300)
        return factor, least - low * factor

    def _place(self) -> None:
        """Position the curves of each axis in the view."""
        for index, axis in enumerate(self.content.axes):
            if index == len(self._groups):
                self._groups.append(pg.ItemGroup())
                self.view.addItem(self._groups[-1], ignoreBounds=True)
            factor, offset = self._to_view(axis)
            slope, shift = self.content.y_scale.multiplied(axis.unit.factor)
            offset += factor * shift
            self._groups[index].setTransform(
                QTransform(1.0, 0.0, 0.0, factor * slope, -self.content.origin, offset)
            )

    def _show_curves(self) -> None:
        lines = self.content.lines
        while len(self._curves) < len(lines):
            self._curves.append(NumberedCurve())
            self._curves[-1].end.setFont(self.font())
            self.scene().addItem(self._curves[-1].end)
        while len(self._curves) > len(lines):
            curve = self._curves.pop()
            self.scene().removeItem(curve.end)
            self.scene().removeItem(curve)
        for curve, line in zip(self._curves, lines, strict=True):
            if curve.parentItem() is not self._groups[line.axis]:
                curve.setParentItem(self._groups[line.axis])
            scales = self.content.x_scale, self.content.y_scale
            curve.show_line(line, self._look.colour("field"), self.devicePixelRatioF(), *scales)
        self._name_ends()
        self._place_ends()

    def _name_ends(self) -> None:
        lines = self.content.lines
        key = (self.width(), self.font().key(), *((each.number, each.name) for each in lines))
        if key == self._named:
            return
        self._named = key
        texts, wide = end_texts(lines, QFontMetricsF(self.font()).horizontalAdvance, self.width())
        for curve, text in zip(self._curves, texts, strict=True):
            curve.end.setText(text)
        self._grid.setColumnFixedWidth(2, wide)

    def _place_ends(self) -> None:
        box, height = self.view.sceneBoundingRect(), self.fontMetrics().height()
        scale = self.content.y_scale
        ends: list[tuple[float, int]] = []
        for index, line in enumerate(self.content.lines):
            ended = len(line.values) > 0 and math.isfinite(line.values[-1])
            self._curves[index].end.setVisible(ended)
            if ended and self._curves[index].end.text():
                axis = self.content.axes[line.axis]
                low, high = self._ends(axis)
                place = scale.place(axis.unit.shown(float(line.values[-1])))
                ends.append((box.bottom() - (place - low) / (high - low) * box.height(), index))
        ends.sort()
        places = spread_positions([y for y, _ in ends], box.top(), box.bottom(), 0.8 * height)
        for y, (_, index) in zip(places, ends, strict=True):
            self._curves[index].end.setPos(box.right() + 4.0, y - 0.5 * height)

    def _show_guides(self) -> None:
        content = self.content
        while len(self._guides) < len(content.guides):
            self._guides.append(pg.PlotCurveItem())
            self._guides[-1].setZValue(-1)
            self.view.addItem(self._guides[-1], ignoreBounds=True)
        while len(self._guides) > len(content.guides):
            self.view.removeItem(self._guides.pop())
        axis = content.axes[0]
        for item, guide in zip(self._guides, content.guides, strict=True):
            x = [self._place_at(min(max(each, content.left), content.right)) for each in guide.x]
            shown = [min(max(axis.unit.shown(each), axis.low), axis.high) for each in guide.y]
            item.setPen(pg.mkPen(self._look.colour(guide.colour), style=Qt.PenStyle.DashLine))
            item.setData(x, [content.y_scale.place(each) for each in shown])

    def _show_marks(self) -> None:
        """Draw cursors A and B."""
        content, colour = self.content, self._look.colour
        key = (content.marks, content.origin, content.x_scale, self._look.is_dark)
        if key == self._marks_key:
            return
        self._marks_key = key
        for line in self._marks:
            self.view.removeItem(line)
        self._marks = []
        for name, time in content.marks:
            options = {"position": 0.07, "fill": colour("accent"), "color": colour("on_accent")}
            line = pg.InfiniteLine(
                self._place_at(time),
                angle=90,
                movable=True,
                pen=colour("accent"),
                label=_escaped_format(f"{name} {self._said_at(time)}"),
                labelOpts=options,
            )
            line.sigPositionChangeFinished.connect(partial(self._tell_mark, name))
            self.view.addItem(line, ignoreBounds=True)
            self._marks.append(line)

    def _tell_mark(self, name: str, line: pg.InfiniteLine) -> None:
        place = line.value() + self.content.origin
        self.mark_moved.emit(name, self.content.x_scale.value_of(place))

    def _show_words(self) -> None:
        """Say why the picture is paused, or what to do if there is nothing to draw."""
        self._state.setVisible(bool(self.content.state))
        self._state.setPlainText(f" {self.content.state} ")
        self._state.setPos(6.0, 5.0)
        hint = "" if self.content.lines else self.content.hint
        self._hint.setVisible(bool(hint))
        if hint:
            self._hint.setHtml(f"<div align='center'>{html_text(hint)}</div>")
            self._hint.setTextWidth(max(60.0, self.view.width() - 24.0))
            self._hint.setPos(0.5 * self.view.width(), 0.5 * self.view.height())

    def _show_cursor(self) -> None:
        """Draw the crosshair, with a dot on every curve."""
        content, time = self.content, self.cursor_time
        seen = time is not None and content.left <= time <= content.right
        self._cross.setVisible(seen)
        points = list(content.points)
        if time is not None and seen:
            self._cross.setValue(self._place_at(time))
            self._cross.label.setFormat(_escaped_format(self._said_at(time)))
            wide = 2.2 * self._cross.label.boundingRect().width()
            self._cross.label.setVisible(self.view.width() > wide)  # else its side is clipped
            points += [
                CurveDot(time, value_at(line.time, line.values, time), line.axis, line.colour)
                for line in content.lines
            ]
        points = [each for each in points if math.isfinite(each.x + each.y)]
        self._dots.setVisible(bool(points))
        if not points:
            return
        places = []
        for each in points:
            axis = content.axes[each.axis]
            factor, offset = self._to_view(axis)
            y = content.y_scale.place(axis.unit.shown(each.y)) * factor + offset
            places.append((self._place_at(each.x), y))
        self._dots.setData(
            *zip(*places, strict=True), brush=[pg.mkBrush(each.colour) for each in points]
        )


def _escaped_format(text: str) -> str:
    """Return a text for a line's label, which pyqtgraph takes for a format of the line's value."""
    return plain_name(text).replace("{", "{{").replace("}", "}}")

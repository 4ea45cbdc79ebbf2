"""Where a chart is painted, and where mouse and wheel are heard."""

import dataclasses

from PyQt6.QtCore import QEvent, QPointF, QRectF, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QMouseEvent, QPainter, QPaintEvent, QPen, QPixmap, QResizeEvent, QWheelEvent
from PyQt6.QtWidgets import QSizePolicy, QWidget

from workbench.gui.charts.background import Background
from workbench.gui.charts.layout import Layout, make_layout
from workbench.gui.charts.overlay import Overlay
from workbench.gui.charts.scene import Scene
from workbench.gui.charts.strokes import Stroke, StrokeMaker
from workbench.gui.theme import Look

LEAST_HEIGHT = 120
"""In which a curve can be read [pixels]; a board of more charts is scrolled."""
SMALLEST_BOX = 8.0
"""A drag has to be so long to zoom [pixels]."""


class Canvas(QWidget):
    """Shows a scene.

    Args:
        look: colours.
        parent: whose life it shares.
    """

    hovered = pyqtSignal(object)
    """Time under the mouse [s], None where it has left."""
    turned = pyqtSignal(float, float, float, bool)
    """The wheel: time and share of the height under the mouse, factor, whether over an axis."""
    boxed = pyqtSignal(float, float, float, float)
    """A box was drawn: its first and last time, lower and upper share of the height."""
    reset_wanted = pyqtSignal()
    """A double click."""
    resized = pyqtSignal()
    """Its scene has to be made again for another size."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(parent)
        self._look = look
        self._background = Background(look)
        self._overlay = Overlay(look)
        self._scene = Scene()
        self._maker = StrokeMaker(look.colours.field)
        self._strokes: tuple[Stroke, ...] = ()
        self._pixmap = QPixmap()
        self._key: tuple[object, ...] = ()
        self._pressed: QPointF | None = None
        self._shift = 0.0
        self._at = QPointF()
        self._mouse: float | None = None
        self._focus_shown = False
        self.cursor_time: float | None = None
        self.setMouseTracking(True)
        self.setAttribute(Qt.WidgetAttribute.WA_OpaquePaintEvent)
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(160, LEAST_HEIGHT)
        look.changed.connect(self._repaint_all)

    def sizeHint(self) -> QSize:
        """Return what suits a chart."""
        return QSize(420, 200)

    @property
    def scene(self) -> Scene:
        """What is shown."""
        return self._scene

    @property
    def layout_now(self) -> Layout:
        """Where the parts are."""
        return self.layout_for(len(self._scene.axes))

    def layout_for(self, axes: int) -> Layout:
        """Return where the parts are with so many axes."""
        return make_layout(self.size(), self.fontMetrics(), axes)

    def columns_for(self, layout: Layout) -> int:
        """Return into how many columns curves are divided: one for two pixels of the screen."""
        return max(50, int(0.5 * layout.plot.width() * self.devicePixelRatioF()))

    def show_scene(self, scene: Scene) -> None:
        """Show another scene."""
        self._scene = scene
        self._shift = 0.0
        self._follow_mouse()
        layout = self.layout_now
        if self._maker.ground != self._look.colours.field:
            self._maker = StrokeMaker(self._look.colours.field)
        self._strokes = tuple(self._maker.make(scene, layout, line) for line in scene.lines)
        self.update()

    def move_on(self, left: float, right: float) -> None:
        """Show the same curves in a window that has moved on, from a time to another [s]."""
        scene, layout = self._scene, self.layout_now
        self._shift += layout.x_of(scene, scene.right) - layout.x_of(scene, right)
        follows = scene.origin == scene.right
        origin = right if follows else scene.origin
        self._scene = dataclasses.replace(scene, left=left, right=right, origin=origin)
        self._follow_mouse()
        self.update()

    def forget_mouse(self) -> None:
        """Let the crosshair stay where it is put."""
        self._mouse = None

    def set_cursor(self, time: float | None) -> None:
        """Put the crosshair to a time [s], or take it away."""
        if time != self.cursor_time:
            self.cursor_time = time
            self.update()

    def set_focus_shown(self, shown: bool) -> None:
        """Frame the plot where keys go to this chart."""
        self._focus_shown = shown
        self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint."""
        layout = self.layout_now
        self._refresh_background(layout)
        painter = QPainter(self)
        painter.drawPixmap(0, 0, self._pixmap)
        painter.setClipRect(layout.plot)
        painter.translate(self._shift, 0.0)
        for stroke in self._strokes:
            stroke.paint(painter)
        painter.resetTransform()
        painter.setClipping(False)
        self._overlay.paint_numbers(painter, self._strokes, layout)
        self._overlay.paint_marks(painter, self._scene, layout)
        if self.cursor_time is not None:
            self._overlay.paint_cursor(painter, self._scene, layout, self.cursor_time)
        if self._scene.state:
            self._overlay.paint_state(painter, self._scene.state, layout)
        if self._focus_shown:
            painter.setPen(QPen(self._look.colour("accent"), 2))
            painter.drawRect(layout.plot)
        if self._pressed is not None:
            painter.setPen(QPen(self._look.colour("accent"), 0, Qt.PenStyle.DashLine))
            painter.drawRect(self._box())

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Ask for the scene anew."""
        self.resized.emit()

    def changeEvent(self, event: QEvent | None) -> None:
        """Follow another font."""
        if event is not None and event.type() == QEvent.Type.FontChange:
            self._key = ()
            self.resized.emit()
        super().changeEvent(event)

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        """Zoom about the mouse."""
        if event is None or event.angleDelta().y() == 0:
            return
        layout, place = self.layout_now, event.position()
        factor = 0.85 ** (event.angleDelta().y() / 120.0)
        ctrl = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        over_axis = ctrl or not layout.plot.left() <= place.x() <= layout.plot.right()
        share = (layout.plot.bottom() - place.y()) / layout.plot.height()
        self.turned.emit(layout.time_at(self._scene, place.x()), share, factor, over_axis)
        event.accept()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Begin a box."""
        if event is None:
            return
        left = event.button() == Qt.MouseButton.LeftButton
        if left and self.layout_now.plot.contains(event.position()):
            self._pressed = self._at = event.position()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Follow the mouse."""
        if event is None:
            return
        layout, place = self.layout_now, event.position()
        if self._pressed is not None:
            self._at = place
            self.update()
        self._mouse = place.x() if layout.plot.contains(place) else None
        inside = self._mouse is not None
        self.hovered.emit(layout.time_at(self._scene, place.x()) if inside else None)

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Zoom to the box."""
        if event is None or self._pressed is None:
            return
        self._at = event.position()
        box, layout = self._box(), self.layout_now
        self._pressed = None
        self.update()
        if box.width() < SMALLEST_BOX:
            return
        plot = layout.plot
        self.boxed.emit(
            layout.time_at(self._scene, box.left()),
            layout.time_at(self._scene, box.right()),
            (plot.bottom() - box.bottom()) / plot.height(),
            (plot.bottom() - box.top()) / plot.height(),
        )

    def mouseDoubleClickEvent(self, event: QMouseEvent | None) -> None:
        """Go back to what follows the flight."""
        self.reset_wanted.emit()

    def leaveEvent(self, event: QEvent | None) -> None:
        """The mouse is elsewhere."""
        self._mouse = None
        self.hovered.emit(None)

    def _follow_mouse(self) -> None:
        """Keep the crosshair under the mouse while the picture moves."""
        if self._mouse is not None:
            self.cursor_time = self.layout_now.time_at(self._scene, self._mouse)

    def _box(self) -> QRectF:
        """Return the box that is drawn; a flat one takes the whole height."""
        assert self._pressed is not None
        plot = self.layout_now.plot
        x = sorted(min(max(p.x(), plot.left()), plot.right()) for p in (self._pressed, self._at))
        y = sorted(min(max(p.y(), plot.top()), plot.bottom()) for p in (self._pressed, self._at))
        if y[1] - y[0] < SMALLEST_BOX:
            y = [plot.top(), plot.bottom()]
        return QRectF(QPointF(x[0], y[0]), QPointF(x[1], y[1]))

    def _refresh_background(self, layout: Layout) -> None:
        """Paint grid and axes anew where they have changed."""
        scene, ratio = self._scene, self.devicePixelRatioF()
        hint = "" if scene.lines else scene.hint
        key = (
            *(self.width(), self.height(), ratio, self._look.is_dark, hint),
            *(round(scene.left - scene.origin, 9), round(scene.right - scene.origin, 9)),
            *(scene.x_label, scene.axes, scene.limits),
        )
        if key == self._key:
            return
        self._key = key
        self._pixmap = QPixmap(self.size() * ratio)
        self._pixmap.setDevicePixelRatio(ratio)
        self._pixmap.fill(self._look.colour("card"))
        painter = QPainter(self._pixmap)
        painter.setFont(self.font())
        self._background.paint(painter, scene, layout)
        painter.end()

    def _repaint_all(self) -> None:
        self._key = ()
        self.resized.emit()
        self.update()

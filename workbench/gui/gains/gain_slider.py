"""A slider for one gain: where it is stable, where it began, and what is flown, on its track."""

from PyQt6.QtCore import QPointF, QRectF, Qt, pyqtSignal
from PyQt6.QtGui import QKeyEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF, QWheelEvent
from PyQt6.QtWidgets import QSlider, QWidget

from workbench.gui.gains.gain_scale import GainScale, StepSize, key_step, moves, size_of
from workbench.gui.theme import Look

PLACES = 10000
"""Whole numbers along the track, for those who ask the slider for its value."""
HANDLE = 7.0
"""Its radius [px]."""
FINER = 10.0
"""A drag with Ctrl held moves so many times less."""


class GainSlider(QSlider):
    """Shows a gain along its scale; it moves when told so, and tells what the user wants.

    A press beside the handle makes a coarse step towards it, as a gain is not to leap. With Ctrl
    held a drag is ten times finer. The wheel turns it only while it has the focus.

    Args:
        scale: of its values.
        look: colours.
        parent: owner.

    Attributes:
        scale: of its values; what is shown stays where it is until it is shown anew.
    """

    dragged = pyqtSignal(float)
    """The value that the user wants, in SI."""
    stepped = pyqtSignal(int, object)
    """Direction, -1 or 1, and a `StepSize`."""
    edit_begun = pyqtSignal()
    """What follows, until `edit_ended`, is one change."""
    edit_ended = pyqtSignal()
    """It is over."""

    def __init__(self, scale: GainScale, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(Qt.Orientation.Horizontal, parent)
        self.scale, self._look = scale, look
        self.setRange(0, PLACES)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumWidth(60)
        self._place, self._start = 0.0, 0.0
        self._flown: float | None = None
        self._stable: tuple[float, float] | None = None
        self._fresh = False
        self._held: tuple[float, float] | None = None
        look.changed.connect(self.update)

    def show_value(self, value: float, flown: float) -> None:
        """Show where the value is, and where the flown one; nobody is told."""
        places = self.scale.place(value), self.scale.place(flown)
        if places == (self._place, self._flown):
            return
        self._place, self._flown = places
        blocked = self.blockSignals(True)
        self.setValue(round(self._place * PLACES))
        self.blockSignals(blocked)
        self.update()

    def show_start(self, value: float) -> None:
        """Mark where the flight began."""
        self._start = self.scale.place(value)
        self.update()

    def show_stable(self, stable: tuple[float, float] | None, fresh: bool) -> None:
        """Show between which values the loop is stable, None if unknown.

        Args:
            stable: least and largest value, in SI.
            fresh: whether that was found with the gains that fly.
        """
        low_high = (self.scale.place(stable[0]), self.scale.place(stable[1])) if stable else None
        if (low_high, fresh) != (self._stable, self._fresh):
            self._stable, self._fresh = low_high, fresh
            self.update()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            return
        x = event.position().x()
        handle = self._x(self._place)
        self.edit_begun.emit()
        if abs(x - handle) <= HANDLE + 3.0:
            self._held = (x, self._place)
        else:
            self.stepped.emit(1 if x > handle else -1, StepSize.COARSE)
        self.update()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        if event is None or self._held is None:
            return
        x, place = self._held
        fine = bool(event.modifiers() & Qt.KeyboardModifier.ControlModifier)
        way = (event.position().x() - x) / self._width() / (FINER if fine else 1.0)
        place = min(max(place + way, 0.0), 1.0)
        self._held = (event.position().x(), place)
        self.dragged.emit(self.scale.round_value(place))

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self._held = None
            self.edit_ended.emit()
            self.update()

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        if event is None:
            return
        step = key_step(event.key(), event.modifiers())
        if step is None:
            event.ignore()  # Enter and Escape are the form's
            return
        if not event.isAutoRepeat():
            self.edit_begun.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        if event is not None and not event.isAutoRepeat() and moves(event.key()):
            self.edit_ended.emit()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        if event is None:
            return
        turned = event.angleDelta().y() or event.angleDelta().x()
        if not self.hasFocus() or not turned:
            event.ignore()
            return
        self.stepped.emit(1 if turned > 0 else -1, size_of(event.modifiers()))
        event.accept()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self.height() / 2.0
        on = self.isEnabled()
        self._paint_track(painter, middle)
        if self._stable and on:
            self._paint_stable(painter, middle, *map(self._x, self._stable))
        self._paint_start(painter, middle)
        if self._flown is not None and abs(self._flown - self._place) > 1e-9:
            self._paint_flown(painter, QPointF(self._x(self._flown), middle))
        self._paint_handle(painter, QPointF(self._x(self._place), middle), on)

    def _paint_track(self, painter: QPainter, middle: float) -> None:
        painter.setPen(QPen(self._look.colour("line"), 2.0))
        painter.drawLine(QPointF(self._x(0.0), middle), QPointF(self._x(1.0), middle))

    def _paint_stable(self, painter: QPainter, middle: float, low: float, high: float) -> None:
        """Draw a band with an upright mark at either end; thin and broken where it is old."""
        colour = self._look.colour("good")
        band = QRectF(low, middle - 2.0, high - low, 4.0)
        tint = self._look.colour("good")
        tint.setAlphaF(0.55 if self._fresh else 0.22)
        painter.fillRect(band, tint)
        if not self._fresh:
            colour.setAlphaF(0.5)
        style = Qt.PenStyle.SolidLine if self._fresh else Qt.PenStyle.DotLine
        painter.setPen(QPen(colour, 1.5, style))
        for x in (low, high):
            painter.drawLine(QPointF(x, middle - 6.0), QPointF(x, middle + 6.0))

    def _paint_start(self, painter: QPainter, middle: float) -> None:
        """Draw a small triangle below the track where the flight began."""
        x = self._x(self._start)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self._look.colour("muted"))
        top = middle + 6.0
        corners = [QPointF(x, top), QPointF(x - 3.5, top + 5.0), QPointF(x + 3.5, top + 5.0)]
        painter.drawPolygon(QPolygonF(corners))

    def _paint_flown(self, painter: QPainter, at: QPointF) -> None:
        """Draw a ring where the flight is, while something else is proposed."""
        painter.setPen(QPen(self._look.colour("muted"), 1.5))
        painter.setBrush(self._look.colour("card"))
        painter.drawEllipse(at, HANDLE - 2.5, HANDLE - 2.5)

    def _paint_handle(self, painter: QPainter, at: QPointF, on: bool) -> None:
        if self.hasFocus():
            painter.setPen(QPen(self._look.colour("ink"), 2.0))
        else:
            painter.setPen(QPen(self._look.colour("card"), 1.5))
        painter.setBrush(self._look.colour("accent" if on else "line"))
        painter.drawEllipse(at, HANDLE, HANDLE)

    def _width(self) -> float:
        return max(1.0, self.width() - 2.0 * (HANDLE + 2.0))

    def _x(self, place: float) -> float:
        return HANDLE + 2.0 + place * self._width()

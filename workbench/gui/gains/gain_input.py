"""The two inputs of a gain: its slider and its number, which keys and the wheel step."""

from PyQt6.QtCore import QEvent, QPointF, QRectF, QSignalBlocker, Qt, pyqtSignal
from PyQt6.QtGui import (
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QWheelEvent,
)
from PyQt6.QtWidgets import QAbstractSpinBox, QSlider

from workbench.common.quantity import DisplayUnit
from workbench.gui.gains.gain_scale import GainScale
from workbench.gui.gains.step_key import (
    COARSE_STEP_FACTOR,
    FINE_STEP_FACTOR,
    is_step_key,
    key_step,
    key_step_size,
)
from workbench.gui.number_field import NumberField
from workbench.gui.theme import Look
from workbench.gui.wheel import zoom_notches

GAIN_SLIDER_STEPS = 10000
"""Number of steps along the track, for accessibility tools that read the slider's value."""
SLIDER_HANDLE_RADIUS_PX = 7.0
"""Radius of the slider's handle [px]."""
FINE_DRAG_DIVISOR = 10.0
"""A drag with Shift or Ctrl held is finer by this factor."""
FINE_DRAG_MODIFIERS = Qt.KeyboardModifier.ShiftModifier | Qt.KeyboardModifier.ControlModifier
MAX_TYPED_GAIN = 1e12
"""Every number is accepted, so that the parameter table can say what is wrong with it."""

LIMITS_BAND_HEIGHT_PX = 7.0
"""Height of the band in which all limits hold; that of the stable range is 4 px high [px]."""


class GainSlider(QSlider):
    """Shows a gain along its scale, and reports the user's input; `show_value` moves it.

    A click beside the handle makes a coarse step towards it, because a gain must not jump. With
    Shift held, dragging is ten times finer. The wheel with Ctrl steps a slider that has the focus.

    Args:
        scale: scale of its values.
        look: source of colours.

    Attributes:
        scale: scale of its values; a new scale takes effect when values are shown again.
    """

    dragged = pyqtSignal(float)
    """The value that the user requests, in SI."""
    stepped = pyqtSignal(int, float)
    """Direction, -1 or 1, and size of the step."""
    edit_begun = pyqtSignal()
    """The following input, until `edit_ended`, is one change."""
    edit_ended = pyqtSignal()
    """The change is complete."""

    def __init__(self, scale: GainScale, look: Look) -> None:
        super().__init__(Qt.Orientation.Horizontal)
        self.scale, self._look = scale, look
        self.setRange(0, GAIN_SLIDER_STEPS)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumWidth(60)
        self._place, self._start = 0.0, 0.0
        self._flown: float | None = None
        self._stable: tuple[float, float] | None = None
        self._fresh = False
        self._within_limits: tuple[float, float] | None = None
        self._held: tuple[float, float] | None = None
        look.changed.connect(self.update)

    def show_value(self, value: float, flown: float) -> None:
        """Show the positions of the value and of the flown one, without a signal."""
        places = self.scale.place(value), self.scale.place(flown)
        if places == (self._place, self._flown):
            return
        self._place, self._flown = places
        with QSignalBlocker(self):
            self.setValue(round(self._place * GAIN_SLIDER_STEPS))
        self.update()

    def show_start(self, value: float) -> None:
        """Mark the value at the flight's start."""
        self._start = self.scale.place(value)
        self.update()

    def show_stable(self, stable: tuple[float, float] | None, fresh: bool) -> None:
        """Show the stable range of the loop, None if unknown.

        Args:
            stable: least and largest value, in SI.
            fresh: whether the range belongs to the gains that fly.
        """
        low_high = (self.scale.place(stable[0]), self.scale.place(stable[1])) if stable else None
        if (low_high, fresh) != (self._stable, self._fresh):
            self._stable, self._fresh = low_high, fresh
            self.update()

    def show_within_limits(self, within: tuple[float, float] | None) -> None:
        """Show the range in which all limits hold, in SI; None if unknown, or if there is none."""
        low_high = (self.scale.place(within[0]), self.scale.place(within[1])) if within else None
        if low_high != self._within_limits:
            self._within_limits = low_high
            self.update()

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            return
        x = event.position().x()
        handle = self._x(self._place)
        self.edit_begun.emit()
        if abs(x - handle) <= SLIDER_HANDLE_RADIUS_PX + 3.0:
            self._held = (x, self._place)
        else:
            self.stepped.emit(1 if x > handle else -1, COARSE_STEP_FACTOR)
        self.update()

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        if event is None or self._held is None:
            return
        x, place = self._held
        fine = bool(event.modifiers() & FINE_DRAG_MODIFIERS)
        way = (event.position().x() - x) / self._width() / (FINE_DRAG_DIVISOR if fine else 1.0)
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
            event.ignore()  # the form handles Enter and Escape
            return
        if not event.isAutoRepeat():
            self.edit_begun.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        if event is not None and not event.isAutoRepeat() and is_step_key(event.key()):
            self.edit_ended.emit()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        _step_by_wheel(self, event)

    def paintEvent(self, event: QPaintEvent | None) -> None:
        painter = QPainter(self)
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        middle = self.height() / 2.0
        on = self.isEnabled()
        self._paint_track(painter, middle)
        if self._stable and on:
            self._paint_stable(painter, middle, *map(self._x, self._stable))
        if self._within_limits and on:
            self._paint_within_limits(painter, middle, *map(self._x, self._within_limits))
        self._paint_start(painter, middle)
        if self._flown is not None and abs(self._flown - self._place) > 1e-9:
            self._paint_flown(painter, QPointF(self._x(self._flown), middle))
        self._paint_handle(painter, QPointF(self._x(self._place), middle), on)

    def _paint_track(self, painter: QPainter, middle: float) -> None:
        painter.setPen(QPen(self._look.colour("line"), 2.0))
        painter.drawLine(QPointF(self._x(0.0), middle), QPointF(self._x(1.0), middle))

    def _paint_stable(self, painter: QPainter, middle: float, low: float, high: float) -> None:
        """Draw a band with a vertical mark at each end; thin and dashed if it is outdated."""
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

    def _paint_within_limits(
        self, painter: QPainter, middle: float, low: float, high: float
    ) -> None:
        """Draw a darker and higher band."""
        least = LIMITS_BAND_HEIGHT_PX
        width = max(high - low, least)
        band = QRectF(0.5 * (low + high - width), middle - 0.5 * least, width, least)
        painter.fillRect(band, self._look.colour("good"))

    def _paint_start(self, painter: QPainter, middle: float) -> None:
        """Draw a small triangle below the track at the value of the flight's start."""
        x = self._x(self._start)
        painter.setPen(Qt.PenStyle.NoPen)
        painter.setBrush(self._look.colour("muted"))
        top = middle + 6.0
        corners = [QPointF(x, top), QPointF(x - 3.5, top + 5.0), QPointF(x + 3.5, top + 5.0)]
        painter.drawPolygon(QPolygonF(corners))

    def _paint_flown(self, painter: QPainter, at: QPointF) -> None:
        """Draw a ring at the flown value while another one is proposed."""
        painter.setPen(QPen(self._look.colour("muted"), 1.5))
        painter.setBrush(self._look.colour("card"))
        painter.drawEllipse(at, SLIDER_HANDLE_RADIUS_PX - 2.5, SLIDER_HANDLE_RADIUS_PX - 2.5)

    def _paint_handle(self, painter: QPainter, at: QPointF, on: bool) -> None:
        if self.hasFocus():
            painter.setPen(QPen(self._look.colour("ink"), 2.0))
        else:
            painter.setPen(QPen(self._look.colour("card"), 1.5))
        painter.setBrush(self._look.colour("accent" if on else "line"))
        painter.drawEllipse(at, SLIDER_HANDLE_RADIUS_PX, SLIDER_HANDLE_RADIUS_PX)

    def _width(self) -> float:
        return max(1.0, self.width() - 2.0 * (SLIDER_HANDLE_RADIUS_PX + 2.0))

    def _x(self, place: float) -> float:
        return SLIDER_HANDLE_RADIUS_PX + 2.0 + place * self._width()


class GainField(NumberField):
    """A number with its unit, as shown; the model determines its value."""

    stepped = pyqtSignal(int, float)
    """Direction, -1 or 1, and size of the step."""
    edit_begun = pyqtSignal()
    """The following steps, until `edit_ended`, are one change."""
    edit_ended = pyqtSignal()
    """The change is complete."""

    def __init__(self) -> None:
        super().__init__()
        self.set_range(DisplayUnit(""), -MAX_TYPED_GAIN, MAX_TYPED_GAIN)
        self.setButtonSymbols(QAbstractSpinBox.ButtonSymbols.NoButtons)
        self.setProperty("class", "bare")
        self.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)

    def show_value(self, value: float) -> None:
        """Show a value, without a signal; it replaces a text that was refused."""
        self.restore()
        self.show_si(value)
        self.restore()

    def tell(self, said: str) -> None:
        """Do nothing: the field's line shows the message."""

    def event(self, event: QEvent | None) -> bool:
        # The field's own undo would take the key from the gains' undo.
        if (
            isinstance(event, QKeyEvent)
            and event.type() == QEvent.Type.ShortcutOverride
            and (event.matches(QKeySequence.StandardKey.Undo) or _is_redo(event))
        ):
            event.ignore()
            return False
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        if event is None:
            return
        step = key_step(event.key(), event.modifiers())
        if step is None or event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Right):
            discards = self.is_typed_in and not self.fault and event.key() == Qt.Key.Key_Escape
            super().keyPressEvent(event)
            keys = (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Escape)
            if event.key() in keys and not discards:
                event.ignore()  # the form handles them, too
            return
        if not event.isAutoRepeat():
            self.edit_begun.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        super().keyReleaseEvent(event)
        if event is not None and not event.isAutoRepeat() and is_step_key(event.key()):
            self.edit_ended.emit()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        _step_by_wheel(self, event)

    def stepBy(self, steps: int) -> None:
        self.stepped.emit(1 if steps > 0 else -1, FINE_STEP_FACTOR)


def _is_redo(event: QKeyEvent) -> bool:
    return event.matches(QKeySequence.StandardKey.Redo)


def _step_by_wheel(field: GainSlider | GainField, event: QWheelEvent | None) -> None:
    """Let the wheel with Ctrl step a field that has the focus; otherwise it scrolls the page."""
    if event is None:
        return
    if not field.hasFocus():
        event.ignore()
    elif notches := zoom_notches(event):
        held = event.modifiers() & ~Qt.KeyboardModifier.ControlModifier
        field.stepped.emit(1 if notches > 0.0 else -1, key_step_size(held))

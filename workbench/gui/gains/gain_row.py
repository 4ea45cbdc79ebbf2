"""The line of one parameter: name, slider, number, state, and reset."""

import math
from functools import partial

from PyQt6.QtCore import QEvent, QPointF, QRectF, QSignalBlocker, QSize, Qt, pyqtSignal
from PyQt6.QtGui import (
    QKeyEvent,
    QKeySequence,
    QMouseEvent,
    QPainter,
    QPaintEvent,
    QPen,
    QPolygonF,
    QResizeEvent,
    QWheelEvent,
)
from PyQt6.QtWidgets import QAbstractSpinBox, QSlider, QWidget

from workbench.gui.gains.gain_editor import GainEditor, Mark
from workbench.gui.gains.gain_rows import partner
from workbench.gui.labels import ElidedLabel, set_tip
from workbench.gui.layout import NO_MARGINS, grid, label, tool_button
from workbench.gui.number_field import NumberField
from workbench.gui.style import dressed, set_class
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.scenario.parameters import Parameter

FINEST, FINE, COARSE = 0.1, 1.0, 5.0
"""Sizes of a step, as multiples of the plain one."""
DIGITS = 3
"""Significant digits of a slider's values."""
_KNEE = 10.0
"""Where 0 is allowed, values below default / KNEE are spread evenly, those above by their ratio."""
_UP = (Qt.Key.Key_Right, Qt.Key.Key_Up)
_DOWN = (Qt.Key.Key_Left, Qt.Key.Key_Down)
SLIDER_PLACES = 10000
"""Number of steps along the track, for accessibility tools that read the slider's value."""
HANDLE = 7.0
"""Radius of the slider's handle [px]."""
FINER = 10.0
"""A drag with Ctrl held is finer by this factor."""
LARGEST_TYPED = 1e12
"""Every number is accepted, so that the parameter table can say what is wrong with it."""
MOST_DECIMALS = 3
GAP = 4
"""Space between columns [px]."""
SHAPES = {Mark.KEPT: "", Mark.TRIED: "◆", Mark.PROPOSED: "◇"}
OWN_NAME_WIDTHS, ROOM_FOR_NAME = (11.6, 13.2), 54.0
"""Widths of the parameter's own name, and width of a line with room for the smaller one, in widths
of a digit."""
NAME_WIDTH, FIELD_WIDTH, UNIT_WIDTH, MARK_WIDTH = 14.4, 7.4, 3.8, 1.6
"""Widths of the columns, in widths of a digit, so that all lines have the same."""
LONGEST_NAME, LONGEST_UNIT, TRACK = 22.0, 9.6, 11.0
"""Largest widths of long names and units, while the slider keeps at least the last width."""


class GainScale:
    """Maps values of a row to positions 0 .. 1 along a slider, and back; strictly increasing.

    Logarithmic if all values are positive and span more than a decade; logarithmic with a linear
    part around 0 if 0 is allowed; linear if they span no more than a decade, if only whole numbers
    are allowed, or if the default is an end.

    Args:
        row: the parameter.
        unit: unit in which its values are round.
    """

    def __init__(self, row: Parameter, unit: Unit) -> None:
        self._row, self._unit = row, unit
        self._low, self._high = row.minimum, row.maximum
        even = row.whole or row.default in (row.maximum,)
        if not even and self._low > 0.0:
            even = self._high <= 10.0 * self._low
        self._even = even
        size = max(abs(self._low), abs(self._high))
        self._knee = abs(row.default) / _KNEE or size / 100.0
        self._first = self._bend(self._low)
        self._span = self._bend(self._high) - self._first

    def place(self, value: float) -> float:
        """Return the position of a value, 0 .. 1; values beyond the limits are at the ends."""
        value = min(max(value, self._low), self._high)
        return (self._bend(value) - self._first) / self._span

    def value(self, place: float) -> float:
        """Return the value at a position, within the limits."""
        if place <= 0.0:
            return self._low
        if place >= 1.0:
            return self._high
        bent = self._first + place * self._span
        return self.held(self._unbend(bent))

    def round_value(self, place: float) -> float:
        """Return the allowed value at a position, with three digits as it is shown."""
        shown = self._unit.shown(self.value(place))
        return self.held(self._unit.read(float(f"{shown:.{DIGITS - 1}e}")))

    def stepped(self, value: float, direction: int, size: float) -> float:
        """Return the allowed value one step above (1) or below (-1) another one."""
        shown = self._unit.shown(value)
        step = 1.0 if self._row.whole else self._unit.shown(self.step(value)) * size
        return self.held(self._unit.read(round(shown + direction * step, 9)))

    def held(self, value: float) -> float:
        """Return the nearest allowed value."""
        if self._row.whole:
            value = float(round(value))
        return min(max(value, self._low), self._high)

    def step(self, value: float) -> float:
        """Return the step of an arrow key: 1, 2 or 5 times a power of ten, about 2 % of the value.

        Args:
            value: value at which the step is made.
        """
        if self._row.whole:
            return 1.0
        size = max(abs(value), self._smallest())
        return _round_step(0.02 * size)

    def _smallest(self) -> float:
        """Return the size of the smallest step."""
        return self._low if self._low > 0.0 else self._knee

    def _bend(self, value: float) -> float:
        if self._even:
            return value
        return math.log(value) if self._low > 0.0 else math.asinh(value / self._knee)

    def _unbend(self, bent: float) -> float:
        if self._even:
            return bent
        return math.exp(bent) if self._low > 0.0 else self._knee * math.sinh(bent)


def decimals(step: float) -> int:
    """Return the number of decimals that show a step."""
    return min(6, max(0, -math.floor(math.log10(step) + 1e-9)))


def _round_step(step: float) -> float:
    """Return the nearest of 1, 2, 5 times a power of ten, by ratio."""
    power = 10.0 ** math.floor(math.log10(step))
    nearest = min((1.0, 2.0, 5.0, 10.0), key=lambda each: abs(math.log(step / (each * power))))
    return float(f"{nearest * power:.0e}")


def size_of(modifiers: Qt.KeyboardModifier) -> float:
    """Return the step size of a pressed key: plain, coarse with Shift, finest with Ctrl."""
    if modifiers & Qt.KeyboardModifier.ShiftModifier:
        return COARSE
    if modifiers & Qt.KeyboardModifier.ControlModifier:
        return FINEST
    return FINE


def key_step(key: int, modifiers: Qt.KeyboardModifier) -> tuple[int, float] | None:
    """Return direction and size of a key's step, None for another key."""
    if key in _UP:
        return 1, size_of(modifiers)
    if key in _DOWN:
        return -1, size_of(modifiers)
    if key in (Qt.Key.Key_PageUp, Qt.Key.Key_PageDown):
        return (1 if key == Qt.Key.Key_PageUp else -1), COARSE
    return None


def moves(key: int) -> bool:
    """Return whether a key makes a step."""
    return key_step(key, Qt.KeyboardModifier.NoModifier) is not None


class GainSlider(QSlider):
    """Shows a gain along its scale, and reports the user's input; `show_value` moves it.

    A click beside the handle makes a coarse step towards it, because a gain must not jump. With
    Ctrl held, dragging is ten times finer. The wheel works only while the slider has the focus.

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
        self.setRange(0, SLIDER_PLACES)
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.setMinimumWidth(60)
        self._place, self._start = 0.0, 0.0
        self._flown: float | None = None
        self._stable: tuple[float, float] | None = None
        self._fresh = False
        self._held: tuple[float, float] | None = None
        look.changed.connect(self.update)

    def show_value(self, value: float, flown: float) -> None:
        """Show the positions of the value and of the flown one, without a signal."""
        places = self.scale.place(value), self.scale.place(flown)
        if places == (self._place, self._flown):
            return
        self._place, self._flown = places
        with QSignalBlocker(self):
            self.setValue(round(self._place * SLIDER_PLACES))
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

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            return
        x = event.position().x()
        handle = self._x(self._place)
        self.edit_begun.emit()
        if abs(x - handle) <= HANDLE + 3.0:
            self._held = (x, self._place)
        else:
            self.stepped.emit(1 if x > handle else -1, COARSE)
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
            event.ignore()  # the form handles Enter and Escape
            return
        if not event.isAutoRepeat():
            self.edit_begun.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        if event is not None and not event.isAutoRepeat() and moves(event.key()):
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
        self.set_range(Unit(""), -LARGEST_TYPED, LARGEST_TYPED)
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
            and (event.matches(QKeySequence.StandardKey.Undo) or _redoes(event))
        ):
            event.ignore()
            return False
        return super().event(event)

    def keyPressEvent(self, event: QKeyEvent | None) -> None:
        if event is None:
            return
        step = key_step(event.key(), event.modifiers())
        if step is None or event.key() in (Qt.Key.Key_Left, Qt.Key.Key_Right):
            super().keyPressEvent(event)
            if event.key() in (Qt.Key.Key_Return, Qt.Key.Key_Enter, Qt.Key.Key_Escape):
                event.ignore()  # the form handles them, too
            return
        if not event.isAutoRepeat():
            self.edit_begun.emit()
        self.stepped.emit(*step)

    def keyReleaseEvent(self, event: QKeyEvent | None) -> None:
        super().keyReleaseEvent(event)
        if event is not None and not event.isAutoRepeat() and moves(event.key()):
            self.edit_ended.emit()

    def wheelEvent(self, event: QWheelEvent | None) -> None:
        _step_by_wheel(self, event)

    def stepBy(self, steps: int) -> None:
        self.stepped.emit(1 if steps > 0 else -1, FINE)


def _redoes(event: QKeyEvent) -> bool:
    return event.matches(QKeySequence.StandardKey.Redo)


class GainRow(QWidget):
    """The line of a parameter.

    Args:
        workspace: colours and units.
        editor: sets the parameter.
        row: row of the parameter table.
        parent: the Qt parent.

    Attributes:
        row: row of the parameter table.
    """

    def __init__(
        self,
        workspace: Workspace,
        editor: GainEditor,
        row: Parameter,
        parent: QWidget | None = None,
    ) -> None:
        super().__init__(parent)
        self._workspace, self._editor, self.row = workspace, editor, row
        self._label = editor.label(row)
        self._unit = unit_for(row.unit, workspace.preferences)
        self._mark = Mark.KEPT
        self._seen: tuple[float, float, float] | None = None
        self._stable: tuple[float, float] | None = None
        self._fresh = False
        self._wanted = 0, 0
        self.slider = GainSlider(GainScale(row, self._unit), workspace.look)
        self.field = GainField()
        self.mark = label()
        self.reset = tool_button("↺", self._reset, "quiet compact")
        self.reset.setFixedWidth(24)
        self.error = label(kind="bad", wraps=True)
        self.error.hide()
        self._name = label()
        self.own_name = dressed(ElidedLabel(), "muted small")
        self._unit_shown = label(kind="muted")
        self._name.setBuddy(self.field)
        self._lay_out()
        for part in (self.slider, self.field):
            part.stepped.connect(self._step)
            part.edit_begun.connect(editor.begin_edit)
            part.edit_ended.connect(editor.end_edit)
        self.slider.dragged.connect(partial(editor.propose, row.name))
        self.field.edited.connect(self._type)
        self.field.refused.connect(self._show_error)
        self.show_unit()

    @property
    def wanted_widths(self) -> tuple[int, int]:
        """Widths of the columns of name and unit that this line needs, within limits [px]."""
        advance = self.fontMetrics().horizontalAdvance
        digit = advance("0")
        bounds = ((NAME_WIDTH, LONGEST_NAME), (UNIT_WIDTH, LONGEST_UNIT))
        texts = f"{self._label.words} {self._label.symbol}".strip(), self._unit_shown.text()
        name, unit = (
            min(max(advance(text) + 4, round(least * digit)), round(most * digit))
            for text, (least, most) in zip(texts, bounds, strict=True)
        )
        return name, unit

    def set_widths(self, name: int, unit: int) -> None:
        """Let the columns of name and unit grow to these widths if there is room [px]."""
        self._wanted = name, unit
        self._share_width()

    def _share_width(self) -> None:
        """Give name and unit the width that the slider can spare."""
        digit = self.fontMetrics().horizontalAdvance("0")
        parts, least = (self._name, self._unit_shown), self._least_widths()
        rest = (FIELD_WIDTH + MARK_WIDTH + TRACK) * digit + self.reset.width() + 5 * GAP
        spare = max(0, self.width() - sum(least) - round(rest) - self._own_name_width())
        for part, wanted, width in zip(parts, self._wanted, least, strict=True):
            more = min(max(0, wanted - width), spare)
            spare -= more
            part.setFixedWidth(width + more)

    def matches(self, words: str) -> bool:
        """Return whether all words occur in its name, symbol, group or help."""
        label = self._label
        text = f"{self.row.name} {label.words} {label.symbol} {label.group} {self.row.help}".lower()
        return all(word in text for word in words.lower().split())

    def show_unit(self) -> None:
        """Show name and unit in the preferred units, and the value at the flight's start."""
        self._name.setText(f"{self._label.words} {self._label.symbol}".strip())
        self._unit = unit_for(self.row.unit, self._workspace.preferences)
        scale = self.slider.scale = GainScale(self.row, self._unit)
        start = self._editor.start[self.row.name]
        step = self._unit.shown(scale.step(start))
        fine = decimals(step * FINEST)
        self.field.show_decimals(0 if self.row.whole else min(fine, MOST_DECIMALS))
        self._unit_shown.setText(self._unit.symbol)
        self.slider.show_start(start)
        self._say_names()
        self._seen = None
        self.show_value()

    def show_value(self) -> None:
        """Show the proposed and flown values, and their relation to the kept one."""
        name = self.row.name
        proposed, flown = self._editor.proposed[name], self._editor.flown[name]
        kept = self._editor.kept.get(name, self._editor.start[name])
        mark = self._editor.mark(name)
        seen = (proposed, flown, kept)
        if seen == self._seen and mark is self._mark:
            return  # to keep a text that is being typed here
        self._seen = seen
        self.slider.show_value(proposed, flown)
        if self.error.isHidden():
            self.field.show_value(self._unit.shown(proposed))
        self._mark = mark
        self.mark.setText(SHAPES[mark])
        said = f"{self._label.text}: {mark.value}; kept is {self._text(kept)}"
        self.mark.setAccessibleName(said)
        set_tip(self.mark, "" if mark is Mark.KEPT else said)
        self.reset.setEnabled(proposed != self._editor.start[name])

    def show_range(self, stable: tuple[float, float] | None, fresh: bool) -> None:
        """Show the stable range of the loop.

        Args:
            stable: least and largest value, in SI; None if unknown.
            fresh: whether the range belongs to the gains that fly.
        """
        if (stable, fresh) == (self._stable, self._fresh):
            return
        self._stable, self._fresh = stable, fresh
        self.slider.show_stable(stable, fresh)
        self._say_names()

    def show_error(self, said: str) -> None:
        """Show why a value is refused; "" clears the message."""
        self._show_error(said)
        if not said:
            self.show_value()

    def put_back(self) -> bool:
        """Propose the flown value again, and discard typed text.

        Returns:
            Whether anything changed.
        """
        was = self._mark is Mark.PROPOSED or not self.error.isHidden()
        if was:
            self.show_error("")
            linked = self._editor.linked and partner(self.row.name)
            self._editor.discard([self.row.name, *([linked] if linked else [])])
        self._seen = None  # discards a half-typed text
        self.show_value()
        return was

    def _show_error(self, said: str) -> None:
        """Mark the text in the field as wrong, and leave it as it is."""
        self.error.setText(f"✕ {said}".replace("^2", "²") if said else "")
        self.error.setVisible(bool(said))
        set_class(self.field, "bare bad" if said else "bare")
        self._seen = None

    def _step(self, direction: int, size: float) -> None:
        value = self._editor.proposed[self.row.name]
        self._editor.propose(self.row.name, self.slider.scale.stepped(value, direction, size))

    def _type(self, shown: float) -> None:
        """Propose the typed value; the table refuses invalid ones."""
        value = self._unit.read(shown)
        low, high = self.row.minimum, self.row.maximum
        if self._unit.factor != 1.0 and not low <= value <= high:
            said = f"{self._label.text} is {self._text(value)}: keep it within {self._limits()}"
            self.show_error(said)  # in the unit of the typed text
        else:
            self._show_error("")
            self._editor.propose(self.row.name, value)

    def _reset(self) -> None:
        self._editor.end_edit()
        self._editor.propose(self.row.name, self._editor.start[self.row.name])

    def _limits(self) -> str:
        return f"{self._text(self.row.minimum)} to {self._text(self.row.maximum)}"

    def _text(self, value: float) -> str:
        gap = "" if self._unit.symbol == "°" else " "
        return f"{self._unit.shown(value):.4g}{gap}{self._unit.symbol}".strip()

    def _say_names(self) -> None:
        """Set tool tips and accessible texts: name, unit, range and help."""
        row, words = self.row, self._label.text
        limits = self._limits()
        stable = self._stable
        lines = [f"{row.name}: {row.help}", f"limits {limits}"]
        lines.append(f"▲ at the start {self._text(self._editor.start[row.name])}")
        if stable:
            old = "" if self._fresh else ", with earlier gains"
            lines.append(f"┃ stable {self._text(stable[0])} to {self._text(stable[1])}{old}")
        for part, kind in ((self.slider, "slider"), (self.field, "value")):
            part.setAccessibleName(f"{words} {kind}, {limits}")
            part.setAccessibleDescription("; ".join(lines))
            set_tip(part, "\n".join(lines))
        set_tip(self._name, "\n".join(lines))
        start = self._text(self._editor.start[row.name])
        self.reset.setAccessibleName(f"Reset {words} to {start}")
        set_tip(self.reset, f"Back to {start}, as the flight began")

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Show the parameter's own name if there is room for it."""
        super().resizeEvent(event)
        digit = self.fontMetrics().horizontalAdvance("0")
        spare = self.width() / digit - ROOM_FOR_NAME
        least, most = OWN_NAME_WIDTHS
        known = self._label.words == self.row.name  # a firmware's
        self.own_name.setVisible(spare >= 0.0 and not known)
        self.own_name.setFixedWidth(round(min(max(least, least + spare), most) * digit))
        self._share_width()

    def minimumSizeHint(self) -> QSize:
        """Return the size without the parameter's own name, and with the narrowest columns."""
        least = super().minimumSizeHint()
        grown = self._name.width() + self._unit_shown.width() - sum(self._least_widths())
        return QSize(least.width() - self._own_name_width() - grown, least.height())

    def _own_name_width(self) -> int:
        return self.own_name.width() + GAP if not self.own_name.isHidden() else 0

    def _least_widths(self) -> tuple[int, int]:
        """Least widths of the columns of name and unit [px]."""
        digit = self.fontMetrics().horizontalAdvance("0")
        return round(NAME_WIDTH * digit), round(UNIT_WIDTH * digit)

    def _lay_out(self) -> None:
        digit = self.fontMetrics().horizontalAdvance("0")
        self.field.setFixedWidth(round(FIELD_WIDTH * digit))
        self.mark.setFixedWidth(round(MARK_WIDTH * digit))
        self.mark.setAlignment(Qt.AlignmentFlag.AlignCenter)
        self.own_name.setText(self.row.name)
        self.own_name.setFixedWidth(round(OWN_NAME_WIDTHS[0] * digit))
        parts = (
            self._name,
            self.own_name,
            self.slider,
            self.field,
            self._unit_shown,
            self.mark,
            self.reset,
        )
        box = grid(parts, of=self, margins=NO_MARGINS, spacing=(GAP, 1), stretches=(0, 0, 1))
        box.addWidget(self.error, 1, 0, 1, len(parts))
        self._share_width()


def _step_by_wheel(field: GainSlider | GainField, event: QWheelEvent | None) -> None:
    """Let the wheel step a field that has the focus; otherwise it scrolls the page."""
    if event is None:
        return
    turned = event.angleDelta().y() or event.angleDelta().x()
    if not field.hasFocus() or not turned:
        event.ignore()
        return
    field.stepped.emit(1 if turned > 0 else -1, size_of(event.modifiers()))
    event.accept()

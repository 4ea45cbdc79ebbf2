"""The joystick screen: two sticks, their command, and the drone's response."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from PyQt6.QtCore import QEvent, QPointF, QRectF, QSignalBlocker, QSize, Qt, pyqtSignal
from PyQt6.QtGui import QHideEvent, QMouseEvent, QPainter, QPaintEvent, QPen, QPolygonF, QShowEvent
from PyQt6.QtWidgets import (
    QFrame,
    QSizePolicy,
    QSlider,
    QWidget,
)

from workbench.control.mode import FlightMode
from workbench.gui.flight_control import ON_THE_GROUND
from workbench.gui.help import explain, explained
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.joystick.game_pad import PadButton
from workbench.gui.joystick.keyboard_sticks import KeyWatcher
from workbench.gui.joystick.pad_dialog import PadDialog
from workbench.gui.joystick.pilot import Device, Pilot
from workbench.gui.joystick.piloting import (
    MIDDLE,
    NEUTRAL,
    Bite,
    FlightLimits,
    Handling,
    Stick,
    StickCurve,
    Sticks,
    heading_velocity,
    within_circle,
)
from workbench.gui.labels import Label, set_tip
from workbench.gui.layout import (
    NO_MARGINS,
    Pair,
    buddy,
    button,
    fit_page,
    grid,
    hbox,
    label,
    named,
    vbox,
)
from workbench.gui.preferences import Preferences, find_preference
from workbench.gui.screens import Screen
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.gui.units import Unit, unit_for
from workbench.gui.workspace import Workspace
from workbench.link.messages import ControlState, Hand
from workbench.live.view import LiveView
from workbench.session.snapshot import Snapshot

YAW_RATE = 3
FOLLOW = 7
"""Index in `Snapshot.reference`; the velocity precedes it."""
BAR = 8.0
"""Thickness of a bar [px]."""
TALLEST = 72.0
"""Largest height of a row [px]."""
CURVE_POINTS = 81
DOT = 3.5
HANDLING = (
    "stick_speed",
    "stick_yaw_rate",
    "stick_sensitivity",
    "stick_expo",
    "stick_dead_band",
)
SLIDER_STEPS = 200
"""Number of steps of a slider."""
PERCENT = Unit("%", 100.0)
KNOB_SHARE = 0.2
"""Radius of the knob, as a share of the circle's."""
LARGEST_PAD = 480
"""Largest width and height [px]."""
READY = "Ready: move a stick to fly, release it to stop and hold."
TAKING_OFF = "Taking off: the sticks count once it hovers."
MODE_HELP = "Forward is where the nose points."
KEYS_HELP = "Keys: W A S D and the arrows, held down; not while a field or a slider has the focus."
LEAST_SAID = 0.1
"""Smaller reductions of the keys' speed are not reported as gentle [m/s]."""
TAKES_OVER = "press Start on it, with its sticks released, to take over"
NO_PAD_FLIES = f"The game pad that flew is gone, another one waits: {TAKES_OVER}."
NO_PAD = "Game pad: none is plugged in; it is found as soon as you plug it in."


@dataclass(frozen=True)
class Answered:
    """One axis of a flight; a velocity [m/s] or a yaw rate [rad/s].

    Attributes:
        name: name of the axis; its first direction is positive.
        unit: m/s or rad/s.
        asked: command of the pilot; None while the drone flies to a place by itself.
        flown: present value.
        scale: full length of a bar: full stick, or the flown value if it is larger.
        limit: limit of the flight.
    """

    name: str
    unit: str
    asked: float | None
    flown: float
    scale: float
    limit: float


def answered(snapshot: Snapshot, handling: Handling, limits: FlightLimits) -> tuple[Answered, ...]:
    """Return the four axes of a flight; right is positive, as on a stick."""
    yaw = snapshot.roll_pitch_yaw[2]
    asked, follow = snapshot.reference, snapshot.reference[FOLLOW] > 0.0
    wanted = heading_velocity(asked[:3], yaw)
    flown = heading_velocity(snapshot.v_WB, yaw)
    speed, turn = handling.speed, handling.yaw_rate
    rows = (
        ("Forward", "m/s", wanted[0], flown[0], speed, limits.level),
        ("Right", "m/s", -wanted[1], -flown[1], speed, limits.level),
        ("Climb", "m/s", wanted[2], flown[2], speed, limits.climb),
        ("Turn right", "rad/s", -asked[YAW_RATE], -snapshot.w_WB[2], turn, limits.turn),
    )
    return tuple(
        Answered(name, unit, None if follow else want, fly, scale, limit)
        for name, unit, want, fly, scale, limit in rows
    )


class ResponseView(QWidget):
    """Paints rows of `Answered`.

    Args:
        look: source of colours.
        preferences: source of units.
    """

    def __init__(self, look: Look, preferences: Preferences) -> None:
        super().__init__()
        self._look, self._preferences = look, preferences
        self._rows: tuple[Answered, ...] = ()
        self._texts: tuple[tuple[str, str], ...] = ()
        self.setAccessibleName("Commanded and flown: forward, right and climb, turn right")
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        look.changed.connect(self.update)

    def sizeHint(self) -> QSize:
        """Return the size of four rows."""
        line = self.fontMetrics().height()
        return QSize(28 * self.fontMetrics().averageCharWidth(), 5 * line + 4 * 28)

    def minimumSizeHint(self) -> QSize:
        """Return the least size without clipping."""
        line = self.fontMetrics().height()
        return QSize(34 * self.fontMetrics().averageCharWidth(), 5 * line + 4 * 20)

    def show_rows(self, rows: tuple[Answered, ...]) -> None:
        """Show the present."""
        if rows != self._rows:
            self._rows = rows
            self._texts = tuple(
                (self._text(row.asked, row), self._text(row.flown, row)) for row in rows
            )
            self.update()

    def paintEvent(self, event: QPaintEvent | None) -> None:
        """Paint all rows."""
        painter = QPainter(self)
        if not self._rows:
            painter.setPen(self._look.colour("muted"))
            painter.drawText(self.rect(), Qt.AlignmentFlag.AlignCenter, "No flight yet.")
            return
        line = self.fontMetrics().height()
        flags = Qt.AlignmentFlag
        width = float(self.width())
        column = min(0.36 * width, 13.0 * self.fontMetrics().averageCharWidth())
        painter.setPen(self._look.colour("muted"))
        head = QRectF(0.0, 0.0, width, line)
        painter.drawText(head, flags.AlignRight, "flown")
        painter.drawText(head.adjusted(0, 0, -column, 0), flags.AlignRight, "asked")
        height = min((self.height() - line) / max(1, len(self._rows)), TALLEST)
        for index, (row, (asked, flown)) in enumerate(zip(self._rows, self._texts, strict=True)):
            top = line + index * height + max(2.0, (height - line - BAR - 8.0) / 2)
            text = QRectF(0.0, top, width, line)
            painter.setPen(self._look.colour("ink"))
            painter.drawText(text, flags.AlignLeft, row.name)
            painter.drawText(text, flags.AlignRight, flown)
            painter.setPen(self._look.colour("command"))
            painter.drawText(text.adjusted(0, 0, -column, 0), flags.AlignRight, asked)
            self._paint_bar(painter, row, QRectF(0.0, top + line + 4.0, width, BAR))

    def _paint_bar(self, painter: QPainter, row: Answered, box: QRectF) -> None:
        """Paint the flown value as a bar, the command as a mark, and the limit as a line."""
        look = self._look
        scale = 1.05 * max(row.scale, abs(row.flown), abs(row.asked or 0.0))
        middle, way = box.center().x(), box.width() / 2
        painter.fillRect(box, look.colour("line"))
        end = middle + way * row.flown / scale
        painter.fillRect(
            QRectF(min(middle, end), box.top(), abs(end - middle), BAR), look.colour("accent")
        )
        painter.setPen(QPen(look.colour("muted"), 1.0))
        painter.drawLine(round(middle), round(box.top()) - 1, round(middle), round(box.bottom()))
        if row.limit < scale:
            painter.setPen(QPen(look.colour("warning"), 1.0, Qt.PenStyle.DashLine))
            for side in (-1.0, 1.0):
                fence = round(middle + side * way * row.limit / scale)
                painter.drawLine(fence, round(box.top()) - 3, fence, round(box.bottom()) + 2)
        if row.asked is not None and abs(row.asked) > 0.01 * scale:
            at = middle + way * row.asked / scale
            painter.fillRect(QRectF(at - 1.5, box.top() - 4.0, 3.0, BAR + 8.0), look.colour("ink"))

    def _text(self, value: float | None, row: Answered) -> str:
        unit = unit_for(row.unit, self._preferences)
        decimals = 1 if unit.symbol == "°/s" else 2
        return "to a place" if value is None else unit.text(value, decimals)


class CurveView(Instrument):
    """Shaped over raw input, with a dot for each deflected axis.

    Args:
        look: source of colours.
        parent: the Qt parent; this object is deleted with it.
    """

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Curve of the sticks", parent)
        self._curve, self._sticks = StickCurve(), NEUTRAL
        self.setSizePolicy(QSizePolicy.Policy.Preferred, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(130, 120)

    def sizeHint(self) -> QSize:
        """Return a small square."""
        return QSize(180, 170)

    def show_curve(self, curve: StickCurve) -> None:
        """Show a curve."""
        if curve != self._curve:
            self._curve = curve
            self.renew()
        self.setAccessibleName(
            f"Curve of the sticks: half stick commands {curve.shaped(0.5):.0%}, full stick "
            f"{curve.shaped(1.0):.0%}"
        )

    def show_sticks(self, sticks: Sticks) -> None:
        """Show the sticks' positions on it."""
        if sticks != self._sticks:
            self._sticks = sticks
            self.update()

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint a dot for each deflected axis."""
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.colour("card"), 1.0))
        painter.setBrush(self.colour("accent"))
        left, right = self._sticks.left, self._sticks.right
        for raw in (left.x, left.y, right.x, right.y):
            if raw != 0.0:
                painter.drawEllipse(self._at(raw, self._curve.shaped(raw)), DOT, DOT)

    @property
    def _box(self) -> QRectF:
        """The square from -1 to 1."""
        line = self.fontMetrics().height()
        side = max(20.0, min(self.width() - 4.0, self.height() - line - 6.0))
        return QRectF((self.width() - side) / 2, 2.0, side, side)

    def _at(self, raw: float, shaped: float) -> QPointF:
        box = self._box
        return QPointF(
            box.left() + (raw + 1.0) / 2 * box.width(),
            box.bottom() - (shaped + 1.0) / 2 * box.height(),
        )

    def paint_still(self, painter: QPainter) -> None:
        """Paint the square, the dead band and the curve."""
        box = self._box
        painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
        painter.setFont(self.font())
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("field"))
        painter.drawRect(box)
        dead = self._curve.dead_band
        painter.fillRect(QRectF(self._at(-dead, 1.0), self._at(dead, -1.0)), self.colour("line"))
        painter.drawLine(self._at(-1.0, 0.0), self._at(1.0, 0.0))
        painter.drawLine(self._at(0.0, -1.0), self._at(0.0, 1.0))
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        painter.setPen(QPen(self.colour("muted"), 1.0, Qt.PenStyle.DotLine))
        painter.drawLine(self._at(-1.0, -1.0), self._at(1.0, 1.0))
        painter.setPen(QPen(self.colour("accent"), 2.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        raws = np.linspace(-1.0, 1.0, CURVE_POINTS)
        painter.drawPolyline(
            QPolygonF([self._at(raw, self._curve.shaped(raw)) for raw in raws.tolist()])
        )
        painter.setPen(self.colour("muted"))
        under = QRectF(0.0, box.bottom() + 3.0, self.width(), self.fontMetrics().height())
        painter.drawText(under, Qt.AlignmentFlag.AlignHCenter, "pushed → commanded ↑")


class HandlingPanel(QWidget):
    """Sliders for the preferences of the sticks.

    Args:
        preferences: storage of the values.
        look: source of colours.

    Attributes:
        curve: the curve beside them.
        sliders: sliders by the name of their preference.
    """

    def __init__(self, preferences: Preferences, look: Look) -> None:
        super().__init__()
        self._preferences = preferences
        self.curve = CurveView(look, self)
        self.sliders: dict[str, QSlider] = {}
        self._values: dict[str, Label] = {}
        rows = map(self._make_row, HANDLING)
        fields = grid(*rows, spacing=(12, 2), stretches=(0, 1))
        fields.setRowStretch(len(HANDLING) + 1, 1)
        defaults = named(
            button("Defaults", self._reset, "quiet compact", "Restore the defaults of all five."),
            "Restore the default feel of the sticks",
        )
        top = hbox(label("Feel of the sticks", "heading"), 1, defaults)
        left = vbox(top, (fields, 1), spacing=0)
        hbox((left, 3), (self.curve, 1), of=self, margins=NO_MARGINS, spacing=16)
        preferences.changed.connect(self._follow)

    def _make_row(self, name: str) -> tuple[QWidget, ...]:
        row = find_preference(name)
        slider = QSlider(Qt.Orientation.Horizontal, self)
        slider.setRange(0, SLIDER_STEPS)
        slider.setPageStep(SLIDER_STEPS // 10)
        set_tip(slider, row.help)
        low, high = self._text(name, row.minimum), self._text(name, row.maximum)
        slider.setAccessibleName(f"{row.label}, {low} to {high}")
        value = label()
        value.setAlignment(Qt.AlignmentFlag.AlignRight | Qt.AlignmentFlag.AlignVCenter)
        value.setMinimumWidth(9 * self.fontMetrics().averageCharWidth())
        self.sliders[name], self._values[name] = slider, value
        self._follow(name)
        slider.valueChanged.connect(lambda place: self._move(name, place))
        before = buddy(row.label, slider, kind="")
        set_tip(before, row.help)
        return before, slider, value

    def _move(self, name: str, place: int) -> None:
        row = find_preference(name)
        value = row.minimum + place / SLIDER_STEPS * (row.maximum - row.minimum)
        step = 0.1 if row.unit == "m/s" else 0.01
        self._preferences.set(name, min(max(round(value / step) * step, row.minimum), row.maximum))

    def _follow(self, name: str) -> None:
        """Show the present preferences."""
        if name in ("speed_unit", "angle_unit"):
            for each in HANDLING:
                self._values[each].setText(self._text(each, self._preferences.number(each)))
        if name not in self.sliders:
            return
        row, value = find_preference(name), self._preferences.number(name)
        slider = self.sliders[name]
        with QSignalBlocker(slider):
            slider.setValue(
                round((value - row.minimum) / (row.maximum - row.minimum) * SLIDER_STEPS)
            )
        self._values[name].setText(self._text(name, value))

    def _text(self, name: str, value: float) -> str:
        si = find_preference(name).unit
        if si == "1":
            return PERCENT.text(value, 0)
        return unit_for(si, self._preferences).text(value, 1)

    def _reset(self) -> None:
        for name in HANDLING:
            self._preferences.reset(name)


@dataclass(frozen=True)
class Words:
    """What a stick does in each direction, and the equivalent keys.

    Attributes:
        name: name of the stick.
        up: effect of the direction away from the pilot; the next three likewise.
        down: towards the pilot.
        left: effect to the left.
        right: effect to the right.
        keys: keys for up, down, left and right.
    """

    name: str
    up: str
    down: str
    left: str
    right: str
    keys: tuple[str, str, str, str]


LEFT_STICK = Words("Left stick", "climb", "sink", "turn left", "turn right", ("W", "S", "A", "D"))
RIGHT_STICK = Words("Right stick", "forward", "back", "left", "right", ("↑", "↓", "←", "→"))


class StickPad(Instrument):
    """Shows a stick, and lets the mouse move it.

    Args:
        words: effects of its directions.
        look: source of colours.
        parent: the Qt parent; this object is deleted with it.

    Attributes:
        stick: the shown position.
    """

    dragged = pyqtSignal(object)
    """The `Stick` while the mouse holds it, None on release."""

    def __init__(self, words: Words, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(
            look,
            f"{words.name}: up {words.up}, down {words.down}, left {words.left}, "
            f"right {words.right}; keys {' '.join(words.keys)}; minus 1 to 1",
            parent,
        )
        self._words = words
        self.stick, self._counts, self._dead_band = MIDDLE, True, 0.0
        self._held = False
        self.setSizePolicy(QSizePolicy.Policy.Expanding, QSizePolicy.Policy.Expanding)
        self.setMinimumSize(170, 170)
        self.setCursor(Qt.CursorShape.OpenHandCursor)

    def sizeHint(self) -> QSize:
        """Return a size that suits a thumb."""
        return QSize(240, 240)

    def show_stick(self, stick: Stick, counts: bool) -> None:
        """Show the stick's position, and whether it has an effect."""
        if (stick, counts) != (self.stick, self._counts):
            before = self._knob()
            self.stick, self._counts = stick, counts
            self.update(before.united(self._knob()).toAlignedRect().adjusted(-4, -4, 4, 4))

    def show_dead_band(self, dead_band: float) -> None:
        """Show the dead band around the centre."""
        if dead_band != self._dead_band:
            self._dead_band = dead_band
            self.renew()

    def place(self, stick: Stick) -> QPointF:
        """Return the position of the knob's centre for a stick."""
        way = self._radius * (1.0 - KNOB_SHARE)
        return self._middle + QPointF(stick.x * way, -stick.y * way)

    def let_go(self) -> None:
        """Return to the centre, whatever the mouse does."""
        if self._held:
            self._held = False
            self.setCursor(Qt.CursorShape.OpenHandCursor)
            self.dragged.emit(None)

    def mousePressEvent(self, event: QMouseEvent | None) -> None:
        """Grab the stick."""
        if event is None or event.button() != Qt.MouseButton.LeftButton:
            super().mousePressEvent(event)
            return
        self._held = True
        self.setCursor(Qt.CursorShape.ClosedHandCursor)
        self._drag(event.position())

    def mouseMoveEvent(self, event: QMouseEvent | None) -> None:
        """Move the stick."""
        if event is not None and self._held:
            self._drag(event.position())

    def mouseReleaseEvent(self, event: QMouseEvent | None) -> None:
        """Release the stick."""
        if event is not None and event.button() == Qt.MouseButton.LeftButton:
            self.let_go()

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the knob."""
        middle, knob = self._middle, self._knob()
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        colour = self.colour("accent" if self._counts else "muted")
        if not self.stick.is_neutral:
            painter.setPen(QPen(colour, 3.0))
            painter.drawLine(middle, knob.center())
        painter.setPen(QPen(self.colour("card"), 2.0))
        painter.setBrush(colour)
        painter.drawEllipse(knob)
        if not self._counts:  # a bar across: not by colour alone
            painter.setPen(QPen(self.colour("card"), 3.0))
            way = QPointF(0.55 * knob.width() / 2, 0.0)
            painter.drawLine(knob.center() - way, knob.center() + way)

    @property
    def _middle(self) -> QPointF:
        return QPointF(self.width() / 2, self.height() / 2)

    @property
    def _radius(self) -> float:
        return min(self.width(), self.height(), LARGEST_PAD) / 2 - 3.0

    def _knob(self) -> QRectF:
        radius = self._radius * KNOB_SHARE
        place = self.place(self.stick)
        return QRectF(place.x() - radius, place.y() - radius, 2 * radius, 2 * radius)

    def _drag(self, to: QPointF) -> None:
        way = self._radius * (1.0 - KNOB_SHARE)
        off = to - self._middle
        self.dragged.emit(within_circle(off.x() / way, -off.y() / way))

    def paint_still(self, painter: QPainter) -> None:
        """Paint circle, cross, dead band and words."""
        middle, radius = self._middle, self._radius
        painter.setFont(self.font())
        painter.setPen(QPen(self.colour("line"), 2.0))
        painter.setBrush(self.colour("ground"))
        painter.drawEllipse(middle, radius, radius)
        way = radius * (1.0 - KNOB_SHARE)
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(Qt.BrushStyle.NoBrush)
        painter.drawEllipse(middle, way / 2, way / 2)
        painter.drawLine(middle - QPointF(way / 2, 0), middle + QPointF(way / 2, 0))
        painter.drawLine(middle - QPointF(0, way / 2), middle + QPointF(0, way / 2))
        dead = self._dead_band * way
        painter.setBrush(self.colour("line"))
        painter.drawRect(QRectF(middle.x() - dead, middle.y() - dead, 2 * dead, 2 * dead))
        self._paint_words(painter)

    def _paint_words(self, painter: QPainter) -> None:
        """Paint the effect of each direction, and its key, along the rim."""
        words, middle, radius = self._words, self._middle, self._radius
        line = painter.fontMetrics().lineSpacing()
        painter.setPen(self.colour("muted"))
        box = QRectF(
            middle.x() - radius + 8, middle.y() - radius + 8, 2 * radius - 16, 2 * radius - 16
        )
        flags, whole = Qt.AlignmentFlag, Qt.TextFlag.TextDontClip.value
        up, down, left, right = words.keys
        painter.drawText(box, flags.AlignHCenter | flags.AlignTop, f"{up}\n{words.up}")
        painter.drawText(box, flags.AlignHCenter | flags.AlignBottom, f"{words.down}\n{down}")
        for text, key, side in (
            (words.left, left, flags.AlignLeft),
            (words.right, right, flags.AlignRight),
        ):
            lines = [key, *text.split()]
            area = QRectF(
                box.left(), middle.y() - line * len(lines) / 2, box.width(), line * len(lines)
            )
            painter.drawText(area, (side | flags.AlignVCenter).value | whole, "\n".join(lines))


def say_state(view: LiveView, barred: str, device: Device) -> str:
    """Return whether the sticks have an effect, as a sentence."""
    if barred:
        return barred
    if view.snapshot is not None and view.snapshot.mode is FlightMode.TAKING_OFF:
        return TAKING_OFF
    return READY if device is Device.NONE else f"You fly, by {device.value}."


def say_control(view: LiveView) -> str:
    """Return who has control, as a sentence."""
    control = view.network.control
    if is_client(control):
        assert control is not None
        name = control.name or f"Client {control.peer}"
        return f"{name} flies over the network. A stick that you move takes over."
    if view.network.server is None:
        return "No server runs, so nobody else can fly."
    if control is not None and control.hand is Hand.OPERATOR:
        return "You have control. Clients wait until you give it back."
    return "Nobody has control. A stick that you move takes it."


def say_bites(bites: tuple[Bite, ...], preferences: Preferences) -> str:
    """Return which limits of the flight reduce the command, "" for none."""
    said = []
    for bite in bites:
        unit = unit_for(bite.unit, preferences)
        said.append(
            f"{bite.what} is held to {unit.text(bite.limit, 1)} by {bite.parameter}, not "
            f"{unit.text(bite.asked, 1)}"
        )
    return "Limit: " + "; ".join(said) + "." if said else ""


def is_client(control: ControlState | None) -> bool:
    """Return whether a client has control."""
    return control is not None and control.hand is Hand.CLIENT


def is_operator(control: ControlState | None) -> bool:
    """Return whether the operator has taken control, so that clients must wait."""
    return control is not None and control.hand is Hand.OPERATOR


def say_keys(pilot: Pilot, preferences: Preferences) -> str:
    """Return which keys fly, and how gently near an obstacle."""
    most, plain = pilot.key_handling.speed, pilot.handling.speed
    if most > plain - LEAST_SAID:
        return KEYS_HELP
    metres = unit_for("m", preferences).text(max(0.0, pilot.clearance), 1)
    speed = unit_for("m/s", preferences).text(most, 1)
    return f"{KEYS_HELP} An obstacle is {metres} away: held keys command {speed} at most."


class StateBar(QFrame):
    """Two lines of text and three buttons, each shown only when useful.

    Args:
        pilot: pilot of the sticks.
        workspace: services that all screens share.
    """

    def __init__(self, pilot: Pilot, workspace: Workspace) -> None:
        super().__init__()
        self._pilot, self._workspace = pilot, workspace
        self.setProperty("class", "card")
        explain(self, "Who flies")
        self.state = label(kind="value", wraps=True)
        self.control = label(kind="muted", wraps=True)
        flight = workspace.flight
        self.take_off = button(
            "Take off", lambda: flight.order(lambda live: live.request("take_off")), "primary"
        )
        self.take_over = button(
            "Take over", lambda: flight.order(lambda live: live.take_over()), "primary"
        )
        self.give_back = button("Give back", pilot.give_back)
        for each, help in (
            (self.take_off, "take off"),
            (self.take_over, "take control from the client that flies"),
            (self.give_back, "let clients request control again"),
        ):
            named(each, f"{each.text()}: {help}").hide()
        words = vbox(self.state, self.control, spacing=2)
        hbox(
            (words, 1),
            self.take_off,
            self.take_over,
            self.give_back,
            of=self,
            margins=(16, 10, 16, 10),
            spacing=8,
        )

    def show_view(self, view: LiveView) -> None:
        """Show the state."""
        pilot, control = self._pilot, view.network.control
        state = say_state(view, pilot.barred, pilot.device)
        _show(self.state, state)
        bites = say_bites(pilot.limits.bites(pilot.wish), self._workspace.preferences)
        _show(self.control, bites or say_control(view))
        set_class(self.control, "warning" if bites else "muted")
        self.take_off.setVisible(pilot.barred == ON_THE_GROUND)
        self.take_over.setVisible(is_client(control))
        has_server = view.network.server is not None
        self.give_back.setVisible(has_server and is_operator(control))


def _show(label: Label, text: str) -> None:
    """Show a text if it has changed: setting a label always triggers a new layout."""
    if label.text() != text:
        label.setText(text)


def say_pad(missing: str, name: str, waiting: int = 0, refused: str = "") -> str:
    """Return a line about the game pads.

    Args:
        missing: why there are none, else "".
        name: name of the pad that flies, "" without one.
        waiting: number of other plugged-in pads.
        refused: why one of them may not take over.
    """
    if missing:
        return missing
    if refused:
        return refused
    if not name:
        return NO_PAD_FLIES if waiting else NO_PAD
    buttons = ", ".join(f"{each.place}: {each.words}" for each in PadButton)
    if waiting:
        return f"{name} flies, {waiting} waits: {TAKES_OVER}. {buttons}."
    return f"Game pad: {name}. {buttons}."


class JoystickScreen(Screen):
    """Fly by mouse, keyboard or game pad.

    Args:
        workspace: services that all screens share.

    Attributes:
        pilot: reads the sticks and flies.
        left_pad: the stick for climb and yaw.
        right_pad: the stick for horizontal flight.
        response: commanded and flown values.
        handling: sensitivity of the sticks.
        state_bar: whether the sticks have an effect, and who has control.
    """

    def __init__(self, workspace: Workspace) -> None:
        super().__init__(workspace)
        look, preferences = workspace.look, workspace.preferences
        self.setFocusPolicy(Qt.FocusPolicy.StrongFocus)
        self.pilot = Pilot(workspace.flight, preferences, self)
        self.state_bar = StateBar(self.pilot, workspace)
        self.left_pad = StickPad(LEFT_STICK, look, self)
        self.right_pad = StickPad(RIGHT_STICK, look, self)
        self.response = ResponseView(look, preferences)
        self.handling = HandlingPanel(preferences, look)
        self._keys_line = label(KEYS_HELP, "muted", wraps=True)
        self._pad_line = label("", "muted", wraps=True)
        help = "What the axes of each pad do, and which pad flies."
        self.pads_button = button("Game pads…", self._map_pads, "quiet compact", help)
        self._keys = KeyWatcher(
            self, self._press, self._let_go_key, self.pilot.keyboard.release_all
        )
        self._lay_out()
        self.left_pad.dragged.connect(lambda stick: self.pilot.hold_stick("left", stick))
        self.right_pad.dragged.connect(lambda stick: self.pilot.hold_stick("right", stick))
        self.pilot.changed.connect(self._show_sticks)
        self._show_sticks()

    def begin(self, view: LiveView) -> None:
        """Note that a flight has begun."""
        self.pilot.begin(view)
        self.show_view(view)

    def show_view(self, view: LiveView) -> None:
        """Show the command and the response, and who has control."""
        if view.snapshot is not None and self.workspace.flight.live is not None:
            self.response.show_rows(answered(view.snapshot, self.pilot.handling, self.pilot.limits))
        self.state_bar.show_view(view)
        _show(self._keys_line, say_keys(self.pilot, self.workspace.preferences))

    def release(self) -> None:
        """Release both sticks."""
        self.left_pad.let_go()
        self.right_pad.let_go()
        self.pilot.release()

    def close_screen(self) -> None:
        """Close the game pads."""
        self.release()
        self.pilot.close()

    def showEvent(self, event: QShowEvent | None) -> None:
        """Start reading the sticks."""
        super().showEvent(event)
        self.pilot.listen_to_pads(self.isActiveWindow())
        self.pilot.start()
        self._keys.start()
        self.setFocus(Qt.FocusReason.OtherFocusReason)
        self.show_view(self.workspace.flight.view)

    def hideEvent(self, event: QHideEvent | None) -> None:
        """Stop reading the sticks."""
        super().hideEvent(event)
        self._keys.stop()
        self.release()
        self.pilot.stop()

    def event(self, event: QEvent | None) -> bool:
        """Release the sticks when another window becomes active."""
        if event is not None and event.type() is QEvent.Type.WindowDeactivate:
            self.pilot.listen_to_pads(False)
            self.release()
        elif event is not None and event.type() is QEvent.Type.WindowActivate:
            self.pilot.listen_to_pads(True)
        return super().event(event)

    def _map_pads(self) -> None:
        """Open the dialog of the pads; the main window is then inactive, so no pad flies."""
        self.release()
        PadDialog(self.pilot, self.workspace.look, self).show()  # not modal: STOP stays available

    def _press(self, key: Any) -> None:
        self.pilot.keyboard.press(key)
        self.pilot.look()

    def _let_go_key(self, key: Any) -> None:
        self.pilot.keyboard.release(key)
        self.pilot.look()

    def _show_sticks(self) -> None:
        """Show the sticks' positions."""
        pilot = self.pilot
        counts = not pilot.barred
        self.left_pad.show_stick(pilot.sticks.left, counts)
        self.right_pad.show_stick(pilot.sticks.right, counts)
        for pad in (self.left_pad, self.right_pad):
            pad.show_dead_band(pilot.handling.curve.dead_band)
        self.handling.curve.show_curve(pilot.handling.curve)
        self.handling.curve.show_sticks(pilot.sticks)
        said = say_pad(pilot.pads.missing, pilot.pad_name, pilot.pads_waiting, pilot.hand_over)
        self._pad_line.setText(said)
        self.pads_button.setEnabled(bool(pilot.pads.readings))
        self.state_bar.show_view(self.workspace.flight.view)

    def _lay_out(self) -> None:
        sticks = hbox((self.left_pad, 1), (self.right_pad, 1), spacing=16)
        flying = explained("Sticks", (sticks, 1), label(MODE_HELP, "muted"))
        heading = label("Command and answer", "heading")
        answer = explained("Command and answer", heading, (self.response, 1))
        hints = vbox(self._keys_line, self._pad_line, spacing=2)
        page = vbox(
            self.state_bar,
            (Pair(flying, answer, (3, 2), 12), 1),
            explained("Feel of the sticks", (self.handling, 1)),
            hbox((hints, 1), self.pads_button),
            margins=(16, 12, 16, 12),
            spacing=12,
        )
        fit_page(self, page)

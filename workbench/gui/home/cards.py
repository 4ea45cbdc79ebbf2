"""The base class of the Home screen's cards, and those of battery, flight mode, time and rotors."""

import math
import time
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from enum import Enum
from typing import Any

from PyQt6.QtCore import QPointF, QRectF, Qt
from PyQt6.QtGui import QBrush, QFontMetricsF, QPainter, QPen, QResizeEvent
from PyQt6.QtWidgets import QWidget

from workbench.common.plain_text import plain_name
from workbench.control.mode import FlightMode, Reason
from workbench.gui.help import explain
from workbench.gui.home.sensor_state import Health, SensorState
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.icons import MODES, paint_picture
from workbench.gui.instruments.heading import direction_of, point_of
from workbench.gui.instruments.instrument import LEFT, RIGHT, Hint, Instrument, Sign
from workbench.gui.instruments.readout import WIDEST, Line, Readout
from workbench.gui.theme import Look
from workbench.live.announcer import LOW_CHARGE
from workbench.live.messages import Phase
from workbench.live.view import LiveView
from workbench.plant.rotors import Rotor
from workbench.scenario.parameters import MOST_ROTORS
from workbench.session.snapshot import Snapshot

WIDE = 1.2
"""Least ratio of width to height at which picture and numbers are side by side."""
PICTURE = 0.6
"""Largest share of the width for the picture then."""

PADDING = 0.8
"""Padding inside the frame, relative to plain text."""
TITLE = 1.75
"""Height of the title's line, relative to plain text."""
SIGNS = {
    Health.ABSENT: Sign.OFF,
    Health.OFF: Sign.OFF,
    Health.WAITING: Sign.OFF,
    Health.GOOD: Sign.GOOD,
    Health.OLD: Sign.WARNING,
    Health.FAULTY: Sign.BAD,
}


def beside(
    body: QRectF, gap: float, numbers_height: float, share: float = PICTURE
) -> tuple[QRectF, QRectF]:
    """Return the areas of a card's picture and numbers: side by side, or one above the other.

    Args:
        body: area of the card's content.
        gap: space between the two [px].
        numbers_height: height of the numbers if they are below [px].
        share: largest share of the width for the picture if it is on the left.
    """
    if body.width() >= WIDE * body.height():
        width = min(body.height(), share * body.width())
        picture = QRectF(body.left(), body.top(), width, body.height())
        numbers = QRectF(body)
        numbers.setLeft(picture.right() + gap)
        return picture, numbers
    picture, numbers = QRectF(body), QRectF(body)
    picture.setBottom(body.bottom() - numbers_height - gap)
    numbers.setTop(body.bottom() - numbers_height)
    return picture, numbers


class Card(Instrument):
    """A framed group of related instruments.

    Attributes:
        name: name in the layouts of the Home screen.
        title: title at the top.
        parts: contained instruments.
        sign: the symbol before the note, if any.
        note: the text beside the title.
    """

    ground = "ground"
    name = ""
    title = ""

    def __init__(self, look: Look, units: ShownUnits, parent: QWidget | None = None) -> None:
        super().__init__(look, self.title, parent)
        explain(self, self.title)
        self.units = units
        self.parts: list[Instrument] = []
        self._table: Readout | None = None
        self.note = ""
        self.sign: Sign | None = None

    @property
    def body(self) -> QRectF:
        """The area below the title."""
        pad, size = PADDING * self.text_size, self.text_size
        return self.area.adjusted(pad, 0.5 * pad + TITLE * size, -pad, -0.8 * pad)

    @property
    def spoken(self) -> str:
        """The content as a sentence, for a screen reader."""
        return "; ".join(part.spoken for part in self.parts if part.isVisibleTo(self))

    def begin(self, view: LiveView) -> None:
        """A flight begins."""

    def show_dials(self, view: LiveView, now: Snapshot) -> None:
        """Update smoothly moving parts; called for every view."""

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Update numbers; called ten times a second."""

    def lines(self, units: ShownUnits) -> Sequence[Line]:
        """Return the lines of the card's table, if it has one, in some units."""
        return ()

    def make_table(self, name: str, columns: Sequence[str] = (), widest: str = WIDEST) -> Readout:
        """Return a table of the card's `lines`, whose units follow; arguments as for `Readout`."""
        lines = self.lines(self.units)
        self._table = Readout(self.look, name, lines, columns, widest, self)
        return self._table

    def make_hint(self, name: str) -> Hint:
        """Return a hidden hint, which is shown in place of a table without readings."""
        hint = Hint(self.look, name, self)
        hint.hide()
        return hint

    def use_units(self, units: ShownUnits) -> None:
        """Show numbers in other units from now on."""
        self.units = units
        if self._table is not None:
            for index, line in enumerate(self.lines(units)):
                self._table.set_line(index, line)

    def place_parts(self, body: QRectF) -> None:
        """Place the parts; by default each of them fills the card."""
        for part in self.parts:
            put(part, body)

    def set_note(self, note: str, sign: Sign | None = None) -> None:
        """Show a note beside the title, with a symbol if it is a state."""
        if (note, sign) != (self.note, self.sign):
            self.note, self.sign = note, sign
            self.update(self._title_line.toAlignedRect())

    def set_state(self, state: SensorState) -> None:
        """Show a sensor's state beside the title."""
        self.set_note(state.note, SIGNS[state.health])

    def set_text_size(self, size: float) -> None:
        """Set the text size of the parts, too."""
        super().set_text_size(size)
        for part in self.parts:
            part.set_text_size(size)
        self.place_parts(self.body)

    def paint_still(self, painter: QPainter) -> None:
        """Paint frame and title."""
        self.paint_frame(painter)
        painter.setFont(self.face(1.0, bold=True))
        painter.setPen(self.colour("muted"))
        painter.drawText(self._title_line, LEFT, self.title)

    def paint_frame(self, painter: QPainter) -> None:
        """Paint the frame."""
        painter.setPen(QPen(self.colour("line"), 1.0))
        painter.setBrush(self.colour("card"))
        corner = 0.5 * self.text_size
        painter.drawRoundedRect(self.area.adjusted(0.5, 0.5, -0.5, -0.5), corner, corner)

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the note."""
        line = self._title_line
        if not self.note or not line.intersects(rect):
            return
        painter.setFont(self.face())
        calm = self.sign in (None, Sign.GOOD, Sign.OFF)
        colour = "muted" if calm or self.sign is None else self.sign.value
        painter.setPen(self.colour(colour))
        painter.drawText(line, RIGHT, self.note)
        if self.sign is not None:
            side = 0.85 * self.text_size
            width = painter.fontMetrics().horizontalAdvance(self.note)
            place = QRectF(line.right() - width - 1.4 * side, 0.0, side, side)
            place.moveTop(line.center().y() - side / 2)
            self.sign.paint(painter, place, self.colour(self.sign.value))

    def resizeEvent(self, event: QResizeEvent | None) -> None:
        """Place the parts again."""
        super().resizeEvent(event)
        self.place_parts(self.body)

    @property
    def _title_line(self) -> QRectF:
        pad = PADDING * self.text_size
        return QRectF(pad, 0.5 * pad, self.width() - 2 * pad, TITLE * self.text_size)


def put(part: QWidget, place: QRectF) -> None:
    """Place a widget, in whole pixels."""
    part.setGeometry(place.toRect())


def charge_word(charge: float, reserve: float) -> str:
    """Return a charge 0 .. 1 as a word: empty, at the reserve, low, or good."""
    if math.isnan(charge):
        return "unknown"
    if charge <= 0.0:
        return "empty"
    if charge <= reserve:
        return "reserve: lands"
    return "low" if charge <= reserve + LOW_CHARGE else "good"


class ChargeBar(Instrument):
    """A bar with per cent, and a mark at the charge at which the drone lands by itself."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Battery", parent)
        self._charge, self._reserve = math.nan, 0.15

    @property
    def text(self) -> str:
        """The charge in per cent, as text."""
        if math.isnan(self._charge):
            return "–"
        return f"{100 * self._charge:.0f}\N{NO-BREAK SPACE}%"

    @property
    def word(self) -> str:
        """The charge as a word."""
        return charge_word(self._charge, self._reserve)

    @property
    def spoken(self) -> str:
        """The charge as a sentence."""
        return f"{self.text}, {self.word}; reserve {100 * self._reserve:.0f} %"

    def show_charge(self, charge: float, reserve: float) -> None:
        """Show a charge and the reserve, 0 .. 1."""
        shown = charge if math.isnan(charge) else round(charge, 3)
        if (str(shown), reserve) != (str(self._charge), self._reserve):
            self._charge, self._reserve = shown, reserve
            self.update()

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the bar, the reserve's mark, and per cent."""
        size = self.text_size
        name = {"good": "good", "low": "warning"}.get(self.word, "bad")
        painter.setRenderHint(QPainter.RenderHint.Antialiasing)
        body = self._body()
        painter.setPen(QPen(self.colour("muted"), 1.2))
        painter.setBrush(self.colour("field"))
        painter.drawRoundedRect(body, 3.0, 3.0)
        inner = body.adjusted(2.0, 2.0, -2.0, -2.0)
        full = QRectF(inner)
        charge = 0.0 if math.isnan(self._charge) else max(0.0, min(1.0, self._charge))
        full.setWidth(charge * inner.width())
        painter.fillRect(full, self.colour(name))
        if name != "good":  # not by colour alone
            painter.fillRect(full, QBrush(self.colour("card"), Qt.BrushStyle.BDiagPattern))
        x = inner.left() + self._reserve * inner.width()
        painter.setPen(QPen(self.colour("ink"), 2.0))
        painter.drawLine(QPointF(x, body.top() - 2.0), QPointF(x, body.bottom() + 2.0))
        painter.setFont(self.face(1.5, bold=True))
        painter.setPen(self.colour("ink"))
        painter.drawText(
            QRectF(self.width() - 5.2 * size, 0.0, 5.2 * size, self.height()), RIGHT, self.text
        )

    def _body(self) -> QRectF:
        size = self.text_size
        height = min(1.5 * size, self.height() - 5.0)
        return QRectF(
            1.0, (self.height() - height) / 2, max(10.0, self.width() - 6.0 * size), height
        )


class BatteryCard(Card):
    """The charge, and the reserve at which it lands by itself."""

    name = "battery"
    title = "Battery"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self.bar = ChargeBar(look, self)
        self.parts = [self.bar]

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the charge."""
        reserve = self._watch.value("battery_reserve")
        self.bar.show_charge(now.charge, reserve)
        word = self.bar.word
        signs = {"good": Sign.GOOD, "low": Sign.WARNING}
        self.set_note(
            f"{word}, reserve {100 * reserve:.0f}\N{NO-BREAK SPACE}%", signs.get(word, Sign.BAD)
        )


PHASES: Mapping[Phase, tuple[str, Sign]] = {
    Phase.PAUSED: ("paused", Sign.WARNING),
    Phase.BROKEN: ("broken: reset to fly again", Sign.BAD),
    Phase.ENDED: ("ended: open a scenario", Sign.BAD),
}
"""Text for a flight that does not advance."""
HELD = ("held: reset to fly again", Sign.BAD)
"""Text for a flight whose autopilot has ended."""
CALM = 0.05
"""A slower wind counts as calm [m/s]."""


def wind_text(wind: tuple[float, float, float], units: ShownUnits) -> str:
    """Return a wind in words: its speed, and the direction that it comes from.

    Args:
        wind: velocity of the air in W [m/s].
        units: units of the text.
    """
    if not all(map(math.isfinite, wind)):
        return "wind –"
    east, north, up = wind
    level = math.hypot(east, north)
    parts = []
    if level >= CALM:
        source = direction_of(-east, -north)
        said = units.speed.unit.text(level, 1)
        parts.append(f"wind {said} from {source:03.0f}° ({point_of(source)})")
    if abs(up) >= CALM:
        said = units.speed.unit.text(abs(up), 1)
        parts.append(f"{'up' if up > 0.0 else 'down'} {said}")
    return ", ".join(parts) or "no wind"


class ConditionCard(Card):
    """The flight mode, large."""

    name = "condition"
    title = "Flight condition"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.mode = FlightMode.OFF
        self.facts = ""

    @property
    def spoken(self) -> str:
        """The state as a sentence."""
        return f"{self.mode.label}, {self.facts}"

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show mode, rotors and wind."""
        ended = now.reason is Reason.AUTOPILOT_ENDED
        rotors = "rotors off" if ended or now.mode is FlightMode.OFF else "rotors on"
        self.set_note(*PHASES.get(view.phase, HELD if ended else ("", None)))
        facts = f"{rotors} · {wind_text(now.wind, self.units)}"
        if now.reason.label:
            facts = f"{now.reason.label} · {facts}"
        if (now.mode, facts) != (self.mode, self.facts):
            self.mode, self.facts = now.mode, facts
            self.update(self.body.toAlignedRect())

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint mode and facts."""
        super().paint_moving(painter, rect)
        if not self.facts:
            self._paint_nothing(painter)
            return
        body, size = self.body, self.text_size
        high = min(body.height(), 3.8 * size)
        top = body.top() + (body.height() - high) / 2
        side = 1.7 * size
        shape = QRectF(body.left() + 0.1 * size, top + 0.2 * size, side, side)
        paint_picture(painter, shape, MODES[self.mode], self.colour("accent"))
        painter.setFont(self.face(1.6, bold=True))
        painter.setPen(self.colour("ink"))
        word = QRectF(body.left() + 2.4 * size, top, body.width(), 2.1 * size)
        painter.drawText(word, LEFT, self.mode.label.capitalize())
        painter.setFont(self.face())
        painter.setPen(self.colour("muted"))
        line = QRectF(body.left(), top + 2.2 * size, body.width(), 1.5 * size)
        painter.drawText(line, LEFT, self.facts)

    def _paint_nothing(self, painter: QPainter) -> None:
        """Paint the hint that there is no flight yet."""
        painter.setFont(self.face())
        painter.setPen(self.colour("muted"))
        painter.drawText(self.body, LEFT, "Nothing flies yet: open a scenario.")


def simulated_text(seconds: float, decimals: int) -> str:
    """Return a simulated time [s] as minutes and seconds, with hours if needed: 1:02.5."""
    if not math.isfinite(seconds):
        return "–"
    ticks = round(seconds * 10**decimals)
    whole, part = divmod(ticks, 10**decimals)
    minutes, seconds_left = divmod(whole, 60)
    text = f"{seconds_left:02d}.{part:0{decimals}d}"
    return f"{minutes // 60}:{minutes % 60:02d}:{text}" if minutes >= 60 else f"{minutes}:{text}"


class ClockCard(Card):
    """The large clock; the upper line has the times, the lower one their names."""

    name = "clock"
    title = "Clock"

    def __init__(self, *args: Any) -> None:
        super().__init__(*args)
        self.wall = ""
        self.simulated = "–"
        self.state, self.state_sign = "nothing flies yet", Sign.OFF

    @property
    def spoken(self) -> str:
        """The times as a sentence."""
        return f"local time {self.wall}, simulated time {self.simulated}, {self.state}"

    def show_wall(self) -> None:
        """Show the present time of day."""
        wall = time.strftime("%H:%M:%S")
        if wall != self.wall:
            self.wall = wall
            self.update(self._left_half.toAlignedRect())

    def show_silence(self, seconds: float) -> None:
        """Show that the flight has sent nothing for a time [s]."""
        self._show_state(f"no news for {seconds:.0f} s", Sign.WARNING)

    def show_phase(self, view: LiveView) -> None:
        """Show the state of the flight."""
        match view.phase:
            case Phase.STARTING:
                self._show_state(plain_name(view.said) or "starting", Sign.OFF)
            case Phase.PAUSED:
                self._show_state("paused", Sign.WARNING)
            case Phase.BROKEN:
                self._show_state("broken: last values", Sign.BAD)
            case Phase.ENDED:
                self._show_state("ended: last values", Sign.BAD)
            case Phase.FLYING:
                pace = view.pace
                if pace is None:
                    self._show_state("flying", Sign.GOOD)
                elif pace.too_slow:
                    self._show_state(f"too slow: {pace.text}", Sign.WARNING)
                else:
                    self._show_state(f"{pace.text} real time", Sign.GOOD)

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show the simulated time; with milliseconds while it is paused."""
        self.show_phase(view)
        text = simulated_text(now.time, 1 if view.phase is Phase.FLYING else 3)
        if text != self.simulated:
            self.simulated = text
            self.update(self._upper(self._right_half).toAlignedRect())

    def paint_still(self, painter: QPainter) -> None:
        """Paint the frame and the names of the times."""
        self.paint_frame(painter)
        painter.setFont(self.face())
        painter.setPen(self.colour("muted"))
        painter.drawText(self._lower(self._left_half), LEFT, "Local time")

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint both times, and the state of the flight."""
        if self._left_half.intersects(rect):
            painter.setFont(self.face(2.45, bold=True))
            painter.setPen(self.colour("ink"))
            painter.drawText(self._upper(self._left_half), LEFT, self.wall)
        upper, lower = self._upper(self._right_half), self._lower(self._right_half)
        if upper.intersects(rect):
            painter.setFont(self.face(1.65))
            painter.setPen(self.colour("ink"))
            painter.drawText(upper, LEFT, self.simulated)
            used = painter.fontMetrics().horizontalAdvance(self.simulated)
            painter.setFont(self.face())
            painter.setPen(self.colour("muted"))
            label = upper.adjusted(used + 0.6 * self.text_size, 0.25 * self.text_size, 0.0, 0.0)
            painter.drawText(label, LEFT, "simulated")
        if lower.intersects(rect):
            self._paint_state(painter, lower)

    def _paint_state(self, painter: QPainter, line: QRectF) -> None:
        side = 0.85 * self.text_size
        painter.setFont(self.face())
        sign = QRectF(line.left(), line.center().y() - side / 2, side, side)
        colour = self.state_sign.value
        self.state_sign.paint(painter, sign, self.colour(colour))
        calm = self.state_sign in (Sign.GOOD, Sign.OFF)
        painter.setPen(self.colour("muted" if calm else colour))
        text = painter.fontMetrics().elidedText(
            self.state, Qt.TextElideMode.ElideRight, int(line.width() - 1.5 * side)
        )
        painter.drawText(line.adjusted(1.5 * side, 0.0, 0.0, 0.0), LEFT, text)

    def _show_state(self, state: str, sign: Sign) -> None:
        if (state, sign) != (self.state, self.state_sign):
            self.state, self.state_sign = state, sign
            self.update(self._lower(self._right_half).toAlignedRect())

    @property
    def _inside(self) -> QRectF:
        pad = 1.1 * PADDING * self.text_size
        high = min(self.height() - pad, 5.0 * self.text_size)
        inside = QRectF(pad, 0.0, self.width() - 2 * pad, high)
        inside.moveTop((self.height() - high) / 2)
        return inside

    @property
    def _left_half(self) -> QRectF:
        half = self._inside
        half.setWidth(0.5 * half.width())
        return half

    @property
    def _right_half(self) -> QRectF:
        half = self._inside
        half.setLeft(half.left() + 0.5 * half.width())
        return half

    def _upper(self, half: QRectF) -> QRectF:
        return half.adjusted(0.0, 0.0, 0.0, -0.36 * half.height())

    def _lower(self, half: QRectF) -> QRectF:
        return half.adjusted(0.0, 0.66 * half.height(), 0.0, 0.0)


class RotorState(Enum):
    """A rotor's state, as a word; each also has its own pattern of the bar."""

    FINE = ""
    LIMIT = "at the limit"
    WEAK = "weak"
    STOPPED = "failed"


@dataclass(frozen=True)
class RotorReading:
    """Values of a bar.

    Attributes:
        thrust: thrust [N].
        share: share of the largest thrust, 0 .. 1.
        speed: speed [rad/s].
        state: state of the rotor.
    """

    thrust: float
    share: float
    speed: float
    state: RotorState


class RotorBars(Instrument):
    """A column for each rotor: number, bar, thrust and speed."""

    def __init__(self, look: Look, parent: QWidget | None = None) -> None:
        super().__init__(look, "Rotors", parent)
        self.readings: tuple[RotorReading, ...] = ()
        self._factor = 1.0

    @property
    def spoken(self) -> str:
        """The rotors as a sentence."""
        return "; ".join(
            f"rotor {number}: {each.thrust:.1f} newtons, {each.speed:.0f} radians a second"
            + (f", {each.state.value}" if each.state.value else "")
            for number, each in enumerate(self.readings, 1)
        )

    def begin(self, count: int) -> None:
        """Show a number of rotors at rest."""
        self.readings = (RotorReading(0.0, 0.0, 0.0, RotorState.FINE),) * count
        self.renew()

    def show_rotors(self, readings: Sequence[RotorReading]) -> None:
        """Show the rotors' values."""
        for index, (old, new) in enumerate(zip(self.readings, readings, strict=True)):
            if _seen(old) != _seen(new):
                self.update(self._column(index).toAlignedRect())
        self.readings = tuple(readings)

    def paint_still(self, painter: QPainter) -> None:
        """Paint numbers, empty bars, and the names of the rows."""
        if not self.readings:
            return
        self._fit()
        painter.setFont(self.face(self._factor))
        row = self._row
        legend = QRectF(0.0, 0.0, self._legend, row)
        painter.setPen(self.colour("muted"))
        bottom = self.height()
        painter.drawText(legend.translated(0.0, bottom - 2 * row), LEFT, "N")
        painter.drawText(legend.translated(0.0, bottom - row), LEFT, "rad/s")
        painter.drawText(legend, LEFT, "rotor")
        for index in range(len(self.readings)):
            trough = self._trough(index)
            painter.setPen(QPen(self.colour("line"), 1.0))
            painter.setBrush(self.colour("field"))
            painter.drawRect(trough)
            painter.setPen(QPen(self.colour("ink"), 2.0))
            over = 0.22 * trough.width()
            painter.drawLine(trough.topLeft() - _right(over), trough.topRight() + _right(over))

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the bars that overlap a rectangle, and their numbers."""
        painter.setFont(self.face(self._factor))
        row, middle = self._row, Qt.AlignmentFlag.AlignCenter
        for index, reading in enumerate(self.readings):
            column = self._column(index)
            if not column.intersects(rect):
                continue
            self._paint_bar(painter, self._trough(index), reading)
            painter.setPen(self.colour("ink"))
            line = QRectF(column.left(), column.bottom() - 2 * row, column.width(), row)
            painter.drawText(line, middle, _text(reading.thrust, 1))
            painter.drawText(line.translated(0.0, row), middle, _text(reading.speed, 0))
            head = QRectF(column.left(), 0.0, column.width(), row)
            bad = reading.state is RotorState.STOPPED
            painter.setPen(self.colour("bad" if bad else "muted"))
            painter.drawText(head, middle, f"{index + 1}")

    @property
    def _row(self) -> float:
        return 1.35 * self.text_size

    @property
    def _legend(self) -> float:
        return 3.2 * self.text_size

    def _column(self, index: int) -> QRectF:
        width = min(
            (self.width() - self._legend) / max(1, len(self.readings)), 6.5 * self.text_size
        )
        return QRectF(self._legend + index * width, 0.0, width, self.height())

    def _trough(self, index: int) -> QRectF:
        column = self._column(index)
        width = min(0.5 * column.width(), 2.2 * self.text_size)
        top, bottom = self._row + 3.0, column.height() - 2 * self._row - 3.0
        return QRectF(column.center().x() - width / 2, top, width, max(4.0, bottom - top))

    def _fit(self) -> None:
        """Choose a text size at which the widest number fits into a column."""
        room = self._column(0).width() - 2.0
        for factor in (1.0, 0.92, 0.84, 0.76):
            self._factor = factor
            metrics = QFontMetricsF(self.face(factor))
            if metrics.horizontalAdvance("88.8") <= room:
                return

    def _paint_bar(self, painter: QPainter, trough: QRectF, reading: RotorReading) -> None:
        inner = trough.adjusted(1.0, 1.0, -1.0, 0.0)
        share = min(1.0, max(0.0, reading.share)) if math.isfinite(reading.share) else 0.0
        bar = inner.adjusted(0.0, (1.0 - share) * inner.height(), 0.0, 0.0)
        if reading.state is RotorState.STOPPED:
            pattern = QBrush(self.colour("bad"), Qt.BrushStyle.BDiagPattern)
            painter.fillRect(inner, pattern)
            side = min(inner.width(), inner.height(), 1.3 * self.text_size)
            cross = QRectF(0.0, 0.0, side, side)
            cross.moveCenter(inner.center())
            Sign.BAD.paint(painter, cross, self.colour("bad"))
        elif reading.state is RotorState.FINE:
            painter.fillRect(bar, self.colour("accent"))
        else:
            painter.fillRect(bar, self.colour("warning"))
            painter.fillRect(bar, QBrush(self.colour("card"), Qt.BrushStyle.DiagCrossPattern))


def _right(length: float) -> QPointF:
    return QPointF(length, 0.0)


def _text(value: float, decimals: int) -> str:
    return f"{value:.{decimals}f}" if math.isfinite(value) else "–"


def _seen(reading: RotorReading) -> tuple[str, str, int, RotorState]:
    """Return the visible part of a reading."""
    share = reading.share if math.isfinite(reading.share) else 0.0
    return _text(reading.thrust, 1), _text(reading.speed, 0), round(200 * share), reading.state


AT_LIMIT = 0.98
"""A rotor at this share of its largest thrust is at its limit."""
WHOLE = 0.995
"""A rotor with a smaller share of its thrust is weak."""
NEARLY_NONE = 0.01
"""A rotor with less than this share has failed."""
CONCERNS = (
    (RotorState.STOPPED, Sign.BAD),
    (RotorState.WEAK, Sign.WARNING),
    (RotorState.LIMIT, Sign.WARNING),
)
"""States in order of severity, with their symbols."""


def rotor_reading(
    rotor: Rotor, thrust: float, share: float, speed: float | None = None
) -> RotorReading:
    """Return the values of a rotor's bar.

    Args:
        rotor: the rotor's description.
        thrust: its thrust [N].
        share: share of its thrust that it can produce, 1 without a fault.
        speed: its speed [rad/s]; None for the one that produces the thrust.
    """
    part = thrust / rotor.max_thrust if rotor.max_thrust > 0.0 else 0.0
    if speed is None:
        square = max(0.0, thrust) / rotor.motor_constant if rotor.motor_constant else 0.0
        half = 0.5 * rotor.linear_speed
        speed = math.sqrt(half * half + square) - half
    if share <= NEARLY_NONE:
        state = RotorState.STOPPED
    elif share < WHOLE:
        state = RotorState.WEAK
    elif part >= AT_LIMIT:
        state = RotorState.LIMIT
    else:
        state = RotorState.FINE
    return RotorReading(thrust, part, speed, state)


class RotorCard(Card):
    """A bar for each rotor."""

    name = "rotors"
    title = "Rotors"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self.bars = RotorBars(look, self)
        self.parts = [self.bars]

    def begin(self, view: LiveView) -> None:
        """Show one bar per rotor."""
        assert view.vehicle is not None
        self.bars.begin(len(view.vehicle.rotors))

    def show_numbers(self, view: LiveView, now: Snapshot) -> None:
        """Show thrusts and speeds."""
        assert view.vehicle is not None
        rotors = view.vehicle.rotors
        speeds: Sequence[float | None] = self._watch.rotor_speeds()
        if len(speeds) != len(rotors):
            speeds = [None] * len(rotors)
        readings = [
            rotor_reading(rotor, thrust, self._share(number), speed)
            for number, (rotor, thrust, speed) in enumerate(
                zip(rotors, now.thrusts, speeds, strict=True), 1
            )
        ]
        self.bars.show_rotors(readings)
        for state, sign in CONCERNS:
            numbers = [str(n) for n, each in enumerate(readings, 1) if each.state is state]
            if numbers:
                self.set_note(f"{state.value}: {', '.join(numbers)}", sign)
                return
        most = max(rotor.max_thrust for rotor in rotors)
        self.set_note(f"limit {most:.1f}\N{NO-BREAK SPACE}N")

    def _share(self, number: int) -> float:
        return self._watch.value(f"rotor_{number}") if number <= MOST_ROTORS else 1.0

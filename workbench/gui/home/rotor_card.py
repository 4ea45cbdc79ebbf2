"""What the rotors do: thrust and speed of each as a bar with its limit."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from PyQt6.QtCore import QPointF, QRectF, QSize, Qt
from PyQt6.QtGui import QBrush, QFontMetricsF, QPainter, QPen
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.cards import Card
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import Instrument
from workbench.gui.instruments.sign import Sign, paint_sign
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.plant.rotors import Rotor
from workbench.scenario.parameters import MOST_ROTORS
from workbench.session.snapshot import Snapshot


class RotorState(Enum):
    """How a rotor does, in a word; each has a filling of its bar, too."""

    FINE = ""
    LIMIT = "at the limit"
    WEAK = "weak"
    STOPPED = "failed"


@dataclass(frozen=True)
class RotorReading:
    """What a bar shows.

    Attributes:
        thrust: [N].
        share: of the largest thrust, 0 .. 1.
        speed: [rad/s].
        state: how the rotor does.
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
        """All of it as a sentence."""
        return "; ".join(
            f"rotor {number}: {each.thrust:.1f} newtons, {each.speed:.0f} radians a second"
            + (f", {each.state.value}" if each.state.value else "")
            for number, each in enumerate(self.readings, 1)
        )

    def begin(self, count: int) -> None:
        """Show so many rotors at rest."""
        self.readings = (RotorReading(0.0, 0.0, 0.0, RotorState.FINE),) * count
        self.renew()

    def show_rotors(self, readings: Sequence[RotorReading]) -> None:
        """Show what the rotors do."""
        for index, (old, new) in enumerate(zip(self.readings, readings, strict=True)):
            if _seen(old) != _seen(new):
                self.update(self._column(index).toAlignedRect())
        self.readings = tuple(readings)

    def sizeHint(self) -> QSize:
        """Return a size at which all is readable."""
        return QSize(240, 110)

    def paint_still(self, painter: QPainter) -> None:
        """Paint numbers, troughs, and what the rows are."""
        if not self.readings:
            return
        self._fit()
        painter.setFont(self.face(self._factor))
        row = self._row
        legend = QRectF(0.0, 0.0, self._legend, row)
        left = Qt.AlignmentFlag.AlignLeft | Qt.AlignmentFlag.AlignVCenter
        painter.setPen(self.colour("muted"))
        bottom = self.height()
        painter.drawText(legend.translated(0.0, bottom - 2 * row), left, "N")
        painter.drawText(legend.translated(0.0, bottom - row), left, "rad/s")
        painter.drawText(legend, left, "rotor")
        for index in range(len(self.readings)):
            trough = self._trough(index)
            painter.setPen(QPen(self.colour("line"), 1.0))
            painter.setBrush(self.colour("field"))
            painter.drawRect(trough)
            painter.setPen(QPen(self.colour("ink"), 2.0))
            over = 0.22 * trough.width()
            painter.drawLine(trough.topLeft() - _right(over), trough.topRight() + _right(over))

    def paint_moving(self, painter: QPainter, rect: QRectF) -> None:
        """Paint the bars that a rectangle touches, and their numbers."""
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
        """Choose a size at which the widest number fits into a column."""
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
            painter.setRenderHint(QPainter.RenderHint.Antialiasing)
            paint_sign(painter, cross, Sign.BAD, self.colour("bad"), self.colour("card"))
            painter.setRenderHint(QPainter.RenderHint.Antialiasing, False)
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
    """Return what of a reading can be seen."""
    share = reading.share if math.isfinite(reading.share) else 0.0
    return _text(reading.thrust, 1), _text(reading.speed, 0), round(200 * share), reading.state


LIMIT = 0.98
"""From this share of its largest thrust on, a rotor is at its limit."""
WHOLE = 0.995
"""A rotor that gives a smaller share of its thrust is weak."""
NONE = 0.01
"""And one that gives less than this has failed."""
CONCERNS = (
    (RotorState.STOPPED, Sign.BAD),
    (RotorState.WEAK, Sign.WARNING),
    (RotorState.LIMIT, Sign.WARNING),
)
"""What is told first, and with which sign."""


def rotor_reading(
    rotor: Rotor, thrust: float, share: float, speed: float | None = None
) -> RotorReading:
    """Return what a rotor's bar shows.

    Args:
        rotor: as described.
        thrust: that it gives [N].
        share: of its thrust that it can give, 1 where it is whole.
        speed: [rad/s]; None to take the one that makes the thrust.
    """
    part = thrust / rotor.max_thrust if rotor.max_thrust > 0.0 else 0.0
    if speed is None:
        square = max(0.0, thrust) / rotor.motor_constant if rotor.motor_constant else 0.0
        half = 0.5 * rotor.linear_speed
        speed = math.sqrt(half * half + square) - half
    if share <= NONE:
        state = RotorState.STOPPED
    elif share < WHOLE:
        state = RotorState.WEAK
    elif part >= LIMIT:
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
        """Show as many bars as there are rotors."""
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

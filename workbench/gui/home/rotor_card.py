"""The card of the rotors: a bar for each, with its thrust, speed and state."""

import itertools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from enum import Enum

from PyQt6.QtCore import Qt
from PyQt6.QtWidgets import QGridLayout, QProgressBar, QWidget

from workbench.gui.home.home_card import HomeCard
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.instrument import Sign
from workbench.gui.labels import Label
from workbench.gui.layout import NO_MARGINS, fill, label, named
from workbench.gui.style import set_class
from workbench.gui.theme import Look
from workbench.gui.units import ROTOR_SPEED_UNIT, THRUST_UNIT
from workbench.live.view import LiveView
from workbench.parameters.flight_parameters import MAX_WEAKENED_ROTORS
from workbench.plant.rotors import Rotor
from workbench.session.snapshot import Snapshot


class RotorState(Enum):
    """A rotor's state, the most severe first: a word, a shape beside its number, and a sign.

    The shape is there as the state is not told by colour alone.
    """

    STOPPED = "failed", " ✕", Sign.BAD
    WEAK = "weak", " ▼", Sign.WARNING
    LIMIT = "at the limit", " ▲", Sign.WARNING
    FINE = "", "", Sign.GOOD

    def __init__(self, word: str, shape: str, sign: Sign) -> None:
        self.word, self.shape, self.sign = word, shape, sign


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


class RotorBars(QWidget):
    """A column for each rotor: number, bar, thrust and speed."""

    def __init__(self) -> None:
        super().__init__()
        self.setAccessibleName("Rotors")
        self.readings: tuple[RotorReading, ...] = ()
        self._columns: list[tuple[Label, QProgressBar, Label, Label]] = []
        self._grid = QGridLayout(self)
        self._grid.setContentsMargins(*NO_MARGINS)
        self._grid.setSpacing(2)
        self._grid.setRowStretch(1, 1)
        for row, text in ((0, "rotor"), (2, THRUST_UNIT.symbol), (3, ROTOR_SPEED_UNIT.symbol)):
            self._grid.addWidget(label(text, "muted"), row, 0)

    @property
    def spoken(self) -> str:
        """The rotors as a sentence."""
        return "; ".join(
            f"rotor {number}: {each.thrust:.1f} newtons, {each.speed:.0f} radians a second"
            + (f", {each.state.word}" if each.state.word else "")
            for number, each in enumerate(self.readings, 1)
        )

    def begin(self, count: int) -> None:
        """Show a number of rotors at rest."""
        for part in itertools.chain(*self._columns):
            part.hide()
            part.deleteLater()
        self._columns = []
        for index in range(count):
            column = (label(), QProgressBar(), label(), label())
            bar = named(column[1], f"Share of the thrust of rotor {index + 1}")
            bar.setOrientation(Qt.Orientation.Vertical)
            bar.setTextVisible(False)
            for row, part in enumerate(column):
                self._grid.addWidget(part, row, index + 1, Qt.AlignmentFlag.AlignHCenter)
                self._grid.setColumnStretch(index + 1, 1)
            self._columns.append(column)
        self.show_rotors((RotorReading(0.0, 0.0, 0.0, RotorState.FINE),) * count)

    def show_rotors(self, readings: Sequence[RotorReading]) -> None:
        """Show the rotors' values."""
        self.readings = tuple(readings)
        for number, (each, (head, bar, thrust, speed)) in enumerate(
            zip(readings, self._columns, strict=True), 1
        ):
            head.setText(f"{number}{each.state.shape}")
            bar.setValue(round(100 * min(1.0, each.share)) if math.isfinite(each.share) else 0)
            set_class(bar, "" if each.state is RotorState.FINE else "warning")
            thrust.setText(THRUST_UNIT.number(each.thrust))
            speed.setText(ROTOR_SPEED_UNIT.number(each.speed))


THRUST_LIMIT_SHARE = 0.98
"""A rotor at this share of its largest thrust is at its limit."""
WEAK_THRUST_SHARE = 0.995
"""A rotor with a smaller share of its thrust is weak."""
FAILED_THRUST_SHARE = 0.01
"""A rotor with less than this share has failed."""


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
    if share <= FAILED_THRUST_SHARE:
        state = RotorState.STOPPED
    elif share < WEAK_THRUST_SHARE:
        state = RotorState.WEAK
    elif part >= THRUST_LIMIT_SHARE:
        state = RotorState.LIMIT
    else:
        state = RotorState.FINE
    return RotorReading(thrust, part, speed, state)


class RotorCard(HomeCard):
    """A bar for each rotor."""

    name = "rotors"
    title = "Rotors"

    def __init__(
        self, look: Look, units: ShownUnits, watch: StreamWatch, parent: QWidget | None = None
    ) -> None:
        super().__init__(look, units, parent)
        self._watch = watch
        self.bars = RotorBars()
        fill(self.body, (self.bars, 1))

    @property
    def spoken(self) -> str:
        """The rotors as a sentence."""
        return self.bars.spoken

    def begin(self, view: LiveView) -> None:
        """Show one bar per rotor."""
        assert view.vehicle is not None
        self.bars.begin(len(view.vehicle.rotors))
        self.set_text_size(self.text_size)

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
        for state in RotorState:
            numbers = [str(n) for n, each in enumerate(readings, 1) if each.state is state]
            if numbers and state.word:
                self.set_note(f"{state.word}: {', '.join(numbers)}", state.sign)
                return
        most = max(rotor.max_thrust for rotor in rotors)
        self.set_note(f"limit {THRUST_UNIT.text(most)}")

    def _share(self, number: int) -> float:
        return self._watch.value(f"rotor_{number}") if number <= MAX_WEAKENED_ROTORS else 1.0

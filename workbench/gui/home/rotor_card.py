"""What the rotors do."""

import math
from collections.abc import Sequence

from PyQt6.QtCore import QRectF
from PyQt6.QtWidgets import QWidget

from workbench.gui.home.card import Card, put
from workbench.gui.home.shown_units import ShownUnits
from workbench.gui.home.stream_watch import StreamWatch
from workbench.gui.instruments.rotor_bars import RotorBars, RotorReading, RotorState
from workbench.gui.instruments.sign import Sign
from workbench.gui.theme import Look
from workbench.live.view import LiveView
from workbench.plant.rotors import Rotor
from workbench.scenario.parameters import MOST_ROTORS
from workbench.session.snapshot import Snapshot

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

    @property
    def spoken(self) -> str:
        """All of it as a sentence."""
        return self.bars.spoken

    def place_parts(self, body: QRectF) -> None:
        """Let the bars fill it."""
        put(self.bars, body)

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

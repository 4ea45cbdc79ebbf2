"""Excitations of a drone: steps, doublets, square waves and chirps of a command or a load."""

import math
from dataclasses import dataclass
from enum import Enum

from workbench.common.errors import WorkbenchError
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.axes import CommandAxis
from workbench.scenario.loads import EXCITED_AXES, Load, find_excited

MIN_EXCITATION_PERIOD_S, MAX_EXCITATION_PERIOD_S = 0.1, 60.0
"""Limits of the period [s]."""
CHIRP_START_HZ = 0.1
"""Initial frequency of a chirp; it ends at ten times that or more [1/s]."""
CHIRP_RATIO = 10.0
PULSE_RETURN_TIME_S = 3.0
"""Time to come back after a pulse [s]."""
MAX_SWING_WAIT_S = 60.0
"""Longest wait before a round until joints no longer swing [s]."""
EDGE_TOLERANCE_S = 1e-9
"""A time this close before an edge counts as at it, as sums of periods have rounding errors [s]."""


class Shape(Enum):
    """The shape of a command over time."""

    STEP = "step"
    """The amplitude for a period, then zero for a period."""
    DOUBLET = "doublet"
    """The amplitude for half a period, its negative for the other half, then zero for one."""
    SQUARE = "square wave"
    """The amplitude and its negative alternately, half a period each."""
    CHIRP = "chirp"
    """A sine with a frequency that rises from 0.1 Hz to ten times that or more, within a period."""
    PULSE = "pulse"
    """The amplitude for a period, or the peak of a gust, then zero while the drone comes back."""


@dataclass(frozen=True)
class Excitation:
    """A command or a load along one axis; the other axes are held at rest.

    Attributes:
        axis: x, y, z (velocity in W) or yaw (rate), a setpoint of attitude or rate, or the name of
            a load.
        shape: of the command over time.
        amplitude: [m/s] or [rad/s], of an attitude [rad], of a load [N] or [N·m].
        period: [s].
        repeats: whether it repeats until stopped.
    """

    axis: str
    shape: Shape
    amplitude: float
    period: float
    repeats: bool = False

    def check(self, limit: float = math.inf) -> None:
        """Check that it can be flown.

        Args:
            limit: largest amplitude, in its unit.

        Raises:
            WorkbenchError: for the first error.
        """
        names = [row.name for row in EXCITED_AXES]
        if self.axis not in names:
            raise WorkbenchError(f"the axis is {self.axis!r:.60}: give one of {', '.join(names)}")
        if not isinstance(self.shape, Shape):
            shapes = ", ".join(shape.value for shape in Shape)
            raise WorkbenchError(f"the shape is {self.shape!r:.60}: give one of {shapes}")
        for name, unit in (("amplitude", self.unit), ("period", "s")):
            number = getattr(self, name)
            if not isinstance(number, int | float) or not math.isfinite(number):
                raise WorkbenchError(
                    f"the {name} is {number!r:.60}: give it a finite number of {unit}"
                )
        if not 0.0 < abs(self.amplitude) <= limit:
            raise WorkbenchError(
                f"the amplitude is {self.amplitude:g} {self.unit}: give a value other than 0, "
                f"within ±{limit:g} {self.unit}"
            )
        if isinstance(self.row, Load) and self.row.is_gust and self.shape is not Shape.PULSE:
            raise WorkbenchError("a gust rises and falls by itself: give it the shape pulse")
        if not MIN_EXCITATION_PERIOD_S <= self.period <= MAX_EXCITATION_PERIOD_S:
            raise WorkbenchError(
                f"the period is {self.period:g} s: give it one from {MIN_EXCITATION_PERIOD_S:g} "
                f"to {MAX_EXCITATION_PERIOD_S:g} s"
            )

    @property
    def row(self) -> CommandAxis | AttitudeAxis | Load:
        """The axis or the load."""
        return find_excited(self.axis)

    @property
    def unit(self) -> str:
        """Unit of the amplitude."""
        return self.row.unit

    @property
    def round_time(self) -> float:
        """Duration of a round [s]."""
        if self.shape is Shape.PULSE:
            return self.period + PULSE_RETURN_TIME_S
        return 2.0 * self.period if self.rests else self.period

    @property
    def rests(self) -> bool:
        """Whether a round ends at rest, so that the next one begins at rest."""
        return self.shape in (Shape.STEP, Shape.DOUBLET, Shape.PULSE)

    @property
    def edges(self) -> tuple[float, ...]:
        """Times within a round at which the command jumps [s]; none for a chirp."""
        match self.shape:
            case Shape.STEP | Shape.PULSE:
                return (0.0, self.period)
            case Shape.DOUBLET:
                return (0.0, 0.5 * self.period, self.period)
            case Shape.SQUARE:
                return (0.0, 0.5 * self.period)
            case Shape.CHIRP:
                return ()

    @property
    def longest_level(self) -> float:
        """Longest time for which the command has one sign [s]; of a chirp half its first wave."""
        match self.shape:
            case Shape.STEP | Shape.PULSE:
                return self.period
            case Shape.DOUBLET | Shape.SQUARE:
                return 0.5 * self.period
            case Shape.CHIRP:
                return min(self.period, 0.5 / CHIRP_START_HZ)

    def command(self, t: float) -> float:
        """Return the command at a time [s] since the beginning of the first round.

        It is 0 before, and also after unless the excitation repeats.
        """
        if t < 0.0:
            return 0.0
        if self.repeats:
            t = math.fmod(t + EDGE_TOLERANCE_S, self.round_time)
        elif t >= self.round_time - EDGE_TOLERANCE_S:
            return 0.0
        return self.amplitude * self._share(t + EDGE_TOLERANCE_S)

    def _share(self, t: float) -> float:
        """Return the share of the amplitude at a time within a round."""
        half = 0.5 * self.period
        match self.shape:
            case Shape.STEP | Shape.PULSE:
                return 1.0 if t < self.period else 0.0
            case Shape.DOUBLET:
                return 1.0 if t < half else -1.0 if t < self.period else 0.0
            case Shape.SQUARE:
                return 1.0 if t < half else -1.0
            case Shape.CHIRP:
                return self._sine(t)

    def _sine(self, t: float) -> float:
        """Return the sine of a chirp.

        Its frequency rises linearly. The final frequency is such that whole waves fill the period,
        and the sine ends as it began.
        """
        waves = math.ceil(
            0.5 * (1.0 + CHIRP_RATIO) * CHIRP_START_HZ * self.period - EDGE_TOLERANCE_S
        )
        last = 2.0 * waves / self.period - CHIRP_START_HZ
        pace = (last - CHIRP_START_HZ) / self.period
        return math.sin(2.0 * math.pi * (CHIRP_START_HZ + 0.5 * pace * t) * t)


@dataclass(frozen=True)
class ActiveExcitation:
    """An excitation in flight.

    Attributes:
        excitation: the one flown.
        began: simulated time at which the present round began, or is about to begin [s].
        round: number of the present round, from 1; 0 while the drone comes to rest before it.
        from_rest: whether the round began at rest, as the first one and those after a return do.
        returning: whether the round is over and the drone returns to the start of the first one.
        hover: angle of the hover before it, from which an attitude steps [rad], or velocity of the
            drift in wind, from which a command steps [m/s or rad/s]; 0 if it is level or at rest.
        waited: time for which it has waited until joints no longer swing [s], None if it does not.
        swings: whether joints still swung when the round began, so that it has no numbers.
        drifts: whether it waits until the drone drifts steadily in wind.
        unsteady: why the air leaves its steps without a steady state, "" if it does not.
    """

    excitation: Excitation
    began: float
    round: int
    from_rest: bool = False
    returning: bool = False
    hover: float = 0.0
    waited: float | None = None
    swings: bool = False
    drifts: bool = False
    unsteady: str = ""

    @property
    def rounds_flown(self) -> int:
        """Number of rounds that were flown to their end."""
        return self.round if self.returning else max(0, self.round - 1)

    @property
    def again(self) -> bool:
        """Whether this round followed the one before directly."""
        return self.round > 1 and not self.from_rest

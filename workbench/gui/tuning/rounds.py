"""The steps that one round of an excitation is made of."""

from dataclasses import dataclass

from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import Load


@dataclass(frozen=True)
class StepPart:
    """A step within a round, from one level of the command to another.

    Attributes:
        begin: from the round's edge on [s].
        end: when the command changes again [s].
        before: level before, in the unit of the excitation's amplitude.
        level: that is asked for.
    """

    begin: float
    end: float
    before: float
    level: float

    @property
    def duration(self) -> float:
        """For how long the level is asked for [s]."""
        return self.end - self.begin

    @property
    def jump(self) -> float:
        """By how much the command changes."""
        return self.level - self.before


def step_parts(excitation: Excitation, *, again: bool = False) -> tuple[StepPart, ...]:
    """Return the steps of a round in their order, back to rest left out; a chirp has none.

    Args:
        excitation: what is flown.
        again: whether a round of the same was flown just before.
    """
    size, period = excitation.amplitude, excitation.period
    half = 0.5 * period
    match excitation.shape:
        case Shape.STEP:
            return (StepPart(0.0, period, 0.0, size),)
        case Shape.PULSE:  # what a load has done is over when the drone is back
            over = excitation.round_time if isinstance(excitation.row, Load) else period
            return (StepPart(0.0, over, 0.0, size),)
        case Shape.DOUBLET:
            return (StepPart(0.0, half, 0.0, size), StepPart(half, period, size, -size))
        case Shape.SQUARE:
            first = StepPart(0.0, half, -size if again else 0.0, size)
            return (first, StepPart(half, period, size, -size))
    return ()

"""One round of an excitation in whole physics steps."""

import bisect
import dataclasses
import math

from workbench.scenario.excitation import Excitation
from workbench.scenario.scenario import Rates

NEAR = 1e-6
"""A time this share of a step after a step is at it."""


class StepPlan:
    """Tells at which steps of a round a command changes, and to what.

    A round is a whole number of control periods, the nearest: begun with a control update, every
    round looks the same to the law. A chirp changes with every control update.

    Args:
        excitation: what is flown.
        rates: of the flight.

    Attributes:
        length: of a round, in steps.
    """

    def __init__(self, excitation: Excitation, rates: Rates) -> None:
        self._once = dataclasses.replace(excitation, repeats=False)
        self._step = rates.physics_step
        control = round(rates.control_period / self._step)
        self.length = control * max(1, round(excitation.round_time / rates.control_period))
        edges = [math.ceil(edge / self._step - NEAR) for edge in excitation.edges]
        self._changes = edges or range(0, self.length, control)

    def next_change(self, step: int) -> int:
        """Return the first step after one at which the command changes, or the round ends."""
        place = bisect.bisect_right(self._changes, step)
        return min(self._changes[place], self.length) if place < len(self._changes) else self.length

    def value(self, step: int) -> float:
        """Return the command at a step of the round [m/s] or [rad/s]."""
        return self._once.command(step * self._step)

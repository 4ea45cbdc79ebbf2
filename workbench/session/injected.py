"""A flown injection: a multisine at a loop point, and the response there."""

import math
from array import array
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from workbench.control.controller import Controller
from workbench.scenario.multisine import Multisine, multisine
from workbench.scenario.scenario import Injection, Rates

if TYPE_CHECKING:
    from pydrake.systems.framework import Context

    from workbench.systems.flight_computer import FlightComputer


@dataclass(frozen=True)
class InjectedSignal:
    """A signal injected at a loop point, and the response, at each update after a first period.

    The first period is left out, as it has the transient. The response is the signal that the law
    reads before the injection is added.

    Attributes:
        asked: the injection.
        multisine: one period of the injected signal, of unit RMS.
        came: (P, N) response in each whole period, in the unit of the point.
    """

    asked: Injection
    multisine: Multisine
    came: np.ndarray

    @property
    def sent(self) -> np.ndarray:
        """The injected signal of a period (N)."""
        return self.asked.size * self.multisine.values


@dataclass
class ActiveInjection:
    """Adds the values of an injection, one at each control update, or at each n-th one.

    If the part of the law that reads the point runs only in every n-th update, each value is held
    over n updates, and the response counts in the updates in which that part runs.

    Args:
        injection: a checked injection.
        place: index of its point among those of the controller.
        first: earliest physics step at which it may start.
        rates: rates of the flight.
        divider: n.

    Attributes:
        came: response at each update so far.
        is_over: whether it has ended.
    """

    injection: Injection
    place: int
    first: int
    rates: Rates
    divider: int = 1
    came: array = field(default_factory=lambda: array("d"))
    is_over: bool = False

    @classmethod
    def starting(
        cls, injection: Injection, law: Controller, start: float, rates: Rates
    ) -> "ActiveInjection":
        """Return a checked injection into a law, from a time [s] on."""
        first = round(start / rates.physics_step)
        place = law.point_names.index(injection.point)
        return cls(injection, place, first, rates, law.point_dividers[injection.point])

    def __post_init__(self) -> None:
        wanted, period = self.injection, self.divider * self.rates.control_period
        self.multisine = multisine(wanted.lowest, wanted.highest, period)
        self._steps = round(period / self.rates.physics_step)
        self.first = math.ceil(self.first / self._steps) * self._steps  # that part runs here

    @property
    def length(self) -> int:
        """Number of updates in the injection."""
        return self.injection.periods * len(self.multisine.values)

    @property
    def share(self) -> float:
        """Flown share of the injection, 0 .. 1."""
        return 1.0 if self.is_over else len(self.came) / self.length

    @property
    def next_step(self) -> int:
        """The physics step of the next update with a value, or of the first one after the end."""
        return self.first + len(self.came) * self._steps

    @property
    def injected(self) -> InjectedSignal:
        """The whole periods measured so far."""
        count = len(self.multisine.values)
        whole = max(0, math.floor(len(self.came) / count) - 1)
        came = np.frombuffer(self.came)[count : (1 + whole) * count] if whole else np.empty(0)
        return InjectedSignal(self.injection, self.multisine, came.reshape(whole, count).copy())

    def act(self, step: int, computer: "FlightComputer", context: "Context") -> None:
        """Add the value of an update that is due at a step, or end the injection after the last.

        Args:
            step: of the physics.
            computer: with the loop point.
            context: of the computer.
        """
        if step < self.next_step:
            return
        if len(self.came) == self.length:
            computer.close_loops(context)
            self.is_over = True
            return
        values = self.multisine.values
        value = self.injection.size * values[len(self.came) % len(values)]
        self.came.append(computer.probed(context, self.place, float(value)))

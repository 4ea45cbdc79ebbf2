"""The search's problem: gains as coordinates, and what requirements see of them."""

import dataclasses
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from workbench.design.tune.measure import Instruments, Quantity
from workbench.design.tune.requirement import Requirement
from workbench.design.tune.variables import Variables, loops_for


@dataclass(frozen=True)
class FlownProblem:
    """Gains to find, and what is required of flights and loops with them.

    Attributes:
        instruments: what measures.
        variables: the gains that may change.
        base: all parameter values, for those that may not.
        requirements: what is required (R).
        corrections: what the full diagram had more than the instruments, by requirement.
    """

    instruments: Instruments
    variables: Variables
    base: Mapping[str, float]
    requirements: tuple[Requirement, ...]
    corrections: Mapping[Requirement, float] = field(default_factory=dict)

    @property
    def low(self) -> np.ndarray:
        """Smallest coordinates (n)."""
        return self.variables.low

    @property
    def high(self) -> np.ndarray:
        """Largest coordinates (n)."""
        return self.variables.high

    @property
    def matters(self) -> np.ndarray:
        """Which coordinates (n) what is required depends on."""
        subjects = [requirement.wish.subject for requirement in self.requirements]
        law = self.instruments.controller
        loops = [loop for subject in subjects for loop in loops_for(law, subject)]
        names = {name for loop in loops for name in loop.gains}
        return np.array([not names.isdisjoint(group) for group in self.variables.groups])

    def gains(self, point: np.ndarray) -> dict[str, float]:
        """Return all parameter values at coordinates (n)."""
        return {**self.base, **self.variables.gains(point)}

    def values(self, points: np.ndarray) -> np.ndarray:
        """Return the values (N, R) of what is required, at points (N, n)."""
        return self.measured([self.gains(point) for point in points])

    def measured(self, gains: Sequence[Mapping[str, float]]) -> np.ndarray:
        """Return the values (N, R) of what is required, with N sets of all parameter values."""
        quantities = [quantity(requirement) for requirement in self.requirements]
        values = self.instruments.measure(gains, quantities)
        added = [self.corrections.get(requirement, 0.0) for requirement in self.requirements]
        return np.asarray(values + np.array(added))

    def demanding(self, requirements: Sequence[Requirement]) -> "FlownProblem":
        """Return the problem with other requirements."""
        return dataclasses.replace(self, requirements=tuple(requirements))


def quantity(requirement: Requirement) -> Quantity:
    """Return what a requirement bounds."""
    wish = requirement.wish
    return Quantity(requirement.case, wish.metric.kind, wish.subject, wish.metric.name)

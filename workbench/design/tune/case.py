"""The vehicles that a set of gains must fly: the one described, and its neighbours."""

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.plant.variation import Variation

if TYPE_CHECKING:
    from workbench.plant.rotor_sources.sidecar import IdentifiedRow

SHARES = {
    "mass": ("thrust_to_weight", "motor_constant"),
    "inertia": ("inertia_x", "inertia_y", "inertia_z"),
    "rotor_lag": ("lag_with_delay",),
}
"""What was identified that says by how much each of a vehicle's numbers may differ."""
LARGEST = 0.9
"""Share by which one may differ at most."""


@dataclass(frozen=True)
class Robustness:
    """How unsure the vehicle is, and what is still asked of the gains there.

    Attributes:
        mass: may differ by this share.
        inertia: may differ by this share.
        rotor_lag: may differ by this share.
        margin_share: margins keep at least this share of what is wished for.
        overshoot_factor: overshoot and steady-state error are at most so many times what is
            wished for; both are shares by which the response misses its command.
    """

    mass: float = 0.2
    inertia: float = 0.3
    rotor_lag: float = 0.5
    margin_share: float = 0.6
    overshoot_factor: float = 2.0


@dataclass(frozen=True)
class Case:
    """A vehicle to fly, by factors on what the controller believes: see `Variation`."""

    mass: float = 1.0
    inertia: float = 1.0
    rotor_lag: float = 1.0

    @property
    def variation(self) -> Variation:
        """For a scenario's vehicle."""
        return Variation(mass=self.mass, inertia=self.inertia, rotor_lag=self.rotor_lag)

    def __str__(self) -> str:
        if self == NOMINAL:
            return "as described"
        return f"mass x {self.mass:g}, inertia x {self.inertia:g}, rotor lag x {self.rotor_lag:g}"


NOMINAL = Case()


def identified_robustness(sidecar: Path) -> Robustness | None:
    """Return the robustness that intervals of 95 % ask for; None where none were identified.

    A log gives thrust over mass, so the mass differs as that does; of three inertias the one that
    is known least counts. What was not identified keeps its default.

    Args:
        sidecar: rotors (YAML), as `workbench identify` writes them.

    Raises:
        WorkbenchError: with file and line, for what is unknown or of another type.
    """
    from workbench.plant.rotor_sources.sidecar import load_identified  # it loads Drake

    rows = {row.name: row for row in load_identified(sidecar)}
    shares = {
        name: min(max(_share(rows[each]) for each in known), LARGEST)
        for name, names in SHARES.items()
        if (known := [each for each in names if each in rows and rows[each].value > 0.0])
    }
    return Robustness(**shares) if shares else None


def _share(row: "IdentifiedRow") -> float:
    """Return how far an interval reaches from its value, as a share of it."""
    return max(row.high - row.value, row.value - row.low) / row.value


def corners(robustness: Robustness) -> list[Case]:
    """Return all combinations of the least and the most of mass, inertia and rotor lag."""
    shares = (robustness.mass, robustness.inertia, robustness.rotor_lag)
    ends = [(1.0 - share, 1.0 + share) if share else (1.0,) for share in shares]
    found = [Case(*factors) for factors in itertools.product(*ends)]
    return [case for case in found if case != NOMINAL]

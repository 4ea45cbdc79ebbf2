"""The vehicles that a set of gains must fly: the described one, and variations of it."""

import itertools
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.plant.variation import Variation

if TYPE_CHECKING:
    from workbench.plant.rotor_sources.sidecar import IdentifiedRow

UNCERTAINTY_SOURCES = {
    "mass": ("thrust_to_weight", "motor_constant"),
    "inertia": ("inertia_x", "inertia_y", "inertia_z"),
    "rotor_lag": ("lag_with_delay",),
}
"""The identified quantities that determine the uncertainty of each number of a vehicle."""
MAX_UNCERTAINTY = 0.9
"""Largest uncertainty, as a share."""


@dataclass(frozen=True)
class Robustness:
    """The uncertainty of the vehicle, and the demands on the gains for it.

    Attributes:
        mass: its uncertainty, as a share.
        inertia: its uncertainty, as a share.
        rotor_lag: its uncertainty, as a share.
        margin_share: margins keep at least this share of the wished ones.
        overshoot_factor: limit of overshoot and steady-state error, as a factor on the wished ones;
            both are shares of the command.
    """

    mass: float = 0.2
    inertia: float = 0.3
    rotor_lag: float = 0.5
    margin_share: float = 0.6
    overshoot_factor: float = 2.0


@dataclass(frozen=True)
class VehicleCase:
    """A vehicle to fly, given by factors on what the controller knows, see `Variation`."""

    mass: float = 1.0
    inertia: float = 1.0
    rotor_lag: float = 1.0

    @property
    def variation(self) -> Variation:
        """The variation for the vehicle of a scenario."""
        return Variation(mass=self.mass, inertia=self.inertia, rotor_lag=self.rotor_lag)

    def __str__(self) -> str:
        if self == NOMINAL_CASE:
            return "as described"
        return f"mass x {self.mass:g}, inertia x {self.inertia:g}, rotor lag x {self.rotor_lag:g}"


NOMINAL_CASE = VehicleCase()


def identified_robustness(sidecar: Path | str) -> Robustness | None:
    """Return the robustness required by 95 % confidence intervals; None if none were identified.

    A log yields thrust over mass, so its uncertainty is used for the mass. Of three inertias the
    least certain one counts. Others keep their defaults.

    Args:
        sidecar: one with intervals, as `workbench identify` writes them.

    Raises:
        WorkbenchError: with file and line, for an unknown key or a wrong type.
    """
    from workbench.plant.rotor_sources.sidecar import load_sidecar  # it loads Drake

    rows = {row.name: row for row in load_sidecar(Path(sidecar))[1].identified}
    shares = {
        name: min(max(_half_width_share(rows[each]) for each in known), MAX_UNCERTAINTY)
        for name, names in UNCERTAINTY_SOURCES.items()
        if (known := [each for each in names if each in rows and rows[each].value > 0.0])
    }
    return Robustness(**shares) if shares else None


def _half_width_share(row: "IdentifiedRow") -> float:
    """Return the half width of an interval, as a share of its value."""
    return max(row.high - row.value, row.value - row.low) / row.value


def robustness_corners(robustness: Robustness) -> list[VehicleCase]:
    """Return all combinations of the extremes of mass, inertia and rotor lag."""
    shares = (robustness.mass, robustness.inertia, robustness.rotor_lag)
    ends = [(1.0 - share, 1.0 + share) if share else (1.0,) for share in shares]
    found = [VehicleCase(*factors) for factors in itertools.product(*ends)]
    return [case for case in found if case != NOMINAL_CASE]

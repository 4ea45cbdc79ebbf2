"""How a vehicle in flight differs from the one that its controller knows."""

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.vehicle import Vehicle

LEAST, MOST = 0.1, 10.0
"""Bounds of the factors."""
LATEST = 16
"""Most control periods of delay."""


@dataclass
class Variation:
    """Factors on what flies, of which the controller knows nothing, and a delay.

    Attributes:
        mass: factor on the mass; centre and moments of inertia stay.
        inertia: factor on all moments of inertia about the centre of mass.
        rotor_lag: factor on both time constants of all rotors.
        control_delay: control periods by which the controller sees the state late.
    """

    mass: float = 1.0
    inertia: float = 1.0
    rotor_lag: float = 1.0
    control_delay: int = 0

    @property
    def nominal(self) -> bool:
        """Whether the vehicle is as the controller believes; it may still be seen late."""
        return self.mass == self.inertia == self.rotor_lag == 1.0

    def check(self, where: str = "") -> None:
        """Refuse what cannot fly.

        Args:
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: for the first number out of bounds.
        """
        for name in ("mass", "inertia", "rotor_lag"):
            value = getattr(self, name)
            if not LEAST <= value <= MOST:
                raise WorkbenchError(
                    f"{where}the variation of {name} is {value:g}: give a factor within "
                    f"{LEAST:g} .. {MOST:g}"
                )
        if not (
            0 <= self.control_delay <= LATEST and int(self.control_delay) == self.control_delay
        ):
            raise WorkbenchError(
                f"{where}the control_delay is {self.control_delay}: give 0 .. {LATEST} periods"
            )


def varied(description: "Description", vehicle: "Vehicle", variation: Variation) -> "Description":
    """Return the description of what flies.

    All mass is gathered in the base link, so that the moments of inertia of the whole can be
    scaled; that changes nothing of how a rigid body moves.

    Args:
        description: of the vehicle as the controller knows it.
        vehicle: its record.
        variation: how the flying one differs.
    """
    if variation.nominal:
        return description
    from pydrake.math import RigidTransform  # the record above is read without Drake

    from workbench.plant.model import Inertial

    inertia = variation.inertia * vehicle.inertia
    whole = Inertial(
        mass=variation.mass * vehicle.mass,
        X_LI=RigidTransform(list(vehicle.p_BoBcm_B)),
        moments=(float(inertia[0, 0]), float(inertia[1, 1]), float(inertia[2, 2])),
        products=(float(inertia[0, 1]), float(inertia[0, 2]), float(inertia[1, 2])),
    )
    links = tuple(
        dataclasses.replace(link, inertial=whole if link.name == description.base_link else None)
        for link in description.model.links
    )
    rotors = tuple(
        dataclasses.replace(
            rotor,
            time_constant_up=variation.rotor_lag * rotor.time_constant_up,
            time_constant_down=variation.rotor_lag * rotor.time_constant_down,
        )
        for rotor in description.rotors
    )
    return dataclasses.replace(
        description, model=dataclasses.replace(description.model, links=links), rotors=rotors
    )

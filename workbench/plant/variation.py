"""The differences between a vehicle in flight and the one that its controller knows."""

import dataclasses
from dataclasses import dataclass
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.model import Inertial, Link
    from workbench.plant.vehicle import Vehicle

MIN_VARIATION_FACTOR, MAX_VARIATION_FACTOR = 0.1, 10.0
"""Bounds of the factors."""
MAX_DELAY_PERIODS = 16
"""Limit of delays in control periods."""
MAX_VARIED_DELAY_S = 0.1
"""Limit of the delays given in seconds [s]."""
DELAY_NAMES = ("sensing_delay", "command_delay")
"""Names of the delays given in seconds."""


@dataclass(frozen=True)
class Delays:
    """Delays in steps of physics.

    Attributes:
        steps: in a control period.
        sensing: delay of the state that the controller sees.
        command: delay of commands.
    """

    steps: int
    sensing: int
    command: int

    @property
    def sensing_delay(self) -> tuple[int, int]:
        """What an update sees: how many periods ago, and the state before which step of it."""
        return -(-self.sensing // self.steps), -self.sensing % self.steps

    @property
    def command_delay(self) -> tuple[int, int]:
        """Which commands act: from how many updates ago, and from which step of a period."""
        return divmod(self.command, self.steps)


@dataclass
class Variation:
    """Factors on the flying vehicle that are unknown to the controller, and delays.

    Attributes:
        mass: factor on the mass; centre of mass and moments of inertia stay.
        inertia: factor on all moments of inertia about the centre of mass.
        rotor_lag: factor on both time constants of all rotors.
        control_delay: delay of the state that the controller sees [control periods].
        sensing_delay: additional delay of that state, in whole steps of physics [s].
        command_delay: delay of its commands to the rotors, in whole steps of physics [s].
    """

    mass: float = 1.0
    inertia: float = 1.0
    rotor_lag: float = 1.0
    control_delay: int = 0
    sensing_delay: float = 0.0
    command_delay: float = 0.0

    @property
    def nominal(self) -> bool:
        """Whether the vehicle is as the controller knows it, apart from delays."""
        return self.mass == self.inertia == self.rotor_lag == 1.0

    def check(self, where: str = "") -> None:
        """Check that all numbers are within their limits.

        Args:
            where: file and line for the message, if any.

        Raises:
            WorkbenchError: for the first number out of limits.
        """
        for name in ("mass", "inertia", "rotor_lag"):
            value = getattr(self, name)
            if not MIN_VARIATION_FACTOR <= value <= MAX_VARIATION_FACTOR:
                raise WorkbenchError(
                    f"{where}the variation of {name} is {value:g}: give a factor within "
                    f"{MIN_VARIATION_FACTOR:g} .. {MAX_VARIATION_FACTOR:g}"
                )
        if not (
            0 <= self.control_delay <= MAX_DELAY_PERIODS
            and int(self.control_delay) == self.control_delay
        ):
            raise WorkbenchError(
                f"{where}the control_delay is {self.control_delay}: give 0 .. {MAX_DELAY_PERIODS} "
                "periods"
            )
        for name in DELAY_NAMES:
            delay = getattr(self, name)
            if not 0.0 <= delay <= MAX_VARIED_DELAY_S:
                raise WorkbenchError(
                    f"{where}the {name} is {delay:g} s: give 0 .. {MAX_VARIED_DELAY_S:g} s"
                )

    def delays(self, physics_step: float, control_period: float) -> "Delays":
        """Return the delays of a flight for these periods [s]."""
        steps = round(control_period / physics_step)
        late = int(self.control_delay) * steps + round(self.sensing_delay / physics_step)
        return Delays(steps, late, round(self.command_delay / physics_step))


def varied_description(
    description: "Description", vehicle: "Vehicle", variation: Variation
) -> "Description":
    """Return the description of what flies.

    All mass of a rigid body is merged into the base link, so that the moments of inertia of the
    whole can be scaled. Its motion stays the same. Where joints move, mass and moments of each link
    are scaled.

    Args:
        description: of the vehicle as the controller knows it.
        vehicle: its record.
        variation: the differences of the flying vehicle.
    """
    if variation.nominal:
        return description
    from pydrake.math import RigidTransform  # the record above needs no Drake

    from workbench.plant.model import inertial_of

    whole = inertial_of(
        variation.mass * vehicle.mass,
        RigidTransform(list(vehicle.p_BoBcm_B)),
        variation.inertia * vehicle.inertia,
    )

    def varied(link: "Link") -> "Inertial | None":
        """Return the inertia of a link that flies."""
        if not vehicle.joints:
            return whole if link.name == description.base_link else None
        if (own := link.inertial) is None:
            return None
        return inertial_of(variation.mass * own.mass, own.X_LI, variation.inertia * own.matrix)

    links = tuple(
        dataclasses.replace(link, inertial=varied(link)) for link in description.model.links
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

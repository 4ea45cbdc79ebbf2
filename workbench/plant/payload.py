"""The payload of a vehicle, and the vehicle with it."""

import dataclasses
from collections.abc import Mapping
from typing import TYPE_CHECKING, NamedTuple

from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.gathered import whole_inertial
from workbench.plant.model import Inertial, inertial_of
from workbench.plant.rotors import allocation_matrix
from workbench.plant.swinging import as_turned
from workbench.plant.vehicle import Vehicle

if TYPE_CHECKING:
    from workbench.plant.description import Description


class Payload(NamedTuple):
    """A box of uniform density fixed to the body; `workbench params` explains its numbers.

    The parameters are sizes, not moments of inertia. Every physical inertia is that of some box, so
    these numbers can be set in any order without an impossible inertia in between. The moments
    scale with the mass.
    """

    payload_mass: float = 0.0
    payload_x: float = 0.0
    payload_y: float = 0.0
    payload_z: float = 0.0
    payload_size_x: float = 0.0
    payload_size_y: float = 0.0
    payload_size_z: float = 0.0
    known_payload_mass: float = 0.0

    @property
    def known(self) -> "Payload":
        """The payload known to the law: its mass may differ, the rest is the same."""
        known = self.known_payload_mass
        return self._replace(payload_mass=known) if known > 0.0 else NO_PAYLOAD

    @property
    def place(self) -> tuple[float, float, float]:
        """The box's centre in the body frame [m]."""
        return self.payload_x, self.payload_y, self.payload_z

    @property
    def inertial(self) -> Inertial:
        """Mass and inertia in the body frame: m / 12 (b² + c²) about an axis across b and c."""
        x, y, z = (size * size for size in self[4:7])
        share = self.payload_mass / 12.0
        return Inertial(
            self.payload_mass,
            RigidTransform(list(self.place)),
            (share * (y + z), share * (x + z), share * (x + y)),
            (0.0, 0.0, 0.0),
        )


NO_PAYLOAD = Payload()
"""The payload of a vehicle that carries nothing."""


def payload_of(values: Mapping[str, float]) -> Payload:
    """Return the payload given by parameter values; a missing one is as without a payload."""
    return Payload(**{name: values[name] for name in Payload._fields if name in values})


def vehicle_with_payload(vehicle: Vehicle, payload: Payload) -> Vehicle:
    """Return a vehicle with its payload as part of it; without a payload, the vehicle itself."""
    if payload.payload_mass == 0.0:
        return vehicle
    centre = RigidTransform(list(vehicle.p_BoBcm_B))
    whole = _inertial_with_payload(inertial_of(vehicle.mass, centre, vehicle.inertia), payload)
    (xx, yy, zz), (xy, xz, yz) = whole.moments, whole.products
    x, y, z = whole.X_LI.translation().tolist()
    return dataclasses.replace(
        vehicle,
        mass=whole.mass,
        p_BoBcm_B=(x, y, z),
        I_BBcm_B=((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)),
    )


def controller_model(vehicle: Vehicle, payload: Payload) -> Vehicle:
    """Return a vehicle with its payload as known to the law.

    Raises:
        WorkbenchError: if no rotor speeds keep it in hover.
    """
    known, vehicle = payload.known, as_turned(vehicle)
    if known == NO_PAYLOAD:
        return vehicle
    whole = vehicle_with_payload(vehicle, known)
    try:
        allocation_matrix(whole.rotors, whole.p_BoBcm_B, whole.tilts)
    except WorkbenchError as error:
        place = ", ".join(f"{p:g}" for p in known.place)
        raise WorkbenchError(
            f"the law cannot fly with a known payload of {known.payload_mass:g} kg "
            f"at ({place}) m: {error}"
        ) from None
    return whole


def description_with_payload(description: "Description", payload: Payload) -> "Description":
    """Return a description with the mass of a payload added to its base link."""
    if payload.payload_mass == 0.0:
        return description
    links = tuple(
        dataclasses.replace(link, inertial=_inertial_with_payload(link.inertial, payload))
        if link.name == description.base_link
        else link
        for link in description.model.links
    )
    return dataclasses.replace(
        description, model=dataclasses.replace(description.model, links=links)
    )


def _inertial_with_payload(bare: Inertial | None, payload: Payload) -> Inertial:
    whole = whole_inertial([(RigidTransform(), bare), (RigidTransform(), payload.inertial)])
    assert whole
    return whole

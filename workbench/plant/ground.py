"""The ground: a half space at z = 0 that a drone rests on, takes off from and lands on."""

import logging

from pydrake.geometry import AddContactMaterial, HalfSpace, ProximityProperties
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant


def add_ground(plant: MultibodyPlant) -> None:
    """Add a half space below z = 0 of the world, with the friction of rubber on concrete.

    Stiffness and dissipation are left to Drake's defaults, which scale with the vehicle's weight
    (the static penetration stays below a tenth of a millimetre).
    """
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(0.8, 0.7), properties=properties)
    # Drake logs from a thread of its own, so the filter has to stay; adding it twice is harmless.
    logging.getLogger("drake").addFilter(_not_about_deformables)
    plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", properties
    )


def _not_about_deformables(record: logging.LogRecord) -> bool:
    """Drop Drake's remark that half spaces do not touch deformable bodies; there are none."""
    return "deformable" not in record.getMessage()

"""The ground: a half space at z = 0 that a drone rests on, takes off from and lands on."""

import logging

from pydrake.geometry import (
    AddContactMaterial,
    HalfSpace,
    PerceptionProperties,
    ProximityProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant


def add_ground(plant: MultibodyPlant, scene_graph: SceneGraph) -> None:
    """Add a half space below z = 0 of the world, which sensors see and Meshcat does not draw."""
    # Drake logs from a thread of its own, so the filter has to stay; adding it twice is harmless.
    logging.getLogger("drake").addFilter(_not_about_deformables)
    geometry = plant.RegisterCollisionGeometry(
        plant.world_body(), RigidTransform(), HalfSpace(), "ground", contact_properties()
    )
    seen = PerceptionProperties()
    seen.AddProperty("phong", "diffuse", Rgba(0.45, 0.47, 0.45, 1.0))
    seen.AddProperty("label", "id", RenderLabel.kDontCare)
    scene_graph.AssignRole(plant.get_source_id(), geometry, seen)


def contact_properties() -> ProximityProperties:
    """Return what ground and obstacles feel like: the friction of rubber on concrete.

    Stiffness and dissipation are left to Drake's defaults, which scale with the vehicle's weight
    (the static penetration stays below a tenth of a millimetre).
    """
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(0.8, 0.7), properties=properties)
    return properties


def _not_about_deformables(record: logging.LogRecord) -> bool:
    """Drop Drake's remark that half spaces do not touch deformable bodies; there are none."""
    return "deformable" not in record.getMessage()

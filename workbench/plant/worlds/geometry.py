"""Shapes of obstacles as Drake geometries with roles."""

import copy
import logging
from collections.abc import Iterable

import pydrake.geometry as drake
from pydrake.geometry import (
    AddContactMaterial,
    GeometryId,
    GeometryInstance,
    HalfSpace,
    IllustrationProperties,
    PerceptionProperties,
    ProximityProperties,
    RenderLabel,
    Rgba,
    SceneGraph,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import CoulombFriction, MultibodyPlant

from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Mesh, Sphere

ObstacleRgba = tuple[float, float, float, float]
DEFAULT_OBSTACLE_RGBA: ObstacleRgba = (0.7, 0.7, 0.7, 1.0)
"""The default colour."""


def collision(name: str, X_OG: RigidTransform, shape: GeometryShape) -> GeometryInstance:
    """Return a geometry for contact; the file of a mesh is its convex hull."""
    geometry = GeometryInstance(X_OG, drake_shape(shape), name)
    geometry.set_proximity_properties(contact_properties())
    return geometry


def visual(
    name: str, X_OG: RigidTransform, shape: GeometryShape, colour: ObstacleRgba | None
) -> GeometryInstance:
    """Return a geometry for drawing and sensors; without `colour` a mesh has that of its file."""
    if colour is None and not isinstance(shape, Mesh):
        colour = DEFAULT_OBSTACLE_RGBA
    return _seen(GeometryInstance(X_OG, _drawn(shape), name), colour)


def solid_geometry(
    name: str, shape: GeometryShape, colour: ObstacleRgba | None
) -> GeometryInstance:
    """Return a geometry for contact, drawing and sensors."""
    geometry = _seen(
        GeometryInstance(RigidTransform(), _drawn(shape), name), colour or DEFAULT_OBSTACLE_RGBA
    )
    geometry.set_proximity_properties(contact_properties())
    return geometry


def drawn_if_none(
    visuals: Iterable[GeometryInstance], collisions: Iterable[GeometryInstance]
) -> tuple[GeometryInstance, ...]:
    """Return the visuals, or the collision shapes as visuals if there are none.

    Sensors must see everything that the drone can touch.
    """
    return tuple(visuals) or tuple(
        _seen(
            GeometryInstance(each.pose(), copy.copy(each.shape()), each.name()),
            DEFAULT_OBSTACLE_RGBA,
        )
        for each in collisions
    )


def _seen(geometry: GeometryInstance, colour: ObstacleRgba | None) -> GeometryInstance:
    """Give a geometry the roles for drawing and sensors."""
    illustration, perception = IllustrationProperties(), PerceptionProperties()
    if colour is not None:
        illustration.AddProperty("phong", "diffuse", Rgba(*colour))
        perception.AddProperty("phong", "diffuse", Rgba(*colour))
    perception.AddProperty("label", "id", RenderLabel.kDontCare)
    geometry.set_illustration_properties(illustration)
    geometry.set_perception_properties(perception)
    return geometry


def _drawn(shape: GeometryShape) -> drake.Shape:
    """Return Drake's shape for drawing."""
    return drake.Mesh(str(shape.path)) if isinstance(shape, Mesh) else drake_shape(shape)


def drake_shape(shape: GeometryShape) -> drake.Shape:
    """Return Drake's shape for touching, that of a mesh its convex hull."""
    match shape:
        case Box((x, y, z)):
            return drake.Box(x, y, z)
        case Sphere(radius):
            return drake.Sphere(radius)
        case Cylinder(radius, length):
            return drake.Cylinder(radius, length)
        case Capsule(radius, length):
            return drake.Capsule(radius, length)
        case Ellipsoid((a, b, c)):
            return drake.Ellipsoid(a, b, c)
        case Mesh(path=path):
            return drake.Convex(str(path))


def add_ground(plant: MultibodyPlant, scene_graph: SceneGraph) -> GeometryId:
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
    return geometry


def contact_properties() -> ProximityProperties:
    """Return the contact properties of ground and obstacles: the friction of rubber on concrete.

    Stiffness and dissipation are left to Drake's defaults, which scale with the vehicle's weight
    (the static penetration stays below a tenth of a millimetre).
    """
    properties = ProximityProperties()
    AddContactMaterial(friction=CoulombFriction(0.8, 0.7), properties=properties)
    return properties


def _not_about_deformables(record: logging.LogRecord) -> bool:
    """Drop Drake's remark that half spaces do not touch deformable bodies; there are none."""
    return "deformable" not in record.getMessage()

"""Bodies that Drake has read from model directives, as obstacles."""

import copy
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryId,
    GeometryInstance,
    HalfSpace,
    Mesh,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import RigidBody
from pydrake.systems.framework import Context

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import read_plain
from workbench.common.yaml_files import YamlFile
from workbench.plant.drawable import MAX_MESH_FILE_BYTES, MeshUse, convert_meshes
from workbench.plant.shapes import Mesh as MeshFile
from workbench.plant.worlds.geometry import drawn_if_none
from workbench.plant.worlds.world import StaticObstacle

MAX_OBSTACLE_EXTENT_M = 1e6
"""Limit of the sides and coordinates of obstacles [m]."""


def obstacle_of_body(
    plant: MultibodyPlant,
    inspector: SceneGraphInspector,
    file: YamlFile,
    body: RigidBody,
    context: Context,
) -> StaticObstacle:
    """Return a body as an obstacle.

    Raises:
        WorkbenchError: if it could move, or is infinite or too far away.
    """
    name = body.scoped_name().get_full()
    collisions = _geometries(inspector, name, plant.GetCollisionGeometriesForBody(body))
    visuals = _geometries(inspector, name, plant.GetVisualGeometriesForBody(body))
    if not plant.IsAnchored(body):
        raise WorkbenchError(
            f"{_where(file, name)}the body '{name}' is not fixed to the world: add_weld it "
            f"(add_weld: {{parent: world, child: {name}}}), or list it under `moving`"
        )
    if any(isinstance(each.shape(), HalfSpace) for each in collisions):
        raise WorkbenchError(
            f"{_where(file, name)}the body '{name}' has an endless plane as collision shape: use a "
            "box; there is ground at z = 0 anyway"
        )
    X_WO = plant.EvalBodyPoseInWorld(context, body)
    for geometry in (*collisions, *visuals):
        refuse_invalid_geometry(_where(file, name), name, X_WO, geometry)
    where = _where(file, name)
    drawn = drawn_if_none(visuals, collisions)
    return StaticObstacle(
        name, X_WO, collisions, tuple(_with_normals(where, each) for each in drawn)
    )


def _with_normals(where: str, geometry: GeometryInstance) -> GeometryInstance:
    """Return a visual; one with an OBJ without normals, which Drake's cameras refuse, with them.

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    shape = geometry.shape()
    path = shape.source().path() if isinstance(shape, Mesh) else Path()
    if path.suffix.lower() != ".obj" or not path.is_file():
        return geometry
    data = read_plain(path, MAX_MESH_FILE_BYTES)
    if data.startswith(b"vn") or b"\nvn" in data:
        return geometry
    seen = geometry.perception_properties() or geometry.illustration_properties()
    rgba = None
    if seen is not None and seen.HasProperty("phong", "diffuse"):
        color = seen.GetProperty("phong", "diffuse")
        rgba = (color.r(), color.g(), color.b(), color.a())
    use = MeshUse(MeshFile(str(path), path), "visual", rgba)
    converted = convert_meshes([use])[use]
    if isinstance(converted, WorkbenchError):
        raise WorkbenchError(f"{where}{converted}") from converted
    shown = GeometryInstance(geometry.pose(), Mesh(str(converted), shape.scale3()), geometry.name())
    if perceived := geometry.perception_properties():
        shown.set_perception_properties(copy.copy(perceived))
    if drawn := geometry.illustration_properties():
        shown.set_illustration_properties(copy.copy(drawn))
    return shown


def _where(file: YamlFile, body: str) -> str:
    """Return file and line of the directive that adds the model of a body."""
    for index, item in enumerate(file.data["directives"]):
        if body.startswith(f"{item.get('add_model', {}).get('name')}::"):
            return file.where("directives", index)
    return file.where("directives")


def _geometries(
    inspector: SceneGraphInspector, body: str, ids: Sequence[GeometryId]
) -> tuple[GeometryInstance, ...]:
    """Return copies of a body's geometries, named after it."""
    copies = [inspector.CloneGeometryInstance(id) for id in ids]
    for geometry in copies:
        geometry.set_name(f"{body}::{geometry.name().rpartition('::')[2]}")
    return tuple(copies)


def refuse_invalid_geometry(
    where: str, name: str, X_WO: RigidTransform, geometry: GeometryInstance
) -> None:
    """Reject a geometry of an obstacle with an invalid size or position.

    Args:
        where: "file:line: ", for the beginning of the message.
        name: of the obstacle.
        X_WO: pose of the obstacle.
        geometry: of the obstacle, with its pose in O.

    Raises:
        WorkbenchError: if a number is not finite or beyond `MAX_OBSTACLE_EXTENT_M`, or a side not
            positive.
    """
    parts = (X_WO, geometry.pose())
    if not all(_is_place(each) for each in parts):
        raise WorkbenchError(
            f"{where}'{name}' has no finite position, or is more than {MAX_OBSTACLE_EXTENT_M:g} m "
            "away: give it "
            "a pose of finite numbers"
        )
    sides = np.array(_shape_sides(geometry.shape()))
    if not (np.isfinite(sides) & (sides > 0.0) & (sides <= MAX_OBSTACLE_EXTENT_M)).all():
        numbers = ", ".join(f"{side:g}" for side in sides)
        raise WorkbenchError(
            f"{where}'{name}' has a {type(geometry.shape()).__name__.lower()} with {numbers}: "
            f"give it numbers above 0 and up to {MAX_OBSTACLE_EXTENT_M:g}"
        )


def _is_place(X: RigidTransform) -> bool:
    matrix = X.GetAsMatrix34()
    return bool((np.abs(matrix) <= MAX_OBSTACLE_EXTENT_M).all())  # false for NaN


def _shape_sides(shape: Shape) -> tuple[float, ...]:
    """Return the sides and radii of a shape [m], or the absolute scale of a mesh."""
    match shape:
        case Box():
            return tuple(shape.size())
        case Sphere():
            return (shape.radius(),)
        case Cylinder() | Capsule():
            return (shape.radius(), shape.length())
        case Ellipsoid():
            return (shape.a(), shape.b(), shape.c())
        case Mesh() | Convex():
            return tuple(np.abs(shape.scale3()))
        case _:
            return ()

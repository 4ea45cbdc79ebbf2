"""Read a world from Gazebo's SDF, with all models static."""

import dataclasses
import math
from collections.abc import Mapping, Sequence
from pathlib import Path

import numpy as np
from pydrake.geometry import GeometryInstance

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.detachable_joint import held_models
from workbench.extras.formats.sdf_include import SdfFile, SdfFiles
from workbench.extras.formats.sdf_node import Node, sdf_number, sdf_triple
from workbench.extras.formats.sdf_poses import MODEL_FRAME_NAME, Poses
from workbench.extras.formats.sdf_shapes import link_shapes
from workbench.extras.formats.sdf_tree import SdfTree, build_sdf_tree
from workbench.extras.formats.sdf_world import (
    gazebo_scenery_name,
    has_motors,
    list_of_names,
    top_models,
    top_name,
    world_element,
    world_of,
)
from workbench.plant.drawable import with_converted_meshes
from workbench.plant.formats.sdf_pose import sdf_numbers
from workbench.plant.home import DEFAULT_HOME, MAX_FIELD_T, Home, WorldVector
from workbench.plant.model import Link, LinkShape, Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Mesh
from workbench.plant.worlds.geometry import collision, drawn_if_none, visual
from workbench.plant.worlds.world import StaticObstacle, World

MAX_WORLD_MODELS = 5000
MAX_WORLD_LINKS = 20_000
_IGNORED_WORLD_TAGS = ("actor", "population", "road", "state")
"""Elements of a world, besides models, that get a remark and are not built."""
_MAX_GROUND_TILT_RAD = 1e-6
"""Largest tilt of the ground [rad]."""
_MAX_GROUND_OFFSET_M = 1e-3
"""Largest distance of the ground from z = 0 [m]."""


def read_gazebo_world(path: Path, packages: Mapping[str, Path | str]) -> World:
    """Return the world in an SDF file, versions 1.3 to 1.12.

    Lights, physics, plugins and other elements that are not obstacles are left out without a
    remark.

    Args:
        path: the file.
        packages: folders by name, in addition to those that are found.

    Raises:
        WorkbenchError: naming file and line, for invalid content. A missing model is only a remark.
    """
    finder = PackageFinder(path, packages)
    files = SdfFiles(finder)
    file = files.open(path)
    remarks = Remarks()
    world = _world(file, remarks)
    tree = world_of(file, world, _world_models(file, files, remarks))
    links = _links(tree, Poses(tree, remarks), finder, remarks)
    return World(
        source=path,
        name=path.stem,
        title=tree.name,
        obstacles=obstacles_of(path, links, remarks),
        home=_world_home(world, remarks),
        remarks=tuple(remarks.found),
    )


def _world(file: SdfFile, remarks: Remarks) -> Node:
    """Return the world in a file, or its root element without a world."""
    world = Node(world_element(file), file.path, file.version, "", MODEL_FRAME_NAME)
    for tag in _IGNORED_WORLD_TAGS:
        count = len(world.children(tag))
        if count:
            text = f"{count} of them; left out"
            remarks.add("ignored", file.path, f"<{tag}> of the world", text)
    return world


def _world_models(file: SdfFile, files: SdfFiles, remarks: Remarks) -> list[SdfTree]:
    """Return the models of a world, without missing ones and drones."""
    tops = top_models(file)
    if len(tops) > MAX_WORLD_MODELS:
        raise WorkbenchError(
            f"{file.path}: has more than {MAX_WORLD_MODELS} models: leave some out"
        )
    trees: dict[str, SdfTree] = {}
    left_out: set[str] = set()
    links = 0
    for top in tops:
        if gazebo_scenery_name(top):
            continue
        try:
            tree = build_sdf_tree(file, top, files, trees)
            tree.check_complete()
        except WorkbenchError as fault:
            text = str(fault).removeprefix(f"{file.path}:{top.element.line}: ")
            remarks.add("missing", file.path, f"model '{top_name(top)}'", f"{text}; left out")
            left_out.add(top_name(top))
            continue
        if has_motors(tree):
            text = "it has motors, so it is another drone; left out"
            remarks.add("ignored", file.path, f"model '{tree.name}'", text)
            left_out |= {tree.name, *held_models(tree.plugins)}
            continue
        trees[tree.name] = tree
        links += len(tree.links)
        if links > MAX_WORLD_LINKS:
            raise top.fault(
                f"with this the world has more than {MAX_WORLD_LINKS} links: leave some out"
            )
    standing = [tree for name, tree in trees.items() if name not in left_out]
    return _models_with_poses(file, standing, left_out, remarks)


def _models_with_poses(
    file: SdfFile, trees: list[SdfTree], left_out: set[str], remarks: Remarks
) -> list[SdfTree]:
    """Return the models without those that are, even indirectly, relative to one left out."""
    while lost := [tree for tree in trees if _base(tree) in left_out]:
        for tree in lost:
            text = f"its pose is relative to '{_base(tree)}', which is left out; left out"
            remarks.add("missing", file.path, f"model '{tree.name}'", text)
            left_out.add(tree.name)
        trees = [tree for tree in trees if tree not in lost]
    loose = [tree.name for tree in trees if not tree.static]
    if loose:
        text = f"{list_of_names(loose)} could move, but stand still here"
        remarks.add("assumed", file.path, "models that are not static", text)
    return trees


def _base(tree: SdfTree) -> str:
    """Return the model that the pose of a model is relative to, "" for the world."""
    pose = tree.models[-1].pose  # the frame of a model comes after those of nested models
    return pose.attribute("relative_to").partition("::")[0] if pose else ""


def _links(tree: SdfTree, poses: Poses, finder: PackageFinder, remarks: Remarks) -> list[Link]:
    """Return the links of all models, with poses in the world."""
    links = []
    for node in tree.links:
        solid = without_planes(node, poses, remarks)
        links.append(
            Link(
                name=node.full_name,
                X_ML=poses.X_MF(node.full_name),
                inertial=None,
                visuals=tuple(link_shapes(solid, "visual", poses, finder, remarks)),
                collisions=tuple(link_shapes(solid, "collision", poses, finder, remarks)),
            )
        )
    return links


def _world_home(world: Node, remarks: Remarks) -> Home | None:
    """Return the position on the earth and the magnetic field in a world, if stated."""
    field = _world_magnetic_field(world, remarks)
    place = world.child("spherical_coordinates")
    if place is None:
        return dataclasses.replace(DEFAULT_HOME, magnetic_field=field) if field else None
    latitude, longitude, altitude, heading = (
        sdf_number(place, tag, 0.0)
        for tag in ("latitude_deg", "longitude_deg", "elevation", "heading_deg")
    )
    if abs(latitude) > 90.0 or abs(longitude) > 180.0:
        raise place.fault("the latitude must be within ±90 degrees, the longitude within ±180")
    if heading:
        text = f"heading_deg is {heading:g}; x is taken to point east"
        remarks.add("ignored", place.file, "<spherical_coordinates>", text)
    return Home(math.radians(latitude), math.radians(longitude), altitude, field)


def _world_magnetic_field(world: Node, remarks: Remarks) -> WorldVector | None:
    """Return the magnetic field in a world: east, north and up [T]."""
    stated = world.child("magnetic_field")
    if stated is None or not stated.text:
        return None
    east, north, up = sdf_numbers(stated.element, 3)
    if max(abs(east), abs(north), abs(up)) > MAX_FIELD_T:
        text = f"{stated.text}: no component can be beyond {MAX_FIELD_T:g} T; that of the earth"
        remarks.add("ignored", stated.file, "<magnetic_field>", text)
        return None
    return (east, north, up)


def without_planes(link: Node, poses: Poses, remarks: Remarks) -> Node:
    """Return a link without planes for contact, and without the visual of the ground.

    The ground is the half space in every world; other planes are not supported.

    Args:
        link: with its `<visual>` and `<collision>` elements.
        poses: of all links.
        remarks: receives remarks on planes for contact other than the ground.
    """
    left_out = []
    for part in link.children("visual", "collision"):
        geometry = part.child("geometry")
        plane = geometry.child("plane") if geometry else None
        if plane is None:
            continue
        X_WP = poses.X_MF(link.full_name) @ poses.X_LF(part, link.full_name)
        normal = np.array(sdf_triple(plane, "normal", (0.0, 0.0, 1.0)))
        n_W = X_WP.rotation().matrix() @ normal / max(float(np.linalg.norm(normal)), 1e-12)
        height = float(X_WP.translation()[2])
        is_ground = (
            np.hypot(n_W[0], n_W[1]) < _MAX_GROUND_TILT_RAD
            and n_W[2] > 0.0
            and abs(height) < _MAX_GROUND_OFFSET_M
        )
        if is_ground or part.element.tag == "collision":
            left_out.append(part.element)
        if not is_ground and part.element.tag == "collision":
            text = f"an endless plane that is not the ground at z = 0 (here {height:g} m); left out"
            remarks.add("ignored", part.file, f"{part.title} of link '{link.full_name}'", text)
    if not left_out:
        return link
    kept = link.element.like(link.element.attrib)
    kept.text = link.element.text
    kept.extend(child for child in link.element if child not in left_out)
    return dataclasses.replace(link, element=kept)


def obstacles_of(
    source: Path, links: Sequence[Link], remarks: Remarks
) -> tuple[StaticObstacle, ...]:
    """Return an obstacle for each link with a shape, with meshes converted for Drake.

    Args:
        source: file of the world.
        links: with poses in the world.
        remarks: receives remarks on meshes that are missing, unreadable, or replaced by hulls.
    """
    model = Model(source, source.stem, tuple(links), (), (), (), ())
    model.refuse_long_names()
    converted = with_converted_meshes(model, remarks, "left out")
    hulls = sum(isinstance(each.shape, Mesh) for link in converted for each in link.collisions)
    if hulls:
        text = f"{hulls} of them use their convex hulls"
        remarks.add("assumed", source, "meshes of collisions", text)
    obstacles = [_obstacle_of_link(link) for link in converted]
    return tuple(obstacle for obstacle in obstacles if obstacle.visuals)


def _obstacle_of_link(link: Link) -> StaticObstacle:
    collisions = [
        collision(name, each.X_LS, each.shape)
        for name, each in zip(
            _unique_shape_names(link, link.collisions), link.collisions, strict=True
        )
    ]
    visuals: list[GeometryInstance] = [
        visual(name, each.X_LS, each.shape, each.rgba)
        for name, each in zip(_unique_shape_names(link, link.visuals), link.visuals, strict=True)
        if not each.is_missing
    ]
    return StaticObstacle(
        link.name, link.X_ML, tuple(collisions), drawn_if_none(visuals, collisions)
    )


def _unique_shape_names(link: Link, shapes: Sequence[LinkShape]) -> list[str]:
    """Return names of the shapes of a link, with numbers if one occurs twice."""
    names = [shape.name.replace("::", "_") for shape in shapes]
    if len(set(names)) < len(names):
        names = [f"{name}_{index}" for index, name in enumerate(names)]
    return [f"{link.name}::{name}" for name in names]

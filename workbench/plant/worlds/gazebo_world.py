"""Read a world from Gazebo's SDF: every model in it, standing still."""

import math
from collections.abc import Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_include import SdfFile, SdfFiles
from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.sdf_poses import ROOT, Poses
from workbench.plant.formats.sdf_shapes import ShapeReader
from workbench.plant.formats.sdf_tree import SdfTree, grow_in_world
from workbench.plant.formats.sdf_values import number
from workbench.plant.formats.sdf_world import (
    gazebos_own,
    has_motors,
    list_of_names,
    top_models,
    top_name,
    world_of,
)
from workbench.plant.formats.xml import Element
from workbench.plant.home import Home
from workbench.plant.model import Link
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.worlds.gazebo_planes import without_planes
from workbench.plant.worlds.links import obstacles_of
from workbench.plant.worlds.world import World

MOST_MODELS = 5000
MOST_LINKS = 20_000
_NOT_BUILT = ("actor", "population", "road", "state")
"""What a world may have besides models, and is not built."""


def read_gazebo_world(path: Path, packages: Mapping[str, Path | str]) -> World:
    """Return the world of an SDF file, versions 1.3 to 1.12.

    Lights, physics, plugins and what else does not stand in the way are left out without a word.

    Args:
        path: the file.
        packages: folders by name, besides those that are found.

    Raises:
        WorkbenchError: naming file and line of what cannot be read. A model that is not found is
            no failure but a remark.
    """
    finder = PackageFinder(path, packages)
    files = SdfFiles(finder)
    file = files.open(path)
    remarks = Remarks()
    world = _world(file, remarks)
    tree = world_of(file, world, _models(file, files, remarks))
    links = _links(tree, Poses(tree, remarks), finder, remarks)
    return World(
        source=path,
        name=path.stem,
        title=tree.name,
        obstacles=obstacles_of(path, links, remarks),
        home=_home(world, remarks),
        remarks=tuple(remarks.found),
    )


def _world(file: SdfFile, remarks: Remarks) -> Node:
    """Return the world of a file; where it has none, the file itself."""
    worlds = [each for each in file.root.findall("world") if isinstance(each, Element)]
    if len(worlds) > 1:
        raise WorkbenchError(f"{file.path}: has {len(worlds)} worlds: leave one in it")
    world = Node(worlds[0] if worlds else file.root, file.path, file.version, "", ROOT)
    for tag in _NOT_BUILT:
        count = len(world.children(tag))
        if count:
            text = f"{count} of them; not built"
            remarks.add("ignored", file.path, f"<{tag}> of the world", text)
    return world


def _models(file: SdfFile, files: SdfFiles, remarks: Remarks) -> list[SdfTree]:
    """Return the models of a world that can be had, but for drones."""
    tops = top_models(file)
    if len(tops) > MOST_MODELS:
        raise WorkbenchError(f"{file.path}: has more than {MOST_MODELS} models: leave some out")
    trees: dict[str, SdfTree] = {}
    left_out: set[str] = set()
    links = 0
    for top in tops:
        if gazebos_own(top):
            continue
        try:
            tree = grow_in_world(file, top, files, trees)
        except WorkbenchError as fault:
            text = str(fault).removeprefix(f"{file.path}:{top.element.line}: ")
            remarks.add("missing", file.path, f"model '{top_name(top)}'", f"{text}; left out")
            left_out.add(top_name(top))
            continue
        if has_motors(tree):
            text = "it has motors: a drone that would fly on its own; left out"
            remarks.add("ignored", file.path, f"model '{tree.name}'", text)
            left_out.add(tree.name)
            continue
        trees[tree.name] = tree
        links += len(tree.links)
        if links > MOST_LINKS:
            raise top.fault(f"with this the world has more than {MOST_LINKS} links: leave some out")
    return _placed(file, list(trees.values()), left_out, remarks)


def _placed(
    file: SdfFile, trees: list[SdfTree], left_out: set[str], remarks: Remarks
) -> list[SdfTree]:
    """Return the models that do not stand relative to one that is left out, or to such a one."""
    while lost := [tree for tree in trees if _base(tree) in left_out]:
        for tree in lost:
            text = f"it stands relative to '{_base(tree)}', which is left out; left out"
            remarks.add("missing", file.path, f"model '{tree.name}'", text)
            left_out.add(tree.name)
        trees = [tree for tree in trees if tree not in lost]
    loose = [tree.name for tree in trees if not tree.static]
    if loose:
        text = f"{list_of_names(loose)} could move, and stand still here"
        remarks.add("assumed", file.path, "models that are not static", text)
    return trees


def _base(tree: SdfTree) -> str:
    """Return the model that a model's pose is relative to, "" where it is to the world."""
    pose = tree.models[-1].pose  # a model's own frame comes after those of the models in it
    return pose.attribute("relative_to").partition("::")[0] if pose else ""


def _links(tree: SdfTree, poses: Poses, finder: PackageFinder, remarks: Remarks) -> list[Link]:
    """Return the links of all models, with poses in the world."""
    reader = ShapeReader(poses, finder, remarks)
    links = []
    for node in tree.links:
        solid = without_planes(node, poses, remarks)
        links.append(
            Link(
                name=node.full_name,
                X_ML=poses.X_MF(node.full_name),
                inertial=None,
                visuals=tuple(reader.visuals(solid)),
                collisions=tuple(reader.collisions(solid)),
            )
        )
    return links


def _home(world: Node, remarks: Remarks) -> Home | None:
    """Return where on the earth a world says that it is."""
    place = world.child("spherical_coordinates")
    if place is None:
        return None
    latitude, longitude, altitude, heading = (
        number(place, tag, 0.0)
        for tag in ("latitude_deg", "longitude_deg", "elevation", "heading_deg")
    )
    if abs(latitude) > 90.0 or abs(longitude) > 180.0:
        raise place.fault("the latitude must be within ±90 degrees, the longitude within ±180")
    if heading:
        text = f"heading_deg is {heading:g}; x is taken to point east"
        remarks.add("ignored", place.file, "<spherical_coordinates>", text)
    return Home(math.radians(latitude), math.radians(longitude), altitude)

"""Read Drake's model directives in a world file, with Drake, as obstacles."""

import copy
import logging
from bisect import bisect_left
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple
from xml.etree import ElementTree as ET

import numpy as np
import yaml
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
    SceneGraph,
    SceneGraphInspector,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform
from pydrake.multibody.parsing import (
    LoadModelDirectivesFromString,
    Parser,
    ProcessModelDirectives,
)
from pydrake.multibody.plant import MultibodyPlant
from pydrake.multibody.tree import BodyIndex, RigidBody
from pydrake.systems.framework import Context

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_files import read_plain
from workbench.common.yaml_files import YamlFile, read_yaml, tagged_loader
from workbench.plant.drawable import MOST_BYTES, MeshUse, convert
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import place, read_xml
from workbench.plant.packages import PackageFinder
from workbench.plant.shapes import Mesh as MeshFile
from workbench.plant.worlds.geometry import drawn_if_none
from workbench.plant.worlds.world import Obstacle

DEEPEST = 20
"""Largest depth of nested includes."""
MOST_FILES = 1000
"""Largest number of included files; repeated ones count again."""
MOST_DIRECTIVES = 1000
_MOST_MESH_BYTES = 15_000_000
"""Size limit of a mesh, which takes Drake 25 times as much memory [bytes]."""
_MOST_SAID = 300
"""Largest number of characters of Drake's messages to pass on."""
_KINDS = (
    "add_collision_filter_group",
    "add_directives",
    "add_frame",
    "add_model",
    "add_model_instance",
    "add_weld",
)
FARTHEST = 1e6
"""Limit of the sides and coordinates of obstacles [m]."""


class _File(NamedTuple):
    path: Path
    has_directives: bool


class Includes:
    """Checks the includes in the directives of one world."""

    def __init__(self, finder: PackageFinder) -> None:
        """Start counting.

        Args:
            finder: of the named files.
        """
        self._finder = finder
        self._count = 0
        self._inner: dict[_File, tuple[_File, ...]] = {}

    def check(self, path: Path, *, has_directives: bool) -> None:
        """Reject files that would let Drake run for ever, or crash.

        Drake reports missing files.

        Args:
            path: the file in a directive.
            has_directives: whether it has directives, and is not a model.

        Raises:
            WorkbenchError: beginning with the file that includes itself, is nested too deeply,
                exceeds the number of files, cannot be read, or is a MuJoCo model.
        """
        self._walk(_File(path.resolve(), has_directives), ())

    def _walk(self, file: _File, above: tuple[_File, ...]) -> None:
        self._count += 1
        if file in above:
            raise WorkbenchError(f"{file.path}: includes itself: remove this include")
        if len(above) > DEEPEST:
            raise WorkbenchError(
                f"{file.path}: is included more than {DEEPEST} deep: put it into what includes it"
            )
        if self._count > MOST_FILES:
            raise WorkbenchError(
                f"{file.path}: with this one, more than {MOST_FILES} files are included: leave "
                "some out"
            )
        if file not in self._inner:
            self._inner[file] = tuple(self._named(file))
        for inner in self._inner[file]:
            self._walk(inner, (*above, file))

    def _named(self, file: _File) -> Iterator[_File]:
        """Yield the files named in a file that are found."""
        if file.has_directives:
            yield from self._in_directives(file.path)
        elif file.path.suffix.lower() == ".xml":
            raise WorkbenchError(f"{file.path}: is a MuJoCo model: give it as SDF or URDF")
        elif file.path.suffix.lower() != ".obj":
            for element in read_xml(file.path).iter():
                self._check_named(element, file.path)
                if element.tag == "include":
                    yield from self._of_uri(element.findtext("uri", ""), file.path)

    def _check_named(self, element: ET.Element, file: Path) -> None:
        """Reject a file named in an element that is outside of the world's folder, or too large."""
        uri = (element.text if element.tag == "uri" else element.get("filename")) or ""
        for near in _near(file) if uri.strip() else ():
            self._finder.refuse_outside(uri, near, place(element))
            found = self._finder.resolve(uri, near)
            if found and found.is_file() and found.stat().st_size > _MOST_MESH_BYTES:
                most = f"{_MOST_MESH_BYTES // 1_000_000} MB"
                raise WorkbenchError(
                    f"{place(element)}: '{shortened(uri)}' is larger than {most}: use fewer faces"
                )

    def _in_directives(self, path: Path) -> Iterator[_File]:
        items = read_yaml(path, tagged_loader()).data.get("directives")
        for item in items if isinstance(items, list) else []:
            for kind, words in item.items() if isinstance(item, dict) else []:
                uri = words.get("file") if isinstance(words, dict) else None
                found = self._finder.resolve(uri, path) if isinstance(uri, str) else None
                if found and found.is_file():
                    yield _File(found.resolve(), kind == "add_directives")

    def _of_uri(self, uri: str, file: Path) -> Iterator[_File]:
        """Yield the possible files of an `<include>`."""
        for found in dict.fromkeys(self._finder.resolve(uri, near) for near in _near(file)):
            if found and found.is_dir():
                yield from (_File(each, False) for each in _of_folder(found))
            elif found:
                yield _File(found.resolve(), False)


def _near(file: Path) -> tuple[Path, Path]:
    """Return a file, and one of its name in the working directory, which Drake searches, too."""
    return file, Path.cwd() / file.name


def _of_folder(folder: Path) -> Iterator[Path]:
    """Yield the files in the folder of a model, for all versions of SDF."""
    for config in (folder / "model.config", folder / "manifest.xml"):
        for element in read_xml(config).iter("sdf") if config.is_file() else ():
            path = folder / (element.text or "").strip()
            if path.is_file():
                yield path.resolve()


def read_directives(file: YamlFile, finder: PackageFinder) -> tuple[Obstacle, ...]:
    """Return the bodies in the `directives` of a world file as obstacles.

    They are added to a separate plant, so that errors occur here, and the plant of the flight has
    no other bodies than the drone. Packages that Drake would download are unknown.

    Args:
        file: its key `directives` is a list of mappings.
        finder: of the named files, which may refer to the packages given to it.

    Raises:
        WorkbenchError: naming file and line, if Drake rejects a directive, or a model could move.
    """
    items, includes = _items(file), Includes(finder)
    if len(items) > MOST_DIRECTIVES:
        where = file.where("directives")
        raise WorkbenchError(f"{where}there are more than {MOST_DIRECTIVES}: leave some out")
    for index, item in enumerate(items):
        _find(file, index, item, finder, includes)
    with _quiet_drake():
        plant, scene_graph = _accepted(file, items, finder)
    context = plant.CreateDefaultContext()
    bodies = [plant.get_body(BodyIndex(index)) for index in range(1, plant.num_bodies())]
    return tuple(
        _obstacle(plant, scene_graph.model_inspector(), file, body, context) for body in bodies
    )


def _accepted(
    file: YamlFile, items: Sequence[yaml.Node], finder: PackageFinder
) -> tuple[MultibodyPlant, SceneGraph]:
    """Return a finalised plant with directives.

    Raises:
        WorkbenchError: for the first directive that Drake rejects.
    """
    try:
        plant, scene_graph = _processed(items, finder.packages)
        plant.Finalize()
    except (RuntimeError, ValueError, SystemExit) as error:
        bad = bisect_left(
            range(len(items)), True, key=lambda last: _fails(items[: last + 1], finder)
        )
        where = file.where("directives", bad) if bad < len(items) else file.where("directives")
        reason = " ".join(str(error).split())
        if len(reason) > _MOST_SAID:
            reason = f"{reason[:_MOST_SAID]}..."
        raise WorkbenchError(f"{where}Drake refuses it: {reason}") from error
    return plant, scene_graph


@contextmanager
def _quiet_drake() -> Iterator[None]:
    """Suppress Drake's log messages, as its exception has the reason."""
    logger = logging.getLogger("drake")
    logger.addFilter(_nothing)
    try:
        yield
    finally:
        logger.removeFilter(_nothing)


def _nothing(_: logging.LogRecord) -> bool:
    return False


def _processed(
    items: Sequence[yaml.Node], packages: Mapping[str, Path]
) -> tuple[MultibodyPlant, SceneGraph]:
    """Return a plant with directives that is not finalised."""
    plant, scene_graph = MultibodyPlant(0.0), SceneGraph()
    plant.RegisterAsSourceForSceneGraph(scene_graph)
    parser = Parser(plant)
    known = parser.package_map()
    for name in known.GetPackageNames():
        known.Remove(name)
    for name, folder in packages.items():
        known.Add(name, str(folder))
    key = yaml.ScalarNode("tag:yaml.org,2002:str", "directives")
    whole = yaml.MappingNode(
        "tag:yaml.org,2002:map", [(key, yaml.SequenceNode("tag:yaml.org,2002:seq", list(items)))]
    )
    text = str(yaml.serialize(whole, Dumper=yaml.SafeDumper))
    ProcessModelDirectives(LoadModelDirectivesFromString(text), parser)
    return plant, scene_graph


def _fails(items: Sequence[yaml.Node], finder: PackageFinder) -> bool:
    """Return whether Drake rejects these directives; it then rejects any longer list, too."""
    try:
        _processed(items, finder.packages)
    except (RuntimeError, ValueError, SystemExit):
        return True
    return False


def _items(file: YamlFile) -> list[yaml.Node]:
    """Return the directives with their tags."""
    root = yaml.compose(file.text, Loader=tagged_loader())
    return next((node.value for key, node in root.value if key.value == "directives"), [])


def _find(
    file: YamlFile,
    index: int,
    item: yaml.MappingNode,
    finder: PackageFinder,
    includes: Includes,
) -> None:
    """Find the file in a directive, and write its path into the directive.

    Raises:
        WorkbenchError: if the directive is invalid, or its file is missing or includes itself.
    """
    where = file.where("directives", index)
    kinds = [key.value for key, _ in item.value]
    if len(kinds) != 1:
        raise WorkbenchError(f"{where}a directive has one key, as add_model: this has {len(kinds)}")
    if kinds[0] not in _KINDS:
        raise WorkbenchError(f"{where}{unknown_name('directive', kinds[0], _KINDS)}")
    for key, node in item.value[0][1].value:
        if key.value != "file" or not isinstance(node, yaml.ScalarNode):
            continue
        path = finder.resolve(node.value, finder.source)
        finder.refuse_outside(node.value, finder.source, where.removesuffix(": "))
        if path is None or not path.is_file():
            scheme, _, rest = node.value.partition("://")
            package = rest.partition("/")[0]
            known = scheme != "package" or finder.folder(package)
            hint = "give it relative to this file" if known else finder.hint(shortened(package))
            raise WorkbenchError(f"{where}the file '{shortened(node.value)}' is not found: {hint}")
        try:
            includes.check(path, has_directives=kinds[0] == "add_directives")
        except WorkbenchError as fault:
            raise WorkbenchError(f"{where}{fault}") from fault
        node.value = f"file://{path}"


def _obstacle(
    plant: MultibodyPlant,
    inspector: SceneGraphInspector,
    file: YamlFile,
    body: RigidBody,
    context: Context,
) -> Obstacle:
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
        refuse_endless(_where(file, name), name, X_WO, geometry)
    where = _where(file, name)
    drawn = drawn_if_none(visuals, collisions)
    return Obstacle(name, X_WO, collisions, tuple(_with_normals(where, each) for each in drawn))


def _with_normals(where: str, geometry: GeometryInstance) -> GeometryInstance:
    """Return a visual; one with an OBJ without normals, which Drake's cameras refuse, with them.

    Raises:
        WorkbenchError: if the file cannot be read.
    """
    shape = geometry.shape()
    path = shape.source().path() if isinstance(shape, Mesh) else Path()
    if path.suffix.lower() != ".obj" or not path.is_file():
        return geometry
    data = read_plain(path, MOST_BYTES)
    if data.startswith(b"vn") or b"\nvn" in data:
        return geometry
    seen = geometry.perception_properties() or geometry.illustration_properties()
    rgba = None
    if seen is not None and seen.HasProperty("phong", "diffuse"):
        color = seen.GetProperty("phong", "diffuse")
        rgba = (color.r(), color.g(), color.b(), color.a())
    use = MeshUse(MeshFile(str(path), path), "visual", rgba)
    converted = convert([use])[use]
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


def refuse_endless(where: str, name: str, X_WO: RigidTransform, geometry: GeometryInstance) -> None:
    """Reject a geometry of an obstacle with an invalid size or position.

    Args:
        where: "file:line: ", for the beginning of the message.
        name: of the obstacle.
        X_WO: pose of the obstacle.
        geometry: of the obstacle, with its pose in O.

    Raises:
        WorkbenchError: if a number is not finite or beyond `FARTHEST`, or a side not positive.
    """
    parts = (X_WO, geometry.pose())
    if not all(_is_place(each) for each in parts):
        raise WorkbenchError(
            f"{where}'{name}' has no finite position, or is more than {FARTHEST:g} m away: give it "
            "a pose of finite numbers"
        )
    sides = np.array(_sides(geometry.shape()))
    if not (np.isfinite(sides) & (sides > 0.0) & (sides <= FARTHEST)).all():
        numbers = ", ".join(f"{side:g}" for side in sides)
        raise WorkbenchError(
            f"{where}'{name}' has a {type(geometry.shape()).__name__.lower()} with {numbers}: "
            f"give it numbers above 0 and up to {FARTHEST:g}"
        )


def _is_place(X: RigidTransform) -> bool:
    matrix = X.GetAsMatrix34()
    return bool((np.abs(matrix) <= FARTHEST).all())  # false for NaN


def _sides(shape: Shape) -> tuple[float, ...]:
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

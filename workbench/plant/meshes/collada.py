"""Read COLLADA as Gazebo does: units applied, the up axis not, parts named by their nodes.

Gazebo's ColladaLoader (gz-common, graphics/src/ColladaLoader.cc) multiplies all by
`<unit meter=...>` and never looks at `<up_axis>`; RViz leaves it, too. So what a drone's file has
along z is along z of its link, whether it says Y_UP or Z_UP. Its submeshes bear the `name` of their
`<node>`, or of the nearest node above that has one.
"""

import io
import math
from dataclasses import dataclass, replace
from typing import Any
from xml.parsers import expat

import collada
import numpy as np
from trimesh.resolvers import Resolver
from trimesh.visual.material import PBRMaterial

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.materials import make_material, open_picture, vertex_colors
from workbench.plant.meshes.parts import MOST_FACES, Array, Part

_MOST_NODES = 100_000
_LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Of red, green and blue: ITU-R BT.709, as the COLLADA specification asks."""


def read_collada(data: bytes, resolver: Resolver) -> list[Part]:
    """Return the parts of a COLLADA document, in metres.

    Args:
        data: the document.
        resolver: finds pictures by name.

    Raises:
        WorkbenchError: a clause without the file's name. Other exceptions are pycollada's own.
    """
    _refuse_entities(data)
    document = _load(data)
    if any(isinstance(error, collada.common.DaeBrokenRefError) for error in document.errors):
        document = _load(_without_broken_materials(document))
    if document.scene is None:
        raise WorkbenchError("it has no scene")
    meter = document.assetInfo.unitmeter
    meter = 1.0 if meter is None else float(meter)
    if not (math.isfinite(meter) and meter > 0.0):
        raise WorkbenchError(f"its unit of {meter} m is no length")
    reader = _Reader(resolver)
    reader.read(document.scene)
    to_metres = np.diag([meter, meter, meter, 1.0])
    return [part.moved(to_metres @ T) for part, T in reader.found]


def _load(data: bytes) -> Any:
    return collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])


def _without_broken_materials(document: Any) -> bytes:
    """Return a document without references to materials that it lacks, or that are not understood.

    pycollada leaves out a geometry for one of these; Gazebo draws it without.
    """
    root = document.xmlnode.getroot()
    known = {f"#{material.id}" for material in document.materials}
    for common in root.findall(".//{*}technique_common"):
        for child in common.findall("{*}instance_material"):
            if child.get("target") not in known:
                common.remove(child)
    return bytes(collada.xmlutil.etree.tostring(root))


def _refuse_entities(data: bytes) -> None:
    """Refuse a document that declares entities: they stand before the root element or nowhere."""

    def refuse(*_: object) -> None:
        raise WorkbenchError("it declares entities of its own: write out what they stand for")

    def stop(*_: object) -> None:
        raise StopIteration

    parser = expat.ParserCreate()
    parser.EntityDeclHandler = refuse
    parser.StartElementHandler = stop
    try:
        parser.Parse(data, True)
    except StopIteration:
        return
    except expat.ExpatError as error:
        raise WorkbenchError(f"not XML: {expat.ErrorString(error.code)}") from error


@dataclass(frozen=True)
class _Node:
    """A node of the scene on its way: what is above it says where it is and what it is called."""

    node: Any
    T: Array
    name: str


class _Reader:
    """Walks a scene, each instance on its own, within bounds of nodes and faces."""

    def __init__(self, resolver: Resolver) -> None:
        self.found: list[tuple[Part, Array]] = []
        self._resolver = resolver
        self._nodes = 0
        self._faces = 0
        self._parts: dict[tuple[int, int], Part | None] = {}
        self._materials: dict[int, PBRMaterial | None] = {}

    def read(self, scene: Any) -> None:
        todo = [_Node(node, np.eye(4), "") for node in reversed(scene.nodes)]
        while todo:
            self._nodes += 1
            if self._nodes > _MOST_NODES:
                raise WorkbenchError(f"it has more than {_MOST_NODES} nodes")
            here = todo.pop()
            if isinstance(here.node, collada.scene.GeometryNode):
                self._read_geometry(here)
            elif isinstance(here.node, collada.scene.Node):
                T = here.T @ here.node.matrix
                name = here.node.xmlnode.get("name") or here.name
                if isinstance(here.node, collada.scene.NodeNode):
                    name = here.node.node.xmlnode.get("name") or here.name
                todo += [_Node(child, T, name) for child in reversed(here.node.children)]

    def _read_geometry(self, here: _Node) -> None:
        geometry = here.node.geometry
        effects = {each.symbol: each.target.effect for each in here.node.materials}
        names = tuple(str(name) for name in (here.name, geometry.name, geometry.id) if name)
        for primitive in geometry.primitives:
            part = self._part(primitive, effects.get(primitive.material))
            if part is None:
                continue
            self._faces += len(part.faces)
            if self._faces > MOST_FACES:
                raise WorkbenchError(f"it has more than {MOST_FACES} faces")
            self.found.append((replace(part, names=names), here.T))

    def _part(self, primitive: Any, effect: Any) -> Part | None:
        """Return the triangles of a primitive in an effect's looks, made once."""
        key = (id(primitive), id(effect))
        if key not in self._parts:
            self._parts[key] = self._triangles(primitive, effect)
        return self._parts[key]

    def _triangles(self, primitive: Any, effect: Any) -> Part | None:
        if isinstance(primitive, collada.polylist.Polylist):
            primitive = primitive.triangleset()
        if not isinstance(primitive, collada.triangleset.TriangleSet):
            return None  # lines
        if primitive.vertex is None or not len(primitive):
            return None
        material = self._material(effect) if effect is not None else None
        corners = [(primitive.vertex, primitive.vertex_index)]
        if primitive.normal is not None:
            corners.append((primitive.normal, primitive.normal_index))
        if primitive.texcoordset:
            corners.append((primitive.texcoordset[0][:, :2], primitive.texcoord_indexset[0]))
        # Gazebo knows no colours of vertices; beside a material they are often leftovers.
        colors = primitive.sources.get("COLOR", []) if material is None else []
        if colors:
            offset, data = colors[0][0], colors[0][4].data
            corners.append((data, primitive.index[:, :, offset]))
        # One vertex for each set of indices that occurs together.
        together = np.column_stack([np.ravel(index) for _, index in corners])
        rows, faces = np.unique(together, axis=0, return_inverse=True)
        values = [source[rows[:, column]] for column, (source, _) in enumerate(corners)]
        vertices, *rest = values
        return Part(
            names=(),
            vertices=np.asarray(vertices, dtype=float),
            faces=faces.reshape(-1, 3),
            normals=np.asarray(rest.pop(0), dtype=float) if primitive.normal is not None else None,
            uv=rest.pop(0) if primitive.texcoordset else None,
            colors=vertex_colors(255.0 * rest.pop(0)) if colors else None,
            material=material,
        )

    def _material(self, effect: Any) -> PBRMaterial | None:
        if id(effect) not in self._materials:
            self._materials[id(effect)] = _make_material(effect, self._resolver)
        return self._materials[id(effect)]


def _make_material(effect: Any, resolver: Resolver) -> PBRMaterial | None:
    """Return the material of an effect, None if it gives no colour."""
    looks = effect.diffuse
    if looks is None:
        looks = effect.emission  # what the shader `constant` has instead
    if isinstance(looks, collada.material.Map):
        picture = _picture(looks, resolver)
        return make_material((1.0, 1.0, 1.0, _alpha(effect)), picture) if picture else None
    if not isinstance(looks, tuple | list) or len(looks) < 3:
        return None
    return make_material((*looks[:3], _alpha(effect)))


def _picture(found: Any, resolver: Resolver) -> Any:
    try:
        return open_picture(resolver.get(found.sampler.surface.image.path))
    except (OSError, AttributeError, TypeError):  # missing, or a reference to nothing
        return None


def _alpha(effect: Any) -> float:
    """Return how opaque an effect is, 0 .. 1 (COLLADA 1.4.1, Determining Transparency).

    As in Gazebo, it is opaque where `<transparent>` does not say how it is meant; exporters
    disagree, and a drone that cannot be seen is of no use.
    """
    transparent = effect.xmlnode.find(".//{*}transparent")
    color = effect.transparent
    if transparent is None or not isinstance(color, tuple):
        return 1.0
    given = effect.xmlnode.find(".//{*}transparency")
    share = effect.transparency if given is not None else 1.0
    share = share if isinstance(share, float) else 1.0
    light = float(_LUMINANCE @ color[:3])
    opaque = {
        "A_ONE": color[3] * share,
        "A_ZERO": 1.0 - color[3] * share,
        "RGB_ONE": light * share,
        "RGB_ZERO": 1.0 - light * share,
    }.get(transparent.get("opaque"), 1.0)
    return float(np.clip(np.nan_to_num(opaque, nan=1.0), 0.0, 1.0))

"""Read COLLADA files."""

import io
import math
from dataclasses import replace
from functools import cache, partial
from typing import Any
from xml.parsers import expat

import collada
import numpy as np
from trimesh.resolvers import Resolver
from trimesh.visual.material import PBRMaterial

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.materials import make_material, open_picture, vertex_colors
from workbench.plant.meshes.parts import MAX_MESH_FACES, MAX_SCENE_NODES, Array, MeshPart

_LUMINANCE_WEIGHTS = np.array([0.212671, 0.715160, 0.072169])
"""Luminance of red, green and blue: ITU-R BT.709, as in the COLLADA specification."""


def read_collada(data: bytes, resolver: Resolver) -> list[MeshPart]:
    """Return the parts of a COLLADA document in metres, as Gazebo reads it.

    Gazebo's ColladaLoader (gz-common, graphics/src/ColladaLoader.cc) scales by `<unit meter=...>`
    and ignores `<up_axis>`, as RViz does. So z in the file is z of the link, even if the file
    states Y_UP. A submesh has the `name` of its `<node>`, or of the nearest ancestor with one.

    Args:
        data: the document.
        resolver: finds pictures by name.

    Raises:
        WorkbenchError: with a clause as message. pycollada raises other exceptions.
    """
    _refuse_entities(data)
    document = _load_collada(data)
    if any(isinstance(error, collada.common.DaeBrokenRefError) for error in document.errors):
        document = _load_collada(_without_broken_materials(document))
    if document.scene is None:
        raise WorkbenchError("it has no scene")
    meter = document.assetInfo.unitmeter
    meter = 1.0 if meter is None else float(meter)
    if not (math.isfinite(meter) and meter > 0.0):
        raise WorkbenchError(f"its unit of {meter} m is not a length")
    reader = _ColladaSceneReader(resolver)
    reader.read(document.scene)
    to_metres = np.diag([meter, meter, meter, 1.0])
    return [part.moved(to_metres @ T) for part, T in reader.found]


def _load_collada(data: bytes) -> Any:
    return collada.Collada(io.BytesIO(data), ignore=[collada.common.DaeError])


def _without_broken_materials(document: Any) -> bytes:
    """Return a document without references to missing or unsupported materials.

    pycollada omits a geometry with such a reference; Gazebo draws it without material.
    """
    root = document.xmlnode.getroot()
    known = {f"#{material.id}" for material in document.materials}
    for common in root.findall(".//{*}technique_common"):
        for child in common.findall("{*}instance_material"):
            if child.get("target") not in known:
                common.remove(child)
    return bytes(collada.xmlutil.etree.tostring(root))


def _refuse_entities(data: bytes) -> None:
    """Reject a document that declares entities, which are before the root element."""

    def refuse(*_: object) -> None:
        raise WorkbenchError("it declares its own entities: write them out")

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


class _ColladaSceneReader:
    """Walks through all instances of a scene, within limits of nodes and faces."""

    def __init__(self, resolver: Resolver) -> None:
        self.found: list[tuple[MeshPart, Array]] = []
        self._nodes = 0
        self._faces = 0
        self._part = cache(self._triangles)
        self._material = cache(partial(_make_material, resolver=resolver))

    def read(self, scene: Any) -> None:
        todo: list[tuple[Any, Array, str]] = [
            (node, np.eye(4), "") for node in reversed(scene.nodes)
        ]
        while todo:
            self._nodes += 1
            if self._nodes > MAX_SCENE_NODES:
                raise WorkbenchError(f"it has more than {MAX_SCENE_NODES} nodes")
            node, T_above, name = todo.pop()
            if isinstance(node, collada.scene.GeometryNode):
                self._read_geometry(node, T_above, name)
            elif isinstance(node, collada.scene.Node):
                T = T_above @ node.matrix
                named = node.node if isinstance(node, collada.scene.NodeNode) else node
                name = named.xmlnode.get("name") or name
                todo += [(child, T, name) for child in reversed(node.children)]

    def _read_geometry(self, node: Any, T: Array, name: str) -> None:
        geometry = node.geometry
        effects = {each.symbol: each.target.effect for each in node.materials}
        names = tuple(str(each) for each in (name, geometry.name, geometry.id) if each)
        for primitive in geometry.primitives:
            part = self._part(primitive, effects.get(primitive.material))
            if part is None:
                continue
            self._faces += len(part.faces)
            if self._faces > MAX_MESH_FACES:
                raise WorkbenchError(f"it has more than {MAX_MESH_FACES} faces")
            self.found.append((replace(part, names=names), T))

    def _triangles(self, primitive: Any, effect: Any) -> MeshPart | None:
        """Return the triangles of a primitive with an effect."""
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
        # Gazebo ignores vertex colours; with a material they are often leftovers.
        colors = primitive.sources.get("COLOR", []) if material is None else []
        if colors:
            offset, data = colors[0][0], colors[0][4].data
            corners.append((data, primitive.index[:, :, offset]))
        # one vertex for each combination of indices
        together = np.column_stack([np.ravel(index) for _, index in corners])
        rows, faces = np.unique(together, axis=0, return_inverse=True)
        values = [source[rows[:, column]] for column, (source, _) in enumerate(corners)]
        vertices, *rest = values
        return MeshPart(
            names=(),
            vertices=np.asarray(vertices, dtype=float),
            faces=faces.reshape(-1, 3),
            normals=np.asarray(rest.pop(0), dtype=float) if primitive.normal is not None else None,
            uv=rest.pop(0) if primitive.texcoordset else None,
            colors=vertex_colors(255.0 * rest.pop(0)) if colors else None,
            material=material,
        )


def _make_material(effect: Any, resolver: Resolver) -> PBRMaterial | None:
    """Return the material of an effect, None without a colour."""
    looks = effect.diffuse
    if looks is None:
        looks = effect.emission  # used by the shader `constant`
    if isinstance(looks, collada.material.Map):
        picture = _picture(looks, resolver)
        return make_material((1.0, 1.0, 1.0, _alpha(effect)), picture) if picture else None
    if not isinstance(looks, tuple | list) or len(looks) < 3:
        return None
    return make_material((*looks[:3], _alpha(effect)))


def _picture(found: Any, resolver: Resolver) -> Any:
    try:
        return open_picture(resolver.get(found.sampler.surface.image.path))
    except (OSError, AttributeError, TypeError):  # missing, or an invalid reference
        return None


def _alpha(effect: Any) -> float:
    """Return the opacity of an effect, 0 .. 1 (COLLADA 1.4.1, Determining Transparency).

    As in Gazebo, it is 1 if `<transparent>` does not state its mode; exporters disagree about the
    default, and an invisible drone is useless.
    """
    transparent = effect.xmlnode.find(".//{*}transparent")
    color = effect.transparent
    if transparent is None or not isinstance(color, tuple):
        return 1.0
    given = effect.xmlnode.find(".//{*}transparency")
    share = effect.transparency if given is not None else 1.0
    share = share if isinstance(share, float) else 1.0
    light = float(_LUMINANCE_WEIGHTS @ color[:3])
    opaque = {
        "A_ONE": color[3] * share,
        "A_ZERO": 1.0 - color[3] * share,
        "RGB_ONE": light * share,
        "RGB_ZERO": 1.0 - light * share,
    }.get(transparent.get("opaque"), 1.0)
    return float(np.clip(np.nan_to_num(opaque, nan=1.0), 0.0, 1.0))

"""Read and convert untrusted mesh files of common formats, in a child process."""

import io
import math
import re
from collections.abc import Callable, Iterable
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any, NoReturn
from xml.parsers import expat

import collada
import numpy as np
import trimesh
from scipy.spatial import ConvexHull
from trimesh.resolvers import Resolver
from trimesh.visual import TextureVisuals
from trimesh.visual.color import to_rgba
from trimesh.visual.material import PBRMaterial

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import one_line, serve
from workbench.plant.meshes.gltf import GENERATOR, to_z_up, write_gltf
from workbench.plant.meshes.job import MeshJob, reason_file, sealed
from workbench.plant.meshes.materials import make_material, material_of, open_picture, vertex_colors
from workbench.plant.meshes.parts import MOST_FACES, Array, Part, joined
from workbench.plant.meshes.side_files import find_side_file

THINNEST = 1e-3
"""Smallest thickness of a hull [m]; contact would pass through a sheet without volume."""
MOST_VERTICES = 200
_CLOSE = 5e-4
"""Largest depth cut off a hull by leaving out vertices, over its longest side."""
_MANY = 20_000
_MANY_DIRECTIONS = 800
_FEW_VERTICES = 50
_FEW_DIRECTIONS = 20
_MOST_NODES = 20_000
_LONGEST_HEAD = 10_000
_LUMINANCE = np.array([0.212671, 0.715160, 0.072169])
"""Luminance of red, green and blue: ITU-R BT.709, as in the COLLADA specification."""
_FORMATS = {
    ".stl": "stl",
    ".stla": "stl",
    ".stlb": "stl",
    ".obj": "obj",
    ".ply": "ply",
    ".off": "off",
    ".glb": "glb",
    ".gltf": "gltf",
}
"""Formats of trimesh by suffix; `.dae` is read here."""


def convex_hull(points: Array) -> tuple[Array, Array]:
    """Return vertices (n, 3) and faces (m, 3) of a convex hull.

    Vertices are outside of the true hull by half of THINNEST at most, and only if it is thinner
    than that. Extremes along x, y and z are exact, so that a drone stands at the correct height.

    Args:
        points: (k, 3) [m], at least one.

    Raises:
        WorkbenchError: if it cannot be computed, with a clause as message.
    """
    points = np.asarray(points, dtype=float)
    if len(points) > _MANY:
        points = points[_extremes(points, _MANY_DIRECTIONS)]
    points = _thickened(np.unique(points, axis=0))
    try:
        corners = points[_few(points)]
        hull = ConvexHull(corners)
    except (ValueError, RuntimeError) as error:  # QhullError is a RuntimeError
        raise WorkbenchError("its convex hull cannot be found") from error
    used, faces = np.unique(hull.simplices, return_inverse=True)
    vertices = corners[used]
    faces = faces.reshape(-1, 3)
    inward = np.einsum("ij,ij->i", _normals(vertices, faces), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward, ::-1]
    return vertices, faces


def write_obj(vertices: Array, faces: Array) -> bytes:
    """Return the content of an .obj file."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join([*lines, ""]).encode()


def _normals(vertices: Array, faces: Array) -> Array:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def _extremes(points: Array, count: int) -> Array:
    """Return indices of the extreme points along x, y, z and `count` more directions.

    The directions are evenly spread after scaling the bounding box of the points to a cube;
    otherwise all of them would find the ends of a long thin part.
    """
    size = np.ptp(points, axis=0)
    scaled = ((points - points.mean(axis=0)) / np.where(size > 0.0, size, 1.0)).astype(np.float32)
    # points of a Fibonacci sphere
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    z = np.linspace(-1.0, 1.0, count)
    r = np.sqrt(1.0 - z * z)
    directions = np.column_stack([r * np.cos(turn), r * np.sin(turn), z]).astype(np.float32)
    found = [points.argmax(axis=0), points.argmin(axis=0)]
    for some in np.array_split(directions, count // 20 + 1):  # to bound memory
        reach = some @ scaled.T
        found += [reach.argmax(axis=1), reach.argmin(axis=1)]
    return np.unique(np.concatenate(found))


def _thickened(points: Array) -> Array:
    """Return points, duplicated along principal axes in which they are too thin."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    for axis in axes.T:
        if np.ptp(centred @ axis) < THINNEST:
            step = 0.5 * THINNEST * axis
            points = np.vstack([points + step, points - step])
    return points


def _few(points: Array) -> Array:
    """Return indices of few points with a hull close to that of all points.

    Starts with some extremes, and adds the point farthest outside until all are close enough.
    """
    corners = ConvexHull(points).vertices
    if len(corners) > _MANY_DIRECTIONS:  # or the loop below would take long
        corners = corners[_extremes(points[corners], _MANY_DIRECTIONS // 2)]
    if len(corners) <= _FEW_VERTICES:
        return corners
    candidates = points[corners]
    chosen = _extremes(candidates, _FEW_DIRECTIONS).tolist()
    hull = ConvexHull(candidates[chosen], incremental=True)
    enough = _CLOSE * np.ptp(points, axis=0).max()
    while len(chosen) < MOST_VERTICES:
        outside = (candidates @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
        farthest = int(outside.argmax())
        if outside[farthest] <= enough:
            break
        chosen.append(farthest)
        hull.add_points(candidates[farthest : farthest + 1])
    return corners[chosen]


def convert_all(request: Any) -> None:
    """Write the requested files one after the other, or files with the reasons for failures.

    Args:
        request: pairs of the fields of a job and the path to write to.
    """
    for fields, path in request:
        target = Path(path)
        if reason := _reason(MeshJob(**fields), target):
            reason_file(target).write_bytes(reason.encode("utf-8", "replace"))


def _reason(job: MeshJob, target: Path) -> str:
    try:
        target.write_bytes(sealed(convert(job), target.suffix))
    except WorkbenchError as error:
        return str(error)
    except MemoryError:
        return "it needs too much memory"
    except RecursionError:
        return "it is nested too deeply"
    except Exception as error:  # trimesh and pycollada raise any exception on broken files
        return f"it cannot be read: {one_line(error)}"
    return ""


def convert(job: MeshJob) -> bytes:
    """Return the content of the converted file.

    Raises:
        WorkbenchError: with a clause as message. Readers raise other exceptions.
    """
    parts = [part for part in _placed(job) if len(part.faces)]
    if not parts:
        raise WorkbenchError("it has no faces")
    if job.use == "collision":
        return write_obj(*convex_hull(np.concatenate([part.vertices for part in parts])))
    return write_gltf(joined(parts), job.rgba)


def _placed(job: MeshJob) -> list[Part]:
    """Return the parts in use, scaled, centred and checked."""
    scale = np.diag([*job.scale, 1.0])
    parts = [part.moved(scale).checked() for part in read_parts(Path(job.file), job.submesh)]
    if not job.center:
        return parts
    corners = [corner(part.vertices, axis=0) for part in parts for corner in (np.min, np.max)]
    T = np.eye(4)
    T[:3, 3] = -0.5 * (np.min(corners, axis=0) + np.max(corners, axis=0))
    return [part.moved(T) for part in parts]


def read_collada(data: bytes, resolver: Resolver) -> list[Part]:
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
    document = _load(data)
    if any(isinstance(error, collada.common.DaeBrokenRefError) for error in document.errors):
        document = _load(_without_broken_materials(document))
    if document.scene is None:
        raise WorkbenchError("it has no scene")
    meter = document.assetInfo.unitmeter
    meter = 1.0 if meter is None else float(meter)
    if not (math.isfinite(meter) and meter > 0.0):
        raise WorkbenchError(f"its unit of {meter} m is not a length")
    reader = _Reader(resolver)
    reader.read(document.scene)
    to_metres = np.diag([meter, meter, meter, 1.0])
    return [part.moved(to_metres @ T) for part, T in reader.found]


def _load(data: bytes) -> Any:
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


class _Reader:
    """Walks through all instances of a scene, within limits of nodes and faces."""

    def __init__(self, resolver: Resolver) -> None:
        self.found: list[tuple[Part, Array]] = []
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
            if self._nodes > _MOST_NODES:
                raise WorkbenchError(f"it has more than {_MOST_NODES} nodes")
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
            if self._faces > MOST_FACES:
                raise WorkbenchError(f"it has more than {MOST_FACES} faces")
            self.found.append((replace(part, names=names), T))

    def _triangles(self, primitive: Any, effect: Any) -> Part | None:
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
        return Part(
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
    light = float(_LUMINANCE @ color[:3])
    opaque = {
        "A_ONE": color[3] * share,
        "A_ZERO": 1.0 - color[3] * share,
        "RGB_ONE": light * share,
        "RGB_ZERO": 1.0 - light * share,
    }.get(transparent.get("opaque"), 1.0)
    return float(np.clip(np.nan_to_num(opaque, nan=1.0), 0.0, 1.0))


class Beside(Resolver):
    """Finds side files of a mesh for trimesh, read-only."""

    def __init__(self, mesh_file: Path) -> None:
        self._file = mesh_file
        self.file_name = mesh_file.name

    def get(self, key: str) -> bytes:
        path = find_side_file(self._file, str(key))
        if path is None:
            raise FileNotFoundError(key)
        try:
            data = path.read_bytes()
        except PermissionError as error:  # a name that the search for side files did not find
            raise FileNotFoundError(key) from error
        return _as_utf8(data) if path.suffix.lower() == ".mtl" else data

    def keys(self) -> Iterable[str]:
        return ()

    def namespaced(self, namespace: str) -> "Beside":
        return self

    def write(self, name: str, data: object) -> NoReturn:
        raise PermissionError(name)


def read_parts(file: Path, submesh: str) -> list[Part]:
    """Return the parts of a mesh file in metres, transformed by the scene in the file.

    Args:
        file: resolved.
        submesh: name of the requested part, or "" for all.

    Raises:
        WorkbenchError: with a clause as message.
    """
    suffix = file.suffix.lower()
    data = file.read_bytes()
    if (faces := _stated_faces(data, suffix)) > MOST_FACES:
        raise WorkbenchError(f"it states {faces} faces, more than {MOST_FACES}")
    if suffix == ".dae":
        parts = read_collada(data, Beside(file))
    elif suffix in _FORMATS:
        data = _repaired(data, _FORMATS[suffix])
        if suffix == ".obj" and submesh:
            data = _only_object(data, submesh)
        parts = _read_scene(data, _FORMATS[suffix], Beside(file))
    else:
        known = ", ".join(sorted([".dae", *_FORMATS]))
        raise WorkbenchError(f"'{suffix}' cannot be read: convert it to one of {known}")
    if not submesh or suffix == ".obj":
        return parts
    chosen = [part for part in parts if submesh in part.names]
    if not chosen:
        raise _no_such(submesh, (part.names[0] for part in parts if part.names))
    return chosen


def _stated_faces(data: bytes, suffix: str) -> int:
    """Return the number of faces by the head or the lines of a file, 0 if that needs a parser."""
    match suffix:
        case ".stl" | ".stla" | ".stlb":
            length = 84 + 50 * (faces := int.from_bytes(data[80:84], "little"))
            return data.count(b"endfacet") if length > len(data) else faces
        case ".obj":
            return data.count(b"\nf ")
        case ".ply":
            stated = re.search(rb"element\s+face\s+(\d{1,18})", data[:_LONGEST_HEAD])
            return int(stated[1]) if stated else 0
        case ".off":
            stated = re.search(rb"\A(?:OFF)?\s*\d+\s+(\d{1,18})", data[:_LONGEST_HEAD])
            return int(stated[1]) if stated else 0
    return 0


def _repaired(data: bytes, kind: str) -> bytes:
    """Return content for trimesh, which requires UTF-8, and the exact length of an STL."""
    if kind == "stl":
        length = 84 + 50 * int.from_bytes(data[80:84], "little")
        return data[:length] if 84 < length <= len(data) else _as_utf8(data)
    return _as_utf8(data) if kind in ("obj", "off") else data


def _as_utf8(data: bytes) -> bytes:
    try:
        data.decode()
    except UnicodeDecodeError:
        return data.decode("latin-1").encode()
    return data


def _read_scene(data: bytes, kind: str, resolver: Resolver) -> list[Part]:
    scene = trimesh.load_scene(
        io.BytesIO(data), file_type=kind, resolver=resolver, process=False, validate=False
    )
    # Gazebo draws glTF with z up, unlike the standard. Files written by this program are turned for
    # Drake, which takes y as up.
    turn = to_z_up() if f'"generator":"{GENERATOR}"'.encode() in data else np.eye(4)
    light = _opaque if kind in ("gltf", "glb") else vertex_colors
    materials: dict[int, PBRMaterial | None] = {}
    parts = []
    faces = 0
    if len(scene.graph.nodes_geometry) > _MOST_NODES:
        raise WorkbenchError(f"it has more than {_MOST_NODES} nodes")
    for node in sorted(scene.graph.nodes_geometry, key=str):
        T, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue  # points and lines
        if kind == "stl" and np.isfinite(mesh.vertices).all():
            mesh.merge_vertices()  # in an STL, each face has its own three vertices
        faces += len(mesh.faces)
        if faces > MOST_FACES:
            raise WorkbenchError(f"it has more than {MOST_FACES} faces")
        parts.append(_part((str(node), str(name)), mesh, light, materials).moved(turn @ T))
    return parts


def _part(
    names: tuple[str, ...],
    mesh: trimesh.Trimesh,
    light: Callable[[Any], Array],
    materials: dict[int, PBRMaterial | None],
) -> Part:
    """Return one of trimesh's meshes as a part.

    Args:
        names: of the part.
        mesh: of trimesh.
        light: makes colours of vertices linear.
        materials: converted so far, by id of trimesh's; parts with one material share it.
    """
    visual = mesh.visual
    uv = material = colors = None
    if isinstance(visual, TextureVisuals):
        uv = visual.uv
        if visual.material is not None:
            if id(visual.material) not in materials:
                materials[id(visual.material)] = material_of(visual.material)
            material = materials[id(visual.material)]
        colors = visual.vertex_attributes.get("color")
    elif visual.kind in ("vertex", "face"):
        colors = visual.vertex_colors
    n = len(mesh.vertices)
    # Only normals in the file: without any, faces are drawn flat, as in an STL.
    normals = mesh.vertex_normals if "vertex_normals" in mesh._cache else None
    return Part(
        names=names,
        vertices=np.asarray(mesh.vertices, dtype=float),
        faces=np.asarray(mesh.faces),
        normals=None if normals is None else np.asarray(normals, dtype=float),
        uv=None if uv is None or len(uv) != n else np.asarray(uv, dtype=float)[:, :2],
        colors=None if colors is None or len(colors) != n else light(colors),
        material=material,
    )


def _opaque(colors: Any) -> Array:
    """Return vertex colours of glTF, which are linear already, as opaque."""
    found = np.array(to_rgba(colors))
    found[:, 3] = 255
    return found


def _only_object(data: bytes, name: str) -> bytes:
    """Return the content of an OBJ file with the faces of only one object or group.

    The last `o` or `g` names a face, as in tinyobjloader, which Gazebo uses.
    """
    kept = []
    names = []
    here = ""
    found = False
    for line in data.decode().splitlines():
        word, _, rest = line.strip().partition(" ")
        if word in ("o", "g"):
            here = rest.strip()
            names.append(here)
            found |= here == name
        if word != "f" or here == name:
            kept.append(line)
    if not found:
        raise _no_such(name, names)
    return "\n".join(kept).encode()


def _no_such(name: str, known: Iterable[str]) -> WorkbenchError:
    names = list(dict.fromkeys(known))
    more = ", ..." if len(names) > 20 else ""
    has = f"it has {', '.join(names[:20])}{more}" if names else "its parts have no names"
    return WorkbenchError(f"it has no part '{name}': {has}")


if __name__ == "__main__":
    serve(convert_all)

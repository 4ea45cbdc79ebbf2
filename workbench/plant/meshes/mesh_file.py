"""Read the parts of a mesh file of any format."""

import io
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import trimesh
from numpy.typing import ArrayLike
from trimesh.resolvers import Resolver
from trimesh.visual import TextureVisuals
from trimesh.visual.color import to_rgba
from trimesh.visual.material import PBRMaterial

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.collada import read_collada
from workbench.plant.meshes.gltf import GLTF_GENERATOR, to_z_up
from workbench.plant.meshes.materials import material_of, vertex_colors
from workbench.plant.meshes.parts import MAX_MESH_FACES, MAX_SCENE_NODES, Array, MeshPart
from workbench.plant.meshes.side_files import find_side_file

_MAX_MESH_HEAD_BYTES = 10_000
_MESH_FORMATS = {
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


class SideFileResolver(Resolver):
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

    def namespaced(self, namespace: str) -> "SideFileResolver":
        return self

    def write(self, name: str, data: object) -> NoReturn:
        raise PermissionError(name)


def read_parts(file: Path, submesh: str) -> list[MeshPart]:
    """Return the parts of a mesh file in metres, transformed by the scene in the file.

    Args:
        file: resolved.
        submesh: name of the requested part, or "" for all.

    Raises:
        WorkbenchError: with a clause as message.
    """
    suffix = file.suffix.lower()
    data = file.read_bytes()
    if (faces := _stated_faces(data, suffix)) > MAX_MESH_FACES:
        raise WorkbenchError(f"it states {faces} faces, more than {MAX_MESH_FACES}")
    if suffix == ".dae":
        parts = read_collada(data, SideFileResolver(file))
    elif suffix in _MESH_FORMATS:
        data = _repaired_mesh_data(data, _MESH_FORMATS[suffix])
        if suffix == ".obj" and submesh:
            data = _only_object(data, submesh)
        parts = _read_scene(data, _MESH_FORMATS[suffix], SideFileResolver(file))
    else:
        known = ", ".join(sorted([".dae", *_MESH_FORMATS]))
        raise WorkbenchError(f"'{suffix}' cannot be read: convert it to one of {known}")
    if not submesh or suffix == ".obj":
        return parts
    chosen = [part for part in parts if submesh in part.names]
    if not chosen:
        raise _missing_part_error(submesh, (part.names[0] for part in parts if part.names))
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
            stated = re.search(rb"element\s+face\s+(\d{1,18})", data[:_MAX_MESH_HEAD_BYTES])
            return int(stated[1]) if stated else 0
        case ".off":
            stated = re.search(rb"\A(?:OFF)?\s*\d+\s+(\d{1,18})", data[:_MAX_MESH_HEAD_BYTES])
            return int(stated[1]) if stated else 0
    return 0


def _repaired_mesh_data(data: bytes, kind: str) -> bytes:
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


def _read_scene(data: bytes, kind: str, resolver: Resolver) -> list[MeshPart]:
    scene = trimesh.load_scene(
        io.BytesIO(data), file_type=kind, resolver=resolver, process=False, validate=False
    )
    # Gazebo draws glTF with z up, unlike the standard. Files written by this program are turned for
    # Drake, which takes y as up.
    turn = to_z_up() if f'"generator":"{GLTF_GENERATOR}"'.encode() in data else np.eye(4)
    light = _opaque_vertex_colours if kind in ("gltf", "glb") else vertex_colors
    materials: dict[int, PBRMaterial | None] = {}
    parts = []
    faces = 0
    if len(scene.graph.nodes_geometry) > MAX_SCENE_NODES:
        raise WorkbenchError(f"it has more than {MAX_SCENE_NODES} nodes")
    for node in sorted(scene.graph.nodes_geometry, key=str):
        T, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue  # points and lines
        if kind == "stl" and np.isfinite(mesh.vertices).all():
            mesh.merge_vertices()  # in an STL, each face has its own three vertices
        faces += len(mesh.faces)
        if faces > MAX_MESH_FACES:
            raise WorkbenchError(f"it has more than {MAX_MESH_FACES} faces")
        parts.append(_part_of_mesh((str(node), str(name)), mesh, light, materials).moved(turn @ T))
    return parts


def _part_of_mesh(
    names: tuple[str, ...],
    mesh: trimesh.Trimesh,
    light: Callable[[Any], Array],
    materials: dict[int, PBRMaterial | None],
) -> MeshPart:
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
    return MeshPart(
        names=names,
        vertices=np.asarray(mesh.vertices, dtype=float),
        faces=np.asarray(mesh.faces),
        normals=None if normals is None else np.asarray(normals, dtype=float),
        uv=None if uv is None or len(uv) != n else np.asarray(uv, dtype=float)[:, :2],
        colors=None if colors is None or len(colors) != n else light(colors),
        material=material,
    )


def _opaque_vertex_colours(colors: ArrayLike) -> Array:
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
        raise _missing_part_error(name, names)
    return "\n".join(kept).encode()


def _missing_part_error(name: str, known: Iterable[str]) -> WorkbenchError:
    names = list(dict.fromkeys(known))
    more = ", ..." if len(names) > 20 else ""
    has = f"it has {', '.join(names[:20])}{more}" if names else "its parts have no names"
    return WorkbenchError(f"it has no part '{name}': {has}")

"""Read a mesh file of any common format into parts, with the files that it names."""

import io
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Any, NoReturn

import numpy as np
import trimesh
from trimesh.resolvers import Resolver
from trimesh.visual import TextureVisuals
from trimesh.visual.color import to_rgba
from trimesh.visual.material import PBRMaterial, SimpleMaterial

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.collada import read_collada
from workbench.plant.meshes.gltf import GENERATOR, to_z_up
from workbench.plant.meshes.materials import material_of, vertex_colors
from workbench.plant.meshes.parts import MOST_FACES, Array, Part
from workbench.plant.meshes.side_files import find_side_file

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
"""By suffix, for trimesh; `.dae` is read here."""


class Beside(Resolver):
    """Finds the side files of a mesh for trimesh, and writes none."""

    def __init__(self, mesh_file: Path) -> None:
        self._file = mesh_file
        self.file_name = mesh_file.name

    def get(self, key: str) -> bytes:
        path = find_side_file(self._file, str(key))
        if path is None:
            raise FileNotFoundError(key)
        data = path.read_bytes()
        return _as_utf8(data) if path.suffix.lower() == ".mtl" else data

    def keys(self) -> Iterable[str]:
        return ()

    def namespaced(self, namespace: str) -> "Beside":
        return self

    def write(self, name: str, data: object) -> NoReturn:
        raise PermissionError(name)


def read_parts(file: Path, submesh: str) -> list[Part]:
    """Return the parts of a mesh file in metres, each as transformed by the file's own scene.

    Args:
        file: resolved.
        submesh: name of the part that is asked for, or "" for all.

    Raises:
        WorkbenchError: a clause without the file's name.
    """
    suffix = file.suffix.lower()
    data = file.read_bytes()
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


def _repaired(data: bytes, kind: str) -> bytes:
    """Return content that trimesh takes: it asks for UTF-8, and for an exact length of an STL."""
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
    # Gazebo draws glTF with z up, whatever the standard says; but what was written here is turned
    # for Drake, which takes y for up.
    turn = to_z_up() if f'"generator":"{GENERATOR}"'.encode() in data else np.eye(4)
    plain = _Plain(_opaque if kind in ("gltf", "glb") else vertex_colors)
    parts = []
    faces = 0
    for node in sorted(scene.graph.nodes_geometry, key=str):
        T, name = scene.graph[node]
        mesh = scene.geometry[name]
        if not isinstance(mesh, trimesh.Trimesh):
            continue  # points and lines
        if kind == "stl" and np.isfinite(mesh.vertices).all():
            mesh.merge_vertices()  # each face has three of its own there
        faces += len(mesh.faces)
        if faces > MOST_FACES:
            raise WorkbenchError(f"it has more than {MOST_FACES} faces")
        parts.append(plain.part((str(node), str(name)), mesh).moved(turn @ T))
    return parts


class _Plain:
    """Makes parts of trimesh's meshes; those that share a material share one again."""

    def __init__(self, light: Callable[[Any], Array]) -> None:
        self._light = light
        self._materials: dict[int, PBRMaterial] = {}

    def part(self, names: tuple[str, ...], mesh: trimesh.Trimesh) -> Part:
        visual = mesh.visual
        uv = material = colors = None
        if isinstance(visual, TextureVisuals):
            uv = visual.uv
            material = self._material(visual.material)
            colors = visual.vertex_attributes.get("color")
        elif visual.kind in ("vertex", "face"):
            colors = visual.vertex_colors
        n = len(mesh.vertices)
        # Only what the file has: without normals faces are drawn flat, as an STL's should be.
        normals = mesh.vertex_normals if "vertex_normals" in mesh._cache else None
        return Part(
            names=names,
            vertices=np.asarray(mesh.vertices, dtype=float),
            faces=np.asarray(mesh.faces),
            normals=None if normals is None else np.asarray(normals, dtype=float),
            uv=None if uv is None or len(uv) != n else np.asarray(uv, dtype=float)[:, :2],
            colors=None if colors is None or len(colors) != n else self._light(colors),
            material=material,
        )

    def _material(self, found: PBRMaterial | SimpleMaterial | None) -> PBRMaterial | None:
        if found is None:
            return None
        if id(found) not in self._materials:
            self._materials[id(found)] = material_of(found)
        return self._materials[id(found)]


def _opaque(colors: Any) -> Array:
    """Return glTF's colours of vertices, which are light already."""
    found = np.array(to_rgba(colors))
    found[:, 3] = 255
    return found


def _only_object(data: bytes, name: str) -> bytes:
    """Return an OBJ file's content without the faces of all but one object or group.

    Its last `o` or `g` names a face, as in tinyobjloader, which Gazebo reads with.
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

"""Find the textures and materials that a mesh file names, near that file only."""

import html
import re
from collections.abc import Iterator
from itertools import islice
from pathlib import Path

from workbench.plant.packages import exists, own_folder

MAX_SIDE_FILE_BYTES = 64_000_000
"""Size limit of a side file [bytes]."""
_MAX_SIDE_FILE_NAMES = 200
_SIDE_FILE_SUFFIX = re.compile(r"\.(png|jpe?g|bmp|tga|gif|tiff?|webp|dds|mtl|bin)")
"""Endings of pictures, materials and buffers; no other files are read."""
_SIDE_FILE_NAME_PATTERNS = {
    ".dae": re.compile(rb"init_from>\s*(?:<[\w:]*ref>\s*)?([^<>\s][^<>]{0,999})"),
    ".obj": re.compile(rb"mtllib[ \t]+([^\r\n]{1,1000})"),
    ".mtl": re.compile(rb"map_[Kk]d[ \t]+([^\r\n]{1,1000})"),
    ".gltf": re.compile(rb'"uri"\s*:\s*"(?!data:)([^"]{1,1000})"'),
    ".ply": re.compile(rb"TextureFile[ \t]+([^\r\n]{1,1000})"),
}


def find_side_file(mesh_file: Path, name: str) -> Path | None:
    """Return the file for a name in a mesh file, or None.

    For an absolute path or an address, the last part is searched where Gazebo searches: next to the
    mesh, and in `../materials/textures`. Only textures, materials and buffers in the repository,
    package or folder of the mesh are found, after resolving symbolic links.

    Args:
        mesh_file: resolved.
        name: as in the mesh file: a path, which may have %20 for spaces, or a URI.
    """
    folder = mesh_file.parent
    package = own_folder(folder)
    from urllib.parse import unquote  # slow to load, and most meshes name no other file

    plain = unquote(html.unescape(name)).strip().replace("\\", "/")
    last = plain.rpartition("/")[2]
    textures = folder.parent / "materials" / "textures"
    for candidate in (folder / plain, folder / last, textures / last):
        try:
            found = candidate.resolve()
            if (
                found.is_relative_to(package)
                and _SIDE_FILE_SUFFIX.fullmatch(found.suffix.lower())
                and found.is_file()
                and found.stat().st_size <= MAX_SIDE_FILE_BYTES
            ):
                return found
        except (OSError, ValueError, RuntimeError):  # too long, NUL bytes, circular links
            continue
    return None


def refused_names(mesh_file: Path, data: bytes) -> list[str]:
    """Return the names of files in the content of a mesh file that exist and are not used."""
    found = []
    for material in (mesh_file, *side_files(mesh_file, data)):
        content = data if material == mesh_file else material.read_bytes()
        for name in _file_names_in(material.suffix.lower(), content):
            if find_side_file(mesh_file, name) is None and exists(material.parent / name):
                found.append(name)
    return found


def side_files(mesh_file: Path, data: bytes) -> list[Path]:
    """Return the files named in the content of a mesh file, and the files named in those.

    It searches for patterns without parsing the format, fast enough for every start. A change in
    one of these files requires a new conversion.
    """
    found = list(_named_in(mesh_file, mesh_file.suffix.lower(), data))
    for material in [path for path in found if path.suffix.lower() == ".mtl"]:
        found += _named_in(mesh_file, ".mtl", material.read_bytes())
    return sorted(set(found))


def _named_in(mesh_file: Path, suffix: str, data: bytes) -> Iterator[Path]:
    for name in _file_names_in(suffix, data):
        path = find_side_file(mesh_file, name)
        if path:
            yield path


def _file_names_in(suffix: str, data: bytes) -> Iterator[str]:
    """Yield the names of files in the content of a mesh or material file."""
    pattern = _SIDE_FILE_NAME_PATTERNS.get(suffix)
    for match in islice(pattern.finditer(data) if pattern else (), _MAX_SIDE_FILE_NAMES):
        yield match[1].decode("utf-8", "replace").strip()

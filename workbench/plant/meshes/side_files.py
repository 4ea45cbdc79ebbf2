"""Find the textures and materials that a mesh file names, near that file only."""

import html
import re
from collections.abc import Iterator
from pathlib import Path

MOST_BYTES = 64_000_000
"""Size limit of a side file [bytes]."""
_MOST_NAMES = 200
_SUFFIXES = re.compile(r"\.(png|jpe?g|bmp|tga|gif|tiff?|webp|dds|mtl|bin)")
"""Endings of pictures, materials and buffers; no other files are read."""
_NAMES_IN = {
    ".dae": re.compile(rb"init_from>\s*(?:<[\w:]*ref>\s*)?([^<>\s][^<>]{0,999})"),
    ".obj": re.compile(rb"mtllib[ \t]+([^\r\n]{1,1000})"),
    ".mtl": re.compile(rb"map_[Kk]d[ \t]+([^\r\n]{1,1000})"),
    ".gltf": re.compile(rb'"uri"\s*:\s*"(?!data:)([^"]{1,1000})"'),
    ".ply": re.compile(rb"TextureFile[ \t]+([^\r\n]{1,1000})"),
}


def find_side_file(mesh_file: Path, name: str) -> Path | None:
    """Return the file for a name in a mesh file, or None.

    For an absolute path or an address, the last part is searched where Gazebo searches: next to the
    mesh, and in `../materials/textures`. Only textures, materials and buffers in the parent of the
    mesh's folder or below are found, after resolving symbolic links.

    Args:
        mesh_file: resolved.
        name: as in the mesh file: a path, which may have %20 for spaces, or a URI.
    """
    folder = mesh_file.parent
    package = folder.parent if folder.parent != folder.parent.parent else folder
    from urllib.parse import unquote  # slow to load, and most meshes name no other file

    plain = unquote(html.unescape(name)).strip().replace("\\", "/")
    last = plain.rpartition("/")[2]
    textures = folder.parent / "materials" / "textures"
    for candidate in (folder / plain, folder / last, textures / last):
        try:
            found = candidate.resolve()
            if (
                found.is_relative_to(package)
                and _SUFFIXES.fullmatch(found.suffix.lower())
                and found.is_file()
                and found.stat().st_size <= MOST_BYTES
            ):
                return found
        except (OSError, ValueError, RuntimeError):  # too long, NUL bytes, circular links
            continue
    return None


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
    pattern = _NAMES_IN.get(suffix)
    names = pattern.finditer(data) if pattern else ()
    for _, match in zip(range(_MOST_NAMES), names, strict=False):
        path = find_side_file(mesh_file, match[1].decode("utf-8", "replace"))
        if path:
            yield path

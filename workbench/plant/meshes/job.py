"""The input of one mesh conversion, and the seal of its output file."""

import contextlib
import hashlib
import os
import re
import tempfile
import zlib
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from workbench.plant.meshes.side_files import side_files

MESH_CONVERSION_VERSION = 2
"""Version of the conversion; increase it with every change of results."""
_SEAL_FORMAT = b"crc32:%08x"
_SEAL_BYTES = len(b"crc32:00000000")
_SEAL_WRAPPERS = {".gltf": (b',"extras":{"seal":"', b'"}}'), ".obj": (b"# ", b"\n")}
"""Bytes before and after the seal, so that the file stays valid."""

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class MeshJob:
    """One conversion, in types that JSON can hold.

    Attributes:
        file: the mesh file, resolved.
        use: `visual` for drawing; `collision` for the convex hull.
        scale: along each axis; negative values mirror.
        submesh: name of the only part used, or "" for all.
        center: whether to move the used part to its own centre.
        rgba: colour 0 .. 1 of parts without one in the file.
    """

    file: str
    use: Literal["visual", "collision"]
    scale: tuple[float, float, float]
    submesh: str
    center: bool
    rgba: Rgba | None

    def target(self, folder: Path, data: bytes) -> Path:
        """Return the path in a cache folder for this conversion of a content.

        Args:
            folder: of the cache.
            data: content of the mesh file.
        """
        file = Path(self.file)
        key = hashlib.sha256(data)
        rest = (file.suffix.lower(), self.use, self.scale, self.submesh, self.center, self.rgba)
        key.update(repr((MESH_CONVERSION_VERSION, *rest)).encode("utf-8", "surrogatepass"))
        for path in side_files(file, data):
            status = path.stat()
            key.update(repr((str(path), status.st_size, status.st_mtime_ns)).encode())
        name = re.sub(r"[^A-Za-z0-9_-]+", "_", file.stem)[:40]
        suffix = ".gltf" if self.use == "visual" else ".obj"
        return folder / f"{name}-{key.hexdigest()[:32]}{suffix}"


def sealed(data: bytes, suffix: str) -> bytes:
    """Return the content of a glTF or OBJ file with its checksum at the end."""
    before, after = _SEAL_WRAPPERS[suffix]
    if suffix == ".gltf":
        data = data.rstrip().removesuffix(b"}")
    return data + before + _SEAL_FORMAT % zlib.crc32(data) + after


def is_sealed(path: Path) -> bool:
    """Return whether a file exists and its checksum is correct."""
    before, after = _SEAL_WRAPPERS[path.suffix]
    try:
        data = path.read_bytes()
    except OSError:
        return False
    end = len(data) - len(before) - _SEAL_BYTES - len(after)
    return end > 0 and data[end:] == before + _SEAL_FORMAT % zlib.crc32(data[:end]) + after


def reason_file(target: Path) -> Path:
    """Return the file that says why there is no file of a conversion."""
    return target.with_suffix(f"{target.suffix}.refused")


def read_reason(target: Path) -> str | None:
    """Return why a conversion failed, None if there is no such file."""
    try:
        return reason_file(target).read_bytes()[:1000].decode("utf-8", "replace")
    except OSError:
        return None


def write_whole(path: Path, data: bytes) -> None:
    """Write a file atomically, even if others write it at the same time."""
    handle, name = tempfile.mkstemp(dir=path.parent, prefix=f".{path.stem}-")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(data)
            file.flush()
            os.fsync(file.fileno())
        Path(name).replace(path)
    finally:
        with contextlib.suppress(FileNotFoundError):
            Path(name).unlink()

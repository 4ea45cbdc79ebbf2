"""What one conversion of a mesh is given, and the seal on the file that it makes."""

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

VERSION = 2
"""Version of the conversion; increase it with every change of its results."""
_SEAL = b"crc32:%08x"
_SEAL_LENGTH = len(_SEAL % 0)
_WRAPPED = {".gltf": (b',"extras":{"seal":"', b'"}}'), ".obj": (b"# ", b"\n")}
"""What stands before and after the seal, so that a reader of the format takes no offence."""

Rgba = tuple[float, float, float, float]


@dataclass(frozen=True)
class MeshJob:
    """One conversion; plain enough to be sent to another process as JSON.

    Attributes:
        file: the mesh file, resolved.
        use: `visual`: as it is, to be drawn; `collision`: its convex hull.
        scale: along each axis; negative ones mirror.
        submesh: name of the one part that is used, or "" for all of it.
        center: whether what is used is moved to its own centre.
        rgba: colour 0 .. 1 of what has none in the file.
    """

    file: str
    use: Literal["visual", "collision"]
    scale: tuple[float, float, float]
    submesh: str
    center: bool
    rgba: Rgba | None

    def target(self, folder: Path, data: bytes) -> Path:
        """Return the path in a folder that belongs to this conversion of this content.

        Args:
            folder: of the cache.
            data: what is in the mesh file.
        """
        file = Path(self.file)
        key = hashlib.sha256(data)
        rest = (file.suffix.lower(), self.use, self.scale, self.submesh, self.center, self.rgba)
        key.update(repr((VERSION, *rest)).encode("utf-8", "surrogatepass"))
        for path in side_files(file, data):
            status = path.stat()
            key.update(repr((str(path), status.st_size, status.st_mtime_ns)).encode())
        name = re.sub(r"[^A-Za-z0-9_-]+", "_", file.stem)[:40]
        suffix = ".gltf" if self.use == "visual" else ".obj"
        return folder / f"{name}-{key.hexdigest()[:32]}{suffix}"


def sealed(data: bytes, suffix: str) -> bytes:
    """Return the content of a glTF or OBJ file with the checksum of it at its end."""
    before, after = _WRAPPED[suffix]
    if suffix == ".gltf":
        data = data.rstrip().removesuffix(b"}")
    return data + before + _SEAL % zlib.crc32(data) + after


def is_sealed(path: Path) -> bool:
    """Return whether a file is there and as it was sealed."""
    before, after = _WRAPPED[path.suffix]
    try:
        data = path.read_bytes()
    except OSError:
        return False
    end = len(data) - len(before) - _SEAL_LENGTH - len(after)
    return end > 0 and data[end:] == before + _SEAL % zlib.crc32(data[:end]) + after


def write_whole(path: Path, data: bytes) -> None:
    """Write a file whole or not at all, whoever else writes it at the same time."""
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

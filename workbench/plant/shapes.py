"""Shapes of visuals and collisions, in their own frame and in metres."""

from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Box:
    """A box centred on its frame, with full side lengths."""

    size: tuple[float, float, float]


@dataclass(frozen=True)
class Sphere:
    """A sphere centred on its frame."""

    radius: float


@dataclass(frozen=True)
class Cylinder:
    """A cylinder along z, centred on its frame."""

    radius: float
    length: float


@dataclass(frozen=True)
class Capsule:
    """A cylinder along z with hemispherical ends; `length` excludes them."""

    radius: float
    length: float


@dataclass(frozen=True)
class Ellipsoid:
    """An ellipsoid centred on its frame, given by its semi-axes."""

    radii: tuple[float, float, float]


@dataclass(frozen=True)
class Mesh:
    """A mesh file.

    Attributes:
        uri: as in the description, for messages.
        path: the file, or None if not found.
        scale: along each axis; negative values mirror.
        submesh: name of the only part used, or "" for all of it.
        center: whether to move the submesh to its own centre, see SDF's `<center>`.
    """

    uri: str
    path: Path | None
    scale: tuple[float, float, float] = (1.0, 1.0, 1.0)
    submesh: str = ""
    center: bool = False


Shape = Box | Sphere | Cylinder | Capsule | Ellipsoid | Mesh

"""Shapes of visuals and collisions, in their own frame and in metres."""

from dataclasses import dataclass
from itertools import product
from pathlib import Path

import numpy as np


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


GeometryShape = Box | Sphere | Cylinder | Capsule | Ellipsoid | Mesh


def box_corners(half: np.ndarray) -> np.ndarray:
    """Return the corners of a box with half its side lengths (3), (8, 3) [m]."""
    return half * np.array(list(product((-1.0, 1.0), repeat=3)))


def prism_corners(radius: float, half: float, count: int) -> np.ndarray:
    """Return the corners of a regular prism along z, (2 count, 3) [m].

    Args:
        radius: of the circle through the corners of an end [m].
        half: of its length [m].
        count: of the corners of an end.
    """
    angles = np.arange(count) * 2.0 * np.pi / count
    rim = radius * np.stack([np.cos(angles), np.sin(angles)], axis=1)
    return np.concatenate([np.c_[rim, np.full(count, z)] for z in (-half, half)])

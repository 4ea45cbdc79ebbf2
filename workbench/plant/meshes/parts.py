"""Parts of a mesh as arrays, independent of the file format."""

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt
from trimesh.visual.material import PBRMaterial

from workbench.common.errors import WorkbenchError

MAX_MESH_FACES = 2_000_000
MAX_MESH_DISTANCE_M = 1e5
"""Largest distance from the origin [m]; a larger mesh is in millimetres, or broken."""

Array = npt.NDArray[Any]


@dataclass(frozen=True, eq=False)
class MeshPart:
    """Triangles with one material: n vertices and m faces.

    Attributes:
        names: for use in descriptions, the most common first.
        vertices: (n, 3) [m].
        faces: (m, 3), vertices counter-clockwise seen from outside.
        normals: (n, 3), or None for flat faces.
        uv: (n, 2), origin at the bottom left of the picture, or None.
        colors: (n, 4), 0 .. 255, linear, or None.
        material: colour and picture, or None if the file has none.
    """

    names: tuple[str, ...]
    vertices: Array
    faces: Array
    normals: Array | None = None
    uv: Array | None = None
    colors: Array | None = None
    material: PBRMaterial | None = None

    def moved(self, T: Array) -> "MeshPart":
        """Return the part transformed by a (4, 4) matrix, which may mirror; faces stay outward."""
        A = T[:3, :3]
        normals = None
        with np.errstate(all="ignore"):  # `checked` finds invalid numbers
            determinant = np.linalg.det(A)
            vertices = self.vertices @ A.T + T[:3, 3]
            if self.normals is not None and determinant != 0.0:
                # n' = A⁻ᵀ n stays perpendicular to a scaled surface
                normals = self.normals @ np.linalg.inv(A)
                lengths = np.linalg.norm(normals, axis=1, keepdims=True)
                normals = normals / np.where(lengths > 0.0, lengths, 1.0)
        faces = self.faces[:, ::-1] if determinant < 0.0 else self.faces
        return replace(self, vertices=vertices, faces=faces, normals=normals)

    def checked(self) -> "MeshPart":
        """Return the part without unused vertices and faces without area.

        Raises:
            WorkbenchError: with a clause as message.
        """
        if len(self.faces) and not 0 <= self.faces.min() <= self.faces.max() < len(self.vertices):
            raise WorkbenchError("a face names a vertex that is not there")
        a, b, c = self.faces.T
        faces = self.faces[(a != b) & (b != c) & (c != a)]
        used = np.zeros(len(self.vertices), dtype=bool)
        used[faces] = True
        vertices = self.vertices[used]
        if not np.isfinite(vertices).all():
            raise WorkbenchError("a vertex is not a number")
        if len(vertices) and (reach := np.abs(vertices).max()) > MAX_MESH_DISTANCE_M:
            raise WorkbenchError(f"it reaches {reach:.3g} m from its origin: give it a scale")
        return replace(
            self,
            vertices=vertices,
            faces=(np.cumsum(used) - 1)[faces],
            normals=_rows_in_use(self.normals, used),
            uv=_rows_in_use(self.uv, used),
            colors=_rows_in_use(self.colors, used),
        )


def _rows_in_use(rows: Array | None, used: Array) -> Array | None:
    """Return the rows in use, None if one of them is not finite."""
    if rows is None or not np.isfinite(rows[used]).all():
        return None
    return rows[used]


def joined_parts(parts: Sequence[MeshPart]) -> list[MeshPart]:
    """Return parts after joining those of equal appearance; a file may have thousands."""
    alike: dict[tuple[object, ...], list[MeshPart]] = {}
    for part in parts:
        looks = (id(part.material), part.normals is None, part.uv is None, part.colors is None)
        alike.setdefault(looks, []).append(part)
    return [_joined_group(group) for group in alike.values()]


def _joined_group(group: Sequence[MeshPart]) -> MeshPart:
    first = group[0]
    if len(group) == 1:
        return first
    starts = np.cumsum([0, *(len(part.vertices) for part in group[:-1])])

    def rows(name: str) -> Array | None:
        values = [getattr(part, name) for part in group]
        return None if values[0] is None else np.concatenate(values)

    return replace(
        first,
        vertices=np.concatenate([part.vertices for part in group]),
        faces=np.concatenate(
            [part.faces + start for part, start in zip(group, starts, strict=True)]
        ),
        normals=rows("normals"),
        uv=rows("uv"),
        colors=rows("colors"),
    )


MAX_SCENE_NODES = 20_000

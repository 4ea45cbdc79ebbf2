"""Volume, surface, centre of mass and moments of inertia of triangle meshes, as MuJoCo has them."""

from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError

MESH_INERTIA_MODES = ("legacy", "exact", "convex", "shell")
"""How the inertia of a mesh is computed, see `mesh_inertia`."""
_MIN_MESH_MEASURE = 1e-14
"""Smallest volume [m³] or surface [m²] that MuJoCo accepts."""


@dataclass(frozen=True)
class MeshInertia:
    """A mesh as a homogeneous body.

    Attributes:
        size: its volume [m³], or its surface for a shell [m²].
        p: its centre of mass [m].
        R: its principal axes in columns, that of the smallest moment last, right-handed.
        moments: its principal moments about the centre of mass for 1 kg [m²].
        corners: least and largest coordinates of its vertices along the principal axes from the
            centre of mass (2, 3) [m].
    """

    size: float
    p: np.ndarray
    R: np.ndarray
    moments: np.ndarray
    corners: np.ndarray

    @property
    def half_box(self) -> np.ndarray:
        """Half sides of the box with its mass and moments [m]."""
        total = self.moments.sum()
        return np.asarray(0.5 * np.sqrt(np.maximum(6.0 * (total - 2.0 * self.moments), 0.0)))


def read_triangles(file: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return vertices (n, 3) [m] and faces (m, 3) of a converted mesh, z up.

    Args:
        file: a .gltf file that the workbench wrote.
    """
    import trimesh  # takes long to import, and few descriptions need it

    scene = trimesh.load_scene(file, process=False)
    mesh = scene.to_mesh()
    x, y, z = np.asarray(mesh.vertices, dtype=float).T
    return np.column_stack([x, -z, y]), np.asarray(mesh.faces)


def mesh_inertia(vertices: np.ndarray, faces: np.ndarray, mode: str) -> MeshInertia:
    """Return volume, centre of mass and inertia of a mesh.

    Each triangle and the mean of all triangles are the corners of a pyramid. With `exact` their
    signed volumes are added, with `legacy` absolute ones, which for a mesh that is not convex is
    too much; `convex` takes the hull, `shell` the surface (mjCMesh::Process in user_mesh.cc).

    Args:
        vertices: (n, 3) [m].
        faces: (m, 3), seen counter-clockwise from outside; none stands for the hull.
        mode: one of `MESH_INERTIA_MODES`.

    Raises:
        WorkbenchError: with a clause as message, if it has no volume or surface.
    """
    if mode == "convex" or not len(faces):
        faces = _hull_faces(vertices)
    corners = vertices[faces]
    normals = 0.5 * np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(normals, axis=1)
    centres = corners.mean(axis=1)
    if areas.sum() < _MIN_MESH_MEASURE:
        raise WorkbenchError("its surface is too small")
    middle = areas @ centres / areas.sum()
    weights = _triangle_weights(mode, normals, areas, centres - middle)
    total = weights.sum()
    if total < _MIN_MESH_MEASURE:
        hint = "its faces are turned inside out" if total < 0.0 else "set inertia='shell'"
        raise WorkbenchError(f"its volume is too small: {hint}")
    p = weights @ (0.75 * centres + 0.25 * middle) / total
    corners = corners - p
    weights = _triangle_weights(mode, normals, areas, centres - p)
    size = float(weights.sum())
    # second moments of a pyramid to the origin, or of a triangle
    share = (12.0 if mode == "shell" else 20.0) * size
    whole = corners.sum(axis=1)
    products = np.einsum("i,ija,ijb->ab", weights, corners, corners)
    products += np.einsum("i,ia,ib->ab", weights, whole, whole)
    products /= share
    inertia = np.trace(products) * np.eye(3) - products
    moments, R = np.linalg.eigh(inertia)
    moments, R = moments[::-1], R[:, ::-1].copy()
    if np.linalg.det(R) < 0.0:
        R[:, 0] *= -1.0
    along = (vertices - p) @ R
    return MeshInertia(size, p, R, moments, np.array([along.min(axis=0), along.max(axis=0)]))


def _triangle_weights(
    mode: str, normals: np.ndarray, areas: np.ndarray, centres: np.ndarray
) -> np.ndarray:
    """Return the volume of the pyramid on each triangle, or its area for a shell."""
    if mode == "shell":
        return areas
    volumes = np.einsum("ij,ij->i", centres, normals) / 3.0
    return np.abs(volumes) if mode == "legacy" else volumes


def _hull_faces(vertices: np.ndarray) -> np.ndarray:
    """Return the faces of the convex hull of some vertices, outwards."""
    from scipy.spatial import ConvexHull, QhullError  # as above

    try:
        hull = ConvexHull(vertices)
    except (QhullError, ValueError) as error:
        raise WorkbenchError("its convex hull cannot be found") from error
    faces = hull.simplices.copy()
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    inward = np.einsum("ij,ij->i", np.cross(b - a, c - a), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward, ::-1]
    return faces

"""The closed form for meshes: every ray against every triangle."""

from functools import cached_property
from pathlib import Path

import numpy as np

_MOST = 2_000_000
"""Pairs of ray and triangle that are looked at together; they take 200 MB."""


class TriangleMesh:
    """A surface of triangles (m, 3, 3) [m]; it has no inside."""

    def __init__(self, triangles: np.ndarray) -> None:
        self.triangles = np.asarray(triangles, dtype=float)

    @classmethod
    def from_file(cls, path: Path, scale: np.ndarray, *, hull: bool) -> "TriangleMesh":
        """Return the mesh of a file as Drake takes it.

        Args:
            path: .obj, .stl, .gltf or .glb.
            scale: along x, y, z (3).
            hull: whether its convex hull is meant.
        """
        import trimesh

        mesh = trimesh.load_mesh(path, process=False)
        if path.suffix.lower() in (".gltf", ".glb"):
            # these files have y up, Drake z
            mesh.vertices = np.asarray(mesh.vertices)[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
        mesh.vertices = np.asarray(mesh.vertices) * scale
        return cls(np.asarray((mesh.convex_hull if hull else mesh).triangles))

    @cached_property
    def reach(self) -> float:
        """See `lidar_truth.Solid`."""
        return float(np.linalg.norm(self.triangles, axis=2).max())

    def first(self, p_O: np.ndarray, d_O: np.ndarray) -> np.ndarray:
        """See `lidar_truth.Solid`; by the barycentric coordinates of where a plane is met."""
        chunk = max(1, _MOST // len(self.triangles))
        parts = [
            self._first(p_O[start : start + chunk], d_O[start : start + chunk])
            for start in range(0, len(p_O), chunk)
        ]
        return np.concatenate(parts) if parts else np.zeros(0)

    def distance(self, p_O: np.ndarray) -> np.ndarray:
        """See `lidar_truth.Solid`; from the surface, also inside."""
        from trimesh.triangles import closest_point

        found = []
        for point in p_O:
            nearest = closest_point(self.triangles, np.tile(point, (len(self.triangles), 1)))
            found.append(np.linalg.norm(nearest - point, axis=1).min())
        return np.array(found)

    def outline(self) -> np.ndarray:
        """See `lidar_truth.Solid`."""
        return np.unique(self.triangles.reshape(-1, 3), axis=0)

    def _first(self, p: np.ndarray, d: np.ndarray) -> np.ndarray:
        """Return the nearest crossing ahead of each ray, inf without one.

        The normal n = e1 x e2 gives the length to the plane; the point is inside where it lies on
        the inner side of all three edges.
        """
        a, b, c = self.triangles.transpose(1, 0, 2)
        n = np.cross(b - a, c - a)
        with np.errstate(divide="ignore", invalid="ignore"):
            length = (np.sum(a * n, axis=1) - p @ n.T) / (d @ n.T)
            inside = np.isfinite(length) & (length >= 0.0)
        length = np.where(inside, length, 0.0)
        for start, end in ((a, b), (b, c), (c, a)):
            across = np.cross(n, end - start)  # in the triangle's plane, inwards
            side = p @ across.T + length * (d @ across.T) - np.sum(start * across, axis=1)
            inside &= side >= -1e-12 * np.sum(n * n, axis=1)
        return np.min(np.where(inside, length, np.inf), axis=1)

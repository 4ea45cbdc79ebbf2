"""Ray casting against the scene at one time."""

from collections.abc import Sequence

import numpy as np
from pydrake.geometry import Convex, Mesh
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError, drake_error_sentences
from workbench.systems.casting.scene import CastScene
from workbench.systems.casting.solids import as_solid, compiled_nearest_solids, pack_solids
from workbench.systems.casting.surfaces import (
    SINGLE_PRECISION_SLACK,
    Surface,
    compiled_rays_near_surface,
    compiled_shorten_to_triangles,
    join_surface,
)
from workbench.systems.casting.triangle_finder import triangle_finder

_READABLE = (".obj", ".gltf", ".glb", ".stl")
_Y_UP = (".gltf", ".glb")


def mesh_triangles(shape: Mesh | Convex) -> np.ndarray:
    """Return the corners of a mesh's triangles (n, 3, 3) [m], in the geometry's frame and scaled.

    A `Mesh` is read from its file, a glTF with y up, as Drake reads it. For a `Convex` they are
    those of the hull. Triangles without area are left out, because no ray meets them.

    Raises:
        WorkbenchError: if the file cannot be read as triangles.
    """
    corners = _hull_corners(shape) if isinstance(shape, Convex) else _file_corners(shape)
    edges = corners[:, 1:] - corners[:, :1]
    area = np.linalg.norm(np.cross(edges[:, 0], edges[:, 1]), axis=1)
    if not np.isfinite(corners).all() or not area.any():
        raise WorkbenchError(
            f"{shape.source().description()}: has no triangles with finite corners: "
            "rays cannot be cast against it"
        )
    return np.ascontiguousarray(corners[area > 0.0])


def _file_corners(shape: Mesh) -> np.ndarray:
    source = shape.source()
    if not source.is_path() or shape.extension() not in _READABLE:
        raise WorkbenchError(
            f"{source.description()}: rays are cast against mesh files ({', '.join(_READABLE)}): "
            "convert it to one of them"
        )
    import trimesh  # loads all of scipy, which only meshes should pay

    from workbench.plant.meshes.gltf import to_z_up

    try:
        scene = trimesh.load_scene(str(source.path()), process=False, skip_materials=True)
        mesh = scene.to_mesh()
    except (
        Exception
    ) as error:  # trimesh's readers raise whatever a broken file makes them stumble on
        reason = " ".join(str(error).split())
        raise WorkbenchError(f"{source.path()}: cannot be read as a mesh: {reason}") from error
    vertices = np.asarray(mesh.vertices, dtype=float)
    if shape.extension() in _Y_UP:
        vertices = vertices @ to_z_up()[:3, :3].T
    corners: np.ndarray = (vertices * shape.scale3())[mesh.faces]
    return corners


def _hull_corners(shape: Convex) -> np.ndarray:
    """Return the triangles of Drake's own hull, its polygons cut from their first corner."""
    with drake_error_sentences(f"{shape.source().description()}: rays cannot be cast against it"):
        hull = shape.GetConvexHull()
    vertices = np.array([hull.vertex(index) for index in range(hull.num_vertices())])
    data, faces, at = hull.face_data(), [], 0
    while at < len(data):
        polygon = data[at + 1 : at + 1 + data[at]]
        faces += [(polygon[0], *pair) for pair in zip(polygon[1:-1], polygon[2:], strict=True)]
        at += 1 + data[at]
    return vertices[np.array(faces)]


class Caster:
    """Finds the first hit of rays; built once for a scene, with the poses of moving frames.

    Boxes, balls, cylinders, capsules, ellipsoids and half-spaces have closed forms. These are
    exact, where ranges to a mesh of 128 corners around are up to 4 mm wrong. A whole reading of a
    lidar with embree and the same shapes as meshes takes 1.4 to 2 times as long in the shipped
    worlds.

    Meshes and convex hulls use a `triangle_finder` for each frame, in that frame, so that
    nothing is rebuilt when it moves.

    A ray that begins inside a shape hits its surface from within, at the point where it leaves.
    """

    def __init__(self, scene: CastScene) -> None:
        """Prepare a scene.

        Raises:
            WorkbenchError: naming a geometry that cannot be cast against.
        """
        self.scene = scene
        self._solids = pack_solids(scene.geometries)
        self._surfaces = _build_surfaces(scene)

    def cast(
        self,
        p_WS: np.ndarray,
        directions: np.ndarray,
        poses: Sequence[RigidTransform],
        max_range: float,
    ) -> np.ndarray:
        """Return how far rays from one point go (n) [m], infinite where they meet nothing.

        Args:
            p_WS: the point in W (3) [m].
            directions: unit vectors in W (n, 3).
            poses: X_WF of each of `scene.frames`.
            max_range: beyond which nothing is met [m]; may be infinite.
        """
        p_WS = np.ascontiguousarray(p_WS, dtype=float)
        directions = np.ascontiguousarray(directions, dtype=float)
        X_WF = np.array([np.eye(4), *(pose.GetAsMatrix4() for pose in poses)])
        X_WG = X_WF[self._solids.frames] @ self._solids.X_FG
        ranges = np.full(len(directions), np.nextafter(max_range, np.inf))
        compiled_nearest_solids(p_WS, directions, self._solids, X_WG, ranges)
        for surface in self._surfaces:
            surface.shorten(p_WS, directions, X_WF[surface.frame], ranges)
        ranges[ranges > max_range] = np.inf
        return ranges


class _FrameSurface:
    """All triangles fixed to one frame, with what finds those that rays meet."""

    def __init__(self, frame: int, surface: Surface) -> None:
        self.frame = frame
        self._surface = surface
        self._find = triangle_finder(surface)

    def shorten(
        self,
        p_WS: np.ndarray,
        directions: np.ndarray,
        X_WF: np.ndarray,
        ranges: np.ndarray,
    ) -> None:
        """Shorten `ranges` to where the rays meet these triangles."""
        numbers, starts = np.arange(len(ranges)), np.zeros(len(ranges))
        step = SINGLE_PRECISION_SLACK * self._surface.radius
        while len(numbers):
            rays = compiled_rays_near_surface(
                p_WS, directions, self._surface, X_WF, ranges, numbers, starts
            )
            if not len(rays.numbers):
                return
            triangles, distances = self._find(rays)
            numbers, starts = compiled_shorten_to_triangles(
                p_WS,
                directions,
                self._surface,
                X_WF,
                rays,
                triangles,
                distances,
                step,
                ranges,
            )
            step *= 10.0  # so that a ray along a surface does not creep


def _build_surfaces(scene: CastScene) -> list[_FrameSurface]:
    """Return the surfaces of all frames that have triangles."""
    surfaces = []
    for frame in range(1 + len(scene.frames)):
        corners = []
        for geometry in scene.geometries:
            if geometry.frame != frame or as_solid(geometry.shape) is not None:
                continue
            if not isinstance(geometry.shape, Mesh | Convex):
                raise WorkbenchError(
                    f"geometry '{geometry.name}': rays cannot be cast against a "
                    f"{type(geometry.shape).__name__}: draw it as a mesh"
                )
            points = mesh_triangles(geometry.shape).reshape(-1, 3)
            placed = geometry.X_FG.multiply(points.T).T
            corners.append(placed.reshape(-1, 3, 3))
        if corners:
            surfaces.append(_FrameSurface(frame, join_surface(corners)))
    return surfaces

"""Ray casting against the scene at one time."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore import EmbreeDevice
from embreex.rtcore_scene import EmbreeScene
from pydrake.geometry import Convex, Mesh
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError, sentences
from workbench.systems.casting.scene import CastScene
from workbench.systems.casting.solids import as_solid, compiled_nearest_solids, pack_solids
from workbench.systems.casting.surfaces import (
    SLACK,
    Surface,
    compiled_aim,
    compiled_settle,
    join_surface,
)

_READABLE = (".obj", ".gltf", ".glb", ".stl")
_Y_UP = (".gltf", ".glb")
NOTHING = -1
"""The number of the geometry that a ray met which met none."""


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
    with sentences(f"{shape.source().description()}: rays cannot be cast against it"):
        hull = shape.GetConvexHull()
    vertices = np.array([hull.vertex(index) for index in range(hull.num_vertices())])
    data, faces, at = hull.face_data(), [], 0
    while at < len(data):
        polygon = data[at + 1 : at + 1 + data[at]]
        faces += [(polygon[0], *pair) for pair in zip(polygon[1:-1], polygon[2:], strict=True)]
        at += 1 + data[at]
    return vertices[np.array(faces)]


class Returns(NamedTuple):
    """The first hits of rays.

    Attributes:
        ranges: distances from where the rays begin (n) [m], infinite where they met nothing.
        hits: places in `CastScene.geometries` of what they met (n), or `NOTHING`.
    """

    ranges: np.ndarray
    hits: np.ndarray


class Caster:
    """Finds the first hit of rays; built once for a scene, with the poses of moving frames.

    Boxes, balls, cylinders, capsules, ellipsoids and half-spaces have closed forms. These are
    exact, and with bundles of neighbouring rays as fast as embree with a box's twelve triangles.
    Meshes and convex hulls use embree, with one scene for each frame, in that frame, so that
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
    ) -> Returns:
        """Return what rays from one point meet within `max_range` [m].

        Args:
            p_WS: the point in W (3) [m].
            directions: unit vectors in W (n, 3), neighbours near each other where speed matters.
            poses: X_WF of each of `scene.frames`.
            max_range: beyond which nothing is met [m]; may be infinite.
        """
        p_WS = np.ascontiguousarray(p_WS, dtype=float)
        directions = np.ascontiguousarray(directions, dtype=float)
        X_WF = np.empty((1 + len(poses), 3, 4))
        X_WF[0] = np.eye(3, 4)
        for place, pose in enumerate(poses, start=1):
            X_WF[place] = pose.GetAsMatrix34()
        ranges = np.full(len(directions), np.nextafter(max_range, np.inf))
        hits = np.full(len(directions), NOTHING)
        compiled_nearest_solids(p_WS, directions, self._solids, X_WF, ranges, hits)
        for surface in self._surfaces:
            surface.shorten(p_WS, directions, X_WF[surface.frame], ranges, hits)
        ranges[hits == NOTHING] = np.inf
        return Returns(ranges, hits)


class _FrameSurface:
    """All triangles fixed to one frame, with embree's scene of them."""

    def __init__(self, frame: int, surface: Surface, device: EmbreeDevice) -> None:
        self.frame = frame
        self._surface = surface
        self._scene = EmbreeScene(device, robust=True)
        vertices = np.empty((len(surface.first) - 1, 3), dtype=np.float32)
        vertices[surface.vertices] = surface.corners
        TriangleMesh(self._scene, vertices, surface.vertices.astype(np.int32))
        # embree builds its tree at the first ray: now, and not in flight.
        ray = np.ones((1, 3), dtype=np.float32)
        self._scene.run(ray, ray)

    def shorten(
        self,
        p_WS: np.ndarray,
        directions: np.ndarray,
        X_WF: np.ndarray,
        ranges: np.ndarray,
        hits: np.ndarray,
    ) -> None:
        """Shorten `ranges` to where the rays meet these triangles, and write `hits`."""
        numbers, starts = np.arange(len(ranges)), np.zeros(len(ranges))
        step = SLACK * self._surface.radius
        while len(numbers):
            rays = compiled_aim(p_WS, directions, self._surface, X_WF, ranges, numbers, starts)
            if not len(rays.numbers):
                return
            found = self._scene.run(rays.origins, rays.directions, dists=rays.reach, output=1)
            numbers, starts = compiled_settle(
                p_WS,
                directions,
                self._surface,
                X_WF,
                rays,
                found["primID"],
                found["tfar"],
                step,
                ranges,
                hits,
            )
            step *= 10.0  # so that a ray along a surface does not creep


def _build_surfaces(scene: CastScene) -> list[_FrameSurface]:
    """Return the surfaces of all frames that have triangles."""
    device = EmbreeDevice()
    surfaces = []
    for frame in range(1 + len(scene.frames)):
        corners, owners = [], []
        for number, geometry in enumerate(scene.geometries):
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
            owners.append(number)
        if corners:
            surfaces.append(_FrameSurface(frame, join_surface(corners, owners), device))
    return surfaces

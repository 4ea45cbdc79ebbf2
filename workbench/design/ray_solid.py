"""Solids, and where rays enter and leave them."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

Stretch = tuple[np.ndarray, np.ndarray]
"""Lengths at which rays enter and leave (n) [m]; inf and -inf for a ray that misses."""
_MAX_RAY_TRIANGLES = 2_000_000
"""Largest number of pairs of ray and triangle computed together; they take 200 MB."""


@dataclass(frozen=True, eq=False)
class RaySolid:
    """A solid in its own frame O; rays are unit vectors, all lengths in m.

    Attributes:
        reach: largest distance of any of its points from the origin.
        first: returns how far rays from points (n, 3) along directions (n, 3) go (n), inf at a
            miss.
        distance: returns how far points (n, 3) are from it (n), 0 inside.
        outline: points of its surface (n, 3) whose convex hull shows its shape.
    """

    reach: float
    first: Callable[[np.ndarray, np.ndarray], np.ndarray]
    distance: Callable[[np.ndarray], np.ndarray]
    outline: np.ndarray


def box(half: Sequence[float] | np.ndarray) -> RaySolid:
    """Return a box about the origin, given by half its sides along x, y, z."""
    sides = np.array(half)
    signs = np.array([[x, y, z] for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)])

    def distance(p_O: np.ndarray) -> np.ndarray:
        return np.asarray(np.linalg.norm(np.maximum(np.abs(p_O) - sides, 0.0), axis=1))

    return RaySolid(
        reach=float(np.linalg.norm(sides)),
        first=lambda p_O, d_O: first_met(_slabs(p_O, d_O, sides)),
        distance=distance,
        outline=signs * sides,
    )


def sphere(radius: float) -> RaySolid:
    """Return a sphere about the origin."""
    return RaySolid(
        reach=radius,
        first=lambda p_O, d_O: first_met(_ball_stretches(p_O, d_O, radius)),
        distance=lambda p_O: np.maximum(np.linalg.norm(p_O, axis=1) - radius, 0.0),
        outline=radius * _ball_points(),
    )


def cylinder(radius: float, length: float) -> RaySolid:
    """Return a cylinder along z about the origin."""

    def distance(p_O: np.ndarray) -> np.ndarray:
        across = np.hypot(p_O[:, 0], p_O[:, 1]) - radius
        along = np.abs(p_O[:, 2]) - 0.5 * length
        return np.hypot(np.maximum(across, 0.0), np.maximum(along, 0.0))

    return RaySolid(
        reach=float(np.hypot(radius, 0.5 * length)),
        first=lambda p_O, d_O: first_met(_tube(p_O, d_O, radius, length)),
        distance=distance,
        outline=np.vstack([_rim(radius, z * length) for z in (-0.5, 0.5)]),
    )


def capsule(radius: float, length: float) -> RaySolid:
    """Return a cylinder along z with hemispherical ends; `length` excludes them."""
    ends = np.array([[0.0, 0.0, -0.5 * length], [0.0, 0.0, 0.5 * length]])
    ball = radius * _ball_points()

    def first(p_O: np.ndarray, d_O: np.ndarray) -> np.ndarray:
        parts = [_tube(p_O, d_O, radius, length)]
        parts += [_ball_stretches(p_O - end, d_O, radius) for end in ends]
        enters, leaves = zip(*parts, strict=True)
        return first_met((np.min(enters, axis=0), np.max(leaves, axis=0)))

    def distance(p_O: np.ndarray) -> np.ndarray:
        axis = np.zeros_like(p_O)
        axis[:, 2] = np.clip(p_O[:, 2], -0.5 * length, 0.5 * length)
        return np.maximum(np.linalg.norm(p_O - axis, axis=1) - radius, 0.0)

    return RaySolid(
        reach=radius + 0.5 * length,
        first=first,
        distance=distance,
        outline=np.vstack([ball[ball[:, 2] * end[2] >= 0.0] + end for end in ends]),
    )


def ellipsoid(radii: Sequence[float]) -> RaySolid:
    """Return an ellipsoid about the origin with its half axes along x, y, z."""
    r = np.array(radii)

    def distance(p_O: np.ndarray) -> np.ndarray:
        """Return distances; the nearest point is r² p / (r² + s), where s >= 0 solves it outside.

        |r p / (r² + s)| falls with s, from above 1 to below it. Bisection runs to machine
        precision.
        """
        outside = np.sum((p_O / r) ** 2, axis=1) > 1.0
        low = np.zeros(len(p_O))
        high = np.linalg.norm(p_O, axis=1) * r.max()
        for _ in range(80):
            middle = 0.5 * (low + high)
            beyond = np.sum((r * p_O / (r * r + middle[:, None])) ** 2, axis=1) > 1.0
            low, high = np.where(beyond, middle, low), np.where(beyond, high, middle)
        nearest = r * r * p_O / (r * r + high[:, None])
        return np.where(outside, np.linalg.norm(p_O - nearest, axis=1), 0.0)

    return RaySolid(
        reach=max(radii),
        # scaled to the unit sphere; lengths along a ray stay the same
        first=lambda p_O, d_O: first_met(_ball_stretches(p_O / r, d_O / r, 1.0)),
        distance=distance,
        outline=_ball_points() * r,
    )


def half_space() -> RaySolid:
    """Return everything below z = 0."""

    def first(p_O: np.ndarray, d_O: np.ndarray) -> np.ndarray:
        with np.errstate(divide="ignore", invalid="ignore"):
            length = -p_O[:, 2] / d_O[:, 2]
        return np.where(np.isfinite(length) & (length >= 0.0), length, np.inf)

    return RaySolid(
        reach=np.inf,
        first=first,
        distance=lambda p_O: np.maximum(p_O[:, 2], 0.0),
        outline=np.zeros((0, 3)),
    )


def first_met(stretch: Stretch) -> np.ndarray:
    """Return the entry, from inside the exit, inf where neither lies ahead (n)."""
    enter, leave = stretch
    met = (enter <= leave) & (leave >= 0.0)
    return np.where(met, np.where(enter >= 0.0, enter, leave), np.inf)


def _slabs(p: np.ndarray, d: np.ndarray, half: np.ndarray) -> Stretch:
    """Return the stretches of rays within ± half along every axis; p, d (n, k), half (k)."""
    d = d + 0.0  # makes -0 to 0, so that a ray along a face counts as inside it
    with np.errstate(divide="ignore", invalid="ignore"):
        one, other = (-half - p) / d, (half - p) / d
    one, other = np.where(np.isnan(one), -np.inf, one), np.where(np.isnan(other), np.inf, other)
    enter, leave = np.max(np.minimum(one, other), axis=1), np.min(np.maximum(one, other), axis=1)
    return _whole_stretch(enter, leave, enter <= leave)


def _ball_stretches(p: np.ndarray, d: np.ndarray, radius: float) -> Stretch:
    """Return the stretches of rays inside a ball of any dimension; d need not be unit vectors.

    They extend half a chord to both sides of the point nearest to the centre. This loses fewer
    digits than the usual quadratic formula.
    """
    square = np.sum(d * d, axis=1)
    still = square == 0.0  # along a cylinder's axis nothing changes across it
    length = -np.sum(p * d, axis=1) / np.where(still, 1.0, square)
    nearest = p + length[:, None] * d
    room = radius * radius - np.sum(nearest * nearest, axis=1)
    half = np.sqrt(np.maximum(room, 0.0) / np.where(still, 1.0, square))
    half = np.where(still, np.inf, half)
    return _whole_stretch(length - half, length + half, room >= 0.0)


def _tube(p: np.ndarray, d: np.ndarray, radius: float, length: float) -> Stretch:
    """Return the stretches of rays inside a cylinder along z, between its end planes."""
    side = _ball_stretches(p[:, :2], d[:, :2], radius)
    ends = _slabs(p[:, 2:], d[:, 2:], np.array([0.5 * length]))
    enter, leave = np.maximum(side[0], ends[0]), np.minimum(side[1], ends[1])
    return _whole_stretch(enter, leave, enter <= leave)


def _whole_stretch(enter: np.ndarray, leave: np.ndarray, met: np.ndarray) -> Stretch:
    """Return a stretch that is empty where a ray misses the solid."""
    return np.where(met, enter, np.inf), np.where(met, leave, -np.inf)


def _rim(radius: float, z: float) -> np.ndarray:
    """Return points of a circle about the z axis."""
    angles = np.linspace(0.0, 2.0 * np.pi, 48, endpoint=False)
    return np.stack(
        [radius * np.cos(angles), radius * np.sin(angles), np.full(len(angles), z)], axis=1
    )


def _ball_points() -> np.ndarray:
    """Return points of the unit sphere."""
    heights = np.linspace(-0.5 * np.pi, 0.5 * np.pi, 13)
    return np.vstack([_rim(float(np.cos(a)), float(np.sin(a))) for a in heights])


def ray_surface(triangles: np.ndarray) -> RaySolid:
    """Return a surface of triangles (m, 3, 3) [m]; it has no inside."""
    chunk = max(1, _MAX_RAY_TRIANGLES // len(triangles))

    def first(p_O: np.ndarray, d_O: np.ndarray) -> np.ndarray:
        parts = [
            _nearest_crossing(triangles, p_O[start : start + chunk], d_O[start : start + chunk])
            for start in range(0, len(p_O), chunk)
        ]
        return np.concatenate(parts) if parts else np.zeros(0)

    def distance(p_O: np.ndarray) -> np.ndarray:
        """Return the distances from the surface, also inside."""
        from trimesh.triangles import closest_point

        found = []
        for point in p_O:
            nearest = closest_point(triangles, np.tile(point, (len(triangles), 1)))
            found.append(np.linalg.norm(nearest - point, axis=1).min())
        return np.array(found)

    return RaySolid(
        reach=float(np.linalg.norm(triangles, axis=2).max()),
        first=first,
        distance=distance,
        outline=np.unique(triangles.reshape(-1, 3), axis=0),
    )


def surface_of(path: Path, scale: np.ndarray, *, hull: bool) -> RaySolid:
    """Return the mesh of a file in the way that Drake reads it.

    Args:
        path: .obj, .stl, .gltf or .glb.
        scale: along x, y, z (3).
        hull: whether to take its convex hull.
    """
    import trimesh

    mesh = trimesh.load_mesh(path, process=False)
    if path.suffix.lower() in (".gltf", ".glb"):
        # these files have y up, Drake z
        mesh.vertices = np.asarray(mesh.vertices)[:, [0, 2, 1]] * [1.0, -1.0, 1.0]
    mesh.vertices = np.asarray(mesh.vertices) * scale
    return ray_surface(np.asarray((mesh.convex_hull if hull else mesh).triangles, dtype=float))


def _nearest_crossing(triangles: np.ndarray, p: np.ndarray, d: np.ndarray) -> np.ndarray:
    """Return the nearest crossing of triangles ahead of each ray, inf without one.

    The normal n = e1 x e2 gives the length to the plane. The point is inside if it lies on the
    inner side of all three edges.
    """
    a, b, c = triangles.transpose(1, 0, 2)
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

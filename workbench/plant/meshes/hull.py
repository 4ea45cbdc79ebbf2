"""The convex hull of a mesh, with few vertices, and its OBJ text."""

import numpy as np
from scipy.spatial import ConvexHull

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.parts import Array

MIN_HULL_THICKNESS_M = 1e-3
"""Smallest thickness of a hull [m]; contact would pass through a sheet without volume."""
MAX_HULL_VERTICES = 200
_MAX_HULL_CUT_SHARE = 5e-4
"""Largest depth cut off a hull by leaving out vertices, over its longest side."""
_MANY_POINTS = 20_000
_MANY_DIRECTIONS = 800
_FEW_VERTICES = 50
_FEW_DIRECTIONS = 20


def convex_hull(points: Array) -> tuple[Array, Array]:
    """Return vertices (n, 3) and faces (m, 3) of a convex hull.

    Vertices are outside of the true hull by half of THINNEST at most, and only if it is thinner
    than that. Extremes along x, y and z are exact, so that a drone stands at the correct height.

    Args:
        points: (k, 3) [m], at least one.

    Raises:
        WorkbenchError: if it cannot be computed, with a clause as message.
    """
    points = np.asarray(points, dtype=float)
    if len(points) > _MANY_POINTS:
        points = points[_extremes(points, _MANY_DIRECTIONS)]
    points = _thickened(np.unique(points, axis=0))
    try:
        corners = points[_reduced_hull_points(points)]
        hull = ConvexHull(corners)
    except (ValueError, RuntimeError) as error:  # QhullError is a RuntimeError
        raise WorkbenchError("its convex hull cannot be found") from error
    used, faces = np.unique(hull.simplices, return_inverse=True)
    vertices = corners[used]
    faces = faces.reshape(-1, 3)
    inward = np.einsum("ij,ij->i", _normals(vertices, faces), hull.equations[:, :3]) < 0.0
    faces[inward] = faces[inward, ::-1]
    return vertices, faces


def write_obj(vertices: Array, faces: Array) -> bytes:
    """Return the content of an .obj file."""
    lines = [f"v {x:.9g} {y:.9g} {z:.9g}" for x, y, z in vertices.tolist()]
    lines += [f"f {a} {b} {c}" for a, b, c in (faces + 1).tolist()]
    return "\n".join([*lines, ""]).encode()


def _normals(vertices: Array, faces: Array) -> Array:
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    return np.cross(b - a, c - a)


def _extremes(points: Array, count: int) -> Array:
    """Return indices of the extreme points along x, y, z and `count` more directions.

    The directions are evenly spread after scaling the bounding box of the points to a cube;
    otherwise all of them would find the ends of a long thin part.
    """
    size = np.ptp(points, axis=0)
    scaled = ((points - points.mean(axis=0)) / np.where(size > 0.0, size, 1.0)).astype(np.float32)
    # points of a Fibonacci sphere
    turn = np.pi * (3.0 - np.sqrt(5.0)) * np.arange(count)
    z = np.linspace(-1.0, 1.0, count)
    r = np.sqrt(1.0 - z * z)
    directions = np.column_stack([r * np.cos(turn), r * np.sin(turn), z]).astype(np.float32)
    found = [points.argmax(axis=0), points.argmin(axis=0)]
    for some in np.array_split(directions, count // 20 + 1):  # to bound memory
        reach = some @ scaled.T
        found += [reach.argmax(axis=1), reach.argmin(axis=1)]
    return np.unique(np.concatenate(found))


def _thickened(points: Array) -> Array:
    """Return points, duplicated along principal axes in which they are too thin."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    for axis in axes.T:
        if np.ptp(centred @ axis) < MIN_HULL_THICKNESS_M:
            step = 0.5 * MIN_HULL_THICKNESS_M * axis
            points = np.vstack([points + step, points - step])
    return points


def _reduced_hull_points(points: Array) -> Array:
    """Return indices of few points with a hull close to that of all points.

    Starts with some extremes, and adds the point farthest outside until all are close enough.
    """
    corners = ConvexHull(points).vertices
    if len(corners) > _MANY_DIRECTIONS:  # or the loop below would take long
        corners = corners[_extremes(points[corners], _MANY_DIRECTIONS // 2)]
    if len(corners) <= _FEW_VERTICES:
        return corners
    candidates = points[corners]
    chosen = _extremes(candidates, _FEW_DIRECTIONS).tolist()
    hull = ConvexHull(candidates[chosen], incremental=True)
    enough = _MAX_HULL_CUT_SHARE * np.ptp(points, axis=0).max()
    while len(chosen) < MAX_HULL_VERTICES:
        outside = (candidates @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
        farthest = int(outside.argmax())
        if outside[farthest] <= enough:
            break
        chosen.append(farthest)
        hull.add_points(candidates[farthest : farthest + 1])
    return corners[chosen]

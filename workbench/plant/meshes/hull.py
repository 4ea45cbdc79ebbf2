"""The convex hull of points, with few vertices and a thickness, for contact."""

import numpy as np
from scipy.spatial import ConvexHull

from workbench.common.errors import WorkbenchError
from workbench.plant.meshes.parts import Array

THINNEST = 1e-3
"""Of a hull [m]: a sheet has no volume, and contact would pass through it."""
MOST_VERTICES = 200
_CLOSE = 5e-4
"""What of a hull may be cut off by leaving out vertices, over its longest side."""
_MANY = 20_000
_MANY_DIRECTIONS = 800
_FEW_VERTICES = 50
_FEW_DIRECTIONS = 20


def convex_hull(points: Array) -> tuple[Array, Array]:
    """Return vertices (n, 3) and faces (m, 3) of a convex hull.

    No vertex lies outside of the true hull by more than half of THINNEST, and that only where this
    is thinner. Extremes along x, y and z are kept exactly: a drone stands as high as it should.

    Args:
        points: (k, 3) [m], at least one.

    Raises:
        WorkbenchError: if it cannot be found, a clause.
    """
    points = np.asarray(points, dtype=float)
    if len(points) > _MANY:
        points = points[_extremes(points, _MANY_DIRECTIONS)]
    points = _thickened(np.unique(points, axis=0))
    try:
        corners = points[_few(points)]
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
    """Return indices of the points that are farthest along x, y, z and `count` more directions.

    Directions are spread evenly over the points' bounding box made a cube, or those of a long thin
    part would all find its ends.
    """
    size = np.ptp(points, axis=0)
    scaled = ((points - points.mean(axis=0)) / np.where(size > 0.0, size, 1.0)).astype(np.float32)
    # The points of a Fibonacci sphere.
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
    """Return points, doubled along their principal axes where these are too short."""
    centred = points - points.mean(axis=0)
    _, axes = np.linalg.eigh(centred.T @ centred)
    for axis in axes.T:
        if np.ptp(centred @ axis) < THINNEST:
            step = 0.5 * THINNEST * axis
            points = np.vstack([points + step, points - step])
    return points


def _few(points: Array) -> Array:
    """Return indices of few points whose hull is close to that of all.

    Begins with some extremes and adds the point that is farthest outside, until none is by much.
    """
    corners = ConvexHull(points).vertices
    if len(corners) > _MANY_DIRECTIONS:  # the loop below would take long
        corners = corners[_extremes(points[corners], _MANY_DIRECTIONS // 2)]
    if len(corners) <= _FEW_VERTICES:
        return corners
    candidates = points[corners]
    chosen = _extremes(candidates, _FEW_DIRECTIONS).tolist()
    hull = ConvexHull(candidates[chosen], incremental=True)
    enough = _CLOSE * np.ptp(points, axis=0).max()
    while len(chosen) < MOST_VERTICES:
        outside = (candidates @ hull.equations[:, :3].T + hull.equations[:, 3]).max(axis=1)
        farthest = int(outside.argmax())
        if outside[farthest] <= enough:
            break
        chosen.append(farthest)
        hull.add_points(candidates[farthest : farthest + 1])
    return corners[chosen]

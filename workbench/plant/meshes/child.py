"""Convert meshes, in a process of its own: the files come from strangers."""

from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import ConvexHull

from workbench.common.errors import WorkbenchError
from workbench.ipc.limited import one_line, serve
from workbench.plant.meshes.gltf import write_gltf
from workbench.plant.meshes.job import MeshJob, sealed, write_whole
from workbench.plant.meshes.parts import MOST_FACES, Array, Part, joined
from workbench.plant.meshes.reading import read_parts

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


def convert_all(request: Any) -> list[str]:
    """Make the files that are asked for; return for each why it could not be made, or "".

    Args:
        request: pairs of a job's fields and the path to write to.
    """
    return [_reason(MeshJob(**fields), Path(target)) for fields, target in request]


def _reason(job: MeshJob, target: Path) -> str:
    try:
        write_whole(target, sealed(convert(job), target.suffix))
    except WorkbenchError as error:
        return str(error)
    except MemoryError:
        return "it takes more memory than it may"
    except RecursionError:
        return "it is nested too deeply"
    except Exception as error:  # trimesh and pycollada raise anything on broken files
        return f"it cannot be read: {one_line(error)}"
    return ""


def convert(job: MeshJob) -> bytes:
    """Return the content of the converted file.

    Raises:
        WorkbenchError: a clause without the file's name. Other exceptions come from readers.
    """
    parts = [part for part in _placed(job) if len(part.faces)]
    if not parts:
        raise WorkbenchError("it has no faces")
    if sum(len(part.faces) for part in parts) > MOST_FACES:
        raise WorkbenchError(f"it has more than {MOST_FACES} faces")
    if job.use == "collision":
        return write_obj(*convex_hull(np.concatenate([part.vertices for part in parts])))
    return write_gltf(joined(parts), job.rgba)


def _placed(job: MeshJob) -> list[Part]:
    """Return the parts that are used, scaled and centred, checked."""
    scale = np.diag([*job.scale, 1.0])
    parts = [part.moved(scale).checked() for part in read_parts(Path(job.file), job.submesh)]
    if not job.center:
        return parts
    corners = [corner(part.vertices, axis=0) for part in parts for corner in (np.min, np.max)]
    T = np.eye(4)
    T[:3, 3] = -0.5 * (np.min(corners, axis=0) + np.max(corners, axis=0))
    return [part.moved(T) for part in parts]


if __name__ == "__main__":
    serve(convert_all)

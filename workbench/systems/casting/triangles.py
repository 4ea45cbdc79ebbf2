"""The triangles of a mesh as Drake's renderer would show it."""

import numpy as np
from pydrake.geometry import Convex, Mesh

from workbench.common.errors import WorkbenchError, sentences

_READABLE = (".obj", ".gltf", ".glb", ".stl")
_Y_UP = (".gltf", ".glb")


def mesh_triangles(shape: Mesh | Convex) -> np.ndarray:
    """Return the corners of a mesh's triangles (n, 3, 3) [m], in the geometry's frame and scaled.

    A `Mesh` is read from its file, with y up where that is glTF, as Drake reads it. Of a `Convex`
    it is the hull. Triangles without area are left out: no ray meets them.

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

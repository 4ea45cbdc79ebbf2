"""Triangles as Drake has them: its own reader of OBJ, and its own hulls, are the oracle."""

import numpy as np
import pytest
import trimesh
from pydrake.common import MemoryFile
from pydrake.geometry import Convex, InMemoryMesh, Mesh, ReadObjToTriangleSurfaceMesh

from workbench.common.errors import WorkbenchError
from workbench.systems.casting.triangles import mesh_triangles

SCALES = [(1.0, 1.0, 1.0), (2.0, 0.5, -1.5)]


@pytest.fixture(scope="module")
def lopsided():
    """A mesh that looks different from every side."""
    mesh = trimesh.creation.box((1.0, 2.0, 3.0)).subdivide()
    mesh.vertices += [0.1, 0.2, 0.3] + 0.1 * mesh.vertices[:, [1, 2, 0]] ** 2
    mesh.vertices = mesh.vertices.round(3)
    return mesh


def in_order(corners):
    """Return the points (n, 3) of triangles sorted, each once."""
    return np.unique(np.asarray(corners).reshape(-1, 3).round(5), axis=0)


@pytest.mark.parametrize("scale", SCALES)
def test_an_obj_has_the_triangles_that_drake_reads(stored, lopsided, scale):
    shape = stored(lopsided, "lopsided.obj", Mesh, scale)
    drake = ReadObjToTriangleSurfaceMesh(shape.source().path(), scale3=list(scale))
    faces = [[face.vertex(k) for k in range(3)] for face in drake.triangles()]
    expected = np.array(drake.vertices())[faces]
    found = mesh_triangles(shape)
    assert len(found) == len(expected) == len(lopsided.faces)
    np.testing.assert_allclose(
        np.sort(found.mean(axis=1), axis=0), np.sort(expected.mean(axis=1), axis=0), atol=1e-12
    )


@pytest.mark.parametrize("scale", SCALES)
def test_y_is_up_in_gltf_as_drake_has_it(stored, lopsided, scale):
    """Drake turns first and scales then; its hull of a convex mesh has the mesh's corners."""
    shape = stored(lopsided.convex_hull, "lopsided.gltf", Mesh, scale)
    hull = shape.GetConvexHull()
    corners = np.array([hull.vertex(index) for index in range(hull.num_vertices())])
    found = mesh_triangles(shape).reshape(-1, 3)
    np.testing.assert_allclose(found.min(axis=0), corners.min(axis=0), atol=1e-6)
    np.testing.assert_allclose(found.max(axis=0), corners.max(axis=0), atol=1e-6)


@pytest.mark.parametrize("suffix", ["glb", "gltf", "stl", "obj"])
def test_formats_agree(stored, lopsided, suffix):
    found = mesh_triangles(stored(lopsided, f"lopsided_again.{suffix}"))
    expected = lopsided.triangles
    if suffix in ("glb", "gltf"):
        x, y, z = np.moveaxis(expected, -1, 0)
        expected = np.stack([x, -z, y], axis=-1)
    np.testing.assert_allclose(in_order(found), in_order(expected), atol=1e-5)
    assert len(found) == len(expected)


@pytest.mark.parametrize("scale", SCALES)
def test_a_convex_is_its_closed_hull(stored, lopsided, scale):
    shape = stored(lopsided, "lopsided_hull.obj", Convex, scale)
    hull = trimesh.Trimesh(*_indexed(mesh_triangles(shape)), process=True)
    expected = trimesh.convex.convex_hull(lopsided.vertices * scale)
    assert hull.is_watertight
    assert abs(hull.volume) == pytest.approx(expected.volume, rel=1e-9)


def _indexed(corners):
    points, faces = np.unique(corners.reshape(-1, 3), axis=0, return_inverse=True)
    return points, faces.reshape(-1, 3)


def test_triangles_without_area_are_left_out(tmp_path):
    path = tmp_path / "thin.obj"
    path.write_text("v 0 0 0\nv 1 0 0\nv 2 0 0\nv 0 1 0\nf 1 2 3\nf 1 2 4\n")
    assert len(mesh_triangles(Mesh(str(path)))) == 1


@pytest.mark.parametrize(
    ("name", "content", "said"),
    [
        ("a.obj", "nothing here\n", "a.obj"),
        ("b.gltf", "{", "b.gltf: cannot be read as a mesh"),
        ("c.vtk", "# vtk", "convert it to one"),
        ("d.obj", "v 0 0 0\nv 1 0 0\nv 2 0 0\nf 1 2 3\n", "no triangles"),
        ("e.stl", "solid", "e.stl"),
    ],
)
def test_what_cannot_be_read_is_a_sentence(tmp_path, name, content, said):
    path = tmp_path / name
    path.write_text(content)
    with pytest.raises(WorkbenchError, match=said):
        mesh_triangles(Mesh(str(path)))


def test_a_missing_file_and_one_in_memory_are_sentences(tmp_path):
    with pytest.raises(WorkbenchError, match="none.obj"):
        mesh_triangles(Mesh(str(tmp_path / "none.obj")))
    with pytest.raises(WorkbenchError, match="none.obj"):
        mesh_triangles(Convex(str(tmp_path / "none.obj")))
    held = InMemoryMesh(mesh_file=MemoryFile("v 0 0 0\n", ".obj", "held in memory"))
    with pytest.raises(WorkbenchError, match="held in memory"):
        mesh_triangles(Mesh(held))

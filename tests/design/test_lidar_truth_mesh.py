"""Meshes: every triangle by hand, and against the solids that they stand for."""

import math

import numpy as np
import pydrake.geometry as drake
import pytest
import trimesh

from workbench.design.lidar_trial_world import solid_of
from workbench.design.lidar_truth import Box, TriangleMesh

TRIANGLE = TriangleMesh(np.array([[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]]]))


@pytest.mark.parametrize(
    ("start", "direction", "length"),
    [
        ((0.5, 0.5, 4), (0, 0, -1), 3.0),
        ((0.5, 0.5, -1), (0, 0, 1), 2.0),
        ((1.5, 1.5, 4), (0, 0, -1), math.inf),
        ((-0.1, 0.5, 4), (0, 0, -1), math.inf),
        ((0.5, 0.5, 4), (0, 0, 1), math.inf),
        ((-3, 0.5, 1), (1, 0, 0), math.inf),
        ((1.0, 1.0, 4), (0, 0, -1), 3.0),
    ],
)
def test_a_triangle_is_met_from_both_sides_and_only_within_its_edges(start, direction, length):
    found = TRIANGLE.first(np.array([start], dtype=float), np.array([direction], dtype=float))
    assert found == pytest.approx([length])


def test_a_box_of_triangles_is_that_box(tmp_path):
    path = tmp_path / "crate.obj"
    trimesh.creation.box(extents=(0.5, 1.0, 1.5)).export(path)
    box = Box((0.5, 1.0, 1.5))
    rng = np.random.default_rng(5)
    starts = 4.0 * rng.normal(size=(2000, 3))
    aims = rng.normal(size=(2000, 3))
    directions = (aims - starts) / np.linalg.norm(aims - starts, axis=1, keepdims=True)
    expected = box.first(starts, directions)
    assert 200 < np.isfinite(expected).sum() < 1900
    for shape in (drake.Mesh(str(path), 2.0), drake.Convex(str(path), 2.0)):
        mesh = solid_of(shape)
        assert mesh.first(starts, directions) == pytest.approx(expected, abs=1e-7)
        outside = box.distance(starts) > 0.0
        assert mesh.distance(starts[outside][:100]) == pytest.approx(
            box.distance(starts[outside][:100]), abs=1e-7
        )
        assert mesh.reach == pytest.approx(box.reach)


def test_a_hull_fills_what_a_mesh_leaves_open(tmp_path):
    path = tmp_path / "bowl.obj"
    two = [trimesh.creation.box(extents=(1, 1, 1)), trimesh.creation.box(extents=(1, 1, 1))]
    two[1].apply_translation([4.0, 0.0, 0.0])
    trimesh.util.concatenate(two).export(path)
    between = np.array([[2.0, 0.0, 5.0]]), np.array([[0.0, 0.0, -1.0]])
    assert solid_of(drake.Mesh(str(path))).first(*between) == pytest.approx([math.inf])
    assert solid_of(drake.Convex(str(path))).first(*between) == pytest.approx([4.5])


def test_a_gltf_file_stands_as_drake_stands_it_up(tmp_path):
    """Such files have y up; a pyramid shows every axis."""
    corners = np.array([[0, 0, 0], [1, 0, 0], [0, 2, 0], [0, 0, 3]], dtype=float)
    faces = [[0, 2, 1], [0, 1, 3], [0, 3, 2], [1, 2, 3]]
    files = trimesh.Trimesh(corners, faces, process=False).export(file_type="gltf")
    for name, content in files.items():
        (tmp_path / name).write_bytes(content)
    shape = drake.Mesh(str(tmp_path / "model.gltf"), 2.0)
    hull = shape.GetConvexHull()
    expected = np.array([hull.vertex(index) for index in range(hull.num_vertices())])
    found = solid_of(shape).outline()
    apart = np.linalg.norm(found[:, None] - expected[None], axis=2)
    assert apart.min(axis=0) == pytest.approx(0.0, abs=1e-6)
    assert apart.min(axis=1) == pytest.approx(0.0, abs=1e-6)

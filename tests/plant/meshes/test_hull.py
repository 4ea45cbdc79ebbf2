"""Hulls are measured by scipy and by geometry known by hand."""

import numpy as np
import pytest
from pydrake.geometry import Convex
from scipy.spatial import ConvexHull

from workbench.plant.meshes.hull import (
    MAX_HULL_VERTICES,
    MIN_HULL_THICKNESS_M,
    convex_hull,
    write_obj,
)

CUBE = np.array([[x, y, z] for x in (0, 1) for y in (0, 2) for z in (0, 3)], dtype=float)


def sphere(count: int, radius: float = 1.0) -> np.ndarray:
    """Points on a sphere."""
    points = np.random.default_rng(1).normal(size=(count, 3))
    return radius * points / np.linalg.norm(points, axis=1, keepdims=True)


def test_a_box_keeps_its_eight_corners_and_loses_what_is_inside():
    vertices, _ = convex_hull(np.vstack([CUBE, [[0.5, 0.5, 0.5]], CUBE]))
    assert sorted(map(tuple, vertices)) == sorted(map(tuple, CUBE))


def test_faces_look_outward_and_close():
    vertices, faces = convex_hull(sphere(500) + [5.0, -3.0, 2.0])
    a, b, c = (vertices[faces[:, corner]] for corner in range(3))
    volume = np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6.0
    assert volume == pytest.approx(ConvexHull(vertices).volume)


@pytest.mark.parametrize("count", [1_000, pytest.param(30_000, marks=pytest.mark.slow)])
def test_many_vertices_become_few_that_stay_close(count):
    points = sphere(count)
    vertices, _ = convex_hull(points)
    assert len(vertices) <= MAX_HULL_VERTICES
    hull = ConvexHull(vertices)
    outside = (points @ hull.equations[:, :3].T + hull.equations[:, 3]).max()
    assert outside < 0.05
    assert hull.volume > 0.95 * ConvexHull(points).volume


@pytest.mark.parametrize("count", [500, 30_000])
def test_extremes_along_the_axes_are_exact(count):
    points = sphere(count) * [1.0, 0.1, 0.01]
    vertices, _ = convex_hull(points)
    assert (vertices.min(axis=0) == points.min(axis=0)).all()
    assert (vertices.max(axis=0) == points.max(axis=0)).all()


def test_no_vertex_is_invented():
    points = sphere(1_000)
    vertices, _ = convex_hull(points)
    assert set(map(tuple, vertices)) <= set(map(tuple, points))


def test_a_long_thin_part_keeps_its_shape():
    points = sphere(1_000) * [1.0, 0.02, 0.02]
    vertices, _ = convex_hull(points)
    assert ConvexHull(vertices).volume > 0.93 * ConvexHull(points).volume


@pytest.mark.parametrize(
    ("points", "sides"),
    [
        ([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0]], [1, 2, MIN_HULL_THICKNESS_M]),
        ([[0, 0, 0], [0, 0, 1]], [MIN_HULL_THICKNESS_M, MIN_HULL_THICKNESS_M, 1]),
        ([[3, 3, 3]], [MIN_HULL_THICKNESS_M, MIN_HULL_THICKNESS_M, MIN_HULL_THICKNESS_M]),
        (
            [[3, 3, 3], [3, 3, 3]],
            [MIN_HULL_THICKNESS_M, MIN_HULL_THICKNESS_M, MIN_HULL_THICKNESS_M],
        ),
    ],
    ids=["sheet", "line", "point", "point twice"],
)
def test_what_is_flat_becomes_a_millimetre_thick(points, sides):
    vertices, _ = convex_hull(np.array(points, dtype=float))
    assert np.ptp(vertices, axis=0) == pytest.approx(sides)


def test_a_tilted_sheet_is_thick_across_itself():
    turn = np.linalg.qr(np.random.default_rng(2).normal(size=(3, 3)))[0]
    sheet = np.array([[0, 0, 0], [1, 0, 0], [1, 2, 0], [0, 2, 0.0]]) @ turn.T
    vertices, _ = convex_hull(sheet)
    assert np.ptp(vertices @ turn, axis=0) == pytest.approx([1, 2, MIN_HULL_THICKNESS_M])


@pytest.mark.parametrize("size", [1e-9, 1e-4])
def test_a_speck_becomes_a_millimetre_thick(size):
    vertices, _ = convex_hull(size * sphere(100))
    assert (np.ptp(vertices, axis=0) >= MIN_HULL_THICKNESS_M).all()


def test_drake_reads_the_file(tmp_path):
    path = tmp_path / "hull.obj"
    path.write_bytes(write_obj(*convex_hull(CUBE)))
    hull = Convex(str(path)).GetConvexHull()
    assert hull.num_vertices() == 8
    corners = np.array([hull.vertex(i) for i in range(8)])
    assert corners.min(axis=0) == pytest.approx([0, 0, 0])
    assert corners.max(axis=0) == pytest.approx([1, 2, 3])

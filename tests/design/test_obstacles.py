"""The closed forms against lengths by hand, and against Drake's own signed distances."""

import math

import numpy as np
import pydrake.geometry as drake
import pytest
import trimesh
from pydrake.math import RigidTransform

from workbench.design.obstacles import solid_of
from workbench.design.ray_solid import (
    box,
    capsule,
    cylinder,
    ellipsoid,
    half_space,
    ray_surface,
    sphere,
)

BOX = box((0.5, 1.0, 1.5))
BALL = sphere(2.0)
CAN = cylinder(1.0, 4.0)
PILL = capsule(1.0, 4.0)
EGG = ellipsoid((1.0, 2.0, 3.0))
FLOOR = half_space()
TRIANGLE = ray_surface(np.array([[[0.0, 0.0, 1.0], [2.0, 0.0, 1.0], [0.0, 2.0, 1.0]]]))
ROOT = math.sqrt(0.5)


def test_a_ray_goes_as_far_as_by_hand(case):
    for solid, start, direction, length in [
        # along the axes, from outside
        (BOX, (5, 0, 0), (-1, 0, 0), 4.5),
        (BOX, (0, 5, 0), (0, -1, 0), 4.0),
        (BOX, (0, 0, -5), (0, 0, 1), 3.5),
        (BALL, (0, 7, 0), (0, -1, 0), 5.0),
        (CAN, (4, 0, 1), (-1, 0, 0), 3.0),
        (CAN, (0.5, 0, 9), (0, 0, -1), 7.0),
        (PILL, (0, 0, 9), (0, 0, -1), 6.0),
        (PILL, (0, -4, 1.5), (0, 1, 0), 3.0),
        (EGG, (0, 9, 0), (0, -1, 0), 7.0),
        (EGG, (0, 0, 9), (0, 0, -1), 6.0),
        (FLOOR, (3, 4, 2), (0, 0, -1), 2.0),
        # slantwise: through a corner's face, past an edge, onto a cap, half down
        (BOX, (2.5, 2.0, 0), (-ROOT, -ROOT, 0), 2.0 / ROOT),
        (CAN, (3, 0, 4), (-ROOT, 0, -ROOT), 2.0 / ROOT),
        (PILL, (math.sqrt(2), 0, 2 + math.sqrt(2)), (-ROOT, 0, -ROOT), 1.0),
        (FLOOR, (0, 0, 3), (ROOT, 0, -ROOT), 3.0 / ROOT),
        # from inside: the way out
        (BOX, (0, 0, 0), (0, 1, 0), 1.0),
        (BALL, (1, 0, 0), (-1, 0, 0), 3.0),
        (CAN, (0, 0, 1), (0, 0, -1), 3.0),
        (PILL, (0, 0, 0), (0, 0, 1), 3.0),
        (EGG, (0, 0, 0), (1, 0, 0), 1.0),
        (FLOOR, (0, 0, -2), (0, 0, 1), 2.0),
        # touching: along a face, at a point
        (BOX, (5, 1.0, 0), (-1, 0, 0), 4.5),
        (BOX, (5, 1.0, 0), (-1, -0.0, -0.0), 4.5),
        (BOX, (5, -1.0, -1.5), (-1, -0.0, -0.0), 4.5),
        (BALL, (5, 2.0, 0), (-1, 0, 0), 5.0),
        (CAN, (5, 0, 2.0), (-1, 0, 0), 4.0),
        # misses: aside, behind, away, along the floor
        (BOX, (5, 1.0 + 1e-9, 0), (-1, 0, 0), math.inf),
        (BALL, (5, 2.0 + 1e-9, 0), (-1, 0, 0), math.inf),
        (CAN, (5, 0, 2.0 + 1e-9), (-1, 0, 0), math.inf),
        (CAN, (1.0 + 1e-9, 0, 9), (0, 0, -1), math.inf),
        (PILL, (0.9, 0, 9), (ROOT, 0, ROOT), math.inf),
        (EGG, (1.0 + 1e-9, 0, 9), (0, 0, -1), math.inf),
        (BOX, (5, 0, 0), (1, 0, 0), math.inf),
        (FLOOR, (0, 0, 2), (1, 0, 0), math.inf),
        (FLOOR, (0, 0, 2), (ROOT, 0, ROOT), math.inf),
    ]:
        with case(solid, start, direction, length):
            found = solid.first(np.array([start], dtype=float), np.array([direction], dtype=float))
            assert found == pytest.approx([length], abs=1e-12)


def test_a_point_is_as_far_away_as_by_hand(case):
    for solid, point, distance in [
        (BOX, (3.5, 0, 0), 3.0),
        (BOX, (3.5, 5, 1.5), 5.0),
        (BOX, (0.1, 0, 0), 0.0),
        (BALL, (0, 0, 5), 3.0),
        (CAN, (4, 0, 6), 5.0),
        (CAN, (0.5, 0, -3), 1.0),
        (PILL, (0, 3, 6), 4.0),
        (PILL, (0, 3, 1), 2.0),
        (EGG, (0, 5, 0), 3.0),
        (EGG, (0, 0, -7), 4.0),
        (EGG, (0.5, 0.5, 0.5), 0.0),
        (FLOOR, (9, 9, 2), 2.0),
        (FLOOR, (9, 9, -2), 0.0),
    ]:
        with case(solid, point, distance):
            assert solid.distance(np.array([point], dtype=float)) == pytest.approx(
                [distance], abs=1e-9
            )


SHAPES = [
    drake.Box(1.0, 2.0, 3.0),
    drake.Sphere(0.7),
    drake.Cylinder(0.5, 2.0),
    drake.Capsule(0.4, 1.5),
    drake.HalfSpace(),
]


@pytest.fixture(scope="module", params=SHAPES, ids=lambda shape: type(shape).__name__)
def judged(request):
    """A solid, rays towards it, their lengths, and Drake's signed distance of a point."""
    scene = drake.SceneGraph()
    source = scene.RegisterSource("test")
    geometry = drake.GeometryInstance(RigidTransform(), request.param, "solid")
    geometry.set_proximity_properties(drake.ProximityProperties())
    scene.RegisterAnchoredGeometry(source, geometry)
    context = scene.CreateDefaultContext()

    def signed(point: np.ndarray) -> float:
        query = scene.get_query_output_port().Eval(context)
        return query.ComputeSignedDistanceToPoint(point)[0].distance

    rng = np.random.default_rng(3)
    starts = 4.0 * rng.normal(size=(600, 3))
    ends = rng.normal(size=(600, 3))
    directions = (ends - starts) / np.linalg.norm(ends - starts, axis=1, keepdims=True)
    return solid_of(request.param), starts, directions, signed


def test_rays_end_on_drakes_surface_and_not_before(judged):
    solid, starts, directions, signed = judged
    lengths = solid.first(starts, directions)
    hits = np.flatnonzero(np.isfinite(lengths))
    assert len(hits) > 50
    for index in hits:
        side = math.copysign(1.0, signed(starts[index]))
        end = starts[index] + lengths[index] * directions[index]
        assert abs(signed(end)) < 1e-12
        for share in (0.25, 0.5, 0.9, 0.999):
            before = starts[index] + share * lengths[index] * directions[index]
            assert side * signed(before) > 0.0


def test_rays_that_miss_never_change_sides_for_drake(judged):
    solid, starts, directions, signed = judged
    for index in np.flatnonzero(np.isinf(solid.first(starts, directions)))[:60]:
        side = math.copysign(1.0, signed(starts[index]))
        for length in np.linspace(0.0, 20.0, 60):
            assert side * signed(starts[index] + length * directions[index]) > 0.0


def test_distances_are_drakes(judged):
    solid, starts, _, signed = judged
    expected = [max(0.0, signed(start)) for start in starts]
    assert solid.distance(starts) == pytest.approx(expected, abs=1e-12)


def test_rays_end_on_an_ellipsoid_and_the_nearest_point_is_square_to_it():
    egg = solid_of(drake.Ellipsoid(0.5, 1.0, 1.5))
    rng = np.random.default_rng(4)
    starts = 4.0 * rng.normal(size=(300, 3))
    directions = -starts / np.linalg.norm(starts, axis=1, keepdims=True)
    ends = starts + egg.first(starts, directions)[:, None] * directions
    level = np.sum((ends / [0.5, 1.0, 1.5]) ** 2, axis=1)
    assert level == pytest.approx(1.0, abs=1e-12)
    # Out along the normal from a point of the surface, that point stays the nearest.
    normals = ends / np.square([0.5, 1.0, 1.5])
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    for away in (1e-3, 0.7, 30.0):
        assert egg.distance(ends + away * normals) == pytest.approx(away, rel=1e-9)


@pytest.mark.parametrize(
    "solid", [BOX, BALL, CAN, PILL, EGG], ids=["box", "sphere", "cylinder", "capsule", "ellipsoid"]
)
def test_outlines_lie_on_the_surface_and_within_reach(solid):
    points = solid.outline
    assert np.linalg.norm(points, axis=1).max() == pytest.approx(solid.reach)
    assert solid.distance(points) == pytest.approx(0.0, abs=1e-12)
    assert solid.distance(1.01 * points).min() > 0.0


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
    crate = box((0.5, 1.0, 1.5))
    rng = np.random.default_rng(5)
    starts = 4.0 * rng.normal(size=(2000, 3))
    aims = rng.normal(size=(2000, 3))
    directions = (aims - starts) / np.linalg.norm(aims - starts, axis=1, keepdims=True)
    expected = crate.first(starts, directions)
    assert 200 < np.isfinite(expected).sum() < 1900
    for shape in (drake.Mesh(str(path), 2.0), drake.Convex(str(path), 2.0)):
        mesh = solid_of(shape)
        assert mesh.first(starts, directions) == pytest.approx(expected, abs=1e-7)
        outside = crate.distance(starts) > 0.0
        assert mesh.distance(starts[outside][:100]) == pytest.approx(
            crate.distance(starts[outside][:100]), abs=1e-7
        )
        assert mesh.reach == pytest.approx(crate.reach)


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
    found = solid_of(shape).outline
    apart = np.linalg.norm(found[:, None] - expected[None], axis=2)
    assert apart.min(axis=0) == pytest.approx(0.0, abs=1e-6)
    assert apart.min(axis=1) == pytest.approx(0.0, abs=1e-6)

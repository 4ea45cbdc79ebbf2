"""Seams, corners and outlines of meshes, where single precision decides otherwise than double."""

import numpy as np
import pytest
import trimesh
from pydrake.math import RigidTransform

from workbench.systems.casting.scene import WORLD_FRAME_NUMBER

pytestmark = pytest.mark.usefixtures("finder")


@pytest.fixture(scope="module")
def ball():
    """A convex mesh whose corners a file holds with all their digits."""
    mesh = trimesh.creation.icosphere(3, radius=2.0)
    mesh.vertices = mesh.vertices.round(4)
    return mesh


def seams(mesh, count=2000):
    """Return points on edges of a mesh, and all its corners."""
    random = np.random.default_rng(8)
    edges = mesh.edges_unique[random.integers(len(mesh.edges_unique), size=count)]
    share = random.uniform(0.0, 1.0, (count, 1))
    points = mesh.vertices[edges]
    return np.vstack([points[:, 0] + share * (points[:, 1] - points[:, 0]), mesh.vertices])


@pytest.mark.parametrize("place", [[0.0, 0.0, 0.0], [-300.0, 200.0, 100.0]])
def test_no_ray_slips_through_a_seam_from_inside(make_caster, stored, ball, place):
    caster = make_caster((stored(ball, "inside.obj"), RigidTransform(place), WORLD_FRAME_NUMBER))
    points = seams(ball)
    begin = np.array([0.3, -0.2, 0.1])
    away = np.linalg.norm(points - begin, axis=1)
    found = caster.cast(place + begin, (points - begin) / away[:, None], [], 10.0)
    np.testing.assert_allclose(found, away, atol=1e-9)


def test_no_ray_slips_through_a_seam_from_outside(alone, stored, ball):
    caster, begin = alone(stored(ball, "outside.obj")), np.array([20.0, -7.0, 15.0])
    points = seams(ball)
    # of a nearly round ball, what is well on the near side
    near = points[(points @ begin) > 0.2 * np.linalg.norm(begin) * 2.0]
    away = np.linalg.norm(near - begin, axis=1)
    found = caster.cast(begin, (near - begin) / away[:, None], [], 50.0)
    np.testing.assert_allclose(found, away, atol=1e-9)


def test_beside_a_seam_of_something_large_the_right_side_is_met(alone, stored):
    """Single precision takes the wrong triangle within some hundredths of a millimetre.

    Oracle: of all planes that a ray leaves a convex mesh by, the nearest.
    """
    ball = trimesh.creation.icosphere(2, radius=300.0)
    ball.vertices = ball.vertices.round(2)
    begin = np.array([12.3456789, -45.678912, 7.8912345])
    shift = np.random.default_rng(9).normal(scale=1e-5, size=(2162, 3))
    ends = seams(ball) + shift
    d = (ends - begin) / np.linalg.norm(ends - begin, axis=1)[:, None]
    normals = np.cross(*np.moveaxis(np.diff(ball.triangles, axis=1), 1, 0))
    depth = ((ball.triangles[:, 0] - begin) * normals).sum(axis=1)
    along = d @ normals.T
    expected = np.where(along > 0.0, depth / along, np.inf).min(axis=1)
    found = alone(stored(ball, "large.obj")).cast(begin, d, [], 1e3)
    np.testing.assert_allclose(found, expected, atol=1e-9)


OUTLINES = np.array([[1.0, 0.0], [-1.0, 0.0], [0.0, 1.0], [0.0, -1.0]])
"""Outwards from the four edges of a plate."""


def past(outwards, beyond, count=500):
    """Return where rays begin, and where they pass the top of an 800 m plate's edge by `beyond`."""
    sideways = np.array([-outwards[1], outwards[0]])
    begin = np.array([*(398.7654321 * outwards + 1.2345678 * sideways), 30.0123456])
    along = np.linspace(-20.0, 20.0, count)[:, None]
    level = (400.0 + beyond) * outwards + along * sideways
    return begin, np.column_stack([level, np.full(count, 0.25)])


@pytest.mark.parametrize("outwards", OUTLINES)
@pytest.mark.parametrize(("beyond", "expected"), [(1e-6, 0.0), (-1e-4, 1.0)])
def test_an_outline_ends_where_it_ends(alone, stored, outwards, beyond, expected):
    """Rays that pass a wide plate by a micrometre, where single precision cannot tell."""
    caster = alone(stored(trimesh.creation.box((800.0, 800.0, 0.5)), "plate.obj"))
    begin, ends = past(outwards, beyond)
    away = np.linalg.norm(ends - begin, axis=1)
    found = caster.cast(begin, (ends - begin) / away[:, None], [], 100.0)
    met = np.isfinite(found)
    assert met.mean() == expected
    np.testing.assert_allclose(found[met], away[met], atol=1e-9)


@pytest.mark.parametrize("outwards", OUTLINES)
def test_behind_what_is_not_met_after_all_the_next_is(alone, stored, outwards):
    """The rays above, with a larger plate a metre below: they go on to it."""
    plate = trimesh.creation.box((800.0, 800.0, 0.5))
    below = trimesh.creation.box((900.0, 900.0, 0.5))
    below.apply_translation([0.0, 0.0, -1.0])
    caster = alone(stored(trimesh.util.concatenate([plate, below]), "plates.obj"))
    begin, ends = past(outwards, 1e-6)
    d = (ends - begin) / np.linalg.norm(ends - begin, axis=1)[:, None]
    found = caster.cast(begin, d, [], 100.0)
    np.testing.assert_allclose(begin[2] + found * d[:, 2], -0.75, atol=1e-9)


def test_a_surface_at_the_very_end_of_the_range_is_met(alone, stored):
    caster = alone(stored(trimesh.creation.box((2.0, 2.0, 2.0)), "end.obj"))
    forward = np.array([[1.0, 0.0, 0.0]])
    random = np.random.default_rng(10)
    for away in random.uniform(1.0, 30.0, 200):
        begin = np.array([-1.0 - away, *random.uniform(-0.9, 0.9, 2)])
        assert caster.cast(begin, forward, [], away + 1e-9) == pytest.approx([away])
        assert caster.cast(begin, forward, [], away - 1e-9) == [np.inf]


def test_a_ray_within_a_face_meets_no_more_than_its_edge(alone, stored):
    """Along the top of a box, in its plane: a ray that can creep for ever must not."""
    caster = alone(stored(trimesh.creation.box((2.0, 2.0, 2.0)), "along.obj"))
    found = caster.cast(np.array([-5.0, 0.1, 1.0]), np.array([[1.0, 0.0, 0.0]]), [], 20.0)
    assert found[0] == pytest.approx(4.0) or found[0] == np.inf


def test_each_mesh_of_a_frame_is_met(make_caster, stored):
    cube = stored(trimesh.creation.box((1.0, 1.0, 1.0)), "cube.obj")
    ends = np.array([[5.0 + 3.0 * k, 4.0 * k, 0.0] for k in range(3)])
    caster = make_caster(*((cube, RigidTransform(end), 1) for end in ends), frames=1)
    away = np.linalg.norm(ends, axis=1)
    found = caster.cast(np.zeros(3), ends / away[:, None], [RigidTransform()], 50.0)
    np.testing.assert_allclose(found, away * (1.0 - 0.5 / ends[:, 0]), atol=1e-12)

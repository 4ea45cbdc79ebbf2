"""What is met first, from where, and how far away; expected values by hand."""

import math

import numpy as np
import pytest
import trimesh
from pydrake.common import MemoryFile
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    InMemoryMesh,
    Mesh,
    MeshcatCone,
    ReadObjToTriangleSurfaceMesh,
    Sphere,
)
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.systems.casting.caster import mesh_triangles
from workbench.systems.casting.scene import WORLD_FRAME_NUMBER

AXES = np.vstack([np.eye(3), -np.eye(3)])
FORWARD = np.array([[1.0, 0.0, 0.0]])
SOLIDS = {
    "box": (Box(2.0, 4.0, 6.0), (1.0, 2.0, 3.0)),
    "sphere": (Sphere(1.5), (1.5, 1.5, 1.5)),
    "cylinder": (Cylinder(1.5, 5.0), (1.5, 1.5, 2.5)),
    "capsule": (Capsule(1.5, 2.0), (1.5, 1.5, 2.5)),
    "ellipsoid": (Ellipsoid(1.0, 2.0, 3.0), (1.0, 2.0, 3.0)),
}
SCALES = [(1.0, 1.0, 1.0), (2.0, 0.5, -1.5)]


@pytest.fixture
def shapes(stored):
    """Return the solids above, and a box as a mesh and as a hull, with half their sizes."""
    box = trimesh.creation.box((2.0, 4.0, 6.0))
    return SOLIDS | {
        "mesh": (stored(box, "half.obj"), (1.0, 2.0, 3.0)),
        "hull": (stored(box, "half_hull.obj", Convex), (1.0, 2.0, 3.0)),
    }


@pytest.fixture
def pattern():
    """Directions of a scan of 16 layers and 120 columns."""
    azimuth, elevation = np.meshgrid(np.linspace(-3.1, 3.1, 120), np.linspace(-0.4, 0.4, 16))
    level = np.cos(elevation)
    rays = [level * np.cos(azimuth), level * np.sin(azimuth), np.sin(elevation)]
    return np.stack(rays, axis=2).reshape(-1, 3)


def crowd(random, count):
    """Return random shapes at random poses in a space of 30 m, over a ground."""
    parts = [(HalfSpace(), RigidTransform([0.0, 0.0, -6.0]), WORLD_FRAME_NUMBER)]
    kinds = list(SOLIDS.values())
    for number in range(count):
        turn = RollPitchYaw(*random.uniform(-3.0, 3.0, 3))
        X_WG = RigidTransform(turn, random.uniform(-15.0, 15.0, 3))
        parts.append((kinds[number % len(kinds)][0], X_WG, WORLD_FRAME_NUMBER))
    return parts


@pytest.mark.parametrize("name", [*SOLIDS, "mesh", "hull"])
def test_rays_along_the_axes_meet_the_faces(alone, shapes, name):
    shape, half = shapes[name]
    caster = alone(shape)
    for direction, size in zip(AXES, (*half, *half), strict=True):
        outside = caster.cast(-10.0 * direction, direction[None], [], 20.0)
        assert outside == pytest.approx([10.0 - size], abs=1e-12)
        away = caster.cast(10.0 * direction, direction[None], [], 20.0)
        assert away[0] == math.inf


@pytest.mark.parametrize("name", [*SOLIDS, "mesh", "hull"])
def test_a_ray_from_inside_meets_the_surface_where_it_leaves(alone, shapes, name):
    shape, half = shapes[name]
    caster, middle = alone(shape), np.array([0.2, 0.1, -0.3])
    found = caster.cast(middle, AXES, [], 20.0)
    if name in ("box", "mesh", "hull"):
        np.testing.assert_allclose(found, [*(half - middle), *(half + middle)], atol=1e-12)
    for direction, range in zip(AXES, found, strict=True):
        beyond = middle + (range + 2.0) * direction
        back = caster.cast(beyond, -direction[None], [], 20.0)
        assert back == pytest.approx([2.0], abs=1e-12)


def test_from_below_the_ground_only_its_surface_is_met(alone):
    found = alone(HalfSpace()).cast(np.array([0.0, 0.0, -2.0]), AXES, [], 20.0)
    np.testing.assert_array_equal(found, [math.inf, math.inf, 2.0] + 3 * [math.inf])


@pytest.mark.parametrize("shape", [shape for shape, _ in SOLIDS.values()])
def test_what_is_buried_is_not_met(make_caster, shape):
    buried = (shape, RigidTransform([0.0, 0.0, -3.2]), WORLD_FRAME_NUMBER)
    caster = make_caster(buried, (HalfSpace(), RigidTransform(), WORLD_FRAME_NUMBER))
    found = caster.cast(np.array([0.0, 0.0, 2.0]), -np.eye(3)[2:], [], 20.0)
    assert found == [2.0]


def test_range_ends_where_it_is_said_to(alone):
    caster, origin = alone(Sphere(1.0)), np.array([-5.0, 0.0, 0.0])
    assert caster.cast(origin, FORWARD, [], 4.0)[0] == 4.0
    assert caster.cast(origin, FORWARD, [], np.nextafter(4.0, 0.0))[0] == math.inf
    assert caster.cast(origin, FORWARD, [], math.inf)[0] == 4.0


@pytest.mark.parametrize("distance", [1.0, 30.0, 300.0])
@pytest.mark.parametrize("slope", [1e-1, 1e-3, 1e-5])
@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_a_ray_that_grazes_a_wide_floor(alone, stored, kind, distance, slope):
    """A floor of 600 m in one piece: single precision is 6 mm wrong at a slope of 1e-5."""
    floor = trimesh.creation.box((600.0, 600.0, 2.0)).subdivide()
    shape = Box(600.0, 600.0, 2.0) if kind == "box" else stored(floor, "floor.obj")
    down = np.array([math.cos(slope), 0.0, -math.sin(slope)])
    # beside the seams of its triangles
    origin = np.array([0.7, 13.3, 1.0]) - distance * down
    range = alone(shape).cast(origin, down[None], [], 1000.0)[0]
    assert range == pytest.approx(distance, abs=1e-8)


@pytest.mark.parametrize("short", [1e-9, -1e-9])
@pytest.mark.parametrize("name", SOLIDS)
def test_tangent_rays_at_a_hundred_metres_are_told_apart(alone, name, short):
    shape, half = SOLIDS[name]
    origin = np.array([-100.0, half[1] - short, 0.1 if name == "box" else 0.0])
    met = math.isfinite(alone(shape).cast(origin, FORWARD, [], 200.0)[0])
    assert met is (short > 0.0)


def test_the_nearest_of_many_is_met(make_caster, pattern):
    """What a ray has met rules out what is behind it; with each shape alone nothing does."""
    parts = crowd(np.random.default_rng(1), 60)
    singles = [make_caster(part) for part in parts]
    caster = make_caster(*parts)
    for origin in np.random.default_rng(2).uniform(-10.0, 10.0, (5, 3)):
        found = caster.cast(origin, pattern, [], 25.0)
        each = np.array([single.cast(origin, pattern, [], 25.0) for single in singles])
        np.testing.assert_array_equal(found, each.min(axis=0))
        assert len(np.unique(each.argmin(axis=0))) > 10


def test_neighbours_do_not_matter(make_caster, pattern):
    """A ray gives the same alone, among neighbours, and among rays to everywhere."""
    caster = make_caster(*crowd(np.random.default_rng(3), 60))
    origin = np.array([1.0, 2.0, 0.5])
    found = caster.cast(origin, pattern, [], 25.0)
    order = np.random.default_rng(5).permutation(len(pattern))
    np.testing.assert_array_equal(caster.cast(origin, pattern[order], [], 25.0), found[order])
    single = [caster.cast(origin, ray[None], [], 25.0)[0] for ray in pattern[::37]]
    np.testing.assert_array_equal(single, found[::37])


@pytest.mark.parametrize("kind", ["box", "mesh"])
def test_what_moves_is_met_at_its_pose_of_the_cast(make_caster, stored, kind):
    box = stored(trimesh.creation.box((2.0, 2.0, 2.0)), "cube.obj")
    shape = Box(2.0, 2.0, 2.0) if kind == "box" else box
    in_front = RigidTransform([0.0, 3.0, 0.0])
    caster = make_caster(
        (shape, in_front, 1),
        (Sphere(1.0), RigidTransform([50.0, 0.0, 0.0]), WORLD_FRAME_NUMBER),
        frames=1,
    )
    quarter = RollPitchYaw(0.0, 0.0, -math.pi / 2)  # takes the box from y to x
    for away in (0.0, 10.0, 30.0):
        poses = [RigidTransform(quarter, [away, 0.0, 0.0])]
        found = caster.cast(np.zeros(3), FORWARD, poses, 100.0)
        assert found == pytest.approx([away + 2.0], abs=1e-12)
    aside = [RigidTransform([0.0, 10.0, 0.0])]
    found = caster.cast(np.zeros(3), FORWARD, aside, 100.0)
    assert found == [49.0]


def test_an_empty_scene_returns_nothing(make_caster):
    found = make_caster().cast(np.zeros(3), AXES, [], 10.0)
    assert not np.isfinite(found).any()


def test_a_shape_without_triangles_is_refused_by_name(make_caster):
    with pytest.raises(WorkbenchError, match="geometry 0.*MeshcatCone"):
        make_caster((MeshcatCone(1.0, 1.0, 1.0), RigidTransform(), WORLD_FRAME_NUMBER))


def test_casting_leaves_no_trace(make_caster, stored, pattern):
    """Two casts from one place are equal to the bit, whatever came between."""
    ball = stored(trimesh.creation.icosphere(3), "ball.obj")
    parts = [(ball, RigidTransform([3.0 * k, 5.0, 0.3 * k]), WORLD_FRAME_NUMBER) for k in range(4)]
    caster = make_caster(*parts, *crowd(np.random.default_rng(6), 20))
    before = caster.cast(np.zeros(3), pattern, [], 25.0)
    caster.cast(np.array([4.0, -3.0, 1.0]), pattern, [], 9.0)
    after = caster.cast(np.zeros(3), pattern, [], 25.0)
    np.testing.assert_array_equal(before, after)


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

"""Rays against each kind of shape at ten thousand random poses of shape and sensor.

Oracle of solids: a convex function of place that is 1 on the surface, whose least value along a
ray says whether that meets it, and bisection where. Oracle of meshes: every triangle, by the signs
of the volumes that the ray spans with its edges.
"""

import numpy as np
import pytest
import trimesh
from pydrake.common.eigen_geometry import Quaternion
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    HalfSpace,
    Mesh,
    Sphere,
)
from pydrake.math import RigidTransform

POSES, RAYS = 10_000, 2
REACH = 30.0


def norm(p):
    return np.sqrt(np.einsum("...i,...i", p, p))


def largest(p):
    x, y, z = np.moveaxis(np.abs(p), -1, 0)
    return np.maximum(np.maximum(x, y), z)


def tube(p, radius):
    return np.hypot(p[..., 0], p[..., 1]) / radius


def in_capsule(p):
    """Return the distance from the capsule's axis over its radius."""
    from_end = np.maximum(np.abs(p[..., 2]) - 0.6, 0.0)
    return np.sqrt(p[..., 0] ** 2 + p[..., 1] ** 2 + from_end**2) / 0.3


SOLIDS = {
    "box": (Box(0.4, 1.0, 2.0), lambda p: largest(p / [0.2, 0.5, 1.0]), 1.2),
    "plate": (Box(0.01, 3.0, 3.0), lambda p: largest(p / [0.005, 1.5, 1.5]), 2.2),
    "sphere": (Sphere(0.7), lambda p: norm(p) / 0.7, 0.7),
    "cylinder": (
        Cylinder(0.3, 1.5),
        lambda p: np.maximum(tube(p, 0.3), np.abs(p[..., 2]) / 0.75),
        0.9,
    ),
    "wire": (
        Cylinder(0.01, 4.0),
        lambda p: np.maximum(tube(p, 0.01), np.abs(p[..., 2]) / 2.0),
        0.05,
    ),
    "capsule": (Capsule(0.3, 1.2), in_capsule, 0.9),
    "ellipsoid": (Ellipsoid(0.2, 0.5, 1.1), lambda p: norm(p / [0.2, 0.5, 1.1]), 1.1),
    "half-space": (HalfSpace(), lambda p: 1.0 + p[..., 2], 8.0),
}
"""Shape, function that is 1 on its surface and less inside, and how far around it rays aim [m]."""


@pytest.fixture(scope="module")
def rays():
    """Poses of shape and sensor in W, and a factory of rays that aim around the shape."""
    random = np.random.default_rng(4)
    q = random.normal(size=(POSES, 4))
    quaternions = q / np.linalg.norm(q, axis=1, keepdims=True)
    p_WG = random.uniform(-200.0, 200.0, (POSES, 3))
    away = random.normal(size=(POSES, 3))
    away /= np.linalg.norm(away, axis=1, keepdims=True)
    # some near, some inside, all within reach
    p_WS = p_WG + away * (REACH - 3.0) * random.uniform(0.0, 1.0, (POSES, 1)) ** 2
    aims = random.uniform(-1.0, 1.0, (POSES, RAYS, 3))
    poses = [RigidTransform(Quaternion(q), p) for q, p in zip(quaternions, p_WG, strict=True)]
    return poses, p_WS, aims


def cast_all(caster, poses, p_WS, directions, max_range):
    """Return ranges (POSES, RAYS), a cast for each pose."""
    each = zip(poses, p_WS, directions, strict=True)
    return np.array([caster.cast(p, d, [X], max_range) for X, p, d in each])


def aimed(rays, around):
    """Return directions in W (POSES, RAYS, 3), and rays in the shape's frame."""
    poses, p_WS, aims = rays
    R_WG = np.array([X.rotation().matrix() for X in poses])
    p_WG = np.array([X.translation() for X in poses])
    directions = p_WG[:, None] + around * aims - p_WS[:, None]
    directions /= norm(directions)[..., None]
    p_GS = np.einsum("nij,ni->nj", R_WG, p_WS - p_WG)
    return directions, p_GS[:, None], np.einsum("nij,nki->nkj", R_WG, directions)


def lowest(function, o, d, low, high):
    """Return where along rays a convex function is least, by golden section."""
    share = 0.5 * (np.sqrt(5.0) - 1.0)
    a, b = np.full(d.shape[:2], low), np.full(d.shape[:2], high)
    for _ in range(65):
        left, right = b - share * (b - a), a + share * (b - a)
        lower = function(o + left[..., None] * d) < function(o + right[..., None] * d)
        a, b = np.where(lower, a, left), np.where(lower, right, b)
    return 0.5 * (a + b)


def crossing(function, o, d, outside, inside):
    """Return where a function is 1 between points outside and inside, by bisection."""
    for _ in range(50):
        middle = 0.5 * (outside + inside)
        within = function(o + middle[..., None] * d) <= 1.0
        outside, inside = np.where(within, outside, middle), np.where(within, middle, inside)
    return 0.5 * (outside + inside)


def first_met(function, o, d):
    """Return the ranges that a perfect instrument shows, and the least value along each ray."""
    begins_inside = np.broadcast_to(function(o) <= 1.0, d.shape[:2])
    zero, far = np.zeros(d.shape[:2]), np.full(d.shape[:2], REACH)
    least = lowest(function, o, d, 0.0, REACH)
    value = function(o + least[..., None] * d)
    entry = crossing(function, o, d, zero, least)
    leaves = begins_inside & (function(o + far[..., None] * d) > 1.0)
    exit = crossing(function, o, d, far, zero)
    ranges = np.where(~begins_inside & (value <= 1.0), entry, np.inf)
    return np.where(leaves, exit, ranges), value


@pytest.mark.parametrize(
    "name",
    [
        name if name in ("plate", "cylinder") else pytest.param(name, marks=pytest.mark.slow)
        for name in SOLIDS
    ],
)
def test_every_true_hit_is_found_and_no_other(make_caster, rays, name):
    shape, function, around = SOLIDS[name]
    directions, o, d = aimed(rays, around)
    caster = make_caster((shape, RigidTransform(), 1), frames=1)
    ranges = cast_all(caster, rays[0], rays[1], directions, REACH)
    expected, _ = first_met(function, o, d)
    met = np.isfinite(expected)
    assert 0.02 < met.mean() < 0.98
    np.testing.assert_array_equal(np.isfinite(ranges), met)
    assert np.abs(ranges[met] - expected[met]).max() < 1e-10


def triangles_met(triangles, o, d):
    """Return how far rays (n, 3) go to the first of all triangles (m, 3, 3), inf at a miss."""
    corners = [triangles[:, corner] for corner in range(3)]
    moment = np.cross(o, d)
    volumes = [
        d @ np.cross(p, q).T + moment @ (q - p).T
        for p, q in zip(corners, corners[1:] + corners[:1], strict=True)
    ]
    low, high = np.minimum.reduce(volumes), np.maximum.reduce(volumes)
    normal = np.cross(corners[1] - corners[0], corners[2] - corners[0])
    with np.errstate(divide="ignore", invalid="ignore"):
        distance = ((corners[0] * normal).sum(axis=1) - o @ normal.T) / (d @ normal.T)
    met = ((low >= 0.0) | (high <= 0.0)) & (distance >= 0.0)
    return np.where(met, distance, np.inf).min(axis=1)


@pytest.mark.parametrize("kind", [Mesh, pytest.param(Convex, marks=pytest.mark.slow)])
@pytest.mark.usefixtures("finder")
def test_every_true_hit_on_a_mesh_is_found_and_no_other(make_caster, stored, rays, kind):
    mesh = trimesh.creation.torus(0.7, 0.25, major_sections=7, minor_sections=5)
    mesh.vertices = mesh.vertices.round(3)  # all digits that the file has
    shape = stored(mesh, f"torus_{kind.__name__}.obj", kind)
    triangles = mesh.convex_hull.triangles if kind is Convex else mesh.triangles
    directions, o, d = aimed(rays, 0.9)
    caster = make_caster((shape, RigidTransform(), 1), frames=1)
    ranges = cast_all(caster, rays[0], rays[1], directions, REACH)
    o = np.broadcast_to(o, d.shape).reshape(-1, 3)
    expected = triangles_met(triangles, o, d.reshape(-1, 3)).reshape(POSES, RAYS)
    met = np.isfinite(expected)
    assert 0.02 < met.mean() < 0.98
    np.testing.assert_array_equal(np.isfinite(ranges), met)
    assert np.abs(ranges[met] - expected[met]).max() < 1e-10

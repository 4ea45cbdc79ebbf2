"""Lowest points by hand: shapes turned, lifted, and a mesh."""

import math
from pathlib import Path

import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.plant.loading import ground_clearance
from workbench.plant.model import Link, LinkShape, Model
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Sphere

S = math.sqrt(0.5)
EIGHTH = math.pi / 4.0
HULL = "v 0 0 0.1\nv 1 0 0.5\nv 0 1 0.5\nf 1 2 3\n"


def clearance(shape, roll=0.0, height=0.0, X_ML=None):
    X_LS = RigidTransform(RollPitchYaw(roll, 0.0, 0.0), [0.3, 0.2, height])
    link = Link("base", X_ML or RigidTransform(), None, (), (LinkShape("c", X_LS, shape),))
    return ground_clearance(Model(Path("m"), "m", (link,), (), (), (), ()), "base")


@pytest.mark.parametrize(
    ("shape", "roll", "depth"),
    [
        (Box((1.0, 0.4, 0.2)), 0.0, 0.1),
        (Box((1.0, 0.4, 0.2)), EIGHTH, S * 0.3),
        (Sphere(0.2), EIGHTH, 0.2),
        (Cylinder(0.1, 0.6), 0.0, 0.3),
        (Cylinder(0.1, 0.6), math.pi / 2.0, 0.1),
        (Cylinder(0.1, 0.6), EIGHTH, S * 0.4),
        (Capsule(0.1, 0.6), EIGHTH, 0.1 + S * 0.3),
        (Ellipsoid((1.0, 0.3, 0.4)), math.pi / 2.0, 0.3),
    ],
)
@pytest.mark.parametrize("height", [0.0, -0.5])
def test_the_lowest_point_counts(shape, roll, depth, height):
    assert clearance(shape, roll, height) == pytest.approx(depth - height)


def test_of_a_mesh_the_lowest_corner_counts(tmp_path):
    path = tmp_path / "hull.obj"
    path.write_text(HULL)
    assert clearance(Mesh("hull.obj", path)) == pytest.approx(-0.1)
    assert clearance(Mesh("hull.obj", path), math.pi) == pytest.approx(0.5)


def test_the_base_links_own_pose_does_not_matter():
    X_ML = RigidTransform(RollPitchYaw(0.0, 0.0, 1.0), [1.0, 2.0, 3.0])
    assert clearance(Sphere(0.2), X_ML=X_ML) == pytest.approx(0.2)

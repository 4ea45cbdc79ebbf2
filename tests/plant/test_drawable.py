"""Simple shapes where meshes are missing; sizes by hand."""

import pytest
from pydrake.math import RigidTransform

from workbench.plant.drawable import (
    inertia_box,
    rotor_disc_radius,
    substitute_shapes,
    with_bumper,
    without_missing_meshes,
)
from workbench.plant.model import Inertial, Link, LinkShape
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Box, Cylinder, Mesh, Sphere

HERE = RigidTransform()


def link(inertial=None, collisions=(), name="base") -> Link:
    return Link(name, HERE, inertial, (), collisions)


def rotors(*places: tuple[float, float]) -> list[Rotor]:
    return [
        Rotor(f"r{i}", f"r{i}", f"r{i}", (x, y, 0.0), (0.0, 0.0, 1.0), 1, 1e-5, 0.02, 0.02, 0.02, 1)
        for i, (x, y) in enumerate(places)
    ]


def test_the_box_of_an_inertia_has_its_moments():
    """m (y² + z²)/12 and so on, of 2 kg and 0.3 x 0.2 x 0.1 m."""
    x, y, z = 0.3, 0.2, 0.1
    moments = tuple(2.0 * sides / 12.0 for sides in (y**2 + z**2, x**2 + z**2, x**2 + y**2))
    box = inertia_box(Inertial(2.0, HERE, moments, (0.0, 0.0, 0.0)))
    assert box.size == pytest.approx((x, y, z))


@pytest.mark.parametrize(("moment", "side"), [(0.0, 0.02), (100.0, 0.6)])
def test_its_sides_stay_within_what_a_drone_measures(moment, side):
    box = inertia_box(Inertial(1.0, HERE, (moment,) * 3, (0.0, 0.0, 0.0)))
    assert box.size == pytest.approx((side,) * 3)


def test_discs_of_neighbours_keep_apart():
    """0.45 of 0.4 m; a rotor right below does not count."""
    square = rotors((0.2, 0.2), (-0.2, 0.2), (-0.2, -0.2), (0.2, -0.2), (0.2, 0.2))
    assert rotor_disc_radius("r0", square) == pytest.approx(0.18)
    assert rotor_disc_radius("base", square) == 0.0


def test_a_link_is_drawn_by_what_touches_else_a_disc_else_its_inertia():
    touching = (LinkShape("c", HERE, Sphere(0.1)), LinkShape("m", HERE, Mesh("a.stl", None)))
    inertial = Inertial(1.0, HERE, (0.01, 0.01, 0.01), (0.0, 0.0, 0.0))
    square = rotors((0.2, 0.0), (-0.2, 0.0))
    assert [shape for _, shape in substitute_shapes(link(inertial, touching), square)] == [
        Sphere(0.1)
    ]
    (disc,) = substitute_shapes(link(inertial, name="r0"), square)
    assert disc[1] == Cylinder(pytest.approx(0.18), 0.004)
    (box,) = substitute_shapes(link(inertial), square)
    assert isinstance(box[1], Box)
    assert len(substitute_shapes(link(), square)) == 1


def test_only_missing_meshes_are_replaced():
    kept = LinkShape("kept", HERE, Sphere(1.0), None)
    missing = [LinkShape(name, HERE, Mesh("a.stl", None), None) for name in "ab"]
    visuals = without_missing_meshes([kept, *missing], [(HERE, Sphere(0.1))])
    assert [visual.shape for visual in visuals] == [Sphere(1.0), Sphere(0.1)]


def test_a_bumper_is_as_wide_as_the_rotors_are_apart():
    base = with_bumper(link(), rotors((0.2, 0.1), (-0.2, -0.1)))
    assert base.collisions[0].shape == Box((0.4, 0.2, pytest.approx(0.04)))

"""Farthest points by hand, and by points drawn on shapes."""

import math

import numpy as np
import pytest
import trimesh
from pydrake.math import RigidTransform, RollPitchYaw, RotationMatrix

from tests.jointed import drone, joint, link
from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.loading import load_vehicle
from workbench.plant.meshes.gltf import write_gltf
from workbench.plant.meshes.parts import MeshPart
from workbench.plant.model import Link, LinkShape, Model
from workbench.plant.reach import ReachSphere, reach_sphere
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Sphere

X_ODD = RigidTransform(RollPitchYaw(0.4, -0.3, 1.0), [0.3, -0.2, 0.1])
HUB = (0.5, 0.0, 0.2)


def model_of(*links: Link) -> Model:
    return Model("here", "m", tuple(links), (), (), (), ())


def body(shape, X_LS=X_ODD, X_ML=None) -> Link:
    pose = X_ML or RigidTransform()
    return Link("base", pose, None, (), (LinkShape("c", X_LS, shape),))


def rotor(link: str, hub=HUB, axis=(0.0, 0.0, 1.0)) -> Rotor:
    return Rotor("r", "j", link, hub, axis, 1, 1e-5, 0.02, 0.01, 0.02, 1000.0)


@pytest.mark.parametrize(
    ("shape", "radius"),
    [
        (Box((0.6, 0.4, 0.2)), 0.5 * math.sqrt(0.36 + 0.16 + 0.04)),
        (Sphere(0.2), 0.2),
        (Cylinder(0.3, 0.8), 0.5),
        (Capsule(0.1, 0.6), 0.4),
        (Ellipsoid((0.1, 0.3, 0.2)), 0.3),
    ],
)
def test_a_shape_alone_is_held_about_its_own_middle(shape, radius):
    found = reach_sphere(model_of(body(shape)), "base", ())
    assert found.p_BC == pytest.approx(X_ODD.translation(), abs=1e-3)
    assert radius <= found.radius + 1e-12
    assert found.radius == pytest.approx(radius, rel=2e-3)


def test_all_that_touches_and_all_that_is_drawn_counts():
    far = RigidTransform([2.0, 0.0, 0.0])
    drawn = LinkShape("v", far, Sphere(0.1), None)
    link = Link(
        "base", RigidTransform(), None, (drawn,), (LinkShape("c", RigidTransform(), Sphere(0.3)),)
    )
    assert reach_sphere(model_of(link), "base", ()) == ReachSphere(
        (pytest.approx(0.9), 0.0, 0.0), pytest.approx(1.2)
    )


def test_places_are_those_in_the_body_frame():
    X_ML = RigidTransform(RollPitchYaw(0.0, 0.0, 2.0), [1.0, 2.0, 3.0])
    plain = reach_sphere(model_of(body(Box((0.6, 0.4, 0.2)))), "base", ())
    moved = reach_sphere(model_of(body(Box((0.6, 0.4, 0.2)), X_ML=X_ML)), "base", ())
    assert moved.p_BC == pytest.approx(plain.p_BC)
    assert moved.radius == pytest.approx(plain.radius)


@pytest.mark.parametrize("angle", [0.0, 0.7, 1.5, 3.0])
def test_a_blade_counts_with_all_places_it_comes_to(angle):
    """A tip comes as far from the middle as the hub is, and the blade's length beyond."""
    blade = LinkShape("b", RigidTransform([0.05, 0.0, 0.0]), Box((0.1, 1e-6, 1e-6)), None)
    turned = RotationMatrix.MakeZRotation(angle)
    links = [Link("base", RigidTransform(), None, (), ())]
    links += [
        Link(name, RigidTransform(turned, hub), None, (blade,), ())
        for name, hub in (("one", [0.5, 0.0, 0.2]), ("other", [-0.5, 0.0, 0.2]))
    ]
    rotors = [rotor("one"), rotor("other", (-0.5, 0.0, 0.2))]
    found = reach_sphere(model_of(*links), "base", rotors)
    hubs = [math.hypot(x - found.p_BC[0], found.p_BC[1]) for x in (0.5, -0.5)]
    assert found.radius == pytest.approx(max(hubs) + 0.1, abs=1e-5)


def test_a_sphere_holds_every_place_of_a_leaning_blade():
    """Oracle: the blade's corners, turned about the axis by rotations of pydrake.math."""
    axis = np.array([0.3, -0.2, 0.9]) / np.linalg.norm([0.3, -0.2, 0.9])
    shape = Box((0.4, 0.05, 0.02))
    X_BL = RigidTransform(RollPitchYaw(0.2, 0.1, 0.3), np.array(HUB))
    links = (
        body(Box((0.3, 0.3, 0.1))),
        Link("prop", X_BL, None, (LinkShape("b", RigidTransform([0.2, 0, 0]), shape, None),), ()),
    )
    found = reach_sphere(model_of(*links), "base", [rotor("prop", axis=tuple(axis))])
    corners = [
        X_BL @ np.array([0.2 + 0.2 * i, 0.025 * j, 0.01 * k])
        for i in (-1, 1)
        for j in (-1, 1)
        for k in (-1, 1)
    ]
    far = 0.0
    for angle in np.linspace(0.0, 2.0 * math.pi, 721):
        s, cross = (
            math.sin(angle),
            np.array([[0, -axis[2], axis[1]], [axis[2], 0, -axis[0]], [-axis[1], axis[0], 0]]),
        )
        turn = np.eye(3) + s * cross + (1.0 - math.cos(angle)) * cross @ cross
        for corner in corners:
            place = np.array(HUB) + turn @ (corner - HUB)
            far = max(far, float(np.linalg.norm(place - found.p_BC)))
    assert far <= found.radius + 1e-9
    assert found.radius == pytest.approx(far, rel=1e-4)


def test_a_drawn_mesh_counts_as_drake_places_it(tmp_path):
    """Written with z up, 1 m long along z."""
    box = trimesh.creation.box(extents=[0.1, 0.2, 1.0])
    part = MeshPart((), np.array(box.vertices), np.array(box.faces))
    path = tmp_path / "mast.gltf"
    path.write_bytes(write_gltf([part], None))
    link = Link(
        "base",
        RigidTransform(),
        None,
        (LinkShape("v", RigidTransform([0, 0, 0.5]), Mesh("m", path), None),),
        (LinkShape("c", RigidTransform(), Sphere(0.1)),),
    )
    found = reach_sphere(model_of(link), "base", ())
    assert found.p_BC == pytest.approx((0.0, 0.0, 0.45), abs=1e-6)
    assert found.radius == pytest.approx(math.hypot(0.05, 0.1, 0.55), abs=1e-6)


def test_a_mesh_that_is_not_there_does_not_count():
    link = Link(
        "base",
        RigidTransform(),
        None,
        (LinkShape("v", X_ODD, Mesh("gone", None), None),),
        (LinkShape("c", RigidTransform(), Sphere(0.1)),),
    )
    assert reach_sphere(model_of(link), "base", ()).radius == pytest.approx(0.1)


def test_hubs_count_where_propellers_have_no_shape():
    found = reach_sphere(model_of(body(Sphere(0.1), RigidTransform())), "base", [rotor("base")])
    assert found.p_BC[0] == pytest.approx(0.2)
    assert found.radius == pytest.approx(math.hypot(0.3, 0.2 - found.p_BC[2]))


def test_the_shipped_drone_reaches_to_its_blades_tips():
    description = read_description(find_model("dh_drone"))
    found = reach_sphere(description.model, description.base_link, description.rotors)
    tips = 0.25 + 0.127  # arm and blade, from its constants
    height = load_vehicle(find_model("dh_drone")).rotors[0].p_BR[2]
    level = math.hypot(tips, height - found.p_BC[2])
    assert level <= found.radius < level + 0.005
    assert found.p_BC[:2] == pytest.approx((0.0, 0.0), abs=1e-9)


@pytest.mark.parametrize("limits", [(-0.7, 0.2), (-0.2, 0.7)])
def test_a_load_that_slides_is_held_at_either_end_of_its_way(tmp_path, limits):
    """A ball on a slider at the middle of the drone: its radius, and the longer way."""
    ball = link("ball", 0.1, shape='<sphere radius="0.1"/>')
    limit = '<limit lower="{}" upper="{}" effort="-1" velocity="-1"/>'.format(*limits)
    slider = joint("slide", "prismatic", "base", "ball", (0, 0, 0), (0, 0, 1), limit)
    model = read_description(drone(tmp_path, ball + slider)).model
    assert reach_sphere(model, "base", ()).radius == pytest.approx(0.1 + 0.7, abs=1e-6)

"""Oracle: geometry by hand. A rotor's link pushes along its z, its joint turns about its axis."""

import math

import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.mount import body_pose, mount_on_joint

HALF = math.sqrt(0.5)


@pytest.fixture
def mount(model, link, joint):
    """Mount a rotor link, whose pose in the body is given, on a joint."""

    def make(xyz=(0.1, 0.2, 0.3), rpy=(0.0, 0.0, 0.0), remarks=None, mass=None, com=None, **parts):
        X_MB = model().link("base").X_ML
        rotor = link("rotor", X_MB @ RigidTransform(RollPitchYaw(rpy), xyz), mass, com or (0, 0, 0))
        spin = joint("spin", rotor, **parts)
        quad = model(links=[rotor], joints=[spin])
        return mount_on_joint(quad, "base", spin, rotor, quad.source, remarks or Remarks())

    return make


def test_an_upright_joint_gives_place_and_axis_and_no_remark(mount):
    remarks = Remarks()
    found = mount(remarks=remarks)
    assert found.p_BR == pytest.approx((0.1, 0.2, 0.3))
    assert found.axis_B == pytest.approx((0.0, 0.0, 1.0))
    assert found.sense == 1
    assert remarks.found == []


def test_a_tilted_link_tilts_the_thrust(mount):
    remarks = Remarks()
    found = mount(rpy=(math.pi / 4.0, 0.0, 0.0), remarks=remarks)
    assert found.axis_B == pytest.approx((0.0, -HALF, HALF))
    assert found.sense == 1
    assert remarks.found == []


def test_an_axis_downwards_pushes_up_and_turns_reversed(mount):
    remarks = Remarks()
    found = mount(axis=(0.0, 0.0, -1.0), remarks=remarks)
    assert found.axis_B == pytest.approx((0.0, 0.0, 1.0))
    assert found.sense == -1
    (remark,) = remarks.found
    assert (remark.kind, remark.element) == ("repaired", "joint 'spin'")


def test_a_link_upside_down_pushes_down(mount):
    found = mount(rpy=(math.pi, 0.0, 0.0))
    assert found.axis_B == pytest.approx((0.0, 0.0, -1.0))
    assert found.sense == 1


@pytest.mark.parametrize(
    ("axis", "thrust", "sense"),
    [((HALF, 0.0, HALF), (HALF, 0.0, HALF), 1), ((HALF, 0.0, -HALF), (-HALF, 0.0, HALF), -1)],
)
def test_thrust_is_along_a_joint_that_is_tilted_itself(mount, axis, thrust, sense):
    remarks = Remarks()
    found = mount(axis=axis, remarks=remarks)
    assert found.axis_B == pytest.approx(thrust)
    assert found.sense == sense
    assert "45°" in remarks.found[-1].text


def test_an_axis_across_the_links_z_gives_way_to_it(mount):
    """As the x of a URDF's joint without an axis."""
    found = mount(axis=(1.0, 0.0, 0.0))
    assert found.axis_B == pytest.approx((0.0, 0.0, 1.0))
    assert found.sense == 1


def test_a_link_that_leans_pushes_along_its_own_z(mount):
    """A roll of 0.3 leans link z; the joint's axis is turned back to the body's z."""
    back = (0.0, math.sin(0.3), math.cos(0.3))
    found = mount(rpy=(0.3, 0.0, 0.0), axis=back)
    assert found.axis_B == pytest.approx((0.0, -math.sin(0.3), math.cos(0.3)))


def test_the_hub_is_the_joints_origin(mount, model):
    X_MB = model().link("base").X_ML
    found = mount(X_MJ=X_MB @ RigidTransform([0.5, 0.0, 0.0]), mass=0.1, com=(1.0, 1.0, 1.0))
    assert found.p_BR == pytest.approx((0.5, 0.0, 0.0))


@pytest.mark.parametrize(
    ("mass", "hub"),
    [(None, (0.1, 0.2, 0.3)), (0.0, (0.1, 0.2 - 0.07, 0.3)), (0.1, (0.1, 0.13, 0.3))],
)
def test_on_a_fixed_joint_the_hub_is_the_links_centre_of_mass(mount, mass, hub):
    found = mount(
        rpy=(math.pi / 2.0, 0.0, 0.0),
        kind="fixed",
        axis=(1.0, 0.0, 0.0),
        mass=mass,
        com=(0.0, 0.0, 0.07),
    )
    assert found.p_BR == pytest.approx(hub)
    assert found.axis_B == pytest.approx((0.0, -1.0, 0.0), abs=1e-12)


def test_a_base_link_that_is_not_there_is_refused(model):
    with pytest.raises(WorkbenchError, match="no link 'body'"):
        body_pose(model(), "body")

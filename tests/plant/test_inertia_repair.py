"""Oracle: Drake's own test of what a body can have, and hand calculation."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import RotationalInertia

from workbench.common.errors import WorkbenchError
from workbench.plant.model import Inertial, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.repaired_inertia import repair_inertias, with_stated_body

SOURCE = Path("drone.urdf")


def repaired(mass, moments, products=(0.0, 0.0, 0.0), X_LI=None):
    """Return the inertial and the remarks that come of one."""
    inertial = Inertial(mass, X_LI or RigidTransform(), moments, products)
    link = Link("base", RigidTransform(), inertial, (), ())
    remarks = Remarks()
    model = Model(SOURCE, "drone", (link,), (), (), (), ())
    return repair_inertias(model, remarks).links[0].inertial, remarks.found


def matrix_in_L(inertial) -> np.ndarray:
    xx, yy, zz = inertial.moments
    xy, xz, yz = inertial.products
    R = inertial.X_LI.rotation().matrix()
    return R @ np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]]) @ R.T


@pytest.mark.parametrize(
    ("moments", "products"),
    [
        ((0.01, 0.02, 0.025), (0.0, 0.0, 0.0)),
        ((1.0, 1.0, 2.0), (0.0, 0.0, 0.0)),  # a flat plate
        ((0.0, 1e-5, 1e-5), (0.0, 0.0, 0.0)),  # a rod
        ((0.02, 0.02, 0.03), (0.001, -0.002, 0.003)),
    ],
)
def test_what_a_body_can_have_stays_without_a_remark(moments, products):
    inertial, remarks = repaired(1.0, moments, products)
    assert (inertial.moments, inertial.products) == (moments, products)
    assert not remarks


def test_a_link_without_mass_becomes_a_frame():
    inertial, remarks = repaired(0.0, (0.0, 0.0, 0.0))
    assert inertial is None
    assert [remark.kind for remark in remarks] == ["repaired"]
    assert "mass is 0" in str(remarks[0])


def test_the_largest_moment_is_lowered_to_the_sum_of_the_others():
    inertial, remarks = repaired(1.0, (1.0, 10.0, 2.0))
    assert np.diag(matrix_in_L(inertial)) == pytest.approx([1.0, 3.0, 2.0])
    assert "1, 2, 10" in remarks[0].text
    assert "taken as 3" in remarks[0].text


@pytest.mark.parametrize("excess", [1e-14, 1e-10, 5e-7])
def test_a_plate_written_with_few_digits_stays_one_without_a_remark(excess):
    """Drake would take another inertia for it, of a size that has nothing to do with it."""
    inertial, remarks = repaired(1.0, (0.01, 0.02 * (1.0 + excess), 0.01))
    assert not remarks
    assert np.diag(matrix_in_L(inertial)) == pytest.approx([0.01, 0.02, 0.01], rel=1e-6)
    xx, yy, zz = inertial.moments
    assert RotationalInertia(xx, yy, zz, *inertial.products).CouldBePhysicallyValid()


def test_the_lowered_inertia_keeps_its_axes_and_drake_takes_it():
    X_LI = RigidTransform(RollPitchYaw(0.3, -0.2, 0.9), [1.0, 2.0, 3.0])
    products = (0.01, 0.02, -0.015)
    inertial, _ = repaired(2.0, (0.1, 0.3, 0.05), products, X_LI)
    before = matrix_in_L(Inertial(2.0, X_LI, (0.1, 0.3, 0.05), products))
    after = matrix_in_L(inertial)
    assert after @ before == pytest.approx(before @ after)  # same axes commute
    xx, yy, zz = inertial.moments
    assert RotationalInertia(xx, yy, zz, *inertial.products).CouldBePhysicallyValid()
    assert inertial.X_LI.translation() == pytest.approx([1.0, 2.0, 3.0])


def test_products_too_large_for_the_moments_are_left_out():
    inertial, remarks = repaired(1.0, (0.01, 0.01, 0.01), (0.5, 0.0, 0.0))
    assert inertial.products == (0.0, 0.0, 0.0)
    assert "products" in remarks[0].text


def test_no_inertia_at_all_is_a_point_mass():
    inertial, remarks = repaired(0.01, (0.0, 0.0, 0.0))
    assert inertial.mass == 0.01
    assert "point mass" in remarks[0].text


@pytest.mark.parametrize(
    ("mass", "moments", "said"),
    [(-1.0, (1.0, 1.0, 1.0), "mass -1"), (1.0, (1.0, -1.0, 1.0), "negative moment")],
)
def test_what_has_no_plain_meaning_is_refused(mass, moments, said):
    with pytest.raises(WorkbenchError, match=rf"drone.urdf: link 'base' .*{said}"):
        repaired(mass, moments)


def test_a_body_of_a_sidecar_has_its_numbers_in_their_places(tmp_path):
    """It is stated as xx, yy, zz, xy, xz, yz."""
    path = tmp_path / "drone.rotors.yaml"
    path.write_text(
        "body: {mass: 2.0, center_of_mass: [0.1, 0.2, 0.3],"
        " inertia: [0.02, 0.03, 0.04, 0.001, 0.002, 0.003]}\n"
    )
    link = Link("base", RigidTransform(), None, (), ())
    model = Model(SOURCE, "drone", (link,), (), (), (), ())
    body = with_stated_body(model, "base", path, Remarks()).links[0].inertial
    assert body.mass == 2.0 and list(body.X_LI.translation()) == [0.1, 0.2, 0.3]
    rows = [[0.02, 0.001, 0.002], [0.001, 0.03, 0.003], [0.002, 0.003, 0.04]]
    assert matrix_in_L(body) == pytest.approx(np.array(rows), abs=1e-15)
    assert body.matrix == pytest.approx(np.array(rows), abs=1e-15)

"""Mass and inertia; what is made from shapes is compared with Drake's SpatialInertia."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw
from pydrake.multibody.tree import SpatialInertia

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.plant.model import Inertial
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import DescriptionRemark, Remarks


def read(folder: Path, content: str) -> tuple[Inertial, list[DescriptionRemark]]:
    path = folder / "top.sdf"
    path.write_text(
        '<sdf version="1.12">\n<model name="top"><frame name="f"><pose>0 0 5 0 0 0</pose></frame>\n'
        f'<link name="l">\n{content}\n</link></model></sdf>'
    )
    remarks = Remarks()
    return read_sdf(path, PackageFinder(path), remarks).links[0].inertial, remarks.found


def test_a_link_that_says_nothing_has_a_kilogram_and_is_noted(tmp_path):
    inertial, (remark,) = read(tmp_path, "")
    assert (inertial.mass, inertial.moments, inertial.products) == (1.0, (1.0,) * 3, (0.0,) * 3)
    assert inertial.X_LI.IsExactlyIdentity()
    assert (remark.kind, remark.element) == ("assumed", "link 'l'")
    assert "1 kg and 1 kg·m²" in remark.text


def test_an_inertial_without_mass_or_inertia_has_the_defaults_and_is_noted(tmp_path):
    inertial, remarks = read(tmp_path, "<inertial><pose>1 0 0 0 0 0</pose></inertial>")
    assert (inertial.mass, inertial.moments, inertial.products) == (1.0, (1.0,) * 3, (0.0,) * 3)
    assert inertial.X_LI.translation().tolist() == [1.0, 0.0, 0.0]
    assert ["gives no mass" in remarks[0].text, "no <inertia>" in remarks[1].text] == [True, True]


def test_each_moment_and_product_has_its_own_default(tmp_path):
    inertial, remarks = read(
        tmp_path,
        "<inertial><mass>2</mass>"
        "<inertia><iyy>5</iyy><iyz>-0.5</iyz><ixz>0.25</ixz><ixx></ixx></inertia></inertial>",
    )
    assert inertial.mass == 2.0
    assert inertial.moments == (1.0, 5.0, 1.0)
    assert inertial.products == (0.0, 0.25, -0.5)
    assert remarks == []


def test_a_massless_link_stays_massless(tmp_path):
    inertia = "<inertia><ixx>0</ixx><iyy>0</iyy><izz>0</izz></inertia>"
    inertial, _ = read(tmp_path, f"<inertial><mass>0</mass>{inertia}</inertial>")
    assert (inertial.mass, inertial.moments) == (0.0, (0.0, 0.0, 0.0))


def test_the_pose_turns_the_inertia(tmp_path):
    inertial, _ = read(
        tmp_path,
        "<inertial><pose>1 2 3 0.1 0.2 0.3</pose><mass>2</mass><inertia/></inertial>",
    )
    expected = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0])
    assert inertial.X_LI.IsNearlyEqualTo(expected, 1e-12)


@pytest.mark.parametrize("value", ["nan", "inf", "-inf", "1e300", "heavy", "1 2", "1kg"])
@pytest.mark.parametrize(
    "text",
    [
        "<mass>{}</mass><inertia/>",
        "<mass>1</mass><inertia><izz>{}</izz></inertia>",
        "<mass>1</mass><inertia><ixy>{}</ixy></inertia>",
        "<pose>{} 0 0 0 0 0</pose><mass>1</mass><inertia/>",
    ],
)
def test_what_is_no_finite_number_is_refused_with_its_line(tmp_path, text, value):
    with pytest.raises(WorkbenchError) as caught:
        read(tmp_path, f"<inertial>\n{text.format(value)}</inertial>")
    assert str(caught.value).startswith(f"{tmp_path / 'top.sdf'}:5: <")


AUTO = '<inertial auto="true"/>'
SOLIDS = {
    "<box><size>1 2 3</size></box>": SpatialInertia.SolidBoxWithDensity(1000.0, 1.0, 2.0, 3.0),
    "<sphere><radius>0.5</radius></sphere>": SpatialInertia.SolidSphereWithDensity(1000.0, 0.5),
    "<cylinder><radius>2</radius><length>3</length></cylinder>": (
        SpatialInertia.SolidCylinderWithDensity(1000.0, 2.0, 3.0, [0.0, 0.0, 1.0])
    ),
    "<capsule><radius>2</radius><length>3</length></capsule>": (
        SpatialInertia.SolidCapsuleWithDensity(1000.0, 2.0, 3.0, [0.0, 0.0, 1.0])
    ),
    "<ellipsoid><radii>1 2 3</radii></ellipsoid>": (
        SpatialInertia.SolidEllipsoidWithDensity(1000.0, 1.0, 2.0, 3.0)
    ),
}


def collision(geometry: str, inside: str = "") -> str:
    return f'<collision name="c"><geometry>{geometry}</geometry>{inside}</collision>'


def agree(inertial: Inertial, M_LLo: SpatialInertia) -> None:
    """Compare with an inertia about the link's origin, in its axes."""
    assert inertial.mass == pytest.approx(M_LLo.get_mass())
    np.testing.assert_allclose(inertial.X_LI.translation(), M_LLo.get_com(), atol=1e-12)
    I_L = M_LLo.CalcRotationalInertia().ShiftToCenterOfMass(M_LLo.get_mass(), M_LLo.get_com())
    moments, products = I_L.get_moments(), I_L.get_products()
    np.testing.assert_allclose(inertial.moments, moments, rtol=1e-9)
    np.testing.assert_allclose(inertial.products, products, atol=1e-9 * max(moments))


@pytest.mark.parametrize("geometry", SOLIDS)
def test_an_automatic_inertia_is_that_of_the_collision_in_water(tmp_path, geometry):
    inertial, remarks = read(tmp_path, AUTO + collision(geometry))
    agree(inertial, SOLIDS[geometry])
    assert remarks == []


def test_several_collisions_are_added_where_they_are(tmp_path):
    box, sphere, capsule = (
        "<box><size>1 2 3</size></box>",
        "<sphere><radius>0.5</radius></sphere>",
        "<capsule><radius>2</radius><length>3</length></capsule>",
    )
    inertial, _ = read(
        tmp_path,
        AUTO
        + collision(box, "<pose>1 2 3 0.1 0.2 0.3</pose>")
        + collision(sphere, '<pose relative_to="f">0 0 -1 0 0 0</pose>')
        + collision(capsule, "<pose>-4 1 0 1 2 3</pose>"),
    )
    total = SpatialInertia.Zero()
    for geometry, rpy, xyz in (
        (box, (0.1, 0.2, 0.3), [1.0, 2.0, 3.0]),
        (sphere, (0.0, 0.0, 0.0), [0.0, 0.0, 4.0]),
        (capsule, (1.0, 2.0, 3.0), [-4.0, 1.0, 0.0]),
    ):
        R_LC = RollPitchYaw(*rpy).ToRotationMatrix()
        total += SOLIDS[geometry].ReExpress(R_LC).Shift(-np.array(xyz))
    agree(inertial, total)


def test_density_is_the_collisions_own_or_that_of_the_link(tmp_path):
    box = "<box><size>1 1 1</size></box>"
    inertial, _ = read(
        tmp_path,
        '<inertial auto="1"><density>10</density></inertial>'
        + collision(box)
        + collision(box, "<density>30</density><pose>1 0 0 0 0 0</pose>"),
    )
    assert inertial.mass == pytest.approx(40.0)
    np.testing.assert_allclose(inertial.X_LI.translation(), [0.75, 0.0, 0.0])


def test_a_given_mass_scales_an_automatic_inertia(tmp_path):
    box = "<box><size>1 2 3</size></box>"
    inertial, _ = read(tmp_path, '<inertial auto="true"><mass>6</mass></inertial>' + collision(box))
    assert inertial.mass == pytest.approx(6.0)
    np.testing.assert_allclose(inertial.moments, [6.5, 5.0, 2.5])


def test_collisions_without_a_volume_are_left_out_and_noted(tmp_path):
    cone, box = "<cone/>", "<box><size>1 1 1</size></box>"
    inertial, remarks = read(tmp_path, AUTO + collision(box) + collision(cone))
    assert inertial.mass == pytest.approx(1000.0)
    (remark,) = [remark for remark in remarks if remark.kind == "assumed"]
    assert remark.element == "link 'l'"
    assert "automatic inertia leaves out" in remark.text


@pytest.mark.parametrize(
    "content",
    [
        "",
        collision("<mesh><uri>gone.stl</uri></mesh>"),
        collision("<box/>", "<density>0</density>"),
        collision("<box/>", "<density>-5</density>"),
        collision("<sphere><radius>1e-150</radius></sphere>"),
        collision("<capsule><radius>1e-110</radius><length>1e-110</length></capsule>"),
        collision("<box/>", "<density>-5</density>") + collision("<box/>", "<density>5</density>"),
    ],
)
def test_where_nothing_has_a_mass_the_defaults_hold_and_are_noted(tmp_path, content):
    inertial, remarks = read(tmp_path, AUTO + content)
    assert (inertial.mass, inertial.moments) == (1.0, (1.0, 1.0, 1.0))
    assert any("no collision with a mass" in remark.text for remark in remarks)


def test_auto_is_yes_or_no(tmp_path):
    with pytest.raises(WorkbenchError, match="neither true nor false"):
        read(tmp_path, '<inertial auto="perhaps"/>')

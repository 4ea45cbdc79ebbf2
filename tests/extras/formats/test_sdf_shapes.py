"""Shapes, colours and their places on a link."""

import math
from pathlib import Path

import numpy as np
import pytest
from pydrake.math import RigidTransform, RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.plant.model import Link
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import DescriptionRemark, Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Sphere


def read(folder: Path, content: str) -> tuple[Link, list[DescriptionRemark]]:
    """Return the link `l` of that content."""
    path = folder / "top.sdf"
    path.write_text(
        '<sdf version="1.9">\n<model name="top"><frame name="f"><pose>0 0 5 0 0 0</pose></frame>\n'
        '<link name="l"><pose>0 0 1 0 0 0</pose><inertial><mass>1</mass><inertia/></inertial>\n'
        f"{content}\n</link></model></sdf>"
    )
    remarks = Remarks()
    model = read_sdf(path, PackageFinder(path), remarks)
    return model.links[0], remarks.found


def visual(geometry: str, inside: str = "") -> str:
    return f'<visual name="v"><geometry>{geometry}</geometry>{inside}</visual>'


def collision(geometry: str, inside: str = "") -> str:
    return f'<collision name="c"><geometry>{geometry}</geometry>{inside}</collision>'


def fault(folder: Path, content: str) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(folder, content)
    return str(caught.value)


SHAPES = [
    ("<box><size>1 2 3</size></box>", Box((1.0, 2.0, 3.0))),
    ("<sphere><radius>0.5</radius></sphere>", Sphere(0.5)),
    ("<cylinder><radius>2</radius><length>3</length></cylinder>", Cylinder(2.0, 3.0)),
    ("<capsule><radius>2</radius><length>3</length></capsule>", Capsule(2.0, 3.0)),
    ("<ellipsoid><radii>1 2 3</radii></ellipsoid>", Ellipsoid((1.0, 2.0, 3.0))),
    ("<box/>", Box((1.0, 1.0, 1.0))),
    ("<sphere/>", Sphere(1.0)),
    ("<cylinder/>", Cylinder(1.0, 1.0)),
    ("<capsule/>", Capsule(0.5, 1.0)),
    ("<ellipsoid/>", Ellipsoid((1.0, 1.0, 1.0))),
]


@pytest.mark.parametrize(("text", "shape"), SHAPES)
def test_a_shape_is_read_with_the_specifications_defaults(tmp_path, text, shape):
    link, remarks = read(tmp_path, visual(text) + collision(text))
    assert [part.shape for part in link.visuals] == [shape]
    assert [part.shape for part in link.collisions] == [shape]
    assert (link.visuals[0].name, link.collisions[0].name) == ("v", "c")
    assert remarks == []


def test_a_pose_places_a_shape_on_the_link(tmp_path):
    pose = "<pose>1 2 3 0.1 0.2 0.3</pose>"
    link, _ = read(tmp_path, visual("<box/>", pose) + collision("<box/>", pose))
    expected = RigidTransform(RollPitchYaw(0.1, 0.2, 0.3), [1.0, 2.0, 3.0])
    assert link.visuals[0].X_LS.IsNearlyEqualTo(expected, 1e-12)
    assert link.collisions[0].X_LS.IsNearlyEqualTo(expected, 1e-12)


def test_a_pose_may_be_relative_to_any_frame(tmp_path):
    pose = '<pose relative_to="f">0 0 1 0 0 0</pose>'
    link, _ = read(tmp_path, visual("<box/>", pose) + collision("<box/>", pose))
    np.testing.assert_allclose(link.visuals[0].X_LS.translation(), [0.0, 0.0, 5.0])
    np.testing.assert_allclose(link.collisions[0].X_LS.translation(), [0.0, 0.0, 5.0])


def test_parts_without_a_name_get_one(tmp_path):
    nameless = "<visual><geometry><box/></geometry></visual>"
    link, _ = read(tmp_path, nameless * 2)
    assert [part.name for part in link.visuals] == ["visual_0", "visual_1"]


def test_a_cone_becomes_a_cylinder_and_is_noted(tmp_path):
    cone = "<cone><radius>2</radius><length>3</length></cone>"
    link, (remark,) = read(tmp_path, visual(cone))
    assert link.visuals[0].shape == Cylinder(2.0, 3.0)
    assert remark.kind == "repaired"
    assert remark.element == "visual 'v' of link 'l'"


@pytest.mark.parametrize(
    "normal", [(0, 0, 1), (0, 0, -1), (1, 0, 0), (0, -3, 0), (1, 1, 1), (0.1, 0, -1)]
)
def test_a_plane_is_drawn_as_a_thin_box_across_its_normal(tmp_path, normal):
    x, y, z = normal
    plane = f"<plane><normal>{x} {y} {z}</normal><size>2 3</size></plane>"
    link, remarks = read(tmp_path, visual(plane, "<pose>0 0 1 0 0 0</pose>"))
    (part,) = link.visuals
    assert part.shape == Box((2.0, 3.0, 0.001))
    assert remarks == []
    np.testing.assert_allclose(
        part.X_LS.rotation().matrix()[:, 2], np.array(normal) / np.linalg.norm(normal), atol=1e-12
    )
    assert part.X_LS.translation().tolist() == [0.0, 0.0, 1.0]


def test_a_plane_that_looks_up_is_not_turned(tmp_path):
    link, _ = read(tmp_path, visual("<plane/>"))
    assert link.visuals[0].X_LS.IsNearlyEqualTo(RigidTransform(), 1e-15)
    assert link.visuals[0].shape == Box((1.0, 1.0, 0.001))


def test_an_endless_plane_does_not_touch(tmp_path):
    link, (remark,) = read(tmp_path, collision("<plane/>"))
    assert link.collisions == ()
    assert remark.kind == "ignored"
    assert "plane" in remark.text


@pytest.mark.parametrize("tag", ["polyline", "heightmap", "image", "empty"])
def test_what_is_no_shape_here_is_noted(tmp_path, tag):
    link, (remark,) = read(tmp_path, visual(f"<{tag}/>"))
    assert link.visuals == ()
    assert (remark.kind, remark.element) == ("ignored", "visual 'v' of link 'l'")
    assert f"<{tag}>" in remark.text


def test_no_geometry_is_noted(tmp_path):
    link, remarks = read(tmp_path, '<visual name="v"/><collision name="c"><geometry/></collision>')
    assert (link.visuals, link.collisions) == ((), ())
    assert ["no geometry" in remark.text for remark in remarks] == [True, True]


def test_a_mesh_is_found(tmp_path):
    (tmp_path / "part.stl").write_text("")
    mesh = (
        "<mesh><uri>part.stl</uri><scale>1 -2 3</scale>"
        "<submesh><name>lid</name><center>true</center></submesh></mesh>"
    )
    link, _ = read(tmp_path, visual(mesh))
    assert link.visuals[0].shape == Mesh(
        uri="part.stl",
        path=tmp_path / "part.stl",
        scale=(1.0, -2.0, 3.0),
        submesh="lid",
        center=True,
    )


def test_a_missing_mesh_has_no_path(tmp_path):
    link, remarks = read(tmp_path, visual("<mesh><uri>model://gone/part.stl</uri></mesh>"))
    assert link.visuals[0].shape == Mesh("model://gone/part.stl", None)
    assert remarks == []


@pytest.mark.parametrize(
    ("material", "rgba"),
    [
        ("<diffuse>0.1 0.2 0.3 0.4</diffuse><ambient>1 1 1</ambient>", (0.1, 0.2, 0.3, 0.4)),
        ("<diffuse>0.1 0.2 0.3</diffuse>", (0.1, 0.2, 0.3, 1.0)),
        ("<diffuse/><ambient>0.1 0.2 0.3 1</ambient>", (0.1, 0.2, 0.3, 1.0)),
        ("<diffuse>2 -1 0.5 9</diffuse>", (1.0, 0.0, 0.5, 1.0)),
        ("<specular>1 1 1</specular>", None),
        ("<script><name>Gazebo/DarkGrey</name></script>", (0.175, 0.175, 0.175, 1.0)),
        ("<script><uri>x</uri><name>Gazebo/Blue</name></script>", (0.0, 0.0, 1.0, 1.0)),
        ("<script><name>Mine/Own</name></script>", None),
        ("", None),
    ],
)
def test_a_colour_is_that_of_the_material(tmp_path, material, rgba):
    link, _ = read(tmp_path, visual("<box/>", f"<material>{material}</material>"))
    assert link.visuals[0].rgba == rgba


def test_no_material_is_no_colour(tmp_path):
    assert read(tmp_path, visual("<box/>"))[0].visuals[0].rgba is None


def test_transparency_is_taken_from_the_opacity(tmp_path):
    clear = "<transparency>0.25</transparency>"
    red = "<material><diffuse>1 0 0 0.8</diffuse></material>"
    link, _ = read(tmp_path, visual("<box/>", clear + red) + visual("<sphere/>", clear))
    assert link.visuals[0].rgba == pytest.approx((1.0, 0.0, 0.0, 0.6))
    assert link.visuals[1].rgba == pytest.approx((0.7, 0.7, 0.7, 0.75))


BAD_SIZES = ["0", "-1", "nan", "inf", "1e308", "large", "1 2", "1,0"]


@pytest.mark.parametrize("value", BAD_SIZES)
@pytest.mark.parametrize(
    "text",
    [
        "<sphere><radius>{}</radius></sphere>",
        "<cylinder><radius>1</radius><length>{}</length></cylinder>",
        "<box><size>1 1 {}</size></box>",
        "<ellipsoid><radii>{} 1 1</radii></ellipsoid>",
        "<plane><size>1 {}</size></plane>",
        "<cone><radius>{}</radius></cone>",
    ],
)
def test_a_size_that_cannot_be_is_refused(tmp_path, text, value):
    said = fault(tmp_path, visual(text.format(value)))
    assert said.startswith(f"{tmp_path / 'top.sdf'}:4: ")


@pytest.mark.parametrize(
    "text",
    [
        "<mesh/>",
        "<mesh><uri> </uri></mesh>",
        "<mesh><uri>a</uri><scale>1 0 1</scale></mesh>",
        "<mesh><uri>a</uri><scale>1</scale></mesh>",
        "<mesh><uri>a</uri><submesh><center>maybe</center></submesh></mesh>",
        "<plane><normal>0 0 0</normal></plane>",
    ],
)
def test_a_shape_that_cannot_be_is_refused(tmp_path, text):
    assert fault(tmp_path, visual(text)).startswith(f"{tmp_path / 'top.sdf'}:4: ")


@pytest.mark.parametrize("colour", ["1 1", "red", "nan 0 0", "1 1 1 1 1"])
def test_a_colour_that_cannot_be_is_refused(tmp_path, colour):
    said = fault(tmp_path, visual("<box/>", f"<material><diffuse>{colour}</diffuse></material>"))
    assert f"<diffuse>{colour}</diffuse>: give it 3 or 4 numbers" in said


def test_half_a_turn_is_half_a_turn(tmp_path):
    link, _ = read(tmp_path, visual("<box/>", '<pose degrees="1">0 0 0 0 0 180</pose>'))
    assert link.visuals[0].X_LS.rotation().ToRollPitchYaw().yaw_angle() == pytest.approx(math.pi)

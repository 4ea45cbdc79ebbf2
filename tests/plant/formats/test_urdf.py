"""What URDF says, as records; expected values by hand, poses also by Drake."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.urdf import read_urdf
from workbench.plant.formats.urdf_words import note_unknown_urdf
from workbench.plant.formats.xml import parse_xml, read_xml
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Mesh, Sphere

INERTIAL = """<inertial><origin xyz="0.1 0 0" rpy="0 0 1"/><mass value="2"/>
  <inertia ixx="0.1" iyy="0.2" izz="0.25" ixy="0.01" ixz="0.02" iyz="0.03"/></inertial>"""
TREE = f"""<robot name="r">
  <link name="tip">{INERTIAL}</link>
  <joint name="j2" type="continuous"><parent link="arm"/><child link="tip"/>
    <origin xyz="0 0.5 0" rpy="0 0.3 0"/><axis xyz="0 0 -2"/></joint>
  <link name="arm">{INERTIAL}</link>
  <link name="base">{INERTIAL}</link>
  <joint name="j1" type="fixed"><parent link="base"/><child link="arm"/>
    <origin xyz="1 2 3" rpy="0.1 -0.2 1.5"/></joint>
</robot>"""


@pytest.fixture
def read(tmp_path):
    """Read URDF text; return model and remarks."""

    def read_text(text: str):
        path = tmp_path / "r.urdf"
        path.write_text(text)
        remarks = Remarks()
        return read_urdf(path, read_xml(path), PackageFinder(path), remarks), remarks.found

    return read_text


def link(inner: str, more: str = "") -> str:
    return f'<robot name="r">{more}<link name="base">{inner}</link></robot>'


def shape(geometry: str, kind: str = "visual", more: str = "") -> str:
    return f"<{kind}><geometry>{geometry}</geometry>{more}</{kind}>"


def test_poses_are_those_of_drakes_own_parser(read):
    """With all joints at zero; tip comes before its parents in the file."""
    model, _ = read(TREE)
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModelsFromString(TREE, "urdf")
    plant.WeldFrames(plant.world_frame(), plant.GetFrameByName("base"))
    plant.Finalize()
    context = plant.CreateDefaultContext()
    for each in model.links:
        X_WL = plant.EvalBodyPoseInWorld(context, plant.GetBodyByName(each.name))
        assert X_WL.IsNearlyEqualTo(each.X_ML, 1e-12)


def test_a_joint_stands_where_its_child_does_and_its_axis_has_length_one(read):
    model, _ = read(TREE)
    joint = model.joint("j2")
    assert (joint.kind, joint.parent, joint.child) == ("continuous", "arm", "tip")
    assert joint.axis_J == (0.0, 0.0, -1.0)
    assert joint.X_MJ.IsExactlyEqualTo(model.link("tip").X_ML)
    assert model.joint("j1").axis_J == (1.0, 0.0, 0.0)  # the specification's default


def test_mass_and_inertia_are_read(read):
    inertial = read(TREE)[0].link("arm").inertial
    assert inertial.mass == 2.0
    assert inertial.moments == (0.1, 0.2, 0.25)
    assert inertial.products == (0.01, 0.02, 0.03)
    assert inertial.X_LI.translation().tolist() == [0.1, 0.0, 0.0]
    assert inertial.X_LI.rotation().ToRollPitchYaw().vector() == pytest.approx([0.0, 0.0, 1.0])


@pytest.mark.parametrize(
    ("geometry", "expected"),
    [
        ('<box size="1 2 3"/>', Box((1.0, 2.0, 3.0))),
        ('<sphere radius="0.5"/>', Sphere(0.5)),
        ('<cylinder radius="0.5" length="2"/>', Cylinder(0.5, 2.0)),
        ('<capsule radius="0.5" length="2"/>', Capsule(0.5, 2.0)),
        ('<mesh filename="gone.stl" scale="1 1 -1"/>', Mesh("gone.stl", None, (1.0, 1.0, -1.0))),
        ('<mesh filename="gone.stl" scale="2"/>', Mesh("gone.stl", None, (2.0, 2.0, 2.0))),
    ],
)
@pytest.mark.parametrize("kind", ["visual", "collision"])
def test_shapes_are_read(read, geometry, expected, kind):
    base = read(link(shape(geometry, kind)))[0].link("base")
    (found,) = base.visuals if kind == "visual" else base.collisions
    assert found.shape == expected


def test_a_mesh_is_found_beside_the_file(read, tmp_path):
    (tmp_path / "a.stl").touch()
    (visual,) = read(link(shape('<mesh filename="a.stl"/>')))[0].link("base").visuals
    assert visual.shape.path == tmp_path / "a.stl"


RED = '<material name="red"><color rgba="1 0 0 0.5"/></material>'
GAZEBO_BLUE = '<gazebo reference="base"><material>Gazebo/Blue</material></gazebo>'


@pytest.mark.parametrize(
    ("material", "more", "rgba"),
    [
        (RED, "", (1.0, 0.0, 0.0, 0.5)),
        ('<material name="red"/>', RED, (1.0, 0.0, 0.0, 0.5)),
        ("", GAZEBO_BLUE, (0.0, 0.0, 1.0, 1.0)),
        (RED, GAZEBO_BLUE, (1.0, 0.0, 0.0, 0.5)),
        ('<material name="unknown"/>', "", None),
        ("", "", None),
    ],
)
def test_colours_come_from_materials_and_from_gazebo(read, material, more, rgba):
    text = link(shape('<sphere radius="1"/>', more=material), more)
    (visual,) = read(text)[0].link("base").visuals
    assert visual.rgba == rgba


def test_plugins_sensors_and_properties_are_handed_on(read):
    more = """<properties kf="1e-10" km="2e-12"/>
      <gazebo><plugin filename="motor.so"><motorNumber>0</motorNumber></plugin></gazebo>
      <gazebo reference="base"><sensor name="imu" type="imu"><pose>1 2 3 0 0 1.5</pose></sensor>
        <plugin filename="other.so"/></gazebo>"""
    model, remarks = read(link("", more))
    assert [plugin.get("filename") for plugin in model.plugins] == ["motor.so", "other.so"]
    (sensor,) = model.sensors
    assert (sensor.link, sensor.element.get("name")) == ("base", "imu")
    assert sensor.X_LS.translation().tolist() == [1.0, 2.0, 3.0]
    assert np.allclose(sensor.X_LS.rotation().ToRollPitchYaw().vector(), [0.0, 0.0, 1.5])
    assert dict(model.properties) == {"kf": "1e-10", "km": "2e-12"}
    assert not remarks


@pytest.mark.parametrize(
    ("text", "element"),
    [
        (link("", "<rotor/>"), "element <rotor>"),
        (link("<visual/>"), "visual 1 of link 'base'"),
        (link(shape("<torus/>")), "visual 1 of link 'base'"),
        (link("", '<gazebo reference="x"><sensor name="imu"/></gazebo>'), "sensor 'imu'"),
    ],
)
def test_what_is_left_out_is_said(read, text, element):
    (remark,) = read(text)[1]
    assert (remark.kind, remark.element) == ("ignored", element)


JOINT = '<joint name="j" type="fixed"><parent link="{}"/><child link="{}"/>{}</joint>'


def two_links(*joints: str) -> str:
    return f'<robot name="r">\n<link name="a"/>\n<link name="b"/>\n{"".join(joints)}</robot>'


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("<model/>", "the root element is <model>"),
        (two_links(JOINT.format("a", "c", "")), ":4: joint 'j' has the child link 'c'"),
        (two_links(JOINT.format("", "b", "")), "has the parent link ''"),
        (
            two_links(JOINT.format("a", "b", '<axis xyz="0 0 0"/>').replace("fixed", "revolute")),
            "the axis 0 0 0",
        ),
        (two_links(JOINT.format("a", "b", '<axis xyz="0 1"/>')), "give it 3 numbers"),
        (two_links(JOINT.format("a", "b", '<origin xyz="0 nan 1"/>')), "within"),
        (two_links(JOINT.format("a", "b", ""), JOINT.format("a", "b", "")), "two joints named 'j'"),
        (
            two_links(JOINT.format("a", "b", ""), JOINT.format("a", "b", "").replace("'j'", "'k'")),
            "two joints",
        ),
        (
            two_links(JOINT.format("a", "b", ""), JOINT.format("b", "a", "").replace('"j"', '"k"')),
            "form a loop",
        ),
        ('<robot name="r">\n<link name="a"/><link name="a"/></robot>', ":2: there are two links"),
        ("<robot><link/></robot>", "<link> without a name"),
        (link("<inertial/>"), "<inertial> without <mass>"),
        (link('<inertial><mass value="heavy"/></inertial>'), "<mass value='heavy'>"),
        (link("<inertial><mass/></inertial>"), "<mass> without value"),
        (link(shape('<box size="1 1 0"/>')), "positive"),
        (link(shape('<sphere radius="-1"/>')), "positive"),
        (link(shape('<sphere radius="1e300"/>')), "within"),
        (link(shape('<mesh filename="a.stl" scale="1 0 1"/>')), "scale '1 0 1'"),
    ],
)
def test_what_cannot_be_meant_is_a_sentence(read, tmp_path, text, said):
    with pytest.raises(WorkbenchError) as caught:
        read(text)
    assert str(caught.value).startswith(str(tmp_path / "r.urdf"))
    assert said in str(caught.value)


def remarks_on(text: str) -> list[str]:
    remarks = Remarks()
    note_unknown_urdf(Path("a.urdf"), parse_xml(text, Path("a.urdf")), remarks)
    return [f"{remark.element}: {remark.text}" for remark in remarks.found]


@pytest.mark.parametrize(
    ("inner", "said"),
    [
        ('<link name="a"><intertial/></link>', "<intertial>: not known in URDF in <link> of link"),
        ('<link name="a"><intertial/></link>', "did you mean <inertial>?"),
        ('<joint name="j"><orign xyz="1 0 0"/></joint>', "in <joint> of joint 'j'"),
        ('<link name="a"><inertial><mas/></inertial></link>', "did you mean <mass>?"),
        ('<joint name="j"><origin xzy="1 0 0"/></joint>', "attribute xzy of <origin>"),
        ("<rotor/><rotor/>", "element <rotor>: not known in URDF; left out (2 times)"),
    ],
)
def test_a_misspelt_word_is_named_with_its_place(inner, said):
    (remark,) = remarks_on(f"<robot>{inner}</robot>")
    assert said in remark


@pytest.mark.parametrize(
    "inner",
    [
        '<gazebo reference="a"><sensor><at/></sensor><material>Gazebo/Red</material></gazebo>',
        '<properties arm="1"/>',
        '<link name="a"><other:geometry/></link>',
        '<joint name="j"><limit effort="1"/><dynamics damping="0.0"/></joint>',
    ],
)
def test_what_is_used_or_means_nothing_is_not_noted(inner):
    assert remarks_on(f"<robot>{inner}</robot>") == []


def test_what_is_known_and_not_used_is_said():
    inner = """<gazebo reference="a"><mu1>0.9</mu1><kp>1</kp></gazebo>
      <gazebo reference="b"><mu1>0.9</mu1></gazebo><transmission><x/></transmission>
      <joint name="j"><dynamics damping="0.1" friction="0"/></joint>"""
    assert remarks_on(f"<robot>{inner}</robot>") == [
        "element <mu1> of <gazebo>: Gazebo's; not used (2 times)",
        "element <kp> of <gazebo>: Gazebo's; not used",
    ]


def test_what_does_not_act_in_a_joint_is_said():
    """Limits and springs of planar joints, and mimics and servos of joints with several axes."""
    inner = """<joint name="p" type="planar"><limit lower="-1" upper="1" effort="0" velocity="0.0"/>
        <servo/>
        <dynamics damping="1" friction="2" stiffness="3"/><mimic joint="r"/></joint>
      <drake:joint name="b" type="ball"><servo/><dynamics friction="1"/></drake:joint>
      <joint name="u" type="universal"><dynamics friction="1"/><limit lower="-1"/></joint>
      <joint name="r" type="revolute"><safety_controller k_velocity="1"/><calibration rising="0"/>
        <servo/><mimic joint="s"/></joint>"""
    alone = "planar joints have damping alone; not used"
    assert remarks_on(f'<robot xmlns:drake="d">{inner}</robot>') == [
        "element <mimic> of joint 'p': only joints of one axis follow others; not used",
        "element <servo> of joint 'p': the sidecar names the axis that a servo drives; not used",
        *(f"<limit {name}> of joint 'p': {alone}" for name in ("lower", "upper")),
        *(f"<dynamics {name}> of joint 'p': {alone}" for name in ("friction", "stiffness")),
        "element <servo> of joint 'b': the sidecar names the axis that a servo drives; not used",
        "element <safety_controller> of joint 'r': limits of ROS's controllers; not used",
        "element <calibration> of joint 'r': of encoders; not used",
    ]


def test_a_strangers_thousand_words_are_not_all_repeated():
    words = "".join(f"<w{i}/>" for i in range(1000))
    assert len(remarks_on(f"<robot>{words}</robot>")) == 50

"""What a model says, as read; expected values are those written here."""

from pathlib import Path

import numpy as np
import pytest
from pydrake.multibody.parsing import Parser
from pydrake.multibody.plant import MultibodyPlant

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.sdf import read_sdf
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import DescriptionRemark, Remarks

MODEL = """<sdf version="1.9">
<model name="quad">
  <link name="base">
    <inertial>
      <pose>0 0 0.1 0 0 0</pose>
      <mass>1.5</mass>
      <inertia><ixx>0.1</ixx><iyy>0.2</iyy><izz>0.25</izz><ixy>0.01</ixy></inertia>
    </inertial>
    <velocity_decay />
    <sensor name="imu" type="imu">
      <pose>0 0 0.2 0 0 0</pose>
      <update_rate>100</update_rate>
      <plugin filename="sensor_plugin" name="s"/>
    </sensor>
    <sensor name="eye" type="camera"><pose relative_to="mast">0 0 1 0 0 0</pose></sensor>
    <plugin filename="link_plugin" name="l"/>
  </link>
  <link name="rotor"><pose>0.5 0 0 0 0 0</pose></link>
  <frame name="mast" attached_to="base"><pose>0 0 3 0 0 0</pose></frame>
  <joint name="spin" type="revolute">
    <parent>base</parent>
    <child>rotor</child>
    <axis><xyz>0 0 -2</xyz></axis>
    <sensor name="torque" type="force_torque"/>
  </joint>
  <plugin filename="model_plugin" name="m"><jointName>spin</jointName></plugin>
</model>
</sdf>
"""


def write(folder: Path, text: str) -> Path:
    path = folder / "quad.sdf"
    path.write_text(text)
    return path


def read(path: Path, remarks: Remarks | None = None) -> Model:
    return read_sdf(path, PackageFinder(path), remarks or Remarks())


def fault(path: Path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read(path)
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    return said


@pytest.fixture
def model(tmp_path) -> Model:
    return read(write(tmp_path, MODEL))


def test_the_model_has_the_files_name_and_parts(model, tmp_path):
    assert model.source == tmp_path / "quad.sdf"
    assert model.name == "quad"
    assert [link.name for link in model.links] == ["base", "rotor"]
    assert [frame.name for frame in model.frames] == ["mast"]
    assert model.properties == ()


def test_mass_and_inertia_are_read(model):
    inertial = model.links[0].inertial
    assert inertial.mass == 1.5
    assert inertial.moments == (0.1, 0.2, 0.25)
    assert inertial.products == (0.01, 0.0, 0.0)
    assert inertial.X_LI.translation().tolist() == [0.0, 0.0, 0.1]


def test_joints_are_read_with_a_unit_axis(model):
    (joint,) = model.joints
    assert (joint.name, joint.kind, joint.parent, joint.child) == (
        "spin",
        "revolute",
        "base",
        "rotor",
    )
    assert joint.axis_J == (0.0, 0.0, -1.0)
    assert joint.X_MJ.translation().tolist() == [0.5, 0.0, 0.0]


def test_sensors_of_links_are_declared_where_they_are(model, tmp_path):
    imu, eye = model.sensors
    assert imu.element.file == tmp_path / "quad.sdf"
    assert imu.link == "base"
    assert imu.X_LS.translation().tolist() == [0.0, 0.0, 0.2]
    assert imu.element.findtext("update_rate") == "100"
    assert imu.element.line == 10
    np.testing.assert_allclose(eye.X_LS.translation(), [0.0, 0.0, 4.0])


def test_only_plugins_of_the_model_are_declared(model):
    (plugin,) = model.plugins
    assert plugin.get("filename") == "model_plugin"
    assert plugin.findtext("jointName") == "spin"


def test_a_sensor_of_a_joint_is_noted_as_not_used(tmp_path):
    remarks = Remarks()
    read(write(tmp_path, MODEL), remarks)
    (remark,) = [remark for remark in remarks.found if "torque" in remark.element]
    assert remark.kind == "ignored"


def test_a_sensor_relative_to_nothing_is_taken_on_its_link(tmp_path):
    remarks = Remarks()
    path = write(tmp_path, MODEL.replace('relative_to="mast"', 'relative_to="most"'))
    eye = read(path, remarks).sensors[1]
    assert eye.X_LS.translation().tolist() == [0.0, 0.0, 1.0]
    (remark,) = [remark for remark in remarks.found if "eye" in remark.element]
    assert remark.kind == "repaired"
    assert "'most'" in remark.text


KINDS = ["revolute", "continuous", "prismatic", "fixed", "ball", "universal", "revolute2"]


@pytest.mark.parametrize("kind", KINDS)
def test_the_kind_of_a_joint_is_as_written(tmp_path, kind):
    path = write(tmp_path, MODEL.replace('type="revolute"', f'type="{kind}"'))
    assert read(path).joints[0].kind == kind


@pytest.mark.parametrize("kind", ["screw", "gearbox"])
def test_a_joint_that_ties_two_motions_is_refused_by_name(tmp_path, kind):
    path = write(tmp_path, MODEL.replace('type="revolute"', f'type="{kind}"'))
    with pytest.raises(WorkbenchError, match=f"joint '.*' is a {kind} joint, which does not fly"):
        read(path)


def test_the_axis_of_a_joint_without_one_is_z(tmp_path):
    path = write(tmp_path, MODEL.replace("<axis><xyz>0 0 -2</xyz></axis>", ""))
    assert read(path).joints[0].axis_J == (0.0, 0.0, 1.0)


@pytest.mark.parametrize(
    ("kind", "axis", "missing"),
    [
        ("revolute", "", ["axis"]),
        ("universal", "", ["axis", "axis2"]),
        ("universal", "<axis><xyz>1 0 0</xyz></axis>", ["axis2"]),
        ("ball", "", []),
        ("fixed", "", []),
    ],
)
def test_an_axis_that_is_missing_is_noted(tmp_path, kind, axis, missing):
    text = MODEL.replace("<axis><xyz>0 0 -2</xyz></axis>", axis)
    remarks = Remarks()
    read(write(tmp_path, text.replace('type="revolute"', f'type="{kind}"')), remarks)
    noted = [each for each in remarks.found if each.element == "joint 'spin'"]
    assert [each.text for each in noted] == [f"it has no <{tag}>; taken as z" for tag in missing]


def test_an_axis_of_two_that_should_follow_a_joint_is_noted(tmp_path):
    axes = "<axis><xyz>1 0 0</xyz></axis><axis2><xyz>0 1 0</xyz><mimic joint='j'/></axis2>"
    text = MODEL.replace("<axis><xyz>0 0 -2</xyz></axis>", axes)
    remarks = Remarks()
    read(write(tmp_path, text.replace('type="revolute"', 'type="universal"')), remarks)
    (remark,) = [each for each in remarks.found if "mimic" in each.element]
    assert remark.element == "element <mimic> of joint 'spin'"
    assert remark.text == "only joints of one axis follow others; not used"


def test_a_ball_joint_has_the_damping_of_its_axis_as_in_drake(tmp_path):
    """Drake's parser reads it so, too; it has no dry friction."""
    axis = "<axis><xyz>0 0 1</xyz><dynamics><damping>0.02</damping><friction>0.001</friction>"
    text = '<joint name="socket" type="ball"><parent>base</parent><child>bob</child>{}</joint>'
    bodies = '<link name="base"/><link name="bob"><pose>0 0 -1 0 0 0</pose></link>'
    path = write(
        tmp_path,
        f'<sdf version="1.9"><model name="m">{bodies}{text.format(axis + "</dynamics></axis>")}'
        "</model></sdf>",
    )
    (freedom,) = read(path).joints[0].freedoms
    plant = MultibodyPlant(0.0)
    Parser(plant).AddModels(str(path))
    expected = plant.GetJointByName("socket").default_damping_vector()
    assert expected.tolist() == [freedom.damping] * 3 == [0.02] * 3
    assert freedom.friction == 0.001
    path.write_text(path.read_text().replace("0.02", "-1"))
    remarks = Remarks()
    assert read(path, remarks).joints[0].freedoms[0].damping == 0.0
    assert [each.text for each in remarks.found if each.element == "joint 'socket'"] == [
        "<damping>-1</damping> of a ball joint; taken as 0"
    ]


def test_what_follows_a_joint_is_where_the_format_says(tmp_path):
    """multiplier * (leader - reference) + offset: 2 (q - 0.3) + 0.1 is 2 q - 0.5."""
    mimic = (
        "<mimic joint='lead'><multiplier>2</multiplier><offset>0.1</offset>"
        "<reference>0.3</reference></mimic>"
    )
    text = MODEL.replace("<xyz>0 0 -2</xyz>", f"<xyz>0 0 -2</xyz>{mimic}")
    found = read(write(tmp_path, text)).joints[0].mimic
    assert (found.joint, found.multiplier, found.offset) == ("lead", 2.0, pytest.approx(-0.5))


def test_a_fixed_joint_needs_no_direction(tmp_path):
    text = MODEL.replace("0 0 -2", "0 0 0").replace('type="revolute"', 'type="fixed"')
    assert read(write(tmp_path, text)).joints[0].axis_J == (0.0, 0.0, 1.0)


def test_names_with_slashes_are_left_as_they_are(tmp_path):
    text = MODEL.replace("rotor", "quad/rotor").replace('"spin"', '"quad/spin"')
    model = read(write(tmp_path, text))
    assert model.links[1].name == "quad/rotor"
    assert model.joints[0].name == "quad/spin"
    assert model.joints[0].child == "quad/rotor"


def test_parent_and_child_of_very_old_files_are_attributes(tmp_path):
    text = MODEL.replace("<parent>base</parent>", '<parent link="base"/>')
    assert read(write(tmp_path, text)).joints[0].parent == "base"


@pytest.mark.parametrize(
    ("old", "new", "line", "said"),
    [
        ('type="revolute"', 'type="revolut"', 20, "'revolut': did you mean 'revolute'"),
        ('type="revolute"', "", 20, "has the type '': known are ball, continuous"),
        (
            "<child>rotor<",
            "<child>roter<",
            20,
            "'roter', which is not a link, joint, frame or model",
        ),
        ("<child>rotor<", "<child>roter<", 20, "did you mean 'rotor'?"),
        ("<parent>base<", "<parent><", 20, "has no <parent>: name a link"),
        ("<child>rotor</child>", "", 20, "has no <child>: name a link"),
        ("<child>rotor<", "<child>base<", 20, "joins 'base' to itself"),
        ("0 0 -2", "0 0 0", 23, "axis without length"),
        ('<link name="rotor">', "<link>", 18, "<link> without a name: add it"),
        ('<link name="rotor">', '<link name="  ">', 18, "<link> without a name: add it"),
        ('<joint name="spin"', '<joint name="a&#10;b"', 20, "'a\\nb' is not a name"),
    ],
)
def test_what_cannot_be_is_said_with_its_line(tmp_path, old, new, line, said):
    assert MODEL.count(old) == 1
    path = write(tmp_path, MODEL.replace(old, new))
    message = fault(path)
    assert message.startswith(f"{path}:{line}: ")
    assert said in message


def test_a_name_of_a_million_letters_is_refused_in_a_short_sentence(tmp_path):
    text = MODEL.replace('name="mast"', f'name="{"m" * 1_000_000}"')
    assert len(fault(write(tmp_path, text))) < 400


def test_a_model_without_a_link_is_refused(tmp_path):
    path = write(tmp_path, '<sdf version="1.9"><model name="none"/></sdf>')
    assert "model 'none' has no link" in fault(path)


NESTED = """<sdf version="1.9">
<model name="team">
  <link name="body"/>
  <model name="left">
    <link name="hub"><sensor name="imu" type="imu"/></link>
    <link name="rotor"/>
    <joint name="spin" type="revolute"><parent>hub</parent><child>rotor</child></joint>
    <frame name="mark"/>
    <plugin filename="motor" name="p">
      <jointName>spin</jointName>
      <linkName> rotor </linkName>
      <rotorConfiguration><rotor><jointName>spin</jointName></rotor></rotorConfiguration>
      <topic>spin</topic>
    </plugin>
  </model>
  <joint name="hold" type="fixed"><parent>body</parent><child>left::hub</child></joint>
  <plugin filename="other" name="q"><jointName>left::spin</jointName></plugin>
</model>
</sdf>
"""


def test_parts_of_a_model_in_a_model_have_its_name_in_front(tmp_path):
    model = read(write(tmp_path, NESTED))
    assert [link.name for link in model.links] == ["body", "left::hub", "left::rotor"]
    spin, hold = model.joints
    assert (spin.name, spin.parent, spin.child) == ("left::spin", "left::hub", "left::rotor")
    assert (hold.name, hold.parent, hold.child) == ("hold", "body", "left::hub")
    assert (model.frames[0].name, model.frames[0].link) == ("left::mark", "left::hub")
    assert model.sensors[0].link == "left::hub"


def test_names_in_a_plugin_of_a_model_in_a_model_become_names_of_the_whole(tmp_path):
    inner, outer = read(write(tmp_path, NESTED)).plugins
    assert [name.text for name in inner.iter("jointName")] == ["left::spin", "left::spin"]
    assert inner.findtext("linkName") == "left::rotor"
    assert inner.findtext("topic") == "spin"
    assert inner.get("filename") == "motor"
    assert inner.line == 9
    assert outer.findtext("jointName") == "left::spin"


def test_models_in_models_end_at_a_depth(tmp_path):
    text = '<model name="m"><link name="l"/>' * 30 + "</model>" * 30
    assert "more than 20 levels deep" in fault(write(tmp_path, f'<sdf version="1.9">{text}</sdf>'))


@pytest.mark.parametrize(
    "content",
    [
        "<link name='{}'/>",
        "<link name='l'><visual/>{}</link>",
        "<joint name='j' type='fixed'>{}</joint>",
    ],
)
def test_a_model_of_thousands_of_parts_is_refused(tmp_path, content):
    if content.startswith("<link name='{}'"):
        parts = "".join(content.format(index) for index in range(6000))
    else:
        parts = content.format("<sensor/>" * 6000)
    path = write(tmp_path, f'<sdf version="1.9"><model name="m">{parts}</model></sdf>')
    assert "more than 5000 links" in fault(path)


@pytest.fixture
def noted(tmp_path):
    """Return the remarks on a model's content."""

    def note(content: str, version: str = "1.9") -> list[DescriptionRemark]:
        path = tmp_path / "top.sdf"
        inertial = "<inertial><mass>1</mass><inertia/></inertial>"
        path.write_text(
            f'<sdf version="{version}">\n<model name="top">\n<link name="a">{inertial}</link>\n'
            f"{content}\n</model></sdf>"
        )
        remarks = Remarks()
        read_sdf(path, PackageFinder(path), remarks)
        return remarks.found

    return note


def link(content: str) -> str:
    inertial = "<inertial><mass>1</mass><inertia/></inertial>"
    return f'<link name="b">{inertial}\n{content}</link>'


@pytest.mark.parametrize(
    ("content", "parent"),
    [
        ("<foo/>", "model"),
        (link("<foo/>"), "link"),
        (link("<sensor name='s' type='imu'><foo/></sensor>"), "sensor"),
        (link("<visual name='v'><geometry><sphere/></geometry><foo/></visual>"), "visual"),
        (link("<visual name='v'><geometry><foo/><sphere/></geometry></visual>"), "geometry"),
        (link("<collision name='c'><geometry><sphere/></geometry><foo/></collision>"), "collision"),
        ("<model name='m'><foo/></model>", "model"),
        (
            link("")
            + "<joint name='j' type='fixed'><parent>a</parent><child>b</child><foo/></joint>",
            "joint",
        ),
        (
            link("") + "<joint name='j' type='revolute'><parent>a</parent><child>b</child>"
            "<axis><foo/></axis></joint>",
            "axis",
        ),
    ],
)
def test_an_unknown_element_is_noted_with_its_line(noted, content, parent):
    (remark,) = noted(content)
    assert remark.kind == "ignored"
    assert remark.element == f"element <foo> of <{parent}>"
    line = 5 if content.startswith("<link name") and parent not in ("joint", "axis") else 4
    line += content.partition("<foo")[0].count("\n") if parent in ("joint", "axis") else 0
    assert remark.text == f"not in the SDF schema; left out (line {line})"


def test_an_element_of_inertial_and_inertia_is_looked_at(noted):
    content = (
        "<link name='b'><inertial><mass>1</mass><foo/><inertia><bar/></inertia></inertial></link>"
    )
    elements = [remark.element for remark in noted(content)]
    assert elements == ["element <foo> of <inertial>", "element <bar> of <inertia>"]


def test_that_a_drone_is_not_static_is_said(noted):
    (remark,) = noted("<static>true</static>")
    assert remark.element == "element <static> of <model>"
    assert remark.text == "a drone and what it carries fly; not used (line 4)"


def test_the_same_is_noted_once_with_its_number(noted):
    (remark,) = noted(link("<foo/>\n<foo/>\n<foo><foo/></foo>"))
    assert remark.text == "not in the SDF schema; left out (3 times, first in line 5)"


@pytest.mark.parametrize("tag", ["gz_frame_id", "ignition_frame_id"])
def test_gazebos_frame_of_a_sensor_is_taken(noted, tag):
    sensor = f"<sensor name='s' type='imu'><{tag}>b</{tag}></sensor>"
    (remark,) = noted(link(sensor))
    assert remark.kind == "repaired"
    assert remark.element == f"element <{tag}> of <sensor>"
    assert remark.text.startswith("not in the SDF schema; taken as the sensor's frame, as Gazebo")


@pytest.mark.parametrize(
    "content",
    [
        "<plugin filename='f' name='n'><anything><at/></anything></plugin>",
        "<gz:system_priority>1</gz:system_priority>",
        link("<velocity_decay /><gravity>1</gravity><enable_wind>false</enable_wind>"),
        link("<velocity_decay><linear>0.0</linear></velocity_decay><kinematic/>"),
        link("<self_collide>1</self_collide>"),
        link(
            "<collision name='c'><geometry><sphere/></geometry><surface><x/></surface></collision>"
        ),
        link(
            "<visual name='v'><geometry><sphere/></geometry><material><pbr><x/></pbr></material>"
            "<cast_shadows>0</cast_shadows><laser_retro>1</laser_retro></visual>"
        ),
        link(
            "<sensor name='s' type='lidar'><always_on>1</always_on><update_rate>9</update_rate>"
            "<topic>t</topic><visualize>1</visualize><lidar><x/></lidar><navsat/></sensor>"
        ),
        "<self_collide>1</self_collide><static>0</static><allow_auto_disable>1</allow_auto_disable>",
    ],
)
def test_what_the_schema_knows_or_leaves_open_is_not_noted(noted, content):
    assert noted(content) == []


@pytest.mark.parametrize(
    ("content", "element"),
    [
        ("<velocity_decay><linear>0.1</linear></velocity_decay>", "<velocity_decay> of <link>"),
        ("<enable_wind>true</enable_wind>", "<enable_wind> of <link>"),
        ("<gravity>false</gravity>", "<gravity> of <link>"),
        (
            "<collision name='c'><geometry><sphere/></geometry><surface><mu>1</mu></surface>"
            "</collision>",
            "<surface> of <collision>",
        ),
    ],
)
def test_what_the_schema_knows_and_no_flight_uses_is_noted(noted, content, element):
    (remark,) = noted(link(content))
    assert (remark.kind, remark.element) == ("ignored", f"element {element}")
    assert "; not used (line " in remark.text


def test_where_a_joint_should_begin_is_noted(noted):
    joint = "<joint name='j' type='revolute'><parent>world</parent><child>a</child>{}</joint>"
    axis = "<axis><xyz>0 0 1</xyz><initial_position>{}</initial_position></axis>"
    (remark,) = noted(link("") + joint.format(axis.format(0.3)))
    assert remark.element == "element <initial_position> of <axis>"
    assert remark.text.startswith("a scenario says how a flight begins; not used")
    assert noted(link("") + joint.format(axis.format(0.0))) == []


def test_an_old_frame_attribute_of_a_pose_is_noted_in_a_new_file(noted):
    content = link("<pose frame='a'>0 0 0 0 0 0</pose>")
    (remark,) = noted(content)
    assert remark.element == "attribute frame of <pose> of <link>"
    assert noted(content, "1.6") == []


def test_an_old_element_of_an_axis_is_noted_in_a_new_file(noted):
    content = link("") + (
        "<joint name='j' type='revolute'><parent>a</parent><child>b</child>"
        "<axis><use_parent_model_frame>1</use_parent_model_frame></axis></joint>"
    )
    (remark,) = noted(content)
    assert remark.element == "element <use_parent_model_frame> of <axis>"
    assert noted(content, "1.6") == []


def test_a_centre_of_mass_cannot_be_relative_to_a_frame(noted):
    inertial = (
        "<inertial><mass>1</mass><inertia/><pose relative_to='a'>0 0 1 0 0 0</pose></inertial>"
    )
    (remark,) = noted(f"<link name='b'>{inertial}</link>")
    assert remark.element == "attribute relative_to of <pose> of <inertial>"


def test_changes_to_an_include_are_not_applied_and_noted(noted, tmp_path):
    (tmp_path / "arm.sdf").write_text('<sdf version="1.9"><model name="arm"/></sdf>')
    params = "<experimental:params><link element_id='l' action='remove'/></experimental:params>"
    (remark,) = noted(f"<include><uri>arm.sdf</uri>{params}</include>")
    assert remark.kind == "ignored"
    assert "not applied" in remark.text


def test_a_file_that_is_included_twice_is_noted_once(noted, tmp_path):
    (tmp_path / "arm.sdf").write_text(
        '<sdf version="1.9"><model name="arm"><foo/><link name="l"><inertial><mass>1</mass>'
        "<inertia/></inertial></link></model></sdf>"
    )
    found = noted(
        "<include><uri>arm.sdf</uri><bar/></include>"
        "<include><uri>arm.sdf</uri><name>other</name></include>"
    )
    assert [remark.element for remark in found] == [
        "element <bar> of <include>",
        "element <foo> of <model>",
    ]
    assert found[1].file == tmp_path / "arm.sdf"
    assert found[1].text.endswith("(line 1)")


def test_hundreds_of_strange_elements_are_not_all_named(noted):
    found = noted("".join(f"<strange_{index}/>" for index in range(300)))
    assert len(found) == 51
    assert found[-1].text == "not in the SDF schema, or not used (250 kinds)"

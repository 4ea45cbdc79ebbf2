"""What is not in SDF's schema is noted, once; what is one's own business is not."""

import pytest

from workbench.plant.formats.sdf import read_sdf
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remark, Remarks


@pytest.fixture
def noted(tmp_path):
    """Return the remarks on a model's content."""

    def note(content: str, version: str = "1.9") -> list[Remark]:
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
        link("<drake:rotor_inertia>1</drake:rotor_inertia>"),
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

"""Oracle: the texts in this folder's conftest, read with the eye."""

import xml.etree.ElementTree as ET

import pytest

from workbench.errors import WorkbenchError
from workbench.plant.description import read_description


def joint_types(urdf: str) -> dict[str, str]:
    return {joint.get("name"): joint.get("type") for joint in ET.fromstring(urdf).iter("joint")}


def fault(path, args=None) -> str:
    with pytest.raises(WorkbenchError) as caught:
        read_description(path, args)
    return str(caught.value)


def test_a_urdf_is_understood(quad, write):
    path = write(quad)
    description = read_description(path)
    assert description.source == path
    assert description.name == "quad"
    assert description.base_link == "base"
    assert description.urdf == quad
    assert [motor.joint for motor in description.motors] == [f"joint_{i}" for i in range(4)]


def test_a_xacro_is_expanded_with_its_arguments(dh_drone, write):
    text = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    text += '<xacro:arg name="n" default="a"/><link name="$(arg n)"/></robot>'
    path = write(text, "a.urdf.xacro")
    assert read_description(path).base_link == "a"
    assert read_description(path, {"n": "b"}).base_link == "b"


def test_only_rotor_joints_are_fixed(quad, write):
    wheel = '<link name="wheel"/><joint name="axle" type="continuous">'
    wheel += '<parent link="base"/><child link="wheel"/></joint></robot>'
    description = read_description(write(quad.replace("</robot>", wheel)))
    fixed = {f"joint_{i}": "fixed" for i in range(4)}
    assert joint_types(description.with_fixed_rotors()) == {**fixed, "axle": "continuous"}
    assert set(joint_types(description.urdf).values()) == {"continuous"}


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<robot", "<model", ("not XML",)),
        ('<parent link="base"/>', '<parent link="bass"/>', ("joint_0", "parent", "'bass'", "base")),
        ('<child link="rotor_0"/>', '<child link="rotr"/>', ("joint_0", "child", "'rotr'")),
        ('<parent link="base"/>', "", ("joint_0", "parent")),
        ('<mass value="1.2"/>', '<mass value="0"/>', ("base", "'0'", "positive mass")),
        ('<mass value="1.2"/>', '<mass value="-1"/>', ("base", "'-1'", "positive mass")),
        ('<mass value="1.2"/>', '<mass value="nan"/>', ("base", "'nan'", "positive mass")),
        ('<mass value="1.2"/>', '<mass value="1.2kg"/>', ("base", "'1.2kg'", "positive mass")),
        ('<mass value="1.2"/>', "<mass/>", ("base", "positive mass")),
        ("</robot>", '<link name="spare"/></robot>', ("2", "base", "spare")),
    ],
)
def test_what_does_not_fit_together_is_named(broken_quad, old, new, words):
    path = broken_quad(old, new)
    said = fault(path)
    assert said.startswith(str(path))
    assert "\n" not in said
    assert not [word for word in words if word not in said]


def test_broken_xml_is_named_with_its_line(write):
    path = write("<robot>\n<link>\n</robot>")
    assert fault(path).startswith(f"{path}:3: ")


def test_a_root_element_that_is_no_robot_is_refused(write):
    assert "<sdf>" in fault(write("<sdf/>"))


def test_a_ring_of_links_has_no_base(write):
    joint = '<joint name="{}{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
    ring = "".join(joint.format(a, b, a, b) for a, b in ("pq", "qp"))
    said = fault(write(f'<robot name="r"><link name="p"/><link name="q"/>{ring}</robot>'))
    assert "0: none" in said


@pytest.mark.parametrize("name", ["gone.urdf", "gone.xacro"])
def test_a_missing_file_is_named(tmp_path, name):
    said = fault(tmp_path / name)
    assert said.startswith(str(tmp_path / name))
    assert "No such file" in said


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "a.urdf"
    path.write_bytes(b"\xff\xfe\x00")
    assert fault(path).startswith(f"{path}: cannot be read")


def test_other_kinds_of_file_are_refused(write, quad):
    assert "not a .xacro or .urdf" in fault(write(quad, "quad.txt"))


def test_a_plain_urdf_takes_no_arguments(write, quad):
    assert "mass" in fault(write(quad), {"mass": "2"})

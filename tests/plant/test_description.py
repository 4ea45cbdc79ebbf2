"""Oracle: the texts in this folder's conftest, read with the eye."""

import dataclasses
import re

import pytest

from tests.installed import FORMATS
from workbench.common.errors import WorkbenchError
from workbench.common.extensions import load_extensions
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle


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
    assert [link.name for link in description.model.links][:2] == ["base", "rotor_0"]
    assert [rotor.joint for rotor in description.rotors] == [f"joint_{i}" for i in range(4)]
    assert "collision of link 'base'" in [remark.element for remark in description.remarks]


def test_a_xacro_is_expanded_with_its_arguments(dh_drone, write):
    text = '<robot name="a" xmlns:xacro="http://www.ros.org/wiki/xacro">'
    text += '<xacro:arg name="n" default="a"/><link name="$(arg n)"/></robot>'
    path = write(text, "a.urdf.xacro")
    assert read_description(path).base_link == "a"
    assert read_description(path, {"n": "b"}).base_link == "b"


def test_a_joint_that_turns_no_rotor_is_held_and_noted(quad, write):
    wheel = '<link name="wheel"/><joint name="axle" type="continuous">'
    wheel += '<parent link="base"/><child link="wheel"/></joint></robot>'
    description = read_description(write(quad.replace("</robot>", wheel)))
    noted = [remark.element for remark in description.remarks if "joint" in remark.element]
    assert noted == ["joint 'axle'"]


def test_undrawn_it_lacks_what_is_only_drawn(dh_drone):
    undrawn = dh_drone.undrawn()
    assert any(link.visuals for link in dh_drone.model.links)
    assert not any(link.visuals for link in undrawn.model.links)
    again = [
        dataclasses.replace(link, visuals=drawn.visuals)
        for link, drawn in zip(undrawn.model.links, dh_drone.model.links, strict=True)
    ]
    assert tuple(again) == dh_drone.model.links
    model = dataclasses.replace(undrawn.model, links=dh_drone.model.links)
    assert dataclasses.replace(undrawn, model=model) == dh_drone


def test_a_link_that_hangs_on_nothing_is_left_out(quad, write):
    description = read_description(write(quad.replace("</robot>", '<link name="spare"/></robot>')))
    assert "spare" not in [link.name for link in description.model.links]
    assert "link 'spare'" in [remark.element for remark in description.remarks]


def test_plugins_of_gazebos_own_are_listed(quad, write):
    plugin = '<gazebo><plugin name="wind" filename="libwind.so"/></gazebo></robot>'
    description = read_description(write(quad.replace("</robot>", plugin)))
    (remark,) = [remark for remark in description.remarks if remark.kind == "ignored"]
    assert remark.element == "plugin 'wind'"
    assert "libwind.so" in remark.text


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("<robot", "<model", ("not XML",)),
        ('<parent link="base"/>', '<parent link="bass"/>', ("joint_0", "parent", "'bass'", "base")),
        ('<child link="rotor_0"/>', '<child link="rotr"/>', ("joint_0", "child", "'rotr'")),
        ('<parent link="base"/>', "", ("joint_0", "parent")),
        ('<mass value="1.2"/>', '<mass value="-1"/>', ("base", "mass -1")),
        ('<mass value="1.2"/>', '<mass value="nan"/>', ("mass", "'nan'")),
        ('<mass value="1.2"/>', '<mass value="1.2kg"/>', ("mass", "'1.2kg'")),
        ('<mass value="1.2"/>', "<mass/>", ("mass", "without value")),
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


def test_a_folder_stands_for_the_description_in_it(quad, write):
    path = write(quad)
    assert read_description(path.parent).source == path


def test_a_ring_of_links_has_no_base(write):
    joint = '<joint name="{}{}" type="fixed"><parent link="{}"/><child link="{}"/></joint>'
    ring = "".join(joint.format(a, b, a, b) for a, b in ("pq", "qp"))
    said = fault(write(f'<robot name="r"><link name="p"/><link name="q"/>{ring}</robot>'))
    assert "form a loop" in said


@pytest.mark.parametrize("name", ["gone.urdf", "gone.xacro"])
def test_a_missing_file_is_named(tmp_path, name):
    said = fault(tmp_path / name)
    assert said.startswith(str(tmp_path / name))
    assert "no such file" in said


def test_a_file_that_is_no_text_is_refused(tmp_path):
    path = tmp_path / "a.urdf"
    path.write_bytes(b"\xff\xfe\x00")
    assert fault(path).startswith(f"{path}:1: not XML")


def test_the_content_counts_where_the_name_says_nothing(write, quad):
    assert read_description(write(quad, "quad.gazebo")).name == "quad"
    assert "the root element is <model>" in fault(write("<model/>", "quad.txt"))


@pytest.mark.parametrize(
    ("name", "text", "what"),
    [
        ("a.sdf", "<sdf version='1.9'/>", "SDF (<sdf>)"),
        ("a.xml", "<mujoco/>", "MJCF (<mujoco>)"),
        ("a.urdf", "<robot name='a'><link name='b'/>{}</robot>", "gym-pybullet-drones"),
    ],
)
def test_what_no_installed_package_reads_is_named_with_the_package_that_does(
    write, monkeypatch, name, text, what
):
    monkeypatch.setattr("workbench.common.extensions.find_extensions", lambda group: {})
    load_extensions.cache_clear()
    try:
        path = write(text.format("<properties kf='1e-9' km='1e-11'/>"), name)
        said = fault(path)
    finally:
        load_extensions.cache_clear()
    assert said.startswith(f"{path}: it looks like ") and what in said
    assert "which the package workbench.extras.formats reads: install" in said
    assert "\n" not in said


def test_a_gazebo_models_folder_that_no_installed_package_reads_is_named(tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.common.extensions.find_extensions", lambda group: {})
    load_extensions.cache_clear()
    try:
        (tmp_path / "model.config").touch()
        assert "the folder of a Gazebo model, which the package" in fault(tmp_path)
        (tmp_path / "model.config").unlink()
        assert fault(tmp_path) == f"{tmp_path}: no .xacro or .urdf file in this folder"
    finally:
        load_extensions.cache_clear()


XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'


def test_xacro_in_a_urdf_is_expanded(write):
    text = f'<robot name="a" {XACRO}><xacro:if value="1"><link name="b"/></xacro:if></robot>'
    assert read_description(write(text, "a.urdf")).base_link == "b"


def test_a_plain_urdf_takes_no_arguments(write, quad):
    assert "mass" in fault(write(quad), {"mass": "2"})


def many(kind: str, count: int) -> tuple[str, str]:
    """Return a file and its text with a number of links or shapes."""
    box = {
        "urdf": '<{0}><geometry><box size="1 1 1"/></geometry></{0}>',
        "sdf": '<{0} name="{0}{1}"><geometry><box><size>1 1 1</size></box></geometry></{0}>',
    }
    format_, _, what = kind.partition(" ")
    if format_ == "mjcf":
        part = {"links": '<body><geom size="1"/></body>', "shapes": '<geom size="1"/>'}
        part["collisions"] = '<geom size="1" group="4"/>'
        return "a.xml", (
            f"<mujoco><worldbody><body><freejoint/>{part[what] * count}</body></worldbody></mujoco>"
        )
    shape = {"shapes": "visual", "collisions": "collision"}.get(what, "")
    inside = "".join(box[format_].format(shape, i) for i in range(count)) if shape else ""
    links = "" if shape else "".join(f'<link name="l{i}"/>' for i in range(count))
    content = f'<link name="base">{inside}</link>{links}'
    if format_ == "urdf":
        return "a.urdf", f'<robot name="a">{content}</robot>'
    return "a.sdf", f'<sdf version="1.9"><model name="a">{content}</model></sdf>'


@pytest.mark.parametrize(
    ("kind", "count", "said"),
    [
        *(
            (f"{format_} {what}", count, said)
            for format_ in ("urdf", *(("sdf", "mjcf") if FORMATS else ()))
            for what, count, said in (
                ("links", 500, "it has 501 links, more than 500"),
                ("shapes", 1001, "it has 1001 shapes, more than 1000"),
                ("collisions", 301, "it has 301 collision shapes, more than 300"),
            )
        )
    ],
)
def test_too_many_parts_are_refused_before_they_are_read(write, monkeypatch, kind, count, said):
    monkeypatch.setattr("workbench.plant.tree.links_below", None)  # nothing is done with them
    name, text = many(kind, count)
    path = write(text, name)
    assert fault(path) == f"{path}: {said}: give the file of one drone"


def test_a_name_of_any_length_is_a_sentence(quad, write, case):
    """Drake's parser ends the process at a name of 100,000 characters."""
    for kind, name in (("link", "base"), ("link", "rotor_0"), ("joint", "joint_0")):
        assert f'"{name}"' in quad or f">{name}<" in quad
        for length in (1000, 1001, 100_000):
            with case(kind, name, length):
                path = write(re.sub(rf"\b{name}\b", "x" * length, quad))
                if length == 1000:
                    assert make_vehicle(read_description(path)).mass > 0.0
                else:
                    assert f"{kind} 'xxx" in fault(path)
                    assert fault(path).endswith("is longer than 1,000 characters: shorten it")


INERTIAL = (
    '<inertial><mass value="{0}"/><inertia ixx="{0}" iyy="{0}" izz="{0}" ixy="0" ixz="0" iyz="0"/>'
    "</inertial>"
)
MOTOR = (
    '<gazebo><plugin name="m{0}" filename="libgazebo_motor_model.so"><jointName>{1}-{0}</jointName>'
    "<linkName>{0}</linkName><turningDirection>{2}</turningDirection>"
    "<maxRotVelocity>1000</maxRotVelocity><motorConstant>8e-06</motorConstant>"
    "<momentConstant>0.016</momentConstant></plugin></gazebo>"
)


def drone_beside_a_chain(path, carriers):
    """Write a hull of 1 kg with four rotors, some on a longer chain that nothing connects."""
    parts = [f'<link name="{name}">{INERTIAL.format(1.0)}</link>' for name in ("hull", "c0")]
    for name, parent in (("c1", "c0"), ("c2", "c1"), ("c3", "c2"), ("c4", "c3"), ("c5", "c4")):
        parts.append(f'<link name="{name}">{INERTIAL.format(0.01)}</link>')
        parts.append(
            f'<joint name="{parent}-{name}" type="revolute"><parent link="{parent}"/>'
            f'<child link="{name}"/><axis xyz="0 1 0"/>'
            '<limit lower="-1" upper="1" effort="1" velocity="1"/></joint>'
        )
    for rotor, (x, y), turn in zip(
        ("r0", "r1", "r2", "r3"),
        ((1, 1), (-1, 1), (-1, -1), (1, -1)),
        ("ccw", "cw", "ccw", "cw"),
        strict=True,
    ):
        carrier = carriers.get(rotor, "hull")
        parts.append(f'<link name="{rotor}">{INERTIAL.format(0.01)}</link>')
        parts.append(
            f'<joint name="{carrier}-{rotor}" type="continuous"><parent link="{carrier}"/>'
            f'<child link="{rotor}"/><origin xyz="{x} {y} 0"/><axis xyz="0 0 1"/></joint>'
        )
        parts.append(MOTOR.format(rotor, carrier, turn))
    path.write_text(f'<robot name="drone">{"".join(parts)}</robot>')
    return path


def test_of_trees_that_nothing_connects_the_drone_is_the_one_with_the_rotors(tmp_path):
    drone = read_description(drone_beside_a_chain(tmp_path / "two.urdf", {}))
    assert drone.base_link == "hull"
    assert sum(link.inertial.mass for link in drone.model.links) == pytest.approx(1.04)
    left_out = [each.element for each in drone.remarks if "no joint connects it" in each.text]
    assert left_out == [f"link 'c{number}'" for number in range(6)]
    both = drone_beside_a_chain(tmp_path / "both.urdf", {"r2": "c0"})
    with pytest.raises(WorkbenchError, match=r"no joint connects the links 'r\d' and 'r\d', which"):
        read_description(both)

"""The package of messages for users of ROS 2."""

import re
import xml.etree.ElementTree as ElementTree

import pytest

from workbench.commands.cli import main
from workbench.link.ros_messages.library import own_types, schema_text

NEEDED = {"std_msgs", "builtin_interfaces"}


def write(folder):
    return main(["gateway", "ros2", "--write-messages", str(folder)])


@pytest.fixture
def package(tmp_path):
    assert write(tmp_path) == 0
    return tmp_path / "dh_drone_msgs"


def test_each_type_of_ours_is_a_file_with_its_definition(package):
    files = {path.stem: path.read_text() for path in (package / "msg").iterdir()}
    assert set(files) == {name.rsplit("/")[-1] for name in own_types()}
    assert "VelocityData" in files
    for name, text in files.items():
        assert schema_text(f"dh_drone_msgs/msg/{name}").startswith(text)


def test_the_manifest_names_what_the_messages_need(package):
    root = ElementTree.parse(package / "package.xml").getroot()
    assert root.findtext("name") == "dh_drone_msgs"
    assert {each.text for each in root.iter("depend")} == NEEDED
    assert root.findtext("member_of_group") == "rosidl_interface_packages"
    tools = {each.text for each in root.iter("buildtool_depend")}
    assert tools == {"ament_cmake", "rosidl_default_generators"}


def test_the_build_makes_each_message(package):
    text = (package / "CMakeLists.txt").read_text()
    assert text.count("(") == text.count(")")
    made = re.search(r"rosidl_generate_interfaces\((.*?)\)", text, re.DOTALL)[1]
    listed = re.findall(r'"(msg/\w+\.msg)"', made)
    assert sorted(listed) == sorted(f"msg/{path.name}" for path in (package / "msg").iterdir())
    assert set(made.split("DEPENDENCIES")[1].split()) == NEEDED
    for name in NEEDED:
        assert f"find_package({name} REQUIRED)" in text


def test_it_is_written_again_in_its_place(package):
    (package / "msg" / "VelocityData.msg").write_text("old")
    assert write(package.parent) == 0
    assert "v_x" in (package / "msg" / "VelocityData.msg").read_text()


def test_what_is_not_ours_is_left_alone(tmp_path, capsys):
    (tmp_path / "dh_drone_msgs").mkdir()
    (tmp_path / "dh_drone_msgs" / "notes.txt").write_text("mine")
    assert write(tmp_path) == 2
    assert "the folder has something other than the package" in capsys.readouterr().err
    assert [path.name for path in (tmp_path / "dh_drone_msgs").iterdir()] == ["notes.txt"]


def test_a_folder_that_cannot_be_written_is_named(tmp_path, capsys):
    (tmp_path / "file").write_text("")
    assert write(tmp_path / "file") == 2
    assert "cannot be written" in capsys.readouterr().err

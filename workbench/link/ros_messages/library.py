"""The message definitions, one file per type below msg/, and our package for ROS 2.

A type of ours without a file has the fields of its signal.

Users of ROS 2 build the package dh_drone_msgs, which is written from these definitions.
"""

from collections.abc import Callable
from functools import cache
from pathlib import Path

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_files import read_plain_text
from workbench.common.resources import existing_path
from workbench.link.drone_topics import drone_signals
from workbench.link.ros_messages.definitions import SCHEMA_SEPARATOR, Definition, read_definition
from workbench.link.signal import ROS_PACKAGE

MSG_FOLDER = Path(__file__).parent / "msg"


@cache
def type_names() -> tuple[str, ...]:
    """Return the names of all types, such as std_msgs/msg/Header."""
    return tuple(sorted(_texts()))


@cache
def _texts() -> dict[str, str]:
    """Return the texts of all definitions by type."""
    texts = {
        f"{ROS_PACKAGE}/msg/{row.own_type}": row.definition_text
        for row in drone_signals()
        if row.own_type
    }
    return texts | {
        f"{file.parent.name}/msg/{file.stem}": file.read_text(encoding="utf-8")
        for file in MSG_FOLDER.glob("*/*.msg")
    }


@cache
def definition(name: str) -> Definition:
    """Return the definition of a type by its name, such as std_msgs/msg/Header.

    Raises:
        WorkbenchError: if it is unknown.
    """
    if name not in type_names():
        raise unknown_name("type of message", name, type_names())
    return read_definition(name, _texts()[name])


@cache
def included(name: str, find: Callable[[str], Definition] = definition) -> tuple[Definition, ...]:
    """Return the definitions of a type, and then of all types included in it, each once.

    Args:
        name: of the type.
        find: returns the definition of a type by its name.
    """
    found: dict[str, Definition] = {}
    todo = [name]
    while todo:
        now = find(todo.pop(0))
        if now.name not in found:
            found[now.name] = now
            todo += [field.type for field in now.fields if field.nested]
    return tuple(found.values())


@cache
def schema_text(name: str) -> str:
    """Return the schema of a type for files and viewers, with all types included in it."""
    first, *others = included(name)
    parts = [
        f"{SCHEMA_SEPARATOR}\nMSG: {other.name.replace('/msg/', '/')}\n{other.text}"
        for other in others
    ]
    return first.text + "".join(parts)


ROS_PACKAGE_VERSION = "0.1.0"
MAX_MANIFEST_BYTES = 1_000_000
"""Size limit of a package's manifest."""


def package_files(folder: Path) -> dict[Path, str]:
    """Return the files of a package for ament_cmake, and their texts.

    Args:
        folder: for the folder of the package, such as the src of a workspace.

    Raises:
        WorkbenchError: if something else has its name.
    """
    package = folder / ROS_PACKAGE
    manifest = package / "package.xml"
    there = existing_path(str(manifest))
    if existing_path(str(package)) and not (
        there and ROS_PACKAGE in read_plain_text(there, MAX_MANIFEST_BYTES)
    ):
        raise WorkbenchError(
            f"{package}: the folder has something other than the package {ROS_PACKAGE}: name "
            "another "
            "folder"
        )
    files = {manifest: _manifest(), package / "CMakeLists.txt": _build()}
    for name in own_types():
        plain = name.rpartition("/")[2]
        files[package / "msg" / f"{plain}.msg"] = definition(name).text
    return files


def own_types() -> list[str]:
    """Return the names of the types in our package."""
    return [name for name in type_names() if name.startswith(f"{ROS_PACKAGE}/")]


def _needed() -> list[str]:
    """Return the packages with included types."""
    names = {each.name.partition("/")[0] for name in own_types() for each in included(name)}
    return sorted(names - {ROS_PACKAGE})


def _manifest() -> str:
    needs = "".join(f"  <depend>{name}</depend>\n" for name in _needed())
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{ROS_PACKAGE}</name>
  <version>{ROS_PACKAGE_VERSION}</version>
  <description>Messages of the drone of drake-drone-workbench</description>
  <maintainer email="nobody@example.com">drake-drone-workbench</maintainer>
  <license>GPL-3.0-or-later</license>
  <buildtool_depend>ament_cmake</buildtool_depend>
  <buildtool_depend>rosidl_default_generators</buildtool_depend>
{needs}  <exec_depend>rosidl_default_runtime</exec_depend>
  <member_of_group>rosidl_interface_packages</member_of_group>
  <export>
    <build_type>ament_cmake</build_type>
  </export>
</package>
"""


def _build() -> str:
    files = "".join(f'  "msg/{name.rpartition("/")[2]}.msg"\n' for name in own_types())
    found = "".join(f"find_package({name} REQUIRED)\n" for name in _needed())
    return f"""cmake_minimum_required(VERSION 3.8)
project({ROS_PACKAGE})

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{found}
rosidl_generate_interfaces(${{PROJECT_NAME}}
{files}  DEPENDENCIES {" ".join(_needed())}
)

ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""

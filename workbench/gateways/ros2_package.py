"""The package dh_drone_msgs for users of ROS 2 to build, written from the definitions in use."""

from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.gateways.ros_messages.library import definition, included, type_names

PACKAGE = "dh_drone_msgs"
VERSION = "0.1.0"


def write_package(folder: Path) -> list[Path]:
    """Write a package of ament_cmake, and return its files.

    Args:
        folder: where the package's folder is made, as the src of a workspace.

    Raises:
        WorkbenchError: if something else stands there, or it cannot be written.
    """
    package = folder / PACKAGE
    manifest = package / "package.xml"
    if package.exists() and not (manifest.is_file() and PACKAGE in manifest.read_text()):
        raise WorkbenchError(
            f"{package}: something else than the package {PACKAGE} stands there: name another "
            "folder"
        )
    files = {manifest: _manifest(), package / "CMakeLists.txt": _build()}
    for name in own_types():
        plain = name.rpartition("/")[2]
        files[package / "msg" / f"{plain}.msg"] = definition(name).text
    try:
        (package / "msg").mkdir(parents=True, exist_ok=True)
        for path, text in files.items():
            path.write_text(text, encoding="utf-8")
    except OSError as error:
        raise WorkbenchError(f"{package}: cannot be written: {error.strerror or error}") from None
    return list(files)


def own_types() -> list[str]:
    """Return the names of the package's types."""
    return [name for name in type_names() if name.startswith(f"{PACKAGE}/")]


def _needed() -> list[str]:
    """Return the packages whose types are included."""
    names = {each.name.partition("/")[0] for name in own_types() for each in included(name)}
    return sorted(names - {PACKAGE})


def _manifest() -> str:
    needs = "".join(f"  <depend>{name}</depend>\n" for name in _needed())
    return f"""<?xml version="1.0"?>
<package format="3">
  <name>{PACKAGE}</name>
  <version>{VERSION}</version>
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
project({PACKAGE})

find_package(ament_cmake REQUIRED)
find_package(rosidl_default_generators REQUIRED)
{found}
rosidl_generate_interfaces(${{PROJECT_NAME}}
{files}  DEPENDENCIES {" ".join(_needed())}
)

ament_export_dependencies(rosidl_default_runtime)
ament_package()
"""

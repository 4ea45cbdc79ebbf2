"""Read a drone description: from xacro or URDF file to URDF text and the rotors it declares."""

import xml.etree.ElementTree as ET
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import WorkbenchError
from workbench.plant.inertia_check import check_inertias
from workbench.plant.motor_model import MotorModel, read_motor_models
from workbench.plant.xacro import expand_xacro


@dataclass(frozen=True)
class Description:
    """A drone description, expanded and checked as far as text alone allows.

    Attributes:
        source: the file that was read.
        name: the robot's name.
        base_link: the link that no joint has as its child.
        urdf: URDF text as described, with joints that turn.
        motors: the motor models it declares, by motor number.
    """

    source: Path
    name: str
    base_link: str
    urdf: str
    motors: tuple[MotorModel, ...]

    def with_fixed_rotors(self) -> str:
        """Return the URDF text with every rotor's joint fixed.

        The dynamics treat rotors at any speed as part of one rigid body (their spin lives in the
        rotor lag, their gyroscopic moment is neglected); only the picture turns them.
        """
        root = ET.fromstring(self.urdf)
        turning = {motor.joint for motor in self.motors}
        for joint in root.iter("joint"):
            if joint.get("name") in turning:
                joint.set("type", "fixed")
        for mesh in root.iter("mesh"):  # Drake reads text, which lies in no folder
            name = mesh.get("filename", "")
            if name and "://" not in name:
                mesh.set("filename", (self.source.parent / name).resolve().as_uri())
        return ET.tostring(root, encoding="unicode")


def read_description(path: Path, args: Mapping[str, str] | None = None) -> Description:
    """Read a `.xacro` or `.urdf` file.

    Args:
        path: the file.
        args: values for the file's xacro arguments.

    Raises:
        WorkbenchError: if it cannot be expanded, is no robot, or its parts do not fit together.
    """
    if path.suffix not in (".xacro", ".urdf"):
        raise WorkbenchError(f"{path}: not a .xacro or .urdf file")
    if path.suffix == ".urdf" and args:
        raise WorkbenchError(f"{path}: a plain URDF takes no arguments ({', '.join(args)})")
    urdf = expand_xacro(path, args or {}) if path.suffix == ".xacro" else _read(path)
    try:
        root = ET.fromstring(urdf)
    except ET.ParseError as error:
        raise WorkbenchError(f"{path}:{error.position[0]}: not XML: {error}") from error
    if root.tag != "robot":
        raise WorkbenchError(f"{path}: the root element is <{root.tag}>, a URDF has <robot>")
    _check_links_and_joints(path, root)
    check_inertias(path, root)
    return Description(
        source=path,
        name=root.get("name", path.stem),
        base_link=_base_link(path, root),
        urdf=urdf,
        motors=read_motor_models(path, root),
    )


def _read(path: Path) -> str:
    try:
        return path.read_text(encoding="utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise WorkbenchError(f"{path}: cannot be read: {error}") from error


def _names(root: ET.Element, tag: str) -> list[str]:
    return [element.get("name", "") for element in root.findall(tag)]


def _check_links_and_joints(path: Path, root: ET.Element) -> None:
    """Refuse references to missing links, and masses and inertias that no body can have."""
    links = _names(root, "link")
    for joint in root.findall("joint"):
        for end in ("parent", "child"):
            element = joint.find(end)
            link = "" if element is None else element.get("link", "")
            if link not in links:
                raise WorkbenchError(
                    f"{path}: joint '{joint.get('name')}' has the {end} link '{link}', which is "
                    f"not there: links are {', '.join(links)}"
                )
    for body in root.findall("link"):
        mass = body.find("inertial/mass")
        text = "1" if mass is None else mass.get("value", "")
        if not _number(text) > 0.0:
            raise WorkbenchError(
                f"{path}: link '{body.get('name')}' has the mass '{text}': give it a positive mass"
            )


def _number(text: str) -> float:
    """Return a number, or NaN where the text is none."""
    try:
        return float(text)
    except ValueError:
        return float("nan")


def _base_link(path: Path, root: ET.Element) -> str:
    """Return the one link that is no joint's child."""
    children = {child.get("link") for child in root.findall("joint/child")}
    roots = [name for name in _names(root, "link") if name not in children]
    if len(roots) != 1:
        raise WorkbenchError(
            f"{path}: a drone has one link that no joint has as its child, here are "
            f"{len(roots)}: {', '.join(roots) or 'none'}"
        )
    return roots[0]

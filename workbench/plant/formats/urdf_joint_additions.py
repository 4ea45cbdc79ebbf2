"""What elements outside a URDF's joints add to them: springs, and inertias of motors."""

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import cast

from workbench.plant.formats.block import XmlBlock
from workbench.plant.formats.values import attribute_number, shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.model import Joint
from workbench.plant.remarks import Remarks


def with_joint_additions(
    path: Path, robot: Element, joints: Sequence[Joint], remarks: Remarks
) -> tuple[Joint, ...]:
    """Return joints with springs of `<gazebo>` blocks and inertias of transmissions' motors.

    Args:
        path: the file, for remarks.
        robot: its root element.
        joints: as their own elements state them.
        remarks: receives a remark on what names no joint of one axis.

    Raises:
        WorkbenchError: with file and line, for an invalid number.
    """
    found = {joint.name: joint for joint in joints}
    additions = [*_springs(robot), *_motor_inertias(robot)]
    for what, name, numbers in additions:
        joint = found.get(name)
        if joint is None or len(joint.freedoms) != 1 or joint.kind == "ball":
            text = "it acts in joints that turn or slide along one axis"
            remarks.add("ignored", path, f"<{what}> of '{shortened_text(name)}'", text)
            continue
        (own,) = joint.freedoms
        freedom = replace(
            own,
            stiffness=numbers.get("stiffness", own.stiffness),
            rest=numbers.get("rest", own.rest),
            armature=own.armature + numbers.get("armature", 0.0),
        )
        found[name] = replace(joint, freedoms=(freedom,))
    return tuple(found.values())


_Addition = tuple[str, str, Mapping[str, float]]
"""The element, the name of its joint, and numbers of the joint's freedom."""


def _springs(robot: Element) -> list[_Addition]:
    found: list[_Addition] = []
    for block in cast("list[Element]", robot.findall("gazebo")):
        name = block.get("reference", "")
        tags = XmlBlock(f"<gazebo> block of '{shortened_text(name)}'", block)
        if tags.has("springStiffness"):
            stiffness = tags.non_negative("springStiffness", 0.0)
            rest = tags.number("springReference", 0.0)
            found.append(("springStiffness", name, {"stiffness": stiffness, "rest": rest}))
    return found


def simple_actuators(robot: Element) -> list[tuple[str, Element]]:
    """Return the motors of the transmissions that Drake reads, each with the name of its joint."""
    return [
        (joint.get("name", ""), motor)
        for drive in robot.findall("transmission")
        if "SimpleTransmission" in (drive.findtext("type") or drive.get("type", ""))
        for joint in drive.findall("joint")[:1]
        for motor in cast("list[Element]", drive.findall("actuator"))
    ]


def _motor_inertias(robot: Element) -> list[_Addition]:
    """Return the reflected inertias of motors, as in Drake: gear ratio² times rotor inertia."""
    found: list[_Addition] = []
    for joint, motor in simple_actuators(robot):
        inertia, ratio = (
            attribute_number(element, "value") if isinstance(element, Element) else usual
            for tag, usual in (("rotor_inertia", 0.0), ("gear_ratio", 1.0))
            for element in (motor.find(f"drake:{tag}"),)
        )
        if inertia:
            found.append(("drake:rotor_inertia", joint, {"armature": ratio**2 * inertia}))
    return found

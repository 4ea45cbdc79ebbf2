"""Read servos from `<ros2_control>` and `<transmission>`, which state no gains."""

import math
from collections.abc import Iterator

from workbench.plant.formats.block import MAX_BLOCK_NUMBER, XmlBlock
from workbench.plant.formats.xml import Element
from workbench.plant.servo import SERVO_KINDS, Servo
from workbench.plant.servo_sources.declared import DeclaredServo


def ros_servos(drive: Element) -> Iterator[DeclaredServo]:
    """Yield the servos of an element of ROS's control.

    Args:
        drive: a `<ros2_control>` or a `<transmission>`.

    Raises:
        WorkbenchError: with file and line, for an invalid number.
    """
    for joint in drive.findall("joint"):
        if not isinstance(joint, Element):
            continue
        name = joint.get("name", "")
        servo = _commanded(joint) if drive.tag == "ros2_control" else _transmitted(drive, joint)
        if servo:
            yield DeclaredServo(name, 0, servo, drive.file, f"<{drive.tag}>")


def _commanded(joint: Element) -> Servo | None:
    """Return the servo of the first interface of ros2_control; None without one.

    Its first setpoint is the `initial_value` of the joint's state of the commanded kind, where
    Gazebo begins; other states do not count.
    """
    faces, states = (
        {
            each.get("name", "").rpartition("/")[2]: each
            for each in joint.findall(tag)
            if isinstance(each, Element)
        }
        for tag in ("command_interface", "state_interface")
    )
    for kind in SERVO_KINDS:
        if kind in faces:
            least, most = (_parameter(faces[kind], name) for name in ("min", "max"))
            first = _parameter(states[kind], "initial_value") if kind in states else None
            start = first or 0.0
            low = -math.inf if least is None else least
            high = math.inf if most is None else most
            if not low < high:
                low, high = -math.inf, math.inf
            return Servo(kind, lower=low, upper=high, start=start)
    return None


def _parameter(face: Element, name: str) -> float | None:
    """Return a number of an interface of ros2_control, None without it."""
    for each in face.findall("param"):
        if isinstance(each, Element) and each.get("name") == name:
            block = Element(face.tag)
            block.append(each)
            value = XmlBlock(face.tag, block).number("param", 0.0)
            return value if abs(value) < MAX_BLOCK_NUMBER else None
    return None


def _transmitted(drive: Element, joint: Element) -> Servo:
    """Return the servo of a joint of a transmission; without an interface it is one of effort."""
    faces = [*joint.findall("hardwareInterface"), *drive.findall("actuator/hardwareInterface")]
    text = " ".join((each.text or "") for each in faces).lower()
    return Servo(next((kind for kind in SERVO_KINDS if f"{kind}joint" in text), "effort"))

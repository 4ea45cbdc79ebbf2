"""Read servos from plugins of Gazebo Classic, as PX4 and RotorS have them.

These are the channels of the MAVLink interface of type `position`, the gimbal controller, and motor
models of the type `position`. All state their gains in `<joint_control_pid>`.
"""

import math
from collections.abc import Iterator

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import XmlBlock
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks
from workbench.plant.servo import Servo
from workbench.plant.servo_sources.declared import DeclaredServo

_MAVLINK_FILE = "gazebo_mavlink_interface"
_GIMBAL_FILE = "gazebo_gimbal_controller"
_MOTOR_FILE = "gazebo_motor_model"
_GIMBAL_SERVOS = {
    "joint_yaw": ("cgo3_vertical_arm_joint", Servo(stiffness=1.0, damping=0.0, max_effort=1.0)),
    "joint_roll": ("cgo3_horizontal_arm_joint", Servo(stiffness=5.0, damping=0.0, max_effort=0.3)),
    "joint_pitch": ("cgo3_camera_joint", Servo(stiffness=5.0, damping=0.0, max_effort=0.3)),
}
"""Defaults of the gimbal controller by the tags that name joints: the joint, and its servo."""
_GIMBAL_NOTE = "Gazebo holds the camera level by its IMU; here its joints are held"


def has_classic_servos(plugin: Element) -> bool:
    """Return whether a plugin of Gazebo Classic names joints that it drives."""
    return any(True for _ in _channels(plugin))


def classic_servos(plugin: Element, remarks: Remarks) -> Iterator[DeclaredServo]:
    """Yield the servos of a plugin of Gazebo Classic, none for any other plugin.

    Args:
        plugin: of any class.
        remarks: receives remarks on servos without valid numbers, which are not used.
    """
    for tags, joint, usual, notes in _channels(plugin):
        yield from _servo(tags, joint, usual, notes, remarks)


_Notes = tuple[tuple[str, str], ...]


def _channels(plugin: Element) -> Iterator[tuple[XmlBlock, str, Servo, _Notes]]:
    """Yield what has the gains of a joint, its name, the servo without gains, and notes on it."""
    file = plugin.get("filename", "")
    if _MAVLINK_FILE in file:
        for channel in _elements(plugin, "control_channels/channel"):
            tags = XmlBlock("MAVLink interface", channel)
            joint = tags.text("joint_name")
            kind = tags.text("joint_control_type")
            if joint and kind in ("position", "position_kinematic"):
                yield tags, joint, Servo(), ()
    elif _GIMBAL_FILE in file:
        tags = XmlBlock("gimbal controller", plugin)
        channels = {
            (each.findtext("joint_axis") or "").strip(): each
            for each in _elements(plugin, "control_gimbal_channels/channel")
        }
        for tag, (joint, usual) in _GIMBAL_SERVOS.items():
            channel = XmlBlock(tags.what, channels.get(tag, plugin), tag in channels)
            yield channel, tags.text(tag) or joint, usual, ((tags.what, _GIMBAL_NOTE),)
    elif _MOTOR_FILE in file and (plugin.findtext("motorType") or "").strip() == "position":
        tags = XmlBlock("motor model", plugin)
        joint = tags.text("jointName")
        if joint:
            yield tags, joint, Servo(), ()


def _elements(plugin: Element, path: str) -> list[Element]:
    return [each for each in plugin.findall(path) if isinstance(each, Element)]


def _servo(
    tags: XmlBlock, joint: str, usual: Servo, notes: _Notes, remarks: Remarks
) -> Iterator[DeclaredServo]:
    """Yield the servo of a joint, none with invalid numbers.

    Args:
        tags: the element with its `<joint_control_pid>`.
        joint: its name.
        usual: the servo without gains in the file.
        notes: on the servo.
        remarks: receives a remark on an invalid number.
    """
    servo, gains = usual, tags.block("joint_control_pid")
    what = f"servo of '{shortened_text(joint)}'"
    if gains.there:
        try:
            most, least = (gains.number(tag, 0.0) for tag in ("cmdMax", "cmdMin"))
            servo = Servo(
                stiffness=gains.non_negative("p", 0.0),
                damping=gains.non_negative("d", 0.0),
                start=tags.number("zero_position_disarmed", 0.0),
                max_effort=max(abs(most), abs(least)) if most > least else math.inf,
            )
            integral = gains.number("i", 0.0)
        except WorkbenchError as error:
            text = str(error).rpartition(f"{tags.what} has ")[2]
            remarks.add("ignored", tags.file, what, f"{text}; not used")
            return
        if integral:
            notes = ((what, f"its integral gain of {integral:g} is not used"), *notes)
    yield DeclaredServo(joint, 0, servo, tags.file, tags.what, notes)

"""Read servos from Gazebo's plugins that control joints.

Defaults are those of gz-sim's systems of the same names.
"""

import math
from collections.abc import Iterator, Sequence

from workbench.plant.formats.block import XmlBlock
from workbench.plant.formats.values import is_zero_text, listed_names, shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks
from workbench.plant.servo import Servo
from workbench.plant.servo_sources.declared import DeclaredServo

_PLUGINS = {
    "JointPositionController": "joint-position-controller",
    "JointTrajectoryController": "joint-trajectory-controller",
    "JointController": "joint-controller",
    "ApplyJointForce": "apply-joint-force",
}
"""Classes of the plugins, and a part of the names of their files."""
_GAINS_USED = {
    "JointPositionController": ("p_gain", "d_gain", "i_gain"),
    "JointTrajectoryController": ("position_p_gain", "position_d_gain", "velocity_p_gain"),
    "JointController": ("p_gain", "i_gain"),
    "ApplyJointForce": (),
}
"""Gains that are read, by class; those of integrals have a remark of their own."""
_MOST = 1000.0
"""Gazebo's limit of a command that is not stated."""


def joint_plugin_class(plugin: Element) -> str:
    """Return the class of a plugin that controls joints, "" for any other plugin."""
    name, file = plugin.get("name", "").strip(), plugin.get("filename", "")
    for known, part in _PLUGINS.items():
        if name.endswith(f"::{known}") or f"-{part}-" in file or file.endswith(f"-{part}"):
            return known
    return ""


def plugin_servos(plugin: Element, remarks: Remarks) -> Iterator[DeclaredServo]:
    """Yield the servos of a plugin that controls joints.

    Args:
        plugin: of a class that `joint_plugin_class` knows.
        remarks: receives remarks on what is not used.

    Raises:
        WorkbenchError: with file and line, for an invalid number.
    """
    kind = joint_plugin_class(plugin)
    tags = XmlBlock(f"{kind} plugin", plugin)
    places = [each for each in plugin.iter("joint_name") if isinstance(each, Element)]
    unused = list(_unused_terms(plugin, _GAINS_USED[kind]))
    if unused:
        text = f"{listed_names(unused)}: not used"
        remarks.add("ignored", plugin.file, f"{kind} plugin of '{tags.text('joint_name')}'", text)
    axis = int(tags.number("joint_index", 0.0)) if tags.has("joint_index") else 0
    for number, place in enumerate(places):
        name = (place.text or "").strip()
        match kind:
            case "JointPositionController":
                servo = _position(tags)
                gain = tags.number("i_gain", 0.1)
                idle = tags.number("i_max", 1.0) == tags.number("i_min", -1.0) == 0.0
            case "JointTrajectoryController":
                servo, gain, idle = _trajectory(plugin, number), 0.0, True
            case "JointController":
                servo, gain, idle = _velocity(tags), tags.number("i_gain", 0.0), False
            case _:
                servo, gain, idle = Servo("effort"), 0.0, True
        notes: tuple[tuple[str, str], ...] = ()
        if gain and not idle and servo.damping is not None:
            text = f"its integral gain of {gain:g} is not used"
            notes = ((f"servo of '{shortened_text(name)}'", text),)
        yield DeclaredServo(name, axis, servo, plugin.file, f"{kind} plugin", notes)


def _unused_terms(plugin: Element, used: Sequence[str]) -> Iterator[str]:
    """Yield the gains and offsets of a plugin that act in Gazebo, and not here."""
    for child in plugin:
        tag, text = str(child.tag), (child.text or "").strip()
        acts = tag.endswith(("_gain", "cmd_offset")) and tag not in used
        if acts and not is_zero_text(text):
            yield f"<{tag}>{text}"


def _position(tags: XmlBlock) -> Servo:
    """Return the servo of a JointPositionController."""
    start, most = tags.number("initial_position", 0.0), tags.number("cmd_max", _MOST)
    if tags.text("use_velocity_commands").lower() in ("1", "true"):
        return Servo(start=start, max_rate=most if 0.0 < most < _MOST else math.inf)
    return Servo(
        stiffness=tags.number("p_gain", 1.0),
        damping=tags.number("d_gain", 0.01),
        start=start,
        max_effort=_symmetric(most, tags.number("cmd_min", -_MOST)),
    )


def _velocity(tags: XmlBlock) -> Servo:
    """Return the servo of a JointController."""
    start = tags.number("initial_velocity", 0.0)
    if tags.text("use_force_commands").lower() not in ("1", "true"):
        return Servo("velocity", start=start)
    most = _symmetric(tags.number("cmd_max", _MOST), tags.number("cmd_min", -_MOST))
    return Servo("velocity", damping=tags.number("p_gain", 1.0), start=start, max_effort=most)


def _trajectory(plugin: Element, number: int) -> Servo:
    """Return the servo of a joint of a JointTrajectoryController, which lists gains by joint."""

    def nth(tag: str, default: float) -> float:
        found = [each for each in plugin.findall(tag) if isinstance(each, Element)]
        if number >= len(found):
            return default
        block = Element("plugin")
        block.append(found[number])
        return XmlBlock("JointTrajectoryController plugin", block).number(tag, default)

    stiffness, damping = nth("position_p_gain", 0.0), nth("position_d_gain", 0.0)
    start = nth("initial_position", 0.0)
    if not stiffness:
        return Servo(start=start)
    damping += nth("velocity_p_gain", 0.0)
    most = _symmetric(nth("position_cmd_max", _MOST), nth("position_cmd_min", -_MOST))
    return Servo(stiffness=stiffness, damping=damping, start=start, max_effort=most)


def _symmetric(most: float, least: float) -> float:
    """Return the limit of an effort; Gazebo has none where the largest is below the least."""
    return max(abs(most), abs(least)) if most > least else math.inf

"""The words of URDF: elements and attributes that are used, and remarks on those that are not."""

from collections import Counter
from collections.abc import Iterator
from difflib import get_close_matches
from pathlib import Path

from workbench.plant.formats.drake_elements import unused_drake_element
from workbench.plant.formats.urdf_joint_additions import simple_actuators
from workbench.plant.formats.values import is_zero_text, shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

_URDF_CHILDREN = {
    "robot": "link joint material gazebo transmission ros2_control properties cable",
    "link": "inertial visual collision contact self_collision_checking verbose",
    "joint": "origin parent child axis limit dynamics calibration mimic safety_controller servo",
    "inertial": "origin mass inertia",
    "visual": "origin geometry material",
    "collision": "origin geometry verbose contact_coefficients",
    "material": "color texture",
    "cable": "parent child",
}
_URDF_ATTRIBUTES = {
    "origin": "xyz rpy",
    "axis": "xyz",
    "mass": "value",
    "inertia": "ixx iyy izz ixy ixz iyz",
    "mesh": "filename uri scale",
    "box": "size",
    "sphere": "radius",
    "cylinder": "radius length",
    "parent": "link xyz",
    "child": "link xyz",
    "cable": "name length stiffness damping",
    "limit": "lower upper effort velocity acceleration jerk",
    "dynamics": "damping friction stiffness rest armature",
    "mimic": "joint multiplier offset",
}
_GAZEBO_CHILDREN = [
    "material",
    "sensor",
    "plugin",
    "preserveFixedJoint",
    "disableFixedJointLumping",
    "springStiffness",
    "springReference",
]
"""Children of `<gazebo>` that are used, or always hold here; others concern only Gazebo."""
_UNUSED_OF_JOINTS = {
    "safety_controller": "limits of ROS's controllers",
    "calibration": "of encoders",
}
"""Children of any joint that do not act, with the reason."""
_UNUSED_LIMITS = ("acceleration", "jerk", "drake:acceleration")
_SINGLE_AXIS_JOINT_KINDS = ("revolute", "continuous", "prismatic")
_TAGS_OF_MOTORS = ("drake:rotor_inertia", "drake:gear_ratio")
_DRAKE_TAGS_READ = ("drake:joint", *_TAGS_OF_MOTORS)
ROS_DRIVE_TAGS = ("transmission", "ros2_control")
"""Elements that say how ROS drives joints."""
_MAX_URDF_REMARKS = 50
"""Largest number of remarks on unknown parts, and of those on unused ones."""


def note_unknown_urdf(path: Path, robot: Element, remarks: Remarks) -> None:
    """Add remarks on elements and attributes unknown in URDF, one for each place and name.

    Elements of URDF, Gazebo, ROS and Drake that are not used here get remarks, too. The contents of
    blocks of Gazebo and ROS, and names with another prefix, are skipped.

    Raises:
        WorkbenchError: with file and line, for a force or constraint of Drake.
    """
    found: Counter[tuple[str, str]] = Counter()
    _count_unknown(robot, "the robot", found)
    for (what, owner), times in list(found.items())[:_MAX_URDF_REMARKS]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"not known in URDF{owner}; left out{often}")
    for (what, why), times in list(_unused(robot).items())[:_MAX_URDF_REMARKS]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _unused(robot: Element) -> Counter[tuple[str, str]]:
    """Return the unused elements of URDF, Gazebo and ROS, with reason and number."""
    found: Counter[tuple[str, str]] = Counter()
    for child in robot:
        if not isinstance(child, Element):
            continue
        if child.tag == "gazebo":
            tags = (part.tag for part in child if isinstance(part, Element))
            for tag in tags:
                if tag not in _GAZEBO_CHILDREN:
                    found[f"element <{shortened_text(tag)}> of <gazebo>", "Gazebo's"] += 1
        if child.tag in ("joint", "drake:joint"):
            for what, why in _unused_of_joint(child):
                found[f"{what} of joint '{shortened_text(child.get('name', ''))}'", why] += 1
    motors = [part for _, motor in simple_actuators(robot) for part in motor]
    own = [child for child in robot if child.tag not in ("gazebo", "ros2_control")]
    for element in (each for child in own for each in child.iter()):
        if element.tag in _TAGS_OF_MOTORS and element not in motors:
            why = "read in the <actuator> of a SimpleTransmission"
            found[f"element <{element.tag}>", why] += 1
        elif isinstance(element, Element) and element.tag not in _DRAKE_TAGS_READ:
            why = unused_drake_element(element)
            if why:
                found[f"element <{shortened_text(element.tag)}>", why] += 1
            for name in _UNUSED_LIMITS if element.tag == "limit" else ():
                if name in element.attrib:
                    found[f"attribute {name} of <limit>", "no joint has such a limit"] += 1
    return found


def _unused_of_joint(joint: Element) -> Iterator[tuple[str, str]]:
    """Yield what does not act in a joint, and why."""
    kind = joint.get("type", "")
    for tag, why in _UNUSED_OF_JOINTS.items():
        if joint.find(tag) is not None:
            yield f"element <{tag}>", why
    if kind not in _SINGLE_AXIS_JOINT_KINDS and joint.find("mimic") is not None:
        yield "element <mimic>", "only joints of one axis follow others"
    if kind in ("planar", "universal", "ball") and joint.find("servo") is not None:
        yield "element <servo>", "the sidecar names the axis that a servo drives"
    if kind != "planar":
        return
    for tag, used in (("limit", ()), ("dynamics", ("damping",))):
        element = joint.find(tag)
        for name, text in element.attrib.items() if isinstance(element, Element) else ():
            if name not in used and not is_zero_text(text):
                yield f"<{tag} {shortened_text(name)}>", "planar joints have damping alone"


def _count_unknown(element: Element, owner: str, found: Counter[tuple[str, str]]) -> None:
    """Count the unknown parts of an element and of its descendants."""
    known = _URDF_CHILDREN[element.tag].split()
    for child in element:
        if not isinstance(child, Element) or ":" in child.tag:
            continue
        whose = owner
        if child.tag in ("link", "joint"):
            whose = f"{child.tag} '{shortened_text(child.get('name', ''))}'"
        if child.tag not in known:
            place = f" in <{element.tag}> of {whose}" if element.tag != "robot" else ""
            near = get_close_matches(child.tag, known, n=1)
            hint = f", did you mean <{near[0]}>?" if near else ""
            found[f"element <{shortened_text(child.tag)}>", place + hint] += 1
            continue
        attributes = _URDF_ATTRIBUTES.get(child.tag, "").split()
        for name in child.attrib if attributes else ():
            if name not in attributes and ":" not in name:
                what = f"attribute {shortened_text(name)} of <{child.tag}>"
                found[what, f" in <{element.tag}> of {whose}"] += 1
        if child.tag in _URDF_CHILDREN:
            _count_unknown(child, whose, found)

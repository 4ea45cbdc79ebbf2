"""What URDF knows and what of it is used: other elements are most often misspelt, and said."""

from collections import Counter
from difflib import get_close_matches
from pathlib import Path

from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.remarks import Remarks

_CHILDREN = {
    "robot": "link joint material gazebo transmission ros2_control properties",
    "link": "inertial visual collision contact self_collision_checking verbose",
    "joint": "origin parent child axis limit dynamics calibration mimic safety_controller",
    "inertial": "origin mass inertia",
    "visual": "origin geometry material",
    "collision": "origin geometry verbose contact_coefficients",
    "material": "color texture",
}
_ATTRIBUTES = {
    "origin": "xyz rpy",
    "axis": "xyz",
    "mass": "value",
    "inertia": "ixx iyy izz ixy ixz iyz",
    "mesh": "filename uri scale",
    "box": "size",
    "sphere": "radius",
    "cylinder": "radius length",
    "parent": "link",
    "child": "link",
}
_IN_GAZEBO = ["material", "sensor", "plugin", "preserveFixedJoint", "disableFixedJointLumping"]
"""Children of `<gazebo>` that are used, or say what holds here always; others are Gazebo's own."""
_CONTROL = ("transmission", "ros2_control")
_MOST = 50
"""Of such remarks; a stranger's file may have very many."""


def note_unknown(path: Path, robot: Element, remarks: Remarks) -> None:
    """Note elements and attributes that URDF does not know, once for each place and name.

    What URDF, Gazebo and ROS know and no flight uses is noted as well, likewise. Blocks of Gazebo
    and ROS are not looked into, nor are names with a prefix.
    """
    found: Counter[tuple[str, str]] = Counter()
    _count(robot, "the robot", found)
    for (what, owner), times in list(found.items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"not known in URDF{owner}; left out{often}")
    for (what, why), times in list(_unused(robot).items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _unused(robot: Element) -> Counter[tuple[str, str]]:
    """Return what URDF, Gazebo and ROS know and no flight uses, and why, with how often."""
    found: Counter[tuple[str, str]] = Counter()
    for child in robot:
        if not isinstance(child, Element):
            continue
        if child.tag in _CONTROL:
            found[f"element <{child.tag}>", "ROS's, of control"] += 1
        if child.tag == "gazebo":
            tags = (part.tag for part in child if isinstance(part, Element))
            for tag in tags:
                if tag not in _IN_GAZEBO:
                    found[f"element <{shortened(tag)}> of <gazebo>", "Gazebo's"] += 1
        dynamics = child.find("dynamics") if child.tag == "joint" else None
        if dynamics is not None and any(value.strip("0.") for value in dynamics.attrib.values()):
            why = "a rotor's lag is that of its motor, and no other joint moves"
            found["element <dynamics> of <joint>", why] += 1
    return found


def _count(element: Element, owner: str, found: Counter[tuple[str, str]]) -> None:
    """Count what is unknown in an element, and in those below it."""
    known = _CHILDREN[element.tag].split()
    for child in element:
        if not isinstance(child, Element) or ":" in child.tag:
            continue
        whose = owner
        if child.tag in ("link", "joint"):
            whose = f"{child.tag} '{shortened(child.get('name', ''))}'"
        if child.tag not in known:
            place = f" in <{element.tag}> of {whose}" if element.tag != "robot" else ""
            near = get_close_matches(child.tag, known, n=1)
            hint = f", did you mean <{near[0]}>?" if near else ""
            found[f"element <{shortened(child.tag)}>", place + hint] += 1
            continue
        attributes = _ATTRIBUTES.get(child.tag, "").split()
        for name in child.attrib if attributes else ():
            if name not in attributes and ":" not in name:
                what = f"attribute {shortened(name)} of <{child.tag}>"
                found[what, f" in <{element.tag}> of {whose}"] += 1
        if child.tag in _CHILDREN:
            _count(child, whose, found)

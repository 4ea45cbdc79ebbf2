"""The words of SDF: elements that are used, and remarks on those that are not."""

from collections.abc import Iterable
from pathlib import Path

from workbench.extras.formats.sdf_node import FRAME_SEMANTICS_VERSION, Node
from workbench.plant.formats.drake_elements import unused_drake_element
from workbench.plant.formats.values import shortened_text
from workbench.plant.remarks import RemarkKind, Remarks

_SDF_CHILDREN: dict[str, frozenset[str]] = {
    parent: frozenset(children.split())
    for parent, children in {
        "model": "allow_auto_disable enable_wind frame gripper include joint link model "
        "model_state plugin pose self_collide static",
        "include": "model_state name namespace placement_frame plugin pose static uri",
        "link": "audio_sink audio_source battery collision enable_wind frame gravity inertial "
        "kinematic light must_be_base_link particle_emitter pose projector self_collide sensor "
        "velocity_decay visual",
        "inertial": "auto_inertia_params density fluid_added_mass frame inertia mass pose",
        "inertia": "ixx ixy ixz iyy iyz izz",
        "visual": "cast_shadows frame geometry laser_retro material meta plugin pose transparency "
        "visibility_flags",
        "collision": "auto_inertia_params density frame geometry laser_retro max_contacts pose "
        "surface",
        "geometry": "box capsule cone cylinder ellipsoid empty heightmap image mesh plane polyline "
        "sphere",
        "joint": "axis axis2 child frame gearbox_ratio gearbox_reference_body parent physics pose "
        "screw_thread_pitch sensor thread_pitch",
        "axis": "dynamics initial_position limit mimic use_parent_model_frame xyz",
        "sensor": "air_pressure air_speed altimeter always_on camera contact enable_metrics "
        "force_torque frame frame_id gps imu lidar logical_camera magnetometer navsat plugin pose "
        "ray rfid rfidtag sonar topic transceiver update_rate visualize",
    }.items()
}
"""Children by parent, of all versions from 1.4 to 1.12; source: sdformat.org/spec."""
_SDF_CHILDREN_UNUSED: dict[str, dict[str, str]] = {
    "model": {
        "gripper": "no flight has grippers",
        "model_state": "a scenario says how a flight begins",
        "enable_wind": "a scenario says what wind there is",
        "static": "a drone and what it carries fly",
    },
    "include": {
        "model_state": "a scenario says how a flight begins",
        "static": "a drone and what it carries fly",
    },
    "link": {
        "velocity_decay": "drag is that of body and rotors",
        "enable_wind": "a scenario says what wind there is",
        "kinematic": "every link moves with the body",
        "light": "lights are not drawn",
        "battery": "the battery lasts as long as battery_duration says",
        "particle_emitter": "particles are not drawn",
        "projector": "projectors are not drawn",
    },
    "inertial": {"fluid_added_mass": "no flight has added mass"},
    "collision": {"surface": "friction and stiffness of the ground are those of the workbench"},
    "axis": {"initial_position": "a scenario says how a flight begins"},
    "joint": {"physics": "limits and springs of joints are those of the workbench"},
}
"""Children that are valid in SDF and not used here, with the reason."""
_JOINT_TAGS_OF_DRAKE = ("drake:rotor_inertia", "drake:gear_ratio", "drake:mimic")
"""Children of a joint that only Drake has, and that act here as there."""
_EMPTY_VALUES = ("", "0", "false")
_SENSOR_FRAME_TAGS = ("gz_frame_id", "ignition_frame_id")
MAX_SDF_REMARKS = 50
"""Largest number of remarks on unknown or unused elements."""
_UnusedElement = tuple[RemarkKind, Path, str, str]
"""Of an element that is unknown or not used: the kind of its remark, its file, what it is, and a
text."""


def note_unknown_sdf(sources: Iterable[Node], remarks: Remarks) -> None:
    """Add remarks on unknown and unused elements, one for each file, parent and name.

    Args:
        sources: the `<model>` and `<include>` elements that were read.
        remarks: receives the remarks.
    """
    found: dict[_UnusedElement, list[int]] = {}
    seen: set[int] = set()
    for source in sources:
        _collect(source, seen, found)
    for index, ((kind, file, what, text), lines) in enumerate(found.items()):
        if index == MAX_SDF_REMARKS:
            text = f"not in the SDF schema, or not used ({len(found) - index} kinds)"
            remarks.add("ignored", file, "further elements", text)
            break
        where = (
            f"line {lines[0]}"
            if len(lines) == 1
            else f"{len(lines)} times, first in line {lines[0]}"
        )
        remarks.add(kind, file, what, f"{text} ({where})")


def _collect(parent: Node, seen: set[int], found: dict[_UnusedElement, list[int]]) -> None:
    """Collect the unknown and unused descendants of an element, with their lines."""
    if id(parent.element) in seen:  # of a file included twice
        return
    seen.add(id(parent.element))
    for child in parent.children():
        strange = _unused_element(parent, child)
        if strange:
            found.setdefault(strange, []).append(child.element.line)
        elif child.element.tag in _SDF_CHILDREN:
            _collect(child, seen, found)


def _unused_element(parent: Node, child: Node) -> _UnusedElement | None:
    """Return the finding about an element, or None if it is known and used."""
    tag, over = child.element.tag, parent.element.tag
    kind: RemarkKind = "ignored"
    what = f"element <{shortened_text(tag)}> of <{over}>"
    text = "not in the SDF schema; left out"
    new = child.version >= FRAME_SEMANTICS_VERSION
    if over == "sensor" and tag in _SENSOR_FRAME_TAGS:
        kind = "repaired"
        text = "not in the SDF schema; taken as the sensor's frame, as Gazebo does"
    elif tag == "pose" and new and child.attribute("frame"):
        what = f"attribute frame of <pose> of <{over}>"
        text = "not in the SDF schema since 1.7; left out"
    elif tag == "use_parent_model_frame" and new:
        text = "not in the SDF schema since 1.7; left out"
    elif tag == "pose" and over == "inertial" and child.attribute("relative_to"):
        what = "attribute relative_to of <pose> of <inertial>"
    elif tag == "experimental:params":
        text = "it would change the included model; not applied"
    elif tag == "gravity" and over == "link" and not _has_content(child):
        text = "its weight acts here, as on every link; not used"
    elif tag in _SDF_CHILDREN_UNUSED.get(over, {}) and _has_content(child):
        text = f"{_SDF_CHILDREN_UNUSED[over][tag]}; not used"
    elif why := "" if over == "joint" and tag in _JOINT_TAGS_OF_DRAKE else _drake_reason(child):
        text = f"{why}; not used"
    elif tag in _SDF_CHILDREN[over] or ":" in tag:  # the specification allows custom elements
        return None
    return kind, child.file, what, text


def _drake_reason(child: Node) -> str:
    """Return why an element of Drake is not used, "" for any other."""
    if child.element.tag == "drake:joint":
        raise child.fault(
            f"<drake:joint> '{shortened_text(child.name)}' is Drake's own in SDF, and does not "
            "fly: use a joint of SDF, or a planar joint in a URDF"
        )
    return unused_drake_element(child.element)


def _has_content(node: Node) -> bool:
    """Return whether an element or a descendant is neither empty, zero nor false."""
    texts = ((element.text or "").strip().lower() for element in node.element.iter())
    return any(text.rstrip("0").rstrip(".") not in _EMPTY_VALUES for text in texts)

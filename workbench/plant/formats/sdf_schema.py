"""Which elements SDF knows, to say what a file has besides them."""

from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from workbench.plant.formats.sdf_node import FRAME_SEMANTICS, Node
from workbench.plant.formats.values import shortened
from workbench.plant.remarks import RemarkKind, Remarks

_KNOWN: dict[str, frozenset[str]] = {
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
"""Children by their parent: what any version from 1.4 to 1.12 has; source: sdformat.org/spec."""

_UNUSED: dict[str, dict[str, str]] = {
    "model": {
        "gripper": "no flight has grippers",
        "model_state": "a scenario says how a flight begins",
        "enable_wind": "a scenario says what wind there is",
    },
    "include": {"model_state": "a scenario says how a flight begins"},
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
    "collision": {"surface": "friction and stiffness of the ground are the workbench's own"},
    "joint": {"physics": "no joint moves but rotors"},
    "axis": {"dynamics": "a rotor's lag is that of its motor, and no other joint moves"},
}
"""Children that SDF knows and no flight uses, and what holds instead."""
_NOTHING = ("", "0", "false")

_SENSOR_FRAMES = ("gz_frame_id", "ignition_frame_id")
MOST_REMARKS = 50
"""Strange elements of one description that are named one by one."""


@dataclass
class _Strange:
    """What is not in the schema or not used, how often, and the line of the first."""

    kind: RemarkKind
    file: Path
    what: str
    text: str
    line: int
    count: int = 0


def note_unknown(sources: Iterable[Node], remarks: Remarks) -> None:
    """Note what SDF does not know or no flight uses, once for each file, parent and name.

    Args:
        sources: the `<model>` and `<include>` elements that were read.
        remarks: where to note.
    """
    found: dict[tuple[Path, str], _Strange] = {}
    seen: set[int] = set()
    for source in sources:
        _collect(source, seen, found)
    for index, strange in enumerate(found.values()):
        if index == MOST_REMARKS:
            text = f"not in the SDF schema, or not used ({len(found) - index} kinds)"
            remarks.add("ignored", strange.file, "further elements", text)
            break
        first = f"first in line {strange.line}" if strange.count > 1 else f"line {strange.line}"
        times = f"{strange.count} times, " if strange.count > 1 else ""
        remarks.add(strange.kind, strange.file, strange.what, f"{strange.text} ({times}{first})")


def _collect(parent: Node, seen: set[int], found: dict[tuple[Path, str], _Strange]) -> None:
    """Collect what is strange about the children of an element, and theirs."""
    if id(parent.element) in seen:  # a file that is included twice
        return
    seen.add(id(parent.element))
    for child in parent.children():
        strange = _strange(parent, child)
        if strange:
            first = found.setdefault((child.file, strange.what), strange)
            first.count += 1
        elif child.element.tag in _KNOWN:
            _collect(child, seen, found)


def _strange(parent: Node, child: Node) -> _Strange | None:
    """Return what is strange about an element, None where nothing is."""
    tag, over = child.element.tag, parent.element.tag
    kind: RemarkKind = "ignored"
    what = f"element <{shortened(tag)}> of <{over}>"
    text = "not in the SDF schema; left out"
    new = child.version >= FRAME_SEMANTICS
    if over == "sensor" and tag in _SENSOR_FRAMES:
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
        text = "it would change what is included; not applied"
    elif tag in _UNUSED.get(over, {}) and _says_something(child):
        text = f"{_UNUSED[over][tag]}; not used"
    elif tag in _KNOWN[over] or ":" in tag:  # the specification allows elements of one's own
        return None
    return _Strange(kind, child.file, what, text, child.element.line)


def _says_something(node: Node) -> bool:
    """Return whether an element is more than empty, zero or false, all through."""
    texts = ((element.text or "").strip().lower() for element in node.element.iter())
    return any(text.rstrip("0").rstrip(".") not in _NOTHING for text in texts)

"""Read rotors from Gazebo plugins: motor models of RotorS, PX4 and gz-sim, and velocity plugins.

The velocity plugin is that of the paper. It names links and joints, and hardly any constants.
"""

import math
import re
from itertools import count

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import XmlBlock
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import (
    GAZEBO_DEFAULTS,
    MOTOR_CONSTANT_TAGS,
    make_rotor,
    note_assumed,
    read_constants,
    total_mass,
)
from workbench.plant.rotor_sources.mount import Mount, mount_on_joint
from workbench.plant.rotor_sources.names import find_joint, find_link
from workbench.plant.rotor_sources.tags import note_unused, refuse_too_many_rotors, turn_of
from workbench.plant.rotors import Rotor

_VELOCITY_PLUGIN_FILE = "setvelocity"
_VELOCITY_KIND = "velocity plugin"
_NUMBERED_TAG_PATTERN = re.compile(r"(?:joint|link)([0-9]{1,4})")

ASSUMED_THRUST_TO_WEIGHT = 2.0
# RotorS' values with a rounder speed, as in the shipped drone.
ASSUMED_CONSTANTS = GAZEBO_DEFAULTS | {"max_rot_velocity": 1000.0}
_MOTOR_PLUGIN_FILES = ("gazebo_motor_model", "multicopter-motor-model")
_MOTOR_PLUGIN_CLASS = "::MulticopterMotorModel"
_MOTOR_KIND = "motor-model plugin"
_MAX_MOTOR_NUMBER_DIGITS = 4
_MOTOR_PLUGIN_TAGS = (
    *MOTOR_CONSTANT_TAGS,
    "jointName",
    "linkName",
    "turningDirection",
    "motorNumber",
    "actuator_number",
    "motorType",
    "reversible",
)


def is_velocity_plugin(plugin: Element) -> bool:
    """Return whether a plugin is that of the paper, by its file name and numbered joints."""
    return _VELOCITY_PLUGIN_FILE in plugin.get("filename", "").lower() and bool(
        _rotor_numbers(plugin)
    )


def velocity_plugin_joints(plugin: Element) -> list[str]:
    """Return the names of the joints in the block."""
    return [(plugin.findtext(f"joint{number}") or "").strip() for number in _rotor_numbers(plugin)]


def read_velocity_plugin(
    model: Model, plugin: Element, base_link: str, remarks: Remarks
) -> tuple[Rotor, ...]:
    """Return the rotors named in the block, by number.

    The block may have constants for all rotors, with the names in Gazebo's motor model, and
    `turningDirectionN` for each rotor. Missing constants are assumed, see `ASSUMED_CONSTANTS`;
    turning directions then alternate around the drone, and thrust is `ASSUMED_THRUST_TO_WEIGHT`
    times the weight.

    Args:
        model: that declares the plugin.
        plugin: the block.
        base_link: its frame is the body frame.
        remarks: receives remarks on assumptions.

    Raises:
        WorkbenchError: with file and line, for a missing joint or link, or an invalid tag.
    """
    tags = XmlBlock(_VELOCITY_KIND, plugin)
    numbers = _rotor_numbers(plugin)
    refuse_too_many_rotors(plugin.file, len(numbers))
    named = [_named_rotor(tags, number, model, base_link, remarks) for number in numbers]
    if len({joint.name for joint, _ in named}) < len(named):
        raise WorkbenchError(
            f"{tags.where()}: {_VELOCITY_KIND} names a joint twice: name each once"
        )
    constants = read_constants(
        tags, ASSUMED_CONSTANTS, "figures of RotorS and its like", _VELOCITY_KIND, remarks
    )
    numbered = [f"{tag}{n}" for n in numbers for tag in ("joint", "link", "turningDirection")]
    note_unused(tags, ["link", *MOTOR_CONSTANT_TAGS, *numbered], _VELOCITY_KIND, remarks)
    motor_constant = _motor_constant(
        tags, model, len(named), constants["max_rot_velocity"], remarks
    )
    turns = _turning_directions(tags, numbers, [mount for _, mount in named], remarks)
    return tuple(
        make_rotor(model, joint, mount, turn, motor_constant, constants, tags, remarks)
        for (joint, mount), turn in zip(named, turns, strict=True)
    )


def _rotor_numbers(plugin: Element) -> list[str]:
    """Return the numbers in all jointN and linkN, as written, in order."""
    matches = (_NUMBERED_TAG_PATTERN.fullmatch(str(child.tag)) for child in plugin)
    return sorted({match[1] for match in matches if match}, key=lambda text: (int(text), text))


def _named_rotor(
    tags: XmlBlock, number: str, model: Model, base_link: str, remarks: Remarks
) -> tuple[Joint, Mount]:
    """Return joint and mount of the rotor with a number."""
    joint_tag, link_tag = f"joint{number}", f"link{number}"
    joint = find_joint(model, tags.required(joint_tag), tags.where(joint_tag))
    link = find_link(model, tags.required(link_tag), tags.where(link_tag))
    if joint.child != link.name:
        raise WorkbenchError(
            f"{tags.where(link_tag)}: <{link_tag}> is '{link.name}', but '{joint.name}' turns "
            f"another link: name its child link '{joint.child}'"
        )
    return joint, mount_on_joint(model, base_link, joint, link, tags.file, remarks)


def _motor_constant(
    tags: XmlBlock, model: Model, rotors: int, max_rot_velocity: float, remarks: Remarks
) -> float:
    """Return the motor constant in the block, or that for the assumed thrust-to-weight ratio."""
    if tags.has("motorConstant"):
        return tags.positive("motorConstant")
    weight = total_mass(model) * GRAVITY
    constant = ASSUMED_THRUST_TO_WEIGHT * weight / (rotors * max_rot_velocity**2)
    missing = [f"motorConstant {constant:.3g}"]
    note_assumed(
        missing,
        f"thrust {ASSUMED_THRUST_TO_WEIGHT:g} times the weight",
        tags.file,
        _VELOCITY_KIND,
        remarks,
    )
    return constant


def _turning_directions(
    tags: XmlBlock, numbers: list[str], mounts: list[Mount], remarks: Remarks
) -> list[int]:
    """Return the direction of each rotor; missing ones alternate around the drone."""
    assumed: list[str] = []
    turns: list[int] = []
    for number, mount, place in zip(numbers, mounts, _places_around(mounts), strict=True):
        tag = f"turningDirection{number}"
        if tags.has(tag):
            turns.append(turn_of(tags, tag) * mount.sense)
        else:
            turns.append(1 if place % 2 else -1)
            assumed.append(f"{tag} {'ccw' if place % 2 else 'cw'}")
    note_assumed(assumed, "alternating all around", tags.file, _VELOCITY_KIND, remarks)
    return turns


def _places_around(mounts: list[Mount]) -> list[int]:
    """Return the position of each rotor in counter-clockwise order from the first, seen from above.

    Rotors above each other are consecutive, the upper one first.
    """
    x_mid = sum(mount.p_BR[0] for mount in mounts) / len(mounts)
    y_mid = sum(mount.p_BR[1] for mount in mounts) / len(mounts)
    angles = [math.atan2(mount.p_BR[1] - y_mid, mount.p_BR[0] - x_mid) for mount in mounts]
    around = [round((angle - angles[0]) / (2.0 * math.pi) % 1.0, 6) % 1.0 for angle in angles]
    order = sorted(range(len(mounts)), key=lambda i: (around[i], -mounts[i].p_BR[2], i))
    return [order.index(i) for i in range(len(mounts))]


def is_motor_plugin(plugin: Element) -> bool:
    """Return whether a plugin is a motor model, by its file or class name."""
    return plugin.get("name", "").strip().endswith(_MOTOR_PLUGIN_CLASS) or any(
        file in plugin.get("filename", "") for file in _MOTOR_PLUGIN_FILES
    )


def read_motor_plugins(model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return the rotors of all motor-model plugins, by motor number.

    Args:
        model: with the plugins.
        base_link: its frame is the body frame.
        remarks: receives remarks on assumptions.

    Raises:
        WorkbenchError: with file and line, for a missing or invalid tag, a missing joint or link,
            or two plugins with one number or joint.
    """
    turning = [
        plugin
        for plugin in model.plugins
        if is_motor_plugin(plugin) and _turns_a_rotor(plugin, remarks)
    ]
    refuse_too_many_rotors(model.source, len(turning))
    numbered: dict[int, Rotor] = {}
    unnumbered: list[Rotor] = []
    for plugin in turning:
        tags = XmlBlock(_MOTOR_KIND, plugin)
        rotor = _read_motor_plugin(tags, model, base_link, remarks)
        if any(rotor.joint == other.joint for other in (*numbered.values(), *unnumbered)):
            raise WorkbenchError(
                f"{tags.where('jointName')}: two motor-model plugins turn the joint "
                f"'{rotor.joint}': name another one"
            )
        number = _motor_number(tags)
        if number is None:
            unnumbered.append(rotor)
        elif number in numbered:
            raise WorkbenchError(
                f"{tags.where()}: '{numbered[number].name}' and '{rotor.name}' both have the "
                f"motorNumber {number}: number the rotors from 0"
            )
        else:
            numbered[number] = rotor
    free = (number for number in count() if number not in numbered)
    for number, rotor in zip(free, unnumbered):  # noqa: B905 - `free` is infinite
        text = f"motorNumber {number}: not given, the order in the file"
        remarks.add("assumed", model.source, f"motor model of '{rotor.name}'", text)
        numbered[number] = rotor
    return tuple(numbered[number] for number in sorted(numbered))


def _turns_a_rotor(plugin: Element, remarks: Remarks) -> bool:
    """Return whether a motor model has the type velocity; add a remark if not."""
    kind = (plugin.findtext("motorType") or "").strip()
    if kind in ("", "velocity"):
        return True
    if kind == "position" and _MOTOR_PLUGIN_FILES[0] in plugin.get("filename", ""):
        return False  # a servo, see `classic_servos`
    joint = shortened_text(plugin.findtext("jointName") or "")
    text = f"its motorType is {shortened_text(kind)}; not used, a rotor has velocity"
    remarks.add("ignored", plugin.file, f"motor model of '{joint}'", text)
    return False


def _read_motor_plugin(tags: XmlBlock, model: Model, base_link: str, remarks: Remarks) -> Rotor:
    """Return the rotor of one plugin."""
    link = find_link(model, tags.required("linkName"), tags.where("linkName"))
    joint = _plugin_joint(tags, model, link, remarks)
    if joint.child != link.name:
        raise WorkbenchError(
            f"{tags.where('linkName')}: a motor-model plugin names the link '{link.name}', but its "
            f"joint '{joint.name}' turns another one: name the joint's child link '{joint.child}'"
        )
    direction = turn_of(tags, "turningDirection")
    motor_constant = tags.positive("motorConstant")
    element = f"motor model of '{joint.name}'"
    constants = read_constants(tags, GAZEBO_DEFAULTS, "Gazebo's defaults", element, remarks)
    note_unused(tags, _MOTOR_PLUGIN_TAGS, element, remarks)
    mount = mount_on_joint(model, base_link, joint, link, tags.file, remarks)
    turn = direction * mount.sense
    return make_rotor(model, joint, mount, turn, motor_constant, constants, tags, remarks)


def _plugin_joint(tags: XmlBlock, model: Model, link: Link, remarks: Remarks) -> Joint:
    """Return the joint named in a plugin, or else the parent joint of its link."""
    name = tags.required("jointName")
    try:
        return find_joint(model, name, tags.where("jointName"))
    except WorkbenchError:
        above = model.joint_of(link.name)
        if above is None:
            raise
    text = (
        f"there is no joint '{shortened_text(name)}'; taken as '{above.name}', which turns its link"
    )
    remarks.add("repaired", tags.file, f"motor model of '{shortened_text(link.name)}'", text)
    return above


def _motor_number(tags: XmlBlock) -> int | None:
    """Return the index of a motor in the commands; gz-sim's name of the tag takes precedence."""
    for tag in ("actuator_number", "motorNumber"):
        if tags.has(tag):
            text = tags.required(tag)
            if not text.isdecimal() or len(text) > _MAX_MOTOR_NUMBER_DIGITS:
                raise tags.fault(tag, "use 0, 1, 2, ...")
            return int(text)
    return None

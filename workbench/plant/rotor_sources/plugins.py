"""Read rotors from Gazebo plugins: motor models of RotorS, PX4 and gz-sim, and velocity plugins.

The velocity plugin is that of the paper. It names links and joints, and hardly any constants.
"""

import math
import re
from dataclasses import dataclass
from itertools import count

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.block import Block
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import (
    CONSTANTS,
    GAZEBO,
    make_rotor,
    note_assumed,
    read_constants,
    total_mass,
)
from workbench.plant.rotor_sources.mount import Mount, mount_on_joint
from workbench.plant.rotor_sources.names import find_joint, find_link
from workbench.plant.rotor_sources.tags import note_unused, refuse_crowd, turn_of
from workbench.plant.rotors import Rotor

_FILE = "setvelocity"
_VELOCITY_KIND = "velocity plugin"
_NUMBERED = re.compile(r"(?:joint|link)([0-9]{1,4})")

THRUST_TO_WEIGHT = 2.0
# RotorS' values with a rounder speed, as in the shipped drone.
ASSUMED = GAZEBO | {"max_rot_velocity": 1000.0}
_FILES = ("gazebo_motor_model", "multicopter-motor-model")
_CLASS = "::MulticopterMotorModel"
_MOTOR_KIND = "motor-model plugin"
_MOST_DIGITS = 4
_USED = (
    *CONSTANTS,
    "jointName",
    "linkName",
    "turningDirection",
    "motorNumber",
    "actuator_number",
    "motorType",
    "reversible",
)


@dataclass(frozen=True)
class _Named:
    """A rotor as named in the block."""

    number: str
    joint: Joint
    mount: Mount


def is_velocity_plugin(plugin: Element) -> bool:
    """Return whether a plugin is that of the paper, by its file name and numbered joints."""
    return _FILE in plugin.get("filename", "").lower() and bool(_numbers(plugin))


def velocity_plugin_joints(plugin: Element) -> list[str]:
    """Return the names of the joints in the block."""
    return [(plugin.findtext(f"joint{number}") or "").strip() for number in _numbers(plugin)]


def read_velocity_plugin(
    model: Model, plugin: Element, base_link: str, remarks: Remarks
) -> tuple[Rotor, ...]:
    """Return the rotors named in the block, by number.

    The block may have constants for all rotors, with the names in Gazebo's motor model, and
    `turningDirectionN` for each rotor. Missing constants are assumed, see `ASSUMED`; turning
    directions then alternate around the drone, and thrust is `THRUST_TO_WEIGHT` times the weight.

    Args:
        model: that declares the plugin.
        plugin: the block.
        base_link: its frame is the body frame.
        remarks: receives remarks on assumptions.

    Raises:
        WorkbenchError: with file and line, for a missing joint or link, or an invalid tag.
    """
    tags = Block(_VELOCITY_KIND, plugin)
    numbers = _numbers(plugin)
    refuse_crowd(plugin.file, len(numbers))
    named = [_named(tags, number, model, base_link, remarks) for number in numbers]
    if len({rotor.joint.name for rotor in named}) < len(named):
        raise WorkbenchError(
            f"{tags.where()}: {_VELOCITY_KIND} names a joint twice: name each once"
        )
    constants = read_constants(
        tags, ASSUMED, "figures of RotorS and its like", _VELOCITY_KIND, remarks
    )
    numbered = [f"{tag}{n}" for n in numbers for tag in ("joint", "link", "turningDirection")]
    note_unused(tags, ["link", *CONSTANTS, *numbered], _VELOCITY_KIND, remarks)
    motor_constant = _motor_constant(
        tags, model, len(named), constants["max_rot_velocity"], remarks
    )
    turns = _turns(tags, named, remarks)
    return tuple(
        make_rotor(model, rotor.joint, rotor.mount, turn, motor_constant, constants, tags, remarks)
        for rotor, turn in zip(named, turns, strict=True)
    )


def _numbers(plugin: Element) -> list[str]:
    """Return the numbers in all jointN and linkN, as written, in order."""
    matches = (_NUMBERED.fullmatch(str(child.tag)) for child in plugin)
    return sorted({match[1] for match in matches if match}, key=lambda text: (int(text), text))


def _named(tags: Block, number: str, model: Model, base_link: str, remarks: Remarks) -> _Named:
    """Return the rotor with a number."""
    joint_tag, link_tag = f"joint{number}", f"link{number}"
    joint = find_joint(model, tags.required(joint_tag), tags.where(joint_tag))
    link = find_link(model, tags.required(link_tag), tags.where(link_tag))
    if joint.child != link.name:
        raise WorkbenchError(
            f"{tags.where(link_tag)}: <{link_tag}> is '{link.name}', but '{joint.name}' turns "
            f"another link: name its child link '{joint.child}'"
        )
    mount = mount_on_joint(model, base_link, joint, link, tags.file, remarks)
    return _Named(number, joint, mount)


def _motor_constant(
    tags: Block, model: Model, rotors: int, max_rot_velocity: float, remarks: Remarks
) -> float:
    """Return the motor constant in the block, or that for the assumed thrust-to-weight ratio."""
    if tags.has("motorConstant"):
        return tags.positive("motorConstant")
    weight = total_mass(model) * GRAVITY
    constant = THRUST_TO_WEIGHT * weight / (rotors * max_rot_velocity**2)
    missing = [f"motorConstant {constant:.3g}"]
    note_assumed(
        missing, f"thrust {THRUST_TO_WEIGHT:g} times the weight", tags.file, _VELOCITY_KIND, remarks
    )
    return constant


def _turns(tags: Block, named: list[_Named], remarks: Remarks) -> list[int]:
    """Return the direction of each rotor; missing ones alternate around the drone."""
    assumed: list[str] = []
    turns: list[int] = []
    for rotor, place in zip(named, _places_around(named), strict=True):
        tag = f"turningDirection{rotor.number}"
        if tags.has(tag):
            turns.append(turn_of(tags, tag) * rotor.mount.sense)
        else:
            turns.append(1 if place % 2 else -1)
            assumed.append(f"{tag} {'ccw' if place % 2 else 'cw'}")
    note_assumed(assumed, "alternating all around", tags.file, _VELOCITY_KIND, remarks)
    return turns


def _places_around(named: list[_Named]) -> list[int]:
    """Return the position of each rotor in counter-clockwise order from the first, seen from above.

    Rotors above each other are consecutive, the upper one first.
    """
    x_mid = sum(rotor.mount.p_BR[0] for rotor in named) / len(named)
    y_mid = sum(rotor.mount.p_BR[1] for rotor in named) / len(named)
    angles = [
        math.atan2(rotor.mount.p_BR[1] - y_mid, rotor.mount.p_BR[0] - x_mid) for rotor in named
    ]
    around = [round((angle - angles[0]) / (2.0 * math.pi) % 1.0, 6) % 1.0 for angle in angles]
    order = sorted(range(len(named)), key=lambda i: (around[i], -named[i].mount.p_BR[2], i))
    return [order.index(i) for i in range(len(named))]


def is_motor_plugin(plugin: Element) -> bool:
    """Return whether a plugin is a motor model, by its file or class name."""
    return plugin.get("name", "").strip().endswith(_CLASS) or any(
        file in plugin.get("filename", "") for file in _FILES
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
    refuse_crowd(model.source, len(turning))
    numbered: dict[int, Rotor] = {}
    unnumbered: list[Rotor] = []
    for plugin in turning:
        tags = Block(_MOTOR_KIND, plugin)
        rotor = _read(tags, model, base_link, remarks)
        if any(rotor.joint == other.joint for other in (*numbered.values(), *unnumbered)):
            raise WorkbenchError(
                f"{tags.where('jointName')}: two motor-model plugins turn the joint "
                f"'{rotor.joint}': name another one"
            )
        number = _number(tags)
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
    joint = shortened(plugin.findtext("jointName") or "")
    text = f"its motorType is {shortened(kind)}; not used, a rotor has velocity"
    remarks.add("ignored", plugin.file, f"motor model of '{joint}'", text)
    return False


def _read(tags: Block, model: Model, base_link: str, remarks: Remarks) -> Rotor:
    """Return the rotor of one plugin."""
    link = find_link(model, tags.required("linkName"), tags.where("linkName"))
    joint = _joint(tags, model, link, remarks)
    if joint.child != link.name:
        raise WorkbenchError(
            f"{tags.where('linkName')}: a motor-model plugin names the link '{link.name}', but its "
            f"joint '{joint.name}' turns another one: name the joint's child link '{joint.child}'"
        )
    direction = turn_of(tags, "turningDirection")
    motor_constant = tags.positive("motorConstant")
    element = f"motor model of '{joint.name}'"
    constants = read_constants(tags, GAZEBO, "Gazebo's defaults", element, remarks)
    note_unused(tags, _USED, element, remarks)
    mount = mount_on_joint(model, base_link, joint, link, tags.file, remarks)
    turn = direction * mount.sense
    return make_rotor(model, joint, mount, turn, motor_constant, constants, tags, remarks)


def _joint(tags: Block, model: Model, link: Link, remarks: Remarks) -> Joint:
    """Return the joint named in a plugin, or else the parent joint of its link."""
    name = tags.required("jointName")
    try:
        return find_joint(model, name, tags.where("jointName"))
    except WorkbenchError:
        above = model.joint_of(link.name)
        if above is None:
            raise
    text = f"there is no joint '{shortened(name)}'; taken as '{above.name}', which turns its link"
    remarks.add("repaired", tags.file, f"motor model of '{shortened(link.name)}'", text)
    return above


def _number(tags: Block) -> int | None:
    """Return the index of a motor in the commands; gz-sim's name of the tag takes precedence."""
    for tag in ("actuator_number", "motorNumber"):
        if tags.has(tag):
            text = tags.required(tag)
            if not text.isdecimal() or len(text) > _MOST_DIGITS:
                raise tags.fault(tag, "use 0, 1, 2, ...")
            return int(text)
    return None

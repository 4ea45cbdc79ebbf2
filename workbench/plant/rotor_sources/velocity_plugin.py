"""Rotors of the paper's plugin block, which names links and joints and hardly any constants."""

import math
import re
from dataclasses import dataclass

from workbench.common.errors import WorkbenchError
from workbench.plant.gravity import GRAVITY
from workbench.plant.model import DeclaredPlugin, Joint, Link, Model
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
from workbench.plant.rotor_sources.tags import Tags, refuse_crowd
from workbench.plant.rotors import Rotor

_FILE = "setvelocity"
_KIND = "velocity plugin"
_NUMBERED = re.compile(r"(?:joint|link)([0-9]{1,4})")

THRUST_TO_WEIGHT = 2.0
# RotorS' figures, with a rounder speed: what the shipped drone has.
ASSUMED = GAZEBO | {"max_rot_velocity": 1000.0}


@dataclass(frozen=True)
class _Named:
    """A rotor as the block names it."""

    number: str
    joint: Joint
    link: Link
    mount: Mount


def is_velocity_plugin(plugin: DeclaredPlugin) -> bool:
    """Return whether a plugin is the paper's: its file, with numbered joints."""
    return _FILE in plugin.element.get("filename", "").lower() and bool(_numbers(plugin))


def velocity_plugin_joints(plugin: DeclaredPlugin) -> list[str]:
    """Return the names of the joints that the block turns, as it has them."""
    return [
        (plugin.element.findtext(f"joint{number}") or "").strip() for number in _numbers(plugin)
    ]


def read_velocity_plugin(
    model: Model, plugin: DeclaredPlugin, base_link: str, remarks: Remarks
) -> tuple[Rotor, ...]:
    """Return the rotors that the block names, in the order of its numbers.

    Constants stand in the block under the names that Gazebo's motor model has for them, for all
    rotors, and `turningDirectionN` for each. What is missing is assumed: see `ASSUMED`; turning
    directions alternate around the drone, and thrust is `THRUST_TO_WEIGHT` times the weight.

    Args:
        model: which declares the plugin.
        plugin: the block.
        base_link: whose frame is the body frame.
        remarks: where to note what was assumed.

    Raises:
        WorkbenchError: with file and line, if a joint or link is not there or a tag cannot be.
    """
    tags = Tags(plugin, _KIND)
    numbers = _numbers(plugin)
    refuse_crowd(plugin.file, len(numbers))
    named = [_named(tags, number, model, base_link, remarks) for number in numbers]
    if len({rotor.joint.name for rotor in named}) < len(named):
        raise WorkbenchError(f"{tags.where()}: {_KIND} names a joint twice: name each once")
    constants = read_constants(tags, ASSUMED, "figures of RotorS and its like", _KIND, remarks)
    numbered = [f"{tag}{n}" for n in numbers for tag in ("joint", "link", "turningDirection")]
    tags.note_unused(["link", *CONSTANTS, *numbered], _KIND, remarks)
    motor_constant = _motor_constant(
        tags, model, len(named), constants["max_rot_velocity"], remarks
    )
    turns = _turns(tags, named, remarks)
    return tuple(
        make_rotor(
            model,
            rotor.joint,
            rotor.link,
            rotor.mount,
            turn,
            motor_constant,
            constants,
            tags,
            remarks,
        )
        for rotor, turn in zip(named, turns, strict=True)
    )


def _numbers(plugin: DeclaredPlugin) -> list[str]:
    """Return the numbers of all jointN and linkN, as written, in their order."""
    matches = (_NUMBERED.fullmatch(str(child.tag)) for child in plugin.element)
    return sorted({match[1] for match in matches if match}, key=lambda text: (int(text), text))


def _named(tags: Tags, number: str, model: Model, base_link: str, remarks: Remarks) -> _Named:
    """Return the rotor of one number."""
    joint_tag, link_tag = f"joint{number}", f"link{number}"
    joint = find_joint(model, tags.text(joint_tag), tags.where(joint_tag))
    link = find_link(model, tags.text(link_tag), tags.where(link_tag))
    if joint.child != link.name:
        raise WorkbenchError(
            f"{tags.where(link_tag)}: <{link_tag}> is '{link.name}', but '{joint.name}' turns "
            f"another link: name its child link '{joint.child}'"
        )
    mount = mount_on_joint(model, base_link, joint, link, tags.file, remarks)
    return _Named(number, joint, link, mount)


def _motor_constant(
    tags: Tags, model: Model, rotors: int, max_rot_velocity: float, remarks: Remarks
) -> float:
    """Return the motor constant of the block, or that of the assumed thrust-to-weight ratio."""
    if tags.has("motorConstant"):
        return tags.positive("motorConstant")
    weight = total_mass(model) * GRAVITY
    constant = THRUST_TO_WEIGHT * weight / (rotors * max_rot_velocity**2)
    missing = [f"motorConstant {constant:.3g}"]
    note_assumed(
        missing, f"thrust {THRUST_TO_WEIGHT:g} times the weight", tags.file, _KIND, remarks
    )
    return constant


def _turns(tags: Tags, named: list[_Named], remarks: Remarks) -> list[int]:
    """Return each rotor's direction about its axis, those not given alternating all around."""
    assumed: list[str] = []
    turns: list[int] = []
    for rotor, place in zip(named, _places_around(named), strict=True):
        tag = f"turningDirection{rotor.number}"
        if tags.has(tag):
            turns.append(tags.turn(tag) * rotor.mount.sense)
        else:
            turns.append(1 if place % 2 else -1)
            assumed.append(f"{tag} {'ccw' if place % 2 else 'cw'}")
    note_assumed(assumed, "alternating all around", tags.file, _KIND, remarks)
    return turns


def _places_around(named: list[_Named]) -> list[int]:
    """Return each rotor's place in the round seen from above, counter-clockwise from the first.

    Rotors above each other follow each other, the upper one first.
    """
    x_mid = sum(rotor.mount.p_BR[0] for rotor in named) / len(named)
    y_mid = sum(rotor.mount.p_BR[1] for rotor in named) / len(named)
    angles = [
        math.atan2(rotor.mount.p_BR[1] - y_mid, rotor.mount.p_BR[0] - x_mid) for rotor in named
    ]
    around = [round((angle - angles[0]) / (2.0 * math.pi) % 1.0, 6) % 1.0 for angle in angles]
    order = sorted(range(len(named)), key=lambda i: (around[i], -named[i].mount.p_BR[2], i))
    return [order.index(i) for i in range(len(named))]

"""Rotors of Gazebo's motor-model plugins: RotorS', PX4's and gz-sim's."""

from itertools import count

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.model import DeclaredPlugin, Joint, Link, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.motor_constants import (
    CONSTANTS,
    GAZEBO,
    make_rotor,
    read_constants,
)
from workbench.plant.rotor_sources.mount import mount_on_joint
from workbench.plant.rotor_sources.names import find_joint, find_link
from workbench.plant.rotor_sources.tags import Tags, refuse_crowd
from workbench.plant.rotors import Rotor

_FILES = ("gazebo_motor_model", "multicopter-motor-model")
_CLASS = "::MulticopterMotorModel"
_KIND = "motor-model plugin"
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


def is_motor_plugin(plugin: DeclaredPlugin) -> bool:
    """Return whether a plugin is a motor model, by its file or its class."""
    return plugin.element.get("name", "").strip().endswith(_CLASS) or any(
        file in plugin.element.get("filename", "") for file in _FILES
    )


def read_motor_plugins(model: Model, base_link: str, remarks: Remarks) -> tuple[Rotor, ...]:
    """Return the rotors of all motor-model plugins, by motor number.

    Args:
        model: with the plugins.
        base_link: whose frame is the body frame.
        remarks: where to note what was assumed.

    Raises:
        WorkbenchError: with file and line, if a tag is missing or cannot be, if a joint or link
            is not there, or if two plugins have one number or one joint.
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
        tags = Tags(plugin, _KIND)
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
    for number, rotor in zip(free, unnumbered):  # noqa: B905 - the free numbers are endless
        text = f"motorNumber {number}: not given, the order in the file"
        remarks.add("assumed", model.source, f"motor model of '{rotor.name}'", text)
        numbered[number] = rotor
    return tuple(numbered[number] for number in sorted(numbered))


def _turns_a_rotor(plugin: DeclaredPlugin, remarks: Remarks) -> bool:
    """Return whether a motor model is one of speed and thrust, and note where it is not."""
    kind = (plugin.element.findtext("motorType") or "").strip()
    if kind in ("", "velocity"):
        return True
    joint = shortened(plugin.element.findtext("jointName") or "")
    text = f"its motorType is {shortened(kind)}; not used, a rotor has velocity"
    remarks.add("ignored", plugin.file, f"motor model of '{joint}'", text)
    return False


def _read(tags: Tags, model: Model, base_link: str, remarks: Remarks) -> Rotor:
    """Return the rotor of one plugin."""
    link = find_link(model, tags.text("linkName"), tags.where("linkName"))
    joint = _joint(tags, model, link, remarks)
    if joint.child != link.name:
        raise WorkbenchError(
            f"{tags.where('linkName')}: a motor-model plugin names the link '{link.name}', but its "
            f"joint '{joint.name}' turns another one: name the joint's child link '{joint.child}'"
        )
    direction = tags.turn("turningDirection")
    motor_constant = tags.positive("motorConstant")
    element = f"motor model of '{joint.name}'"
    constants = read_constants(tags, GAZEBO, "Gazebo's defaults", element, remarks)
    tags.note_unused(_USED, element, remarks)
    mount = mount_on_joint(model, base_link, joint, link, tags.file, remarks)
    turn = direction * mount.sense
    return make_rotor(model, joint, link, mount, turn, motor_constant, constants, tags, remarks)


def _joint(tags: Tags, model: Model, link: Link, remarks: Remarks) -> Joint:
    """Return the joint that a plugin names, or the one that its link hangs on."""
    name = tags.text("jointName")
    try:
        return find_joint(model, name, tags.where("jointName"))
    except WorkbenchError:
        above = model.joint_of(link.name)
        if above is None:
            raise
    text = (
        f"there is no joint '{shortened(name)}'; taken as '{above.name}', which its link hangs on"
    )
    remarks.add("repaired", tags.file, f"motor model of '{shortened(link.name)}'", text)
    return above


def _number(tags: Tags) -> int | None:
    """Return the place of a motor in the list of commands; gz-sim's own name for it goes first."""
    for tag in ("actuator_number", "motorNumber"):
        if tags.has(tag):
            text = tags.text(tag)
            if not text.isdecimal() or len(text) > _MOST_DIGITS:
                raise tags.fault(tag, "use 0, 1, 2, ...")
            return int(text)
    return None

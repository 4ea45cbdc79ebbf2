"""What drives the joints of a description, from every way to say it."""

import dataclasses
from collections.abc import Iterator, Sequence
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened_text
from workbench.plant.model import Freedom, Joint, Model
from workbench.plant.remarks import Remarks
from workbench.plant.rotor_sources.names import find_joint
from workbench.plant.servo import ASSUMED_SERVO_RATE_RAD_S, Servo
from workbench.plant.servo_sources.classic_plugins import classic_servos
from workbench.plant.servo_sources.declared import DeclaredServo
from workbench.plant.servo_sources.plugins import joint_plugin_class, plugin_servos
from workbench.plant.servo_sources.ros_drives import ros_servos
from workbench.plant.servo_sources.sidecar_servos import sidecar_servos


def with_servos(model: Model, spinning: set[str], sidecar: Path | None, remarks: Remarks) -> Model:
    """Return a model whose joints have their servos.

    For each freedom the first of these counts: the sidecar, the joint itself (in MJCF its
    actuator), Gazebo's plugins, ROS's control.

    Args:
        model: one tree of links, with the freedoms that move.
        spinning: joints of rotors, which have no servo.
        sidecar: of the description, if any.
        remarks: receives remarks on gains that are assumed, and on servos that are not used.

    Raises:
        WorkbenchError: for an invalid number, or a joint of a sidecar that does not exist.
    """
    stated = sidecar_servos(sidecar) if sidecar else ()
    joints = {joint.name: joint for joint in model.joints}
    driven: dict[tuple[str, int], Servo] = {}
    for each in stated:
        joint = find_joint(model, each.joint, f"{each.file}: servos")
        if each.axis >= len(joint.freedoms):
            raise WorkbenchError(
                f"{each.file}: servos: the joint '{shortened_text(each.joint)}' does not move: "
                "leave its servo out"
            )
        driven[joint.name, joint.place_of(each.axis)] = each.servo
    for joint in model.joints:
        for axis, freedom in enumerate(joint.freedoms):
            if freedom.servo:
                driven.setdefault((joint.name, axis), freedom.servo)
    for each in _declared(model, remarks):
        try:
            joint = find_joint(model, each.joint, each.element)
        except WorkbenchError as error:
            text = str(error).removeprefix(f"{each.element}: ")
            remarks.add("ignored", each.file, each.element, text)
            continue
        if joint.name in spinning or joint.kind == "fixed":
            continue
        if each.axis >= len(joint.freedoms) or joint.mimic or joint.freedoms[0].kind == "ball":
            why = "follows another one" if joint.mimic else "is held, or turns freely"
            text = f"its joint '{shortened_text(joint.name)}' {why}; not used"
            remarks.add("ignored", each.file, each.element, text)
            continue
        key = joint.name, joint.place_of(each.axis)
        for what, text in each.notes if key not in driven else ():
            remarks.add("ignored", each.file, what, text)
        driven.setdefault(key, each.servo)
    for (name, axis), servo in driven.items():
        freedoms = list(joints[name].freedoms)
        limited = _limited(freedoms[axis], servo)
        freedoms[axis] = dataclasses.replace(freedoms[axis], servo=limited)
        _note_assumed(model, joints[name], limited, remarks)
        joints[name] = dataclasses.replace(joints[name], freedoms=tuple(freedoms))
    return dataclasses.replace(model, joints=tuple(joints.values()))


def _declared(model: Model, remarks: Remarks) -> Iterator[DeclaredServo]:
    """Yield the servos of plugins and of ROS's control."""
    for plugin in model.plugins:
        if joint_plugin_class(plugin):
            yield from plugin_servos(plugin, remarks)
        else:
            yield from classic_servos(plugin, remarks)
    for drive in model.drives:
        found = list(ros_servos(drive))
        if not found:
            text = "it drives no joint; not used"
            remarks.add("ignored", drive.file, f"element <{drive.tag}>", text)
        yield from found


def _limited(freedom: Freedom, servo: Servo) -> Servo:
    """Return a servo within the limits of its freedom."""
    effort, rate = min(servo.max_effort, freedom.effort), servo.max_rate
    lower, upper = servo.lower, servo.upper
    match servo.kind:
        case "position":
            lower, upper, rate = (
                max(lower, freedom.lower),
                min(upper, freedom.upper),
                min(rate, freedom.speed),
            )
        case "velocity":
            lower, upper = max(lower, -freedom.speed), min(upper, freedom.speed)
        case _:
            lower, upper = max(lower, -effort), min(upper, effort)
    if lower > upper:
        lower, upper = freedom.lower, freedom.upper
    found = dataclasses.replace(servo, lower=lower, upper=upper, max_effort=effort, max_rate=rate)
    return dataclasses.replace(found, start=found.within(servo.start))


def _note_assumed(model: Model, joint: Joint, servo: Servo, remarks: Remarks) -> None:
    """Note gains that nothing states."""
    if servo.kind == "effort" or (servo.damping is not None and servo.stiffness is not None):
        return
    if servo.kind == "velocity" and servo.damping is not None:
        return
    if servo.stiffness is None:
        text = f"no gains are stated; {ASSUMED_SERVO_RATE_RAD_S:g} rad/s with what it moves"
        remarks.add("assumed", model.source, f"servo of joint '{shortened_text(joint.name)}'", text)


def servo_freedoms(joints: Sequence[Joint]) -> Iterator[tuple[str, Freedom, Servo]]:
    """Yield name, freedom and servo of each freedom that has one, in the order of the plant."""
    for joint in joints:
        for name, freedom in zip(joint.freedom_names, joint.freedoms, strict=True):
            if freedom.servo:
                yield name, freedom, freedom.servo

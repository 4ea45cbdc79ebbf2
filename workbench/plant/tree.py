"""The base link of a model, and the tree of links below it."""

import dataclasses

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import shortened
from workbench.plant.model import MOVING, Joint, Model
from workbench.plant.remarks import Remarks


def find_base_link(model: Model) -> str:
    """Return the link that is not the child of a joint; of several, that with the most links below.

    Raises:
        WorkbenchError: if there is none, or if it is fixed to the world.
    """
    if not model.links:
        raise WorkbenchError(f"{model.source}: it has no links: give the file of one drone")
    children = {joint.child for joint in model.joints if joint.parent != "world"}
    roots = [link.name for link in model.links if link.name not in children]
    if not roots:
        raise WorkbenchError(
            f"{model.source}: a drone has one link that no joint has as its child, but here there "
            "is none: remove the joint above its body"
        )
    base = max(roots, key=lambda name: len(links_below(model, name)))
    if any(link.name == "world" for link in model.links if link.name != base):
        raise WorkbenchError(
            f"{model.source}: a link is named 'world', the name of the ground: rename it"
        )
    nails = [joint for joint in model.joints if joint.parent == "world" and joint.child == base]
    if base == "world" or nails:
        raise WorkbenchError(
            f"{model.source}: the base link '{shortened(base)}' is fixed to the world, but a drone "
            "flies freely: leave out a link named 'world' and its joint"
        )
    return base


def flying_tree(model: Model, base_link: str, rotor_joints: set[str], remarks: Remarks) -> Model:
    """Return the model as the tree below its base link, with remarks on changes.

    Ball joints move, unless a rotor or a sensor is below one, or no mass. Other joints are held at
    zero.

    Args:
        model: as read.
        base_link: its root.
        rotor_joints: names of the joints that turn with rotors, which need no remark.
        remarks: receives a remark for each other joint.
    """
    rotor_links = {joint.child for joint in model.joints if joint.name in rotor_joints}
    bound = rotor_links | {sensor.link for sensor in model.sensors}
    heavy = {link.name for link in model.links if link.inertial and link.inertial.mass > 0.0}
    kept = links_below(model, base_link)
    for link in model.links:
        if link.name not in kept:
            remarks.add(
                "ignored",
                model.source,
                f"link '{shortened(link.name)}'",
                f"no joint connects it to '{shortened(base_link)}'; left out, with its mass",
            )
    joints: list[Joint] = []
    for joint in model.joints:
        if joint.parent not in kept or joint.child not in kept or joint.child == base_link:
            continue
        if any(other.child == joint.child for other in joints):
            text = (
                f"'{shortened(joint.child)}' is already the child of another joint; this one is "
                "left out"
            )
            remarks.add("ignored", model.source, f"joint '{shortened(joint.name)}'", text)
            continue
        if joint.kind in MOVING:
            below = links_below(model, joint.child)
            if below & bound or not below & heavy:
                joint = dataclasses.replace(joint, kind="fixed")
                why = "a rotor or sensor is below it" if below & bound else "nothing below has mass"
                text = f"{why}; held at zero"
            else:
                text = "it moves freely in flight; linear models and sweeps hold it at zero"
            remarks.add("assumed", model.source, f"joint '{shortened(joint.name)}'", text)
        elif joint.kind != "fixed" and joint.name not in rotor_joints:
            text = f"its motion ({shortened(joint.kind)}) does not turn a rotor; held at zero"
            remarks.add("ignored", model.source, f"joint '{shortened(joint.name)}'", text)
        joints.append(joint)
    return dataclasses.replace(
        model,
        links=tuple(link for link in model.links if link.name in kept),
        joints=tuple(joints),
    )


def links_below(model: Model, base_link: str) -> set[str]:
    """Return the names of a link and of all links below it."""
    children: dict[str, list[str]] = {}
    for joint in model.joints:
        children.setdefault(joint.parent, []).append(joint.child)
    found: set[str] = set()
    todo = [base_link]
    while todo:
        name = todo.pop()
        if name not in found:
            found.add(name)
            todo += children.get(name, [])
    return found

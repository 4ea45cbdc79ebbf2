"""The base link of a model, and the tree of links below it."""

import dataclasses
from collections.abc import Mapping

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis
from pydrake.math import RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.values import listed_names, shortened_text
from workbench.plant.gathered import body_roots, whole_inertial
from workbench.plant.model import FREE_JOINT_KIND, Cable, Joint, Model
from workbench.plant.remarks import Remarks

MOVING_JOINT_KINDS = ("revolute", "continuous", "prismatic", "universal", "revolute2", "planar")
"""Kinds of joints that have freedoms, unless their limits leave none."""
MIN_MOVED_INERTIA_KGM2 = 1e-15
"""Moment of inertia about an axis below which nothing is there to turn [kg m²]."""
_MAX_START_STRETCH = 1.05
"""Distance of the ends of a cable over its length, up to which a description may be inexact."""
_NOT_NEGATIVE_WORDS = ("damping", "friction", "stiffness", "armature")


def without_floating_root(model: Model) -> Model:
    """Return a model without a root that is no body, such as `world`, above a floating joint."""
    children = {joint.child for joint in model.joints}
    for joint in model.joints:
        root = model.link(joint.parent)
        alone = sum(other.parent == joint.parent for other in model.joints) == 1
        if joint.kind == "floating" and root and root.name not in children and alone:
            if root.inertial or root.shapes:
                continue
            return dataclasses.replace(
                model,
                links=tuple(link for link in model.links if link is not root),
                joints=tuple(other for other in model.joints if other is not joint),
            )
    return model


def find_base_link(model: Model) -> str:
    """Return the link that is not the child of a joint; of several, that with the most links below.

    A joint that is named from its far end, as SDF allows, has such a link above the body. Then the
    base link is the canonical link, unless the two are one rigid body.

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
    below = {root: links_below(model, root) for root in roots}
    base = max(roots, key=lambda name: len(below[name]))
    canonical = model.canonical_link
    above = [root for root in roots if canonical in below[root]]
    if base in above and (len(above) > 1 or _moves_below(model, base, canonical)):
        base = canonical
    if any(link.name == "world" for link in model.links if link.name != base):
        raise WorkbenchError(
            f"{model.source}: a link is named 'world', the name of the ground: rename it"
        )
    if base == "world":
        raise WorkbenchError(
            f"{model.source}: the base link 'world' is fixed to the world, but a drone flies "
            "freely: leave out a link named 'world' and its joint"
        )
    own = links_below(model, base)
    for joint in model.joints:
        if joint.parent == "world" and joint.child in own:
            link, name = shortened_text(joint.child), shortened_text(joint.name)
            raise WorkbenchError(
                f"{model.source}: the link '{link}' is fixed to the world by the joint '{name}', "
                "but a drone flies freely: leave that out"
            )
    return base


def _moves_below(model: Model, base_link: str, link: str) -> bool:
    """Return whether a joint moves between a link and one below it."""
    fixed = [joint for joint in model.joints if not joint.moves]
    return link not in links_below(dataclasses.replace(model, joints=tuple(fixed)), base_link)


def flying_tree(model: Model, base_link: str, rotor_joints: set[str], remarks: Remarks) -> Model:
    """Return the model as the tree below its base link, with remarks on changes.

    A joint moves in its freedoms, unless it turns a rotor, has no range, or moves nothing that has
    inertia about its axis. Those that do not move are held at zero.

    Args:
        model: as read.
        base_link: its root.
        rotor_joints: names of the joints that turn with rotors, which need no remark.
        remarks: receives a remark for each other joint that is held.

    Raises:
        WorkbenchError: if a joint closes a loop, follows one that does not exist, or itself, or has
            a negative damping, friction, stiffness or armature.
    """
    model = _directed(model, base_link, remarks)
    kept = links_below(model, base_link)
    for link in model.links:
        if link.name not in kept:
            remarks.add(
                "ignored",
                model.source,
                f"link '{shortened_text(link.name)}'",
                f"no joint connects it to '{shortened_text(base_link)}'; left out, with its mass",
            )
    joints: dict[str, Joint] = {}  # by child
    for joint in model.joints:
        if joint.parent not in kept or joint.child not in kept or joint.child == base_link:
            continue
        first = joints.get(joint.child)
        if first is None:
            joints[joint.child] = joint
            continue
        if (first.moves or joint.moves) and joint.name not in rotor_joints:
            raise _loop(model, joint, first)
        text = (
            f"'{shortened_text(joint.child)}' is already the child of another joint; this one "
            "is left out"
        )
        remarks.add("ignored", model.source, f"joint '{shortened_text(joint.name)}'", text)
    links = tuple(link for link in model.links if link.name in kept)
    tree = dataclasses.replace(model, links=links, joints=tuple(joints.values()))
    found = []
    for joint in tree.joints:
        if joint.name not in rotor_joints:
            _refuse_negative(tree, joint)
        why = "" if joint.name in rotor_joints else _why_held(tree, joint)
        if why:
            text = f"{why}; held at zero"
            remarks.add("held", model.source, f"joint '{shortened_text(joint.name)}'", text)
        moves = not why and joint.name not in rotor_joints
        found.append(_started(tree, joint, remarks) if moves else joint.held())
    tree = dataclasses.replace(tree, joints=tuple(found))
    return _with_cables(_with_leaders(tree, remarks), base_link, remarks)


def _directed(model: Model, base_link: str, remarks: Remarks) -> Model:
    """Return a model in which joints whose child is the nearer end are turned round.

    In SDF a link may be the child of several joints: Gazebo knows no direction.
    """
    joints = list(model.joints)
    while True:
        kept = links_below(dataclasses.replace(model, joints=tuple(joints)), base_link)
        place = next(
            (
                i
                for i, joint in enumerate(joints)
                if joint.child in kept
                and joint.parent not in kept
                and model.link(joint.parent)
                and joint.kind != FREE_JOINT_KIND
            ),
            None,
        )
        if place is None:
            return dataclasses.replace(model, joints=tuple(joints))
        joints[place] = joints[place].reversed()
        what = f"joint '{shortened_text(joints[place].name)}'"
        text = f"its child is nearer to '{shortened_text(base_link)}'; taken the other way round"
        remarks.add("repaired", model.source, what, text)


def _with_cables(model: Model, base_link: str, remarks: Remarks) -> Model:
    """Return a model with the cables between links that move relative to each other."""
    roots, kept = body_roots(model, base_link), []
    for cable in model.cables:
        ends = [roots.get(link) for link in (cable.parent, cable.child)]
        if None in ends or ends[0] == ends[1]:
            text = "its ends do not move relative to each other; left out"
            remarks.add("ignored", model.source, f"cable '{shortened_text(cable.name)}'", text)
            continue
        kept.append(cable)
        apart = _distance(model, cable)
        if apart > _MAX_START_STRETCH * cable.length and not cable.stiffness:
            text = f"{apart:.3g} m between its ends: it is too short, and pulls at once"
            remarks.add("assumed", model.source, f"cable '{shortened_text(cable.name)}'", text)
    return dataclasses.replace(model, cables=tuple(kept))


def _distance(model: Model, cable: Cable) -> float:
    """Return the distance between the ends of a cable where all joints begin [m]."""
    above = {joint.child: joint for joint in model.joints}
    ends = []
    for name, place in ((cable.parent, cable.p_parent), (cable.child, cable.p_child)):
        link, joint = model.link(name), above.get(name)
        assert link
        p_M = link.X_ML.multiply(np.array(place))
        for _ in above:
            if joint is None:
                break
            p_M = _at_start(joint, p_M)
            joint = above.get(joint.parent)
        ends.append(p_M)
    return float(np.linalg.norm(ends[1] - ends[0]))


def _at_start(joint: Joint, p_M: np.ndarray) -> np.ndarray:
    """Return where a joint that begins away from zero takes a point on its child (3) [m]."""
    p_J = joint.X_MJ.inverse().multiply(p_M)
    for each in reversed(joint.freedoms):
        axis, at = np.array(each.axis_J), np.array(each.p_J)
        if each.kind == "revolute":
            p_J = at + RotationMatrix(AngleAxis(each.start, axis)).multiply(p_J - at)
        else:
            p_J = p_J + each.start * axis
    moved: np.ndarray = joint.X_MJ.multiply(p_J)
    return moved


def _loop(model: Model, joint: Joint, first: Joint) -> WorkbenchError:
    """Return the error on a joint that closes a loop of links."""
    return WorkbenchError(
        f"{model.source}: joint '{shortened_text(joint.name)}' closes a loop: a joint has "
        f"'{shortened_text(joint.child)}' as its child, and so has '{shortened_text(first.name)}'; "
        "loops of links do not fly: leave one of the joints out"
    )


def _refuse_negative(model: Model, joint: Joint) -> None:
    """Reject numbers of a joint with which it would drive itself."""
    for freedom in joint.freedoms:
        for word in _NOT_NEGATIVE_WORDS:
            if (value := getattr(freedom, word)) < 0.0:
                raise WorkbenchError(
                    f"{model.source}: joint '{shortened_text(joint.name)}' has the {word} "
                    f"{value:g}: give it 0 or more"
                )


def _why_held(model: Model, joint: Joint) -> str:
    """Return why a joint that is not fixed does not move, "" if it does or is fixed."""
    if joint.kind == "fixed":
        return ""
    if not joint.freedoms and joint.kind in MOVING_JOINT_KINDS:
        return "its limits leave no range"
    if not joint.freedoms:
        return f"a joint of the kind '{shortened_text(joint.kind)}' is not flown"
    below = links_below(model, joint.child)
    parts = [(link.X_ML, link.inertial) for link in model.links if link.name in below]
    whole = whole_inertial(parts)
    if whole is None or whole.mass <= 0.0:
        return "nothing below has mass"
    for freedom in joint.freedoms:
        axis = joint.X_MJ.rotation().multiply(np.array(freedom.axis_J))
        arm = whole.X_LI.translation() - joint.X_MJ.multiply(np.array(freedom.p_J))
        R = whole.X_LI.rotation().matrix()
        inertia = whole.mass * float(np.cross(axis, arm) @ np.cross(axis, arm))
        inertia += float(axis @ R @ whole.matrix @ R.T @ axis) + freedom.armature
        if freedom.kind == "revolute" and inertia < MIN_MOVED_INERTIA_KGM2:
            return "nothing below has a moment of inertia about its axis"
    return ""


def _started(model: Model, joint: Joint, remarks: Remarks) -> Joint:
    """Return a joint that begins within its limits, with a remark if that is not at zero."""
    freedoms = tuple(
        dataclasses.replace(each, start=min(max(0.0, each.lower), each.upper))
        for each in joint.freedoms
    )
    for each in freedoms:
        if each.start:
            text = f"zero is outside its limits; it starts at {each.start:.6g}"
            remarks.add("assumed", model.source, f"joint '{shortened_text(joint.name)}'", text)
    return dataclasses.replace(joint, freedoms=freedoms)


def _with_leaders(model: Model, remarks: Remarks) -> Model:
    """Return a model in which each joint that follows another one knows its name in full.

    A follower of a joint that is held is held as well, with a remark.

    Raises:
        WorkbenchError: if it follows one that does not exist.
    """
    joints = {joint.name: joint for joint in model.joints}
    leaders = {joint.name: _leader(model, joint) for joint in model.joints if joint.mimic}
    chains = {name: _chain(model, name, leaders) for name in leaders}
    for name in sorted(chains, key=lambda each: len(chains[each])):  # leaders come first
        joint, (leader, axis) = joints[name], leaders[name]
        leader = joints[leader.name]
        assert joint.mimic
        if not leader.moves:
            text = f"it follows '{shortened_text(leader.name)}', which is held; held at zero"
            remarks.add("held", model.source, f"joint '{shortened_text(name)}'", text)
            joints[name] = joint.held()
            continue
        if axis >= len(leader.freedoms) or leader.freedoms[axis].count > 1:
            raise WorkbenchError(
                f"{model.source}: joint '{shortened_text(name)}' follows "
                f"'{shortened_text(leader.name)}', which has no such axis: name another joint"
            )
        mimic = dataclasses.replace(joint.mimic, joint=leader.freedom_names[axis], axis=0)
        start = mimic.multiplier * leader.freedoms[axis].start + mimic.offset
        freedom = dataclasses.replace(joint.freedoms[0], start=start)
        joints[name] = dataclasses.replace(joint, mimic=mimic, freedoms=(freedom,))
    return dataclasses.replace(model, joints=tuple(joints.values()))


def _chain(model: Model, name: str, leaders: Mapping[str, tuple[Joint, int]]) -> list[str]:
    """Return a joint that follows another one, its leader, the leader of that, and so on.

    Args:
        model: of the drone.
        name: of the joint.
        leaders: of all joints that follow another one, by name.

    Raises:
        WorkbenchError: if it comes back to one of them.
    """
    chain = [name]
    while chain[-1] in leaders:
        leader = leaders[chain[-1]][0].name
        if leader in chain:
            first, *rest = [f"'{shortened_text(each)}'" for each in chain[chain.index(leader) :]]
            names = f"{', '.join([first, *rest[:-1]])} and {rest[-1]}"
            raise WorkbenchError(
                f"{model.source}: joints {names} follow each other: leave one <mimic> out"
            )
        chain.append(leader)
    return chain


def _leader(model: Model, joint: Joint) -> tuple[Joint, int]:
    """Return the joint that another one follows, and which of its freedoms.

    It is one of its own nested model, or of any around it.
    """
    assert joint.mimic
    freedoms = {
        name: (each, axis)
        for each in model.joints
        for axis, name in enumerate(each.freedom_names)
        if each is not joint
    }
    scope = joint.name
    while scope:
        scope = scope.rpartition("::")[0]
        name = f"{scope}::{joint.mimic.joint}" if scope else joint.mimic.joint
        found = model.joint(name)
        if found and found is not joint:
            return found, found.place_of(joint.mimic.axis)
        if name in freedoms:
            return freedoms[name]
    names = [each.name for each in model.joints if each.moves and each is not joint]
    raise WorkbenchError(
        f"{model.source}: joint '{shortened_text(joint.name)}' follows "
        f"'{shortened_text(joint.mimic.joint)}', which does not exist: joints are "
        f"{listed_names(names) or 'none'}"
    )


def hooked_cables(model: Model) -> tuple[Cable, ...]:
    """Return the cables that end in a hook: those that tie a load to something else."""
    loads = {link: load for load in model.loads for link in links_below(model, load)}
    return tuple(
        cable for cable in model.cables if loads.get(cable.parent) != loads.get(cable.child)
    )


def without_loads(model: Model) -> Model:
    """Return a model without what flies freely on cables, and without these cables."""
    below = {link for load in model.loads for link in links_below(model, load)}
    return dataclasses.replace(
        model,
        links=tuple(link for link in model.links if link.name not in below),
        joints=tuple(joint for joint in model.joints if joint.child not in below),
        cables=tuple(each for each in model.cables if below.isdisjoint((each.parent, each.child))),
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

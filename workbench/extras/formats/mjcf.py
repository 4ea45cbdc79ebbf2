"""Read MJCF, the format of MuJoCo: the free body with its mass and inertia, and its actuators."""

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import NamedTuple

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_body import MjcfBodyReader
from workbench.extras.formats.mjcf_compiler import Compiler
from workbench.extras.formats.mjcf_defaults import Defaults
from workbench.extras.formats.mjcf_document import MjcfDocument, read_mjcf_document
from workbench.extras.formats.mjcf_elements import elements, elements_of, padded_numbers
from workbench.extras.formats.mjcf_held_loads import HeldLoad, held_loads, pose_of_link
from workbench.extras.formats.mjcf_meshes import Meshes
from workbench.extras.formats.mjcf_motors import SitePoses, joint_servos, read_actuators
from workbench.extras.formats.mjcf_pose import pose_of
from workbench.extras.formats.mjcf_tendons import drive_by_joints, read_tendons, tendon_sites
from workbench.extras.formats.mjcf_words import check_mjcf_attributes
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    listed_names,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.gathered import body_roots
from workbench.plant.model import (
    FREE_FREEDOMS,
    FREE_JOINT_KIND,
    Freedom,
    Joint,
    Link,
    Mimic,
    Model,
    inertial_of,
    refuse_too_many,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.servo import Servo
from workbench.plant.worlds.world import first_duplicate

_UNUSED_OF_FREE_JOINTS = ("damping", "frictionloss", "stiffness")
"""Attributes of a free joint that do not act."""


def read_mjcf(path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the free body in an MJCF file as a model.

    Poses, masses, inertias and actuators are those of MuJoCo's compiler. The model frame is that
    of the free body; its pose in the file is not used, as a scenario defines it.

    Args:
        path: the file, for messages and relative paths.
        root: its root element.
        finder: of meshes.
        remarks: receives remarks on unused parts.

    Raises:
        WorkbenchError: naming file and element, for invalid content, and for any that may decide
            mass, inertia or thrust and is not read.
    """
    document = read_mjcf_document(path, root, finder, remarks)
    root, compiler = document.root, document.compiler
    drive_by_joints(root, document.defaults)
    tops = [
        each
        for world in elements(root, "worldbody")
        for each in _bodies(world, "", RigidTransform(), compiler)
    ]
    drone, loads, held = _free_bodies(document, tops)
    flying = (drone, *loads)
    used = [each.element for each in held.values()]
    check_mjcf_attributes(path, root, [each.element for each in flying], remarks, used)
    bodies, geoms = (
        sum(1 for each in flying for _ in each.element.iter(tag)) for tag in ("body", "geom")
    )
    refuse_too_many(path, bodies, geoms, 0)
    meshes = Meshes(document, finder)
    reader = MjcfBodyReader(document, meshes)
    reader.add(drone.element, RigidTransform(), "", drone.childclass)
    base, hung = reader.links[0].name, []
    for load in loads:
        X_ML = drone.X_WB.InvertAndCompose(load.X_WB)
        place = len(reader.links)
        hold = held.get(load.element.get("name", ""))
        if hold:
            X_MH = pose_of_link(reader.links, hold.holder)
            X_ML = hold.X_ML(X_MH, X_ML)
            reader.add(load.element, X_ML, "", load.childclass)
            load_name = reader.links[place].name
            joint_name = reader.new_joint_name(hold.element.get("name") or f"{load_name}_hold")
            reader.joints.append(hold.joint(joint_name, load_name, X_MH, X_ML))
            continue
        reader.add(load.element, X_ML, "", load.childclass)
        hung.append(reader.links[place].name)
        joint_name = reader.new_joint_name(f"{hung[-1]}_joint")
        reader.joints.append(_free_joint(load.element, joint_name, base, hung[-1], X_ML))
    _refuse_twins(path, reader.joints)
    links = reader.links
    refuse_too_many(path, 0, 0, sum(len(link.collisions) for link in links))
    if compiler.settotalmass > 0.0:
        others = MjcfBodyReader(document._replace(remarks=Remarks()), meshes)
        for top in tops:
            others.add(top.element, RigidTransform(), "", top.childclass)
        links = _scaled_to_total_mass(path, links, others.links, compiler.settotalmass)
    freedoms = (each for joint in reader.joints for each in joint.freedoms)
    kinds: dict[str, str] = {each.name: each.kind for each in freedoms}
    model = Model(
        source=path,
        name=root.get("model") or path.name.partition(".")[0],
        links=tuple(links),
        joints=tuple(reader.joints),
        frames=(),
        sensors=(),
        plugins=(),
        actuators=tuple(read_actuators(document, reader.sites, kinds)),
        cables=tuple(read_tendons(document, reader.sites, hung)),
    )
    driven = _driven_joints(document, reader, kinds)
    mimics = _equal_joints(document, used, driven, reader.sites, body_roots(model, base))
    joints = tuple(replace(joint, mimic=mimics.get(joint.name)) for joint in driven)
    return replace(model, joints=joints)


def _free_joint(body: Element, usual: str, base: str, load: str, X_ML: RigidTransform) -> Joint:
    """Return the joint of a load that flies freely, with its own name or the usual one."""
    name = next((j.get("name", "") for j in elements(body, "freejoint", "joint")), "")
    return Joint(
        name or usual,
        FREE_JOINT_KIND,
        base,
        load,
        X_ML,
        (0.0, 0.0, 1.0),
        FREE_FREEDOMS,
    )


def _refuse_twins(path: Path, joints: Sequence[Joint]) -> None:
    """Reject two joints with one name, as MuJoCo does."""
    twin = first_duplicate(name for each in joints for name in {each.name, *each.freedom_names})
    if twin is not None:
        raise WorkbenchError(
            f"{path}: there are two joints named '{shortened_text(twin)}': rename one"
        )


def _scaled_to_total_mass(
    path: Path, links: list[Link], every: list[Link], settotalmass: float
) -> list[Link]:
    """Return links with masses and inertias scaled for a total mass of every link of the file."""
    total = sum(link.inertial.mass for link in every if link.inertial)
    if not total > 0.0:
        raise WorkbenchError(f"{path}: <compiler settotalmass>: no body has a mass: give one")
    scale = settotalmass / total
    scaled = []
    for link in links:
        inertial = link.inertial
        if inertial:
            inertial = inertial_of(scale * inertial.mass, inertial.X_LI, scale * inertial.matrix)
        scaled.append(replace(link, inertial=inertial))
    return scaled


class _TopBody(NamedTuple):
    """A body of the world.

    Attributes:
        element: of the body.
        childclass: default class around it.
        X_WB: its pose in the world, with those of the frames around it.
    """

    element: Element
    childclass: str
    X_WB: RigidTransform


def _free_bodies(
    document: MjcfDocument, tops: list[_TopBody]
) -> tuple[_TopBody, list[_TopBody], Mapping[str, HeldLoad]]:
    """Return the drone, its loads, and those that equalities hold; a remark has what is left out.

    Of several free bodies the drone is the one with actuators, or the first.
    """
    path, root, _, defaults, _, remarks = document
    free = [top for top in tops if list(_free_joints(top.element, top.childclass, defaults))]
    if not free:
        names = listed_names([top.element.get("name", "without a name") for top in tops])
        raise WorkbenchError(
            f"{path}: no body in <worldbody> has a <freejoint/>, and a drone flies freely: add it "
            f"to one of {names}"
            if tops
            else f"{path}: there is no <body> in <worldbody>: add one"
        )
    driven = {each.get("site", "") for each in elements_of(root, "actuator")} - {""}
    driven |= {each.get("joint", "") for each in elements_of(root, "actuator")} - {""}
    powered = [top for top in free if _names(top.element, "site", "joint") & driven]
    if len(powered) > 1:
        raise _several(path, powered, "have actuators: give a file with one drone")
    drone = (powered or free)[0]
    loads = [top for top in free if top is not drone]
    ends = tendon_sites(root)
    held = held_loads(document, drone.element, [load.element for load in loads])
    if any(
        not (_names(load.element, "site") & ends or load.element.get("name") in held)
        for load in loads
    ):
        raise _several(
            path,
            free,
            "move freely: give a file with the drone alone, or tie its load "
            "to it by a <weld> or <connect> of body1 and body2, or by a <spatial> tendon",
        )
    geoms = len(root.findall("worldbody/geom"))
    others = [shortened_text(top.element.get("name", "")) for top in tops if top not in free]
    if others or geoms:
        parts = [f"bodies {listed_names(others)}"] if others else []
        parts += [f"{geoms} geoms"] if geoms else []
        text = f"'{shortened_text(drone.element.get('name', ''))}' flies; left out are "
        remarks.add("ignored", path, "objects of the world", text + " and ".join(parts))
    for top in (drone, *loads):
        for joint in _free_joints(top.element, top.childclass, defaults):
            _check_free_joint(path, joint, remarks)
    return drone, loads, held


def _check_free_joint(path: Path, joint: Element, remarks: Remarks) -> None:
    """Reject a free joint with an inertia of its own; a remark has what else does not act."""
    if joint.tag == "freejoint":  # which has no such attributes, nor defaults
        return
    if attribute_number(joint, "armature", "0") != 0.0:
        raise WorkbenchError(
            f"{element_location(joint)}: <joint "
            f"armature='{shortened_text(joint.get('armature', ''))}'>: adds "
            "to mass and inertia of all that flies with it: use a <freejoint>, which has none"
        )
    given = [word for word in _UNUSED_OF_FREE_JOINTS if any(attribute_numbers(joint, word, "0"))]
    if given:
        text = f"{listed_names(given)} of a free joint: not used, air has drag of its own"
        name = shortened_text(joint.get("name", "without a name"))
        remarks.add("ignored", path, f"joint '{name}'", text)


def _several(path: Path, bodies: list[_TopBody], what: str) -> WorkbenchError:
    names = listed_names([body.element.get("name", "") for body in bodies])
    return WorkbenchError(f"{path}: several bodies {what}: {names}")


def _names(body: Element, *tags: str) -> set[str]:
    """Return the names of elements in a body."""
    return {each.get("name", "") for tag in tags for each in body.iter(tag)} - {""}


def _bodies(
    parent: Element, childclass: str, X_WF: RigidTransform, compiler: Compiler
) -> Iterator[_TopBody]:
    """Yield the bodies in a world or a frame at X_WF, also those in further frames."""
    for child in elements(parent, "body", "frame"):
        X_WC = X_WF @ pose_of(child, compiler)
        if child.tag == "body":
            yield _TopBody(child, childclass, X_WC)
        else:
            yield from _bodies(child, child.get("childclass", childclass), X_WC, compiler)


def _free_joints(body: Element, childclass: str, defaults: Defaults) -> Iterator[Element]:
    """Yield the free joints of a body, not of those in it, which may have none."""
    childclass = body.get("childclass", childclass)
    for child in elements(body, "freejoint", "joint", "frame"):
        if child.tag == "frame":
            yield from _free_joints(child, childclass, defaults)
        elif child.tag == "freejoint":
            yield child
        else:
            joint = defaults.applied(child, childclass)
            if joint.get("type") == "free":
                yield joint


def _driven_joints(
    document: MjcfDocument, reader: MjcfBodyReader, kinds: Mapping[str, str]
) -> list[Joint]:
    """Return the joints of a body with their servos, and with what actuators add to them."""
    servos: dict[str, Servo] = {}
    added: dict[str, np.ndarray] = {}
    for driven in joint_servos(document, kinds):
        name, servo = driven.name, driven.servo
        added[name] = added.get(name, np.zeros(2)) + (driven.armature, driven.damping)
        if servo is None:
            continue
        before = servos.get(name)
        if before and before.kind == "position" and servo.kind == "velocity":  # its damping
            damping = (before.damping or 0.0) + (servo.damping or 0.0)
            servos[name] = replace(before, damping=damping)
        elif before:
            text = "another actuator drives it; not used"
            what = f"actuator of joint '{shortened_text(name)}'"
            document.remarks.add("ignored", document.path, what, text)
        else:
            servos[name] = servo.shifted(-reader.references.get(name, 0.0))

    def driven_freedom(freedom: Freedom) -> Freedom:
        if freedom.kind == "ball":
            return freedom
        armature, damping = added.get(freedom.name, np.zeros(2)).tolist()
        return replace(
            freedom,
            servo=servos.get(freedom.name),
            armature=freedom.armature + armature,
            damping=freedom.damping + damping,
        )

    return [
        replace(joint, freedoms=tuple(map(driven_freedom, joint.freedoms)))
        for joint in reader.joints
    ]


def _equal_joints(
    document: MjcfDocument,
    used: Sequence[Element],
    joints: Sequence[Joint],
    sites: SitePoses,
    roots: Mapping[str, str],
) -> dict[str, Mimic]:
    """Return what joints follow, by their names, from `<equality>`.

    Args:
        document: with the equalities.
        used: equalities that hold loads.
        joints: of the drone and its loads.
        sites: link and pose of the sites.
        roots: for each link, the first of those that fly as one body with it.

    Raises:
        WorkbenchError: for an equality that closes a loop.
    """
    moving = {joint.child for joint in joints if joint.moves}
    known = {name for joint in joints for name in joint.freedom_names}
    followers = {joint.name for joint in joints if len(joint.freedoms) <= 1}
    found = {}
    for element in elements_of(document.root, "equality"):
        name = shortened_text(element.get("name", ""))
        what = f"{element_location(element)}: <{f'{element.tag} {name}'.rstrip()}>"
        if element in used or not document.defaults.is_active(element):
            continue
        if element.tag != "joint":
            ends = {
                sites[element.attrib[site]][0]
                if element.get(site) in sites
                else element.get(body, "")
                for site, body in (("site1", "body1"), ("site2", "body2"))
            }
            bodies = {roots.get(end, "") for end in ends}  # "" for the world and what is in it
            if len(bodies) > 1 and bodies & moving:
                advice = "closes a loop of bodies that move, which does not fly: leave it out"
                if any(
                    element.tag == each.tag and ends == {each.get("body1"), each.get("body2")}
                    for each in used
                ):
                    advice = "makes a hinge of another one: give the body a hinge in the tree"
                raise WorkbenchError(
                    f"{what} between {listed_names([end or 'the world' for end in sorted(ends)])} "
                    f"{advice}"
                )
            continue
        coefficients = padded_numbers(element, "polycoef", "0 1", 5)
        leader = element.get("joint2", "")
        if any(coefficients[2:]) or not leader:
            raise WorkbenchError(
                f"{what}: a joint follows another one by a multiple and an offset: give it joint2 "
                "and two numbers of polycoef"
            )
        offset, multiplier = coefficients[:2]
        follower = element.get("joint1", "")
        for suffix in document.suffixes("joint", follower):
            own = leader + suffix if leader + suffix in known else leader
            if follower + suffix in known - followers:
                raise WorkbenchError(
                    f"{what}: '{shortened_text(follower + suffix)}' is one of several joints of a "
                    "body and cannot follow: give its body one joint"
                )
            found[follower + suffix] = Mimic(own, multiplier, offset)
    return found

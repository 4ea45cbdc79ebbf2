"""Merge links of a drone that do not move relative to each other into one rigid body.

In Drake every body, moving or welded, costs about a microsecond per step, and most drones have five
to a dozen links.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.model import (
    Inertial,
    Joint,
    Link,
    LinkShape,
    Model,
    NamedFrame,
    inertial_of,
)

_TINY_INERTIAL = Inertial(1e-12, RigidTransform(), (1e-15, 1e-15, 1e-15), (0.0, 0.0, 0.0))
"""Of links between the joints of a chain: CENIC refuses bodies without mass."""
_LINK_SHAPE_SEPARATOR = "::"
"""Separator between the names of link and shape; Meshcat makes a folder of the first."""


def merged_model(model: Model, base_link: str) -> Model:
    """Return the model with mass and shapes of links that fly as one body in one link.

    The body of the base link has its name and frame. That of others, which hang on a joint that
    moves, is `body_name` of the joint, and its frame is that of the joint. The links become frames
    on their bodies, the model's only frames; joints that do not move are gone, and those that do
    have one freedom each, see `with_single_freedoms`. The names of shapes are those that `link_of`
    reads.

    Args:
        model: one tree of links.
        base_link: its root.
    """
    base = model.link(base_link)
    assert base
    moving = [joint for joint in model.joints if joint.moves]
    names = {base_link: base_link} | {joint.child: body_name(joint) for joint in moving}
    roots = body_roots(model, base_link)
    parts: dict[str, list[Link]] = {root: [] for root in names}
    for link in model.links:
        parts[roots[link.name]].append(link)
    bodies = [_merged_link(base_link, base.X_ML, parts[base_link])]
    bodies += [_merged_link(names[joint.child], joint.X_MJ, parts[joint.child]) for joint in moving]
    joints = [
        dataclasses.replace(joint, parent=names[roots[joint.parent]], child=names[joint.child])
        for joint in moving
    ]
    X_MB = {body.name: body.X_ML for body in bodies}
    on = {link.name: names[roots[link.name]] for link in model.links}
    frames = [
        NamedFrame(link.name, on[link.name], X_MB[on[link.name]].InvertAndCompose(link.X_ML))
        for link in model.links
        if link.name != base_link
    ]
    return with_single_freedoms(
        dataclasses.replace(model, links=tuple(bodies), joints=tuple(joints), frames=tuple(frames))
    )


def with_single_freedoms(model: Model) -> Model:
    """Return a model whose joints have at most one freedom each, named as `freedom_names`.

    A joint of several becomes a chain of joints with links of 1e-12 kg between.
    """
    links, joints = list(model.links), []
    for joint in model.joints:
        if not joint.moves:
            joints.append(joint)
            continue
        parent, last = joint.parent, len(joint.freedoms) - 1
        for number, (name, each) in enumerate(
            zip(joint.freedom_names, joint.freedoms, strict=True)
        ):
            X_MJ = joint.X_MJ @ RigidTransform(np.array(each.p_J))
            child = joint.child
            if number < last:
                child = f"{joint.child}{_LINK_SHAPE_SEPARATOR}{name}"
                links.append(Link(child, X_MJ, _TINY_INERTIAL, (), ()))
            single = dataclasses.replace(each, p_J=(0.0, 0.0, 0.0), name="")
            mimic = joint.mimic if number == 0 else None
            joints.append(
                Joint(name, each.kind, parent, child, X_MJ, each.axis_J, (single,), mimic)
            )
            parent = child
    return dataclasses.replace(model, links=tuple(links), joints=tuple(joints))


def body_name(joint: Joint) -> str:
    """Return the name of the body that hangs on a joint that moves."""
    return f"{joint.child}{_LINK_SHAPE_SEPARATOR}{joint.name}"


def body_roots(model: Model, base_link: str) -> dict[str, str]:
    """Return, for each link, the first of those that fly as one body with it."""
    joints = {joint.child: joint for joint in model.joints}
    found = {joint.child: joint.child for joint in model.joints if joint.moves}
    found[base_link] = base_link
    for link in model.links:
        way = [link.name]
        while way[-1] not in found and way[-1] in joints:
            way.append(joints[way[-1]].parent)
        found |= dict.fromkeys(way, found.get(way[-1], base_link))
    return found


def _merged_link(name: str, X_MB: RigidTransform, links: Sequence[Link]) -> Link:
    """Return links that fly as one body as one link with the frame B."""
    parts = [(X_MB.InvertAndCompose(link.X_ML), link) for link in links]
    return Link(
        name=name,
        X_ML=X_MB,
        inertial=whole_inertial([(X_BL, link.inertial) for X_BL, link in parts]),
        visuals=tuple(
            _moved_shape(link, each, X_BL) for X_BL, link in parts for each in link.visuals
        ),
        collisions=tuple(
            _moved_shape(link, each, X_BL) for X_BL, link in parts for each in link.collisions
        ),
    )


def _moved_shape(link: Link, shape: LinkShape, X_BL: RigidTransform) -> LinkShape:
    name = f"{link.name}{_LINK_SHAPE_SEPARATOR}{shape.name.replace(_LINK_SHAPE_SEPARATOR, '_')}"
    return dataclasses.replace(shape, name=name, X_LS=X_BL @ shape.X_LS)


def link_of(geometry: str, drone: str) -> str:
    """Return the name of the link that a shape of the merged body comes from.

    Args:
        geometry: its name in Drake's scene graph.
        drone: name of the drone's model instance.
    """
    return geometry.removeprefix(f"{drone}{_LINK_SHAPE_SEPARATOR}").rpartition(
        _LINK_SHAPE_SEPARATOR
    )[0]


def whole_inertial(parts: Sequence[tuple[RigidTransform, Inertial | None]]) -> Inertial | None:
    """Return mass and inertia of all parts together, None if none has mass.

    With c_i the centre of mass of a part relative to that of the whole, in B: I = sum of R_i I_i
    R_i^T + m_i (c_i . c_i 1 - c_i c_i^T), the parallel-axis theorem.

    Args:
        parts: X_BL and inertia of each link.
    """
    heavy = [(X_BL @ part.X_LI, part) for X_BL, part in parts if part]
    if len(heavy) < 2:
        return dataclasses.replace(heavy[0][1], X_LI=heavy[0][0]) if heavy else None
    mass = sum(part.mass for _, part in heavy)
    centre = sum(part.mass * X_BI.translation() for X_BI, part in heavy) / mass
    inertia = np.zeros((3, 3))
    for X_BI, part in heavy:
        R, c = X_BI.rotation().matrix(), X_BI.translation() - centre
        inertia += R @ part.matrix @ R.T + part.mass * (c @ c * np.eye(3) - np.outer(c, c))
    return inertial_of(mass, RigidTransform(centre), inertia)

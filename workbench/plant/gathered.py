"""Merge the links of a drone into one rigid body, as none of them moves relative to another.

In Drake every body, moving or welded, costs about a microsecond per step, and most drones have five
to a dozen links.
"""

import dataclasses
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.model import Inertial, Link, LinkShape, Model, NamedFrame, inertial_of

_BETWEEN = "::"
"""Separator between the names of link and shape; Meshcat makes a folder of the first."""


def gathered(model: Model, base_link: str) -> Model:
    """Return the model with all mass and all shapes of its links in the base link.

    The other links become frames on it, its only frames, and there are no joints. The names of
    shapes are those that `link_of` reads.

    Args:
        model: one tree of links.
        base_link: its root.
    """
    base = model.link(base_link)
    assert base
    X_BL = {link.name: base.X_ML.InvertAndCompose(link.X_ML) for link in model.links}

    def moved(link: Link, shape: LinkShape) -> LinkShape:
        X_BS = X_BL[link.name] @ shape.X_LS
        return dataclasses.replace(shape, name=_named(link, shape.name), X_LS=X_BS)

    body = Link(
        name=base_link,
        X_ML=base.X_ML,
        inertial=whole_inertial([(X_BL[link.name], link.inertial) for link in model.links]),
        visuals=tuple(moved(link, each) for link in model.links for each in link.visuals),
        collisions=tuple(moved(link, each) for link in model.links for each in link.collisions),
    )
    frames = tuple(
        NamedFrame(link.name, base_link, X_BL[link.name])
        for link in model.links
        if link.name != base_link
    )
    return dataclasses.replace(model, links=(body,), joints=(), frames=frames)


def link_of(geometry: str, drone: str) -> str:
    """Return the name of the link that a shape of the merged body comes from.

    Args:
        geometry: its name in Drake's scene graph.
        drone: name of the drone's model instance.
    """
    return geometry.removeprefix(f"{drone}{_BETWEEN}").rpartition(_BETWEEN)[0]


def _named(link: Link, shape: str) -> str:
    return f"{link.name}{_BETWEEN}{shape.replace(_BETWEEN, '_')}"


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

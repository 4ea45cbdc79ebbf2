"""Simple shapes in the place of meshes that are missing, and of collisions that were forgotten."""

import dataclasses
import math
from collections.abc import Sequence

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.model import Collision, Inertial, Link, Visual
from workbench.plant.rotors import Rotor
from workbench.plant.shapes import Box, Cylinder, Mesh, Shape

_GREY = (0.55, 0.57, 0.6, 1.0)
_SMALLEST, _LARGEST = 0.02, 0.6
"""Of a stand-in's sides [m]."""
_DISC_SHARE = 0.45
"""A propeller's radius over the distance to the nearest other rotor, so that discs keep apart."""


def stand_ins(link: Link, rotors: Sequence[Rotor]) -> list[tuple[RigidTransform, Shape]]:
    """Return shapes to draw a link by, with their poses in it.

    They are its collision shapes if it has any, a disc for a rotor, else the box that has the
    link's mass and moments of inertia.
    """
    collisions = [
        (each.X_LC, each.shape) for each in link.collisions if not isinstance(each.shape, Mesh)
    ]
    if collisions:
        return [*collisions]
    radius = disc_radius(link.name, rotors)
    if radius:
        return [(RigidTransform(), Cylinder(radius, 0.004))]
    if link.inertial:
        return [(link.inertial.X_LI, inertia_box(link.inertial))]
    return [(RigidTransform(), Box((_SMALLEST, _SMALLEST, _SMALLEST)))]


def without_missing_meshes(
    visuals: Sequence[Visual], shapes: Sequence[tuple[RigidTransform, Shape]]
) -> tuple[Visual, ...]:
    """Return visuals with those of missing meshes replaced, all of them together, by shapes."""
    kept = [v for v in visuals if not (isinstance(v.shape, Mesh) and v.shape.path is None)]
    drawn = [
        Visual(f"stand_in_{index}", X_LV, shape, _GREY)
        for index, (X_LV, shape) in enumerate(shapes)
    ]
    return (*kept, *drawn)


def disc_radius(link: str, rotors: Sequence[Rotor]) -> float:
    """Return a radius for a rotor's disc that does not touch the next [m], 0 for another link."""
    own = next((rotor for rotor in rotors if rotor.joint and rotor.link == link), None)
    if own is None:
        return 0.0
    gaps = [
        gap
        for rotor in rotors
        if (gap := math.hypot(*np.subtract(rotor.p_BR, own.p_BR)[:2])) > 1e-3
    ]
    return float(np.clip(_DISC_SHARE * min(gaps, default=0.2), _SMALLEST, _LARGEST / 2.0))


def inertia_box(inertial: Inertial) -> Box:
    """Return the even box of a mass and its moments of inertia, within what a drone may measure.

    A side's square is 6/m times the sum of the other two moments less its own: the inverse of
    I_xx = m (y² + z²)/12.
    """
    total = sum(inertial.moments)
    x, y, z = (
        float(
            np.clip(
                math.sqrt(max(0.0, 6.0 / inertial.mass * (total - 2.0 * moment))),
                _SMALLEST,
                _LARGEST,
            )
        )
        for moment in inertial.moments
    )
    return Box((x, y, z))


def with_bumper(link: Link, rotors: Sequence[Rotor]) -> Link:
    """Return a base link with a box to stand on, as wide as the rotors are apart."""
    reach = [max((abs(rotor.p_BR[axis]) for rotor in rotors), default=0.1) for axis in (0, 1)]
    x, y = (float(np.clip(2.0 * half, _SMALLEST, 10.0)) for half in reach)
    bumper = Collision("stand_in", RigidTransform(), Box((x, y, 0.1 * max(x, y))))
    return dataclasses.replace(link, collisions=(*link.collisions, bumper))

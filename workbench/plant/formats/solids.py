"""Mass and inertia of homogeneous solids, and of several combined."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.model import Inertial, inertial_of
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Shape, Sphere


@dataclass(frozen=True)
class Solid:
    """A shape with its mass [kg] and its pose in a link L; a point mass without a shape."""

    mass: float
    X_LS: RigidTransform
    shape: Shape | None


def together(solids: Sequence[Solid], scale: float = 1.0) -> Inertial:
    """Return mass and inertia of solids as one body.

    Args:
        solids: one or more, with positive masses.
        scale: factor on mass and inertia.
    """
    total = sum(solid.mass for solid in solids)
    p_LLcm = sum((solid.mass * solid.X_LS.translation() for solid in solids), np.zeros(3)) / total
    I_L = np.zeros((3, 3))
    for solid in solids:
        if solid.shape:
            R_LS = solid.X_LS.rotation().matrix()
            I_L += R_LS @ np.diag(solid.mass * unit_moments(solid.shape)) @ R_LS.T
        p = solid.X_LS.translation() - p_LLcm
        I_L += solid.mass * (p @ p * np.eye(3) - np.outer(p, p))
    return inertial_of(scale * total, RigidTransform(p_LLcm), scale * I_L)


def volume(shape: Shape) -> float:
    """Return the volume of a solid [m³]."""
    match shape:
        case Box(size=size):
            return math.prod(size)
        case Sphere(radius=r):
            return 4.0 / 3.0 * math.pi * r**3
        case Cylinder(radius=r, length=length):
            return math.pi * r**2 * length
        case Capsule(radius=r, length=length):
            return math.pi * r**2 * (length + 4.0 / 3.0 * r)
        case Ellipsoid(radii=radii):
            return 4.0 / 3.0 * math.pi * math.prod(radii)
    raise AssertionError(f"{shape} has no volume")


def unit_moments(shape: Shape) -> np.ndarray:
    """Return the moments of inertia about the centre for 1 kg [m²].

    Source: any table of moments of inertia. A capsule is a cylinder and two hemispheres, with
    centres of mass 3/8 of the radius from their flat sides.
    """
    match shape:
        case Box(size=(x, y, z)):
            return np.array([y * y + z * z, x * x + z * z, x * x + y * y]) / 12.0
        case Sphere(radius=r):
            return np.full(3, 0.4 * r * r)
        case Cylinder(radius=r, length=length):
            across = r * r / 4.0 + length**2 / 12.0
            return np.array([across, across, r * r / 2.0])
        case Capsule(radius=r, length=length):
            ends = 4.0 / 3.0 * r / (length + 4.0 / 3.0 * r)
            tube = 1.0 - ends
            across = tube * (r * r / 4.0 + length**2 / 12.0)
            across += ends * (0.4 * r * r + length**2 / 4.0 + 3.0 / 8.0 * length * r)
            return np.array([across, across, tube * r * r / 2.0 + ends * 0.4 * r * r])
        case Ellipsoid(radii=(a, b, c)):
            return np.array([b * b + c * c, a * a + c * c, a * a + b * b]) / 5.0
    raise AssertionError(f"{shape} has no moments")

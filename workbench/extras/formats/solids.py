"""Mass and inertia of homogeneous solids, and of several combined."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.model import Inertial, inertial_of
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Sphere


@dataclass(frozen=True)
class HomogeneousSolid:
    """A homogeneous body.

    Attributes:
        mass: in kg.
        X_LS: pose of its principal axes at its centre of mass in a link L.
        moments: its moments of inertia about them for 1 kg (3,) [m²].
    """

    mass: float
    X_LS: RigidTransform
    moments: np.ndarray


def combined_inertial(solids: Sequence[HomogeneousSolid], scale: float = 1.0) -> Inertial:
    """Return mass and inertia of solids as one body.

    Args:
        solids: one or more, with positive masses.
        scale: factor on mass and inertia.
    """
    total = sum(solid.mass for solid in solids)
    p_LLcm = sum((solid.mass * solid.X_LS.translation() for solid in solids), np.zeros(3)) / total
    I_L = np.zeros((3, 3))
    for solid in solids:
        R_LS = solid.X_LS.rotation().matrix()
        I_L += R_LS @ np.diag(solid.mass * solid.moments) @ R_LS.T
        p = solid.X_LS.translation() - p_LLcm
        I_L += solid.mass * (p @ p * np.eye(3) - np.outer(p, p))
    return inertial_of(scale * total, RigidTransform(p_LLcm), scale * I_L)


def volume(shape: GeometryShape) -> float:
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


def unit_moments(shape: GeometryShape) -> np.ndarray:
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


def surface_area(shape: GeometryShape) -> float:
    """Return the surface of a shape [m²]; for an ellipsoid, Thomsen's approximation."""
    match shape:
        case Box(size=(x, y, z)):
            return 2.0 * (x * y + y * z + z * x)
        case Sphere(radius=r):
            return 4.0 * math.pi * r**2
        case Cylinder(radius=r, length=length):
            return 2.0 * math.pi * r * (r + length)
        case Capsule(radius=r, length=length):
            return 2.0 * math.pi * r * (2.0 * r + length)
        case Ellipsoid(radii=(a, b, c)):
            p = 1.6075
            mean = ((a * b) ** p + (b * c) ** p + (c * a) ** p) / 3.0
            return float(4.0 * math.pi * mean ** (1.0 / p))
    raise AssertionError(f"{shape} has no surface")


def shell_moments(shape: GeometryShape) -> np.ndarray:
    """Return the moments of inertia of a thin shell about its centre for 1 kg [m²].

    Source: any table of moments of inertia. The shell of an ellipsoid is the layer between it and
    one with radii that are longer by the same small length, as in MuJoCo (mjCGeom::SetInertia).
    """
    match shape:
        case Box(size=(x, y, z)):
            sides = ((x, y, z), (y, z, x), (z, x, y))
            xx, yy, zz = (_box_shell(*side) for side in sides)
            return np.array([xx, yy, zz])
        case Sphere(radius=r):
            return np.full(3, 2.0 / 3.0 * r * r)
        case Cylinder(radius=r, length=length):
            discs = r / (r + length)
            tube = 1.0 - discs
            across = tube * (r * r / 2.0 + length**2 / 12.0)
            across += discs * (r * r / 4.0 + length**2 / 4.0)
            return np.array([across, across, tube * r * r + discs * r * r / 2.0])
        case Capsule(radius=r, length=length):
            ends = 2.0 * r / (2.0 * r + length)
            tube = 1.0 - ends
            across = tube * (r * r / 2.0 + length**2 / 12.0)
            across += ends * (2.0 / 3.0 * r * r + length**2 / 4.0 + length * r / 2.0)
            return np.array([across, across, tube * r * r + ends * 2.0 / 3.0 * r * r])
        case Ellipsoid(radii=(a, b, c)):
            growth = a * b + b * c + c * a
            pairs = ((b, c), (c, a), (a, b))
            inner = np.array([b * b + c * c, c * c + a * a, a * a + b * b])
            return (inner + [2.0 * a * b * c * (y + z) / growth for y, z in pairs]) / 5.0
    raise AssertionError(f"{shape} has no moments")


def _box_shell(x: float, y: float, z: float) -> float:
    """Return the moment about x of the six sides of a box for 1 kg [m²]."""
    across = y * z * (y * y + z * z) / 12.0  # the sides at the ends of x
    level = x * y * (y * y / 12.0 + z * z / 4.0)
    upright = x * z * (z * z / 12.0 + y * y / 4.0)
    return (across + level + upright) / (x * y + y * z + z * x)

"""Mass and inertia of homogeneous solids and shells."""

import math

import numpy as np
from pydrake.geometry import CalcVolume
from pydrake.math import RigidTransform
from pydrake.multibody.tree import UnitInertia

from workbench.plant.model import Inertial
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Sphere
from workbench.plant.worlds.geometry import drake_shape


def solid_inertial(mass: float, X_LS: RigidTransform, moments: np.ndarray) -> Inertial:
    """Return mass and inertia of a homogeneous body.

    Args:
        mass: in kg.
        X_LS: pose of its principal axes at its centre of mass in a link L.
        moments: its moments of inertia about them for 1 kg (3,) [m²].
    """
    x, y, z = (mass * moments).tolist()
    return Inertial(mass, X_LS, (x, y, z), (0.0, 0.0, 0.0))


def unit_moments(shape: GeometryShape) -> np.ndarray:
    """Return the moments of inertia of a solid about its centre for 1 kg [m²].

    They are zero for one without a volume that is a number, on which Drake ends the process.
    """
    if CalcVolume(drake_shape(shape)) < 1e-300:
        return np.zeros(3)
    match shape:
        case Box(size=(x, y, z)):
            unit = UnitInertia.SolidBox(x, y, z)
        case Sphere(radius=r):
            unit = UnitInertia.SolidSphere(r)
        case Cylinder(radius=r, length=length):
            unit = UnitInertia.SolidCylinder(r, length, (0.0, 0.0, 1.0))
        case Capsule(radius=r, length=length):
            unit = UnitInertia.SolidCapsule(r, length, (0.0, 0.0, 1.0))
        case Ellipsoid(radii=(a, b, c)):
            unit = UnitInertia.SolidEllipsoid(a, b, c)
    return np.asarray(unit.get_moments())


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

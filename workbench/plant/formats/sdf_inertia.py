"""Mass and inertia of a link in SDF."""

import math
from dataclasses import dataclass

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.formats.sdf_node import Node
from workbench.plant.formats.sdf_poses import Poses
from workbench.plant.formats.sdf_shapes import solid
from workbench.plant.formats.sdf_values import flag, number, pose
from workbench.plant.model import Inertial
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Shape, Sphere

_DENSITY = 1000.0
"""Of water [kg/m³]: what SDF assumes."""
_DEFAULT = Inertial(1.0, RigidTransform(), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
"""What SDF, and Gazebo with it, take for a link that says nothing."""


def read_inertial(link: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return mass and inertia of a link.

    Args:
        link: its element.
        poses: to find its collisions, where its inertia is to be made from them.
        remarks: where to note what is not in the file.

    Raises:
        WorkbenchError: naming file and line of what is no number.
    """
    node = link.child("inertial")
    if not node:
        text = "it has no <inertial>; SDF's defaults of 1 kg and 1 kg·m² hold, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return _DEFAULT
    if flag(node, node.attribute("auto")):
        return _from_collisions(link, node, poses, remarks)
    if not node.text_of("mass"):
        text = "its <inertial> gives no mass; SDF's default of 1 kg holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
    inertia = node.child("inertia")
    X_LI = pose(node.child("pose"))
    mass = number(node, "mass", 1.0)
    if not inertia:
        text = "its <inertial> has no <inertia>; SDF's default of 1 kg·m² holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return Inertial(mass, X_LI, _DEFAULT.moments, _DEFAULT.products)
    xx, yy, zz = (number(inertia, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (number(inertia, tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))


@dataclass(frozen=True)
class _Body:
    """Mass [kg], centre of mass in L [m] and inertia about it in L's axes [kg·m²]."""

    mass: float
    p_LBcm: np.ndarray
    I_BBcm_L: np.ndarray


def _from_collisions(link: Node, inertial: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return what SDF's `<inertial auto="true">` asks for; a given mass scales it."""
    bodies = []
    density = number(inertial, "density", _DENSITY)
    for node in link.children("collision"):
        shape = solid(node)
        if shape is None:
            text = "automatic inertia leaves out a collision that is no box, sphere, cylinder, "
            text += "capsule or ellipsoid"
            remarks.add("assumed", link.file, link.title, text)
            continue
        X_LC = poses.X_LF(node, link.full_name)
        mass = number(node, "density", density) * _volume(shape)
        R_LC = X_LC.rotation().matrix()
        I_L = R_LC @ np.diag(mass * _unit_moments(shape)) @ R_LC.T
        bodies.append(_Body(mass, X_LC.translation(), I_L))
    total = sum(body.mass for body in bodies)
    if not bodies or min(body.mass for body in bodies) <= 0.0:
        text = "automatic inertia has no collision with a mass; SDF's defaults of 1 kg and 1 kg·m² "
        remarks.add("assumed", link.file, link.title, text + "hold")
        return _DEFAULT
    p_LLcm = sum((body.mass * body.p_LBcm for body in bodies), np.zeros(3)) / total
    I_L = np.zeros((3, 3))
    for body in bodies:
        p = body.p_LBcm - p_LLcm
        I_L += body.I_BBcm_L + body.mass * (p @ p * np.eye(3) - np.outer(p, p))
    scale = number(inertial, "mass", total) / total
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (scale * I_L).tolist()
    return Inertial(scale * total, RigidTransform(p_LLcm), (xx, yy, zz), (xy, xz, yz))


def _volume(shape: Shape) -> float:
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


def _unit_moments(shape: Shape) -> np.ndarray:
    """Return the moments of inertia about the centre, of 1 kg [m²].

    Source: any table of moments of inertia; a capsule is a cylinder and two half spheres, whose
    centres of mass are 3/8 of the radius from their flat sides.
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

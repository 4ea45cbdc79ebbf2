"""How far below its origin a drone's base link touches first, when it stands upright."""

import numpy as np
from pydrake.math import RigidTransform

from workbench.plant.model import Model
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere


def ground_clearance(model: Model, base_link: str) -> float:
    """Return the depth of the lowest point of all collision shapes below the base's origin [m].

    Args:
        model: whose meshes that touch are convex hulls, as .obj files.
        base_link: whose frame is upright.
    """
    base = model.link(base_link)
    assert base
    X_BM = base.X_ML.inverse()
    depths = [
        _depth(X_BM @ link.X_ML @ collision.X_LC, collision.shape)
        for link in model.links
        for collision in link.collisions
    ]
    return max(depths, default=0.0)


def _depth(X_BC: RigidTransform, shape: Shape) -> float:
    """Return how far a shape C reaches down from the origin of B: by its support function."""
    down_C = -X_BC.rotation().matrix()[2]  # the direction down, in the shape's own frame
    across, along = float(np.hypot(*down_C[:2])), float(abs(down_C[2]))
    match shape:
        case Box(size):
            reach = 0.5 * float(np.abs(down_C) @ size)
        case Sphere(radius):
            reach = radius
        case Cylinder(radius, length):
            reach = radius * across + 0.5 * length * along
        case Capsule(radius, length):
            reach = radius + 0.5 * length * along
        case Ellipsoid(radii):
            reach = float(np.linalg.norm(down_C * radii))
        case Mesh():
            reach = float(np.max(_vertices(shape) @ down_C))
    return reach - float(X_BC.translation()[2])


def _vertices(mesh: Mesh) -> np.ndarray:
    """Return the corners of a converted hull (n, 3) [m]."""
    assert mesh.path
    lines = mesh.path.read_text(encoding="utf-8").splitlines()
    return np.array([line.split()[1:4] for line in lines if line.startswith("v ")], dtype=float)

"""How large an obstacle may be, and how far away."""

import numpy as np
from pydrake.geometry import (
    Box,
    Capsule,
    Convex,
    Cylinder,
    Ellipsoid,
    GeometryInstance,
    Mesh,
    Shape,
    Sphere,
)
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError

FARTHEST = 1e6
"""So large may be sides of obstacles and coordinates of their places [m]."""


def refuse_endless(where: str, name: str, X_WO: RigidTransform, geometry: GeometryInstance) -> None:
    """Refuse an obstacle's geometry that has no size or no place.

    Args:
        where: "file:line: ", for the beginning of the message.
        name: of the obstacle.
        X_WO: where it stands.
        geometry: one of its own, posed in it.

    Raises:
        WorkbenchError: if a number is not finite or beyond `FARTHEST`, or a side not positive.
    """
    parts = (X_WO, geometry.pose())
    if not all(_is_place(each) for each in parts):
        raise WorkbenchError(
            f"{where}'{name}' stands nowhere, or more than {FARTHEST:g} m away: give it a "
            "pose of finite numbers"
        )
    sides = np.array(_sides(geometry.shape()))
    if not (np.isfinite(sides) & (sides > 0.0) & (sides <= FARTHEST)).all():
        numbers = ", ".join(f"{side:g}" for side in sides)
        raise WorkbenchError(
            f"{where}'{name}' has a {type(geometry.shape()).__name__.lower()} with {numbers}: "
            f"give it numbers above 0 and up to {FARTHEST:g}"
        )


def _is_place(X: RigidTransform) -> bool:
    matrix = X.GetAsMatrix34()
    return bool((np.abs(matrix) <= FARTHEST).all())  # false for what is no number


def _sides(shape: Shape) -> tuple[float, ...]:
    """Return the sides and radii of a shape [m], the scale of a mesh, whichever way it mirrors."""
    match shape:
        case Box():
            return tuple(shape.size())
        case Sphere():
            return (shape.radius(),)
        case Cylinder() | Capsule():
            return (shape.radius(), shape.length())
        case Ellipsoid():
            return (shape.a(), shape.b(), shape.c())
        case Mesh() | Convex():
            return tuple(np.abs(shape.scale3()))
        case _:
            return ()

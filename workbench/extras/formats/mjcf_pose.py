"""Poses in MJCF."""

import math

import numpy as np
from pydrake.common.eigen_geometry import AngleAxis, Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_compiler import Compiler
from workbench.extras.formats.mjcf_elements import attribute_fault
from workbench.plant.formats.values import attribute_numbers, attribute_triple
from workbench.plant.formats.xml import Element, element_location

ORIENTATION_SIZES = {"quat": 4, "axisangle": 4, "xyaxes": 6, "zaxis": 3, "euler": 3}
"""Attributes of an orientation, and how many numbers each has."""


def pose_of(element: Element, compiler: Compiler) -> RigidTransform:
    """Return the pose of an element in the frame of its parent.

    Raises:
        WorkbenchError: for an invalid position or orientation.
    """
    position = attribute_triple(element, "pos", "0 0 0")
    return RigidTransform(_orientation(element, compiler), np.array(position))


def _orientation(element: Element, compiler: Compiler) -> RotationMatrix:
    given = [name for name in ORIENTATION_SIZES if name in element.attrib]
    if not given:
        return RotationMatrix()
    if len(given) > 1:
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag}> has {' and '.join(given)}: leave one"
        )
    (name,) = given
    values = np.array(attribute_numbers(element, name, ""))
    if len(values) != ORIENTATION_SIZES[name]:
        raise attribute_fault(element, name, f"give it {ORIENTATION_SIZES[name]} numbers")
    turn = 1.0 if compiler.radians else math.pi / 180.0
    match name:
        case "quat":
            return RotationMatrix(Quaternion(_unit_vector(element, name, values)))
        case "axisangle":
            axis = _unit_vector(element, name, values[:3])
            return RotationMatrix(AngleAxis(turn * values[3], axis))
        case "xyaxes":
            x = _unit_vector(element, name, values[:3])
            y = _unit_vector(element, name, values[3:] - x * (x @ values[3:]))
            return RotationMatrix(np.column_stack([x, y, np.cross(x, y)]))
        case "zaxis":
            z = _unit_vector(element, name, values)
            return shortest_rotation_to(z)
    return rotation_from_euler(turn * values, compiler.eulerseq)


def rotation_from_euler(angles: np.ndarray, sequence: str) -> RotationMatrix:
    """Return the orientation for Euler angles, about moved axes or, in capitals, fixed ones."""
    turned = RotationMatrix()
    for angle, axis in zip(angles, sequence, strict=True):
        unit = np.eye(3)["xyz".index(axis.lower())]
        one = RotationMatrix(AngleAxis(float(angle), unit))
        turned = one @ turned if axis.isupper() else turned @ one
    return turned


def shortest_rotation_to(z: np.ndarray) -> RotationMatrix:
    """Return the shortest rotation from z to a unit vector."""
    across = np.cross([0.0, 0.0, 1.0], z)
    length = float(np.linalg.norm(across))
    axis = across / length if length > 1e-9 else np.array([1.0, 0.0, 0.0])
    return RotationMatrix(AngleAxis(math.atan2(length, float(z[2])), axis))


def _unit_vector(element: Element, name: str, values: np.ndarray) -> np.ndarray:
    length = float(np.linalg.norm(values))
    if length < 1e-9:
        raise attribute_fault(element, name, "give it a direction")
    return np.asarray(values / length)

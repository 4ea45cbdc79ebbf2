"""A geom of MJCF: its mass, its solid, its ends and its colour."""

import numpy as np
from pydrake.geometry import CalcVolume
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.mjcf_elements import is_true_attribute
from workbench.extras.formats.mjcf_pose import shortest_rotation_to
from workbench.extras.formats.solids import (
    shell_moments,
    solid_inertial,
    surface_area,
    unit_moments,
)
from workbench.plant.formats.colours import Colour
from workbench.plant.formats.values import (
    attribute_number,
    attribute_numbers,
    attribute_triple,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import Inertial
from workbench.plant.shapes import GeometryShape
from workbench.plant.worlds.geometry import drake_shape

_TWO_POINT_GEOMS = ("capsule", "cylinder", "box", "ellipsoid")
MIN_GEOM_MASS_KG = 1e-14
"""Mass of a geom that does not count [kg], as in MuJoCo."""


def has_own_mass(element: Element) -> bool:
    """Return whether a geom has a mass by its own words."""
    mass = attribute_number(element, "mass") if "mass" in element.attrib else None
    density = attribute_number(element, "density", "1000")
    if (mass is not None and mass < 0.0) or density < 0.0:
        raise mjcf_error(element, "give it a mass or density of 0 or more")
    return density > 0.0 if mass is None else mass > 0.0


def geom_mass(element: Element, size: float) -> float:
    """Return the mass of a geom with a volume [m³], or a surface [m²] for a shell."""
    if "mass" in element.attrib:
        return attribute_number(element, "mass")
    return attribute_number(element, "density", "1000") * size


def geom_solid(element: Element, X_LG: RigidTransform, shape: GeometryShape) -> Inertial | None:
    """Return a geom as a solid, or as a shell."""
    shell = is_true_attribute(element, "shellinertia", "false")
    mass = geom_mass(element, surface_area(shape) if shell else CalcVolume(drake_shape(shape)))
    if mass <= MIN_GEOM_MASS_KG:
        return None
    return solid_inertial(mass, X_LG, shell_moments(shape) if shell else unit_moments(shape))


def pose_from_two_points(element: Element, kind: str) -> tuple[RigidTransform, float]:
    """Return pose and length of what is given by two points; its z axis is from the second."""
    ends = attribute_numbers(element, "fromto", "")
    if kind not in _TWO_POINT_GEOMS:
        raise mjcf_error(
            element, f"fromto is for a {', a '.join(_TWO_POINT_GEOMS)}: give it a type"
        )
    if any(attribute_triple(element, "pos", "0 0 0")):
        raise mjcf_error(element, "it has pos and fromto: leave one")
    if len(ends) != 6 or ends[:3] == ends[3:]:
        raise mjcf_error(element, "fromto is two points apart: give it six numbers")
    way = np.array(ends[:3]) - np.array(ends[3:])
    length = float(np.linalg.norm(way))
    middle = (np.array(ends[:3]) + np.array(ends[3:])) / 2.0
    return RigidTransform(shortest_rotation_to(way / length), middle), length


def mjcf_rgba(element: Element) -> Colour:
    """Return the colour of an element."""
    values = attribute_numbers(element, "rgba", "")
    if len(values) != 4:
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag} "
            f"rgba='{shortened_text(element.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)


def mjcf_error(element: Element, text: str) -> WorkbenchError:
    """Return an error that names an element and where it is."""
    return WorkbenchError(f"{element_location(element)}: <{element.tag}>: {text}")

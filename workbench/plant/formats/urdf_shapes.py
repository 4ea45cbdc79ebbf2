"""Shapes and colours of links in URDF."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.colours import GAZEBO_COLOURS, Colour
from workbench.plant.formats.values import (
    attribute_numbers,
    attribute_triple,
    origin,
    positive_attribute,
    shortened_text,
)
from workbench.plant.formats.xml import Element, element_location
from workbench.plant.model import LinkShape
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Mesh, Sphere


def read_colours(robot: Element) -> dict[str, Colour]:
    """Return colours by name: materials of the robot, and `link NAME` for Gazebo's of a link."""
    colours = {
        material.get("name", ""): colour
        for material in robot.iter("material")
        if isinstance(material, Element) and (colour := _material_rgba(material)) is not None
    }
    for block in robot.findall("gazebo"):
        name = (block.findtext("material") or "").strip()
        if name in GAZEBO_COLOURS:
            colours[f"link {block.get('reference')}"] = GAZEBO_COLOURS[name]
    return colours


def read_shapes(
    path: Path,
    link: Element,
    tag: str,
    colours: Mapping[str, Colour],
    finder: PackageFinder,
    remarks: Remarks,
) -> Iterator[LinkShape]:
    """Yield the shapes of a link for drawing (tag `visual`) or contact (`collision`)."""
    name = link.get("name", "")
    for index, element in enumerate(link.findall(tag)):
        assert isinstance(element, Element)
        what = f"{tag} {index + 1} of link '{shortened_text(name)}'"
        shape = _urdf_shape(path, element, what, finder, remarks)
        if shape is None:
            continue
        X_LS, rgba = origin(element), None
        if tag == "visual":
            rgba = _urdf_colour(element, colours) or colours.get(f"link {name}")
        yield LinkShape(element.get("name") or f"{tag}_{index}", X_LS, shape, rgba)


def _urdf_shape(
    path: Path, parent: Element, what: str, finder: PackageFinder, remarks: Remarks
) -> GeometryShape | None:
    """Return the shape of a visual or collision; None, with a remark, without a usable one."""
    element = parent.find("geometry/*")
    if not isinstance(element, Element):
        remarks.add("ignored", path, what, "it has no geometry")
        return None
    match element.tag:
        case "box":
            size = attribute_triple(element, "size", "")
            return Box(_all_positive(element, "size", size))
        case "sphere":
            return Sphere(positive_attribute(element, "radius"))
        case "cylinder":
            return Cylinder(
                positive_attribute(element, "radius"), positive_attribute(element, "length")
            )
        case "capsule":
            return Capsule(
                positive_attribute(element, "radius"), positive_attribute(element, "length")
            )
        case "ellipsoid":
            radii = attribute_triple(element, "radii", "")
            return Ellipsoid(_all_positive(element, "radii", radii))
        case "mesh":
            return _mesh(path, element, what, finder)
    remarks.add("ignored", path, what, f"a <{shortened_text(element.tag)}> is not a known shape")
    return None


def _mesh(path: Path, element: Element, what: str, finder: PackageFinder) -> Mesh:
    """Return a mesh, found or not."""
    uri = element.get("filename", "") or element.get("uri", "")
    scale = attribute_numbers(element, "scale", "1 1 1")
    if len(scale) == 1:  # not in the specification, but accepted by all parsers of ROS
        scale *= 3
    if len(scale) != 3 or 0.0 in scale:
        raise WorkbenchError(
            f"{element_location(element)}: {what} has a mesh with the scale "
            f"'{shortened_text(element.get('scale', ''))}': give it three numbers, none 0"
        )
    return Mesh(uri, finder.resolve(uri, path) if uri else None, (scale[0], scale[1], scale[2]))


def _all_positive(
    element: Element, attribute: str, values: tuple[float, float, float]
) -> tuple[float, float, float]:
    if min(values) <= 0.0:
        raise WorkbenchError(
            f"{element_location(element)}: <{element.tag} {attribute}='{element.get(attribute)}'>: "
            "give it positive numbers"
        )
    return values


def _urdf_colour(visual: Element, colours: Mapping[str, Colour]) -> Colour | None:
    """Return the colour of a visual, or that of its named material, or None."""
    material = visual.find("material")
    if not isinstance(material, Element):
        return None
    return _material_rgba(material) or colours.get(material.get("name", ""))


def _material_rgba(material: Element) -> Colour | None:
    """Return the colour in a material, or None."""
    colour = material.find("color")
    if not isinstance(colour, Element):
        return None
    values = attribute_numbers(colour, "rgba", "")
    if len(values) == 3:
        values = (*values, 1.0)
    if len(values) != 4:
        raise WorkbenchError(
            f"{element_location(colour)}: <color rgba='{shortened_text(colour.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)

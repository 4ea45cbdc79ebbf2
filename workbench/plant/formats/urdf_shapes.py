"""Visuals, collisions and colours of a URDF."""

from collections.abc import Iterator, Mapping
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.colours import GAZEBO_COLOURS, Colour
from workbench.plant.formats.values import numbers, origin, positive, shortened, triple
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import Collision, Visual
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere


def read_colours(path: Path, robot: Element) -> dict[str, Colour]:
    """Return colours by name: the robot's materials, and `link NAME` for Gazebo's of a link."""
    colours = {
        material.get("name", ""): colour
        for material in robot.iter("material")
        if isinstance(material, Element) and (colour := _rgba(path, material)) is not None
    }
    for block in robot.findall("gazebo"):
        name = (block.findtext("material") or "").strip()
        if name in GAZEBO_COLOURS:
            colours[f"link {block.get('reference')}"] = GAZEBO_COLOURS[name]
    return colours


def read_visuals(
    path: Path,
    link: Element,
    name: str,
    colours: Mapping[str, Colour],
    finder: PackageFinder,
    remarks: Remarks,
) -> tuple[Visual, ...]:
    """Return the drawn shapes of a link."""
    return tuple(
        Visual(
            name=label,
            X_LV=origin(path, element),
            shape=shape,
            rgba=_colour(path, element, colours) or colours.get(f"link {name}"),
        )
        for label, element, shape in _shapes(path, link, "visual", name, finder, remarks)
    )


def read_collisions(
    path: Path, link: Element, name: str, finder: PackageFinder, remarks: Remarks
) -> tuple[Collision, ...]:
    """Return the shapes of a link that touch."""
    return tuple(
        Collision(label, origin(path, element), shape)
        for label, element, shape in _shapes(path, link, "collision", name, finder, remarks)
    )


def _shapes(
    path: Path, link: Element, tag: str, name: str, finder: PackageFinder, remarks: Remarks
) -> Iterator[tuple[str, Element, Shape]]:
    """Yield name, element and shape of a link's visuals or collisions that have a shape."""
    for index, element in enumerate(link.findall(tag)):
        assert isinstance(element, Element)
        what = f"{tag} {index + 1} of link '{shortened(name)}'"
        shape = _shape(path, element, what, finder, remarks)
        if shape is not None:
            yield element.get("name") or f"{tag}_{index}", element, shape


def _shape(
    path: Path, parent: Element, what: str, finder: PackageFinder, remarks: Remarks
) -> Shape | None:
    """Return the shape of a visual or collision; None, with a remark, where there is none."""
    element = parent.find("geometry/*")
    if not isinstance(element, Element):
        remarks.add("ignored", path, what, "it has no geometry")
        return None
    match element.tag:
        case "box":
            size = triple(path, element, "size", "")
            return Box(_all_positive(path, element, "size", size))
        case "sphere":
            return Sphere(positive(path, element, "radius"))
        case "cylinder":
            return Cylinder(positive(path, element, "radius"), positive(path, element, "length"))
        case "capsule":
            return Capsule(positive(path, element, "radius"), positive(path, element, "length"))
        case "ellipsoid":
            radii = triple(path, element, "radii", "")
            return Ellipsoid(_all_positive(path, element, "radii", radii))
        case "mesh":
            return _mesh(path, element, what, finder)
    remarks.add(
        "ignored", path, what, f"a <{shortened(element.tag)}> is no shape that is known here"
    )
    return None


def _mesh(path: Path, element: Element, what: str, finder: PackageFinder) -> Mesh:
    """Return a mesh, found or not."""
    uri = element.get("filename", "") or element.get("uri", "")
    scale = numbers(path, element, "scale", "1 1 1")
    if len(scale) == 1:  # not in the specification, but all parsers of ROS take it
        scale *= 3
    if len(scale) != 3 or 0.0 in scale:
        raise WorkbenchError(
            f"{place(path, element)}: {what} has a mesh with the scale "
            f"'{shortened(element.get('scale', ''))}': give it three numbers, none 0"
        )
    return Mesh(uri, finder.resolve(uri, path) if uri else None, (scale[0], scale[1], scale[2]))


def _all_positive(
    path: Path, element: Element, attribute: str, values: tuple[float, float, float]
) -> tuple[float, float, float]:
    if min(values) <= 0.0:
        raise WorkbenchError(
            f"{place(path, element)}: <{element.tag} {attribute}='{element.get(attribute)}'>: "
            "give it positive numbers"
        )
    return values


def _colour(path: Path, visual: Element, colours: Mapping[str, Colour]) -> Colour | None:
    """Return a visual's own colour, or the one that its material's name stands for."""
    material = visual.find("material")
    if not isinstance(material, Element):
        return None
    return _rgba(path, material) or colours.get(material.get("name", ""))


def _rgba(path: Path, material: Element) -> Colour | None:
    """Return the colour that a material gives, if it gives one."""
    colour = material.find("color")
    if not isinstance(colour, Element):
        return None
    values = numbers(path, colour, "rgba", "")
    if len(values) == 3:
        values = (*values, 1.0)
    if len(values) != 4:
        raise WorkbenchError(
            f"{place(path, colour)}: <color rgba='{shortened(colour.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)

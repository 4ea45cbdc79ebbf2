"""Visuals and collisions of a link in SDF."""

from collections.abc import Iterator

import numpy as np
from pydrake.common.eigen_geometry import Quaternion
from pydrake.math import RigidTransform, RotationMatrix

from workbench.extras.formats.sdf_node import Node, sdf_number, sdf_triple
from workbench.extras.formats.sdf_poses import Poses
from workbench.plant.formats.colours import GAZEBO_COLOURS, Colour
from workbench.plant.formats.sdf_pose import sdf_flag, sdf_numbers
from workbench.plant.formats.values import shortened_text
from workbench.plant.model import LinkShape
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, GeometryShape, Mesh, Sphere

_PLANE_THICKNESS_M = 0.001
_UNCOLOURED_RGBA: Colour = (0.7, 0.7, 0.7, 1.0)
"""Approximate colour of a shape without a material in Gazebo."""


_PlacedShape = tuple[GeometryShape, RigidTransform]
"""A shape S, and its pose in the frame F of its visual or collision."""


def link_shapes(
    link: Node, tag: str, poses: Poses, finder: PackageFinder, remarks: Remarks
) -> Iterator[LinkShape]:
    """Yield the shapes of a link for drawing (tag `visual`) or contact (`collision`).

    Args:
        link: its element.
        tag: of the shapes.
        poses: of the model.
        finder: of meshes.
        remarks: receives remarks on what is left out, or taken for something else.
    """
    for index, node in enumerate(link.children(tag)):
        title = _shape_title(node, index, link)
        geometry = node.child("geometry")
        if tag == "collision" and geometry and geometry.child("plane"):
            text = "an endless plane cannot be part of a drone; left out"
            remarks.add("ignored", node.file, title, text)
            continue
        placed = _placed_shape(node, title, finder, remarks)
        if placed:
            shape, X_FS = placed
            yield LinkShape(
                name=node.attribute("name") or f"{tag}_{index}",
                X_LS=poses.X_LF(node, link.full_name) @ X_FS,
                shape=shape,
                rgba=_sdf_colour(node) if tag == "visual" else None,
            )


def _placed_shape(
    part: Node, title: str, finder: PackageFinder, remarks: Remarks
) -> _PlacedShape | None:
    """Return the shape of a visual or collision; None, with a remark, without a usable one."""
    shape = part_solid(part)
    if shape:
        return (shape, RigidTransform())
    geometry = part.child("geometry")
    tags = [node.element.tag for node in geometry.children()] if geometry else []
    for node in geometry.children("mesh", "cone", "plane") if geometry else []:
        match node.element.tag:
            case "mesh":
                return (_mesh(node, finder), RigidTransform())
            case "cone":
                text = "a cone is taken as the cylinder around it"
                remarks.add("repaired", part.file, title, text)
                return (_cylinder(node), RigidTransform())
            case "plane":
                return _plane(node)
    what = f"a <{shortened_text(tags[0])}> is not a supported shape" if tags else "no geometry"
    remarks.add("ignored", part.file, title, f"{what}; left out")
    return None


def _mesh(node: Node, finder: PackageFinder) -> Mesh:
    """Return a mesh, found or not."""
    uri = node.text_of("uri")
    if not uri:
        raise node.fault("<mesh> without a <uri>: say which file it is")
    scale = sdf_triple(node, "scale", (1.0, 1.0, 1.0))
    if 0.0 in scale:
        raise node.fault("<scale> of a <mesh> has a 0: give it three numbers, none 0")
    submesh = node.child("submesh")
    center = submesh.child("center") if submesh else None
    return Mesh(
        uri=uri,
        path=finder.resolve(uri, node.file),
        scale=scale,
        submesh=submesh.text_of("name") if submesh else "",
        center=sdf_flag(center.element, center.text) if center else False,
    )


def part_solid(part: Node) -> GeometryShape | None:
    """Return the shape of a visual or collision if it has a known volume, or None.

    Raises:
        WorkbenchError: naming file and line, for a size that is not positive.
    """
    geometry = part.child("geometry")
    solids = ("box", "sphere", "cylinder", "capsule", "ellipsoid")
    for node in geometry.children(*solids) if geometry else []:
        match node.element.tag:
            case "box":
                return Box(_box_sides(node, "size"))
            case "sphere":
                return Sphere(_positive_number(node, "radius", 1.0))
            case "cylinder":
                return _cylinder(node)
            case "capsule":
                return Capsule(
                    _positive_number(node, "radius", 0.5), _positive_number(node, "length", 1.0)
                )
            case "ellipsoid":
                return Ellipsoid(_box_sides(node, "radii"))
    return None


def _cylinder(node: Node) -> Cylinder:
    return Cylinder(_positive_number(node, "radius", 1.0), _positive_number(node, "length", 1.0))


def _plane(node: Node) -> _PlacedShape:
    """Return a thin box that looks like a plane."""
    normal = np.array(sdf_triple(node, "normal", (0.0, 0.0, 1.0)))
    size = node.child("size")
    x, y = sdf_numbers(size.element, 2) if size and size.text else (1.0, 1.0)
    length = float(np.linalg.norm(normal))
    if length < 1e-9 or min(x, y) <= 0.0:
        raise node.fault("<plane>: give it a normal and two positive sizes")
    nx, ny, nz = normal / length
    # The shortest turn from z to the normal; from z to -z, half a turn about x.
    turn = (
        np.array([1.0 + nz, -ny, nx, 0.0]) if nz > -1.0 + 1e-9 else np.array([0.0, 1.0, 0.0, 0.0])
    )
    R_FS = RotationMatrix(Quaternion(turn / np.linalg.norm(turn)))
    return (Box((x, y, _PLANE_THICKNESS_M)), RigidTransform(R_FS, np.zeros(3)))


def _positive_number(parent: Node, tag: str, default: float) -> float:
    found = sdf_number(parent, tag, default)
    if found <= 0.0:
        raise parent.fault(
            f"<{tag}>{found:g}</{tag}> of <{parent.element.tag}>: give it a positive number"
        )
    return found


def _box_sides(parent: Node, tag: str) -> tuple[float, float, float]:
    found = sdf_triple(parent, tag, (1.0, 1.0, 1.0))
    if min(found) <= 0.0:
        raise parent.fault(f"<{tag}> of <{parent.element.tag}>: give it three positive numbers")
    return found


def _sdf_colour(visual: Node) -> Colour | None:
    """Return the colour of the material of a visual, or None."""
    opacity = 1.0 - min(1.0, max(0.0, sdf_number(visual, "transparency", 0.0)))
    material = visual.child("material")
    colour = _material_colour(material) if material else None
    if opacity == 1.0:
        return colour
    red, green, blue, alpha = colour or _UNCOLOURED_RGBA
    return (red, green, blue, alpha * opacity)


def _material_colour(material: Node) -> Colour | None:
    for tag in ("diffuse", "ambient"):
        node = material.child(tag)
        if node and node.text:
            clamped = [min(1.0, max(0.0, value)) for value in sdf_numbers(node.element, 3, 4)]
            red, green, blue, alpha = (*clamped, 1.0)[:4]
            return (red, green, blue, alpha)
    script = material.child("script")
    return GAZEBO_COLOURS.get(script.text_of("name")) if script else None


def _shape_title(node: Node, index: int, link: Node) -> str:
    name = shortened_text(node.attribute("name")) or str(index + 1)
    return f"{node.element.tag} '{name}' of link '{link.full_name}'"

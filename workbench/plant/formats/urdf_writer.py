"""Write a model as URDF that Drake takes as it is: plain shapes, meshes by path, one tree."""

from collections.abc import Iterable, Sequence
from pathlib import Path
from xml.etree import ElementTree as ET

from pydrake.math import RigidTransform, RollPitchYaw

from workbench.plant.model import Inertial, Joint, Link, LinkShape, Model
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere


def write_urdf(model: Model, turning: Iterable[str] = ()) -> ET.Element:
    """Return a model as the `<robot>` element of a URDF.

    Args:
        model: one tree of links; its meshes are files that Drake reads.
        turning: names of joints to write as continuous; all others are fixed.
    """
    names = set(turning)
    robot = ET.Element("robot", name=model.name)
    # Where a joint turns about another point than its link's origin, the link's frame moves there.
    frames = {
        link.name: joint.X_MJ
        if (joint := model.joint_of(link.name)) and joint.name in names
        else link.X_ML
        for link in model.links
    }
    for link in model.links:
        _add_link(robot, link, frames[link.name].inverse() @ link.X_ML)
    for joint in model.joints:
        X_PC = frames[joint.parent].inverse() @ frames[joint.child]
        _add_joint(robot, joint, X_PC, "continuous" if joint.name in names else "fixed")
    return robot


def _add_link(robot: ET.Element, link: Link, X_FL: RigidTransform) -> None:
    """Add a link whose frame F is not that of the description."""
    element = ET.SubElement(robot, "link", name=link.name)
    if link.inertial:
        _add_inertial(element, link.inertial, X_FL)
    for tag, shapes in (("visual", link.visuals), ("collision", link.collisions)):
        for name, shape in zip(_different(shapes), shapes, strict=True):
            _add_shape(element, tag, name, shape, X_FL)


def _add_inertial(link: ET.Element, inertial: Inertial, X_FL: RigidTransform) -> None:
    element = ET.SubElement(link, "inertial")
    _add_origin(element, X_FL @ inertial.X_LI)
    ET.SubElement(element, "mass", value=repr(inertial.mass))
    names = ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    values = (*inertial.moments, *inertial.products)
    ET.SubElement(element, "inertia", dict(zip(names, map(repr, values), strict=True)))


def _different(shapes: Sequence[LinkShape]) -> list[str]:
    """Return names of shapes, with numbers behind if one came twice; Drake wants each once."""
    names = [shape.name for shape in shapes]
    if len(set(names)) == len(names):
        return names
    return [f"{name}_{index}" for index, name in enumerate(names)]


def _add_shape(
    link: ET.Element, tag: str, name: str, shape: LinkShape, X_FL: RigidTransform
) -> None:
    element = ET.SubElement(link, tag, name=name)
    _add_origin(element, X_FL @ shape.X_LS)
    geometry = ET.SubElement(element, "geometry")
    geometry.append(_geometry(shape.shape))
    if shape.rgba:
        name = "rgba_" + "_".join(f"{round(255 * value):02x}" for value in shape.rgba)
        material = ET.SubElement(element, "material", name=name)
        ET.SubElement(material, "color", rgba=_text(shape.rgba))
    if tag == "collision" and isinstance(shape.shape, Mesh):
        ET.SubElement(geometry[0], "drake:declare_convex")


def _geometry(shape: Shape) -> ET.Element:
    match shape:
        case Box(size):
            return ET.Element("box", size=_text(size))
        case Sphere(radius):
            return ET.Element("sphere", radius=repr(radius))
        case Cylinder(radius, length):
            return ET.Element("cylinder", radius=repr(radius), length=repr(length))
        case Capsule(radius, length):
            return ET.Element("capsule", radius=repr(radius), length=repr(length))
        case Ellipsoid((a, b, c)):
            return ET.Element("drake:ellipsoid", a=repr(a), b=repr(b), c=repr(c))
        case Mesh(uri=uri, path=path):
            return ET.Element("mesh", filename=_uri(path) if path else uri)


def _add_joint(robot: ET.Element, joint: Joint, X_PC: RigidTransform, kind: str) -> None:
    element = ET.SubElement(robot, "joint", name=joint.name, type=kind)
    _add_origin(element, X_PC)
    ET.SubElement(element, "parent", link=joint.parent)
    ET.SubElement(element, "child", link=joint.child)
    if kind != "fixed":
        ET.SubElement(element, "axis", xyz=_text(joint.axis_J))


def _add_origin(element: ET.Element, X: RigidTransform) -> None:
    rpy = RollPitchYaw(X.rotation()).vector()
    ET.SubElement(element, "origin", xyz=_text(X.translation()), rpy=_text(rpy))


def _uri(path: Path) -> str:
    """Return an absolute path as file URI, a relative one as it is."""
    return path.as_uri() if path.is_absolute() else path.as_posix()


def _text(values: Iterable[float]) -> str:
    return " ".join(repr(float(value)) for value in values)

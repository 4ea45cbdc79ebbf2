"""Read URDF, with Gazebo's extensions in `<gazebo>` blocks."""

from collections import Counter
from collections.abc import Iterator, Mapping
from difflib import get_close_matches
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.colours import GAZEBO_COLOURS, Colour
from workbench.plant.formats.sdf_node import FRAME_SEMANTICS, Node, pose
from workbench.plant.formats.values import (
    listed,
    number,
    numbers,
    origin,
    positive,
    shortened,
    triple,
)
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import (
    DeclaredSensor,
    Inertial,
    Joint,
    Link,
    LinkShape,
    Model,
    refuse_too_many,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.shapes import Box, Capsule, Cylinder, Ellipsoid, Mesh, Shape, Sphere

_CHILDREN = {
    "robot": "link joint material gazebo transmission ros2_control properties",
    "link": "inertial visual collision contact self_collision_checking verbose",
    "joint": "origin parent child axis limit dynamics calibration mimic safety_controller",
    "inertial": "origin mass inertia",
    "visual": "origin geometry material",
    "collision": "origin geometry verbose contact_coefficients",
    "material": "color texture",
}
_ATTRIBUTES = {
    "origin": "xyz rpy",
    "axis": "xyz",
    "mass": "value",
    "inertia": "ixx iyy izz ixy ixz iyz",
    "mesh": "filename uri scale",
    "box": "size",
    "sphere": "radius",
    "cylinder": "radius length",
    "parent": "link",
    "child": "link",
}
_IN_GAZEBO = ["material", "sensor", "plugin", "preserveFixedJoint", "disableFixedJointLumping"]
"""Children of `<gazebo>` that are used, or always hold here; others concern only Gazebo."""
_CONTROL = ("transmission", "ros2_control")
_MOST = 50
"""Largest number of remarks on unknown parts, and of those on unused ones."""


def read_colours(robot: Element) -> dict[str, Colour]:
    """Return colours by name: materials of the robot, and `link NAME` for Gazebo's of a link."""
    colours = {
        material.get("name", ""): colour
        for material in robot.iter("material")
        if isinstance(material, Element) and (colour := _rgba(material)) is not None
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
        what = f"{tag} {index + 1} of link '{shortened(name)}'"
        shape = _shape(path, element, what, finder, remarks)
        if shape is None:
            continue
        X_LS, rgba = origin(element), None
        if tag == "visual":
            rgba = _colour(element, colours) or colours.get(f"link {name}")
        yield LinkShape(element.get("name") or f"{tag}_{index}", X_LS, shape, rgba)


def _shape(
    path: Path, parent: Element, what: str, finder: PackageFinder, remarks: Remarks
) -> Shape | None:
    """Return the shape of a visual or collision; None, with a remark, without a usable one."""
    element = parent.find("geometry/*")
    if not isinstance(element, Element):
        remarks.add("ignored", path, what, "it has no geometry")
        return None
    match element.tag:
        case "box":
            size = triple(element, "size", "")
            return Box(_all_positive(element, "size", size))
        case "sphere":
            return Sphere(positive(element, "radius"))
        case "cylinder":
            return Cylinder(positive(element, "radius"), positive(element, "length"))
        case "capsule":
            return Capsule(positive(element, "radius"), positive(element, "length"))
        case "ellipsoid":
            radii = triple(element, "radii", "")
            return Ellipsoid(_all_positive(element, "radii", radii))
        case "mesh":
            return _mesh(path, element, what, finder)
    remarks.add("ignored", path, what, f"a <{shortened(element.tag)}> is not a known shape")
    return None


def _mesh(path: Path, element: Element, what: str, finder: PackageFinder) -> Mesh:
    """Return a mesh, found or not."""
    uri = element.get("filename", "") or element.get("uri", "")
    scale = numbers(element, "scale", "1 1 1")
    if len(scale) == 1:  # not in the specification, but accepted by all parsers of ROS
        scale *= 3
    if len(scale) != 3 or 0.0 in scale:
        raise WorkbenchError(
            f"{place(element)}: {what} has a mesh with the scale "
            f"'{shortened(element.get('scale', ''))}': give it three numbers, none 0"
        )
    return Mesh(uri, finder.resolve(uri, path) if uri else None, (scale[0], scale[1], scale[2]))


def _all_positive(
    element: Element, attribute: str, values: tuple[float, float, float]
) -> tuple[float, float, float]:
    if min(values) <= 0.0:
        raise WorkbenchError(
            f"{place(element)}: <{element.tag} {attribute}='{element.get(attribute)}'>: "
            "give it positive numbers"
        )
    return values


def _colour(visual: Element, colours: Mapping[str, Colour]) -> Colour | None:
    """Return the colour of a visual, or that of its named material, or None."""
    material = visual.find("material")
    if not isinstance(material, Element):
        return None
    return _rgba(material) or colours.get(material.get("name", ""))


def _rgba(material: Element) -> Colour | None:
    """Return the colour in a material, or None."""
    colour = material.find("color")
    if not isinstance(colour, Element):
        return None
    values = numbers(colour, "rgba", "")
    if len(values) == 3:
        values = (*values, 1.0)
    if len(values) != 4:
        raise WorkbenchError(
            f"{place(colour)}: <color rgba='{shortened(colour.get('rgba', ''))}'>: "
            "give it four numbers"
        )
    r, g, b, a = (min(1.0, max(0.0, value)) for value in values)
    return (r, g, b, a)


def note_unknown(path: Path, robot: Element, remarks: Remarks) -> None:
    """Add remarks on elements and attributes unknown in URDF, one for each place and name.

    Elements of URDF, Gazebo and ROS that are not used here get remarks, too. The contents of blocks
    of Gazebo and ROS, and names with a prefix, are skipped.
    """
    found: Counter[tuple[str, str]] = Counter()
    _count(robot, "the robot", found)
    for (what, owner), times in list(found.items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"not known in URDF{owner}; left out{often}")
    for (what, why), times in list(_unused(robot).items())[:_MOST]:
        often = "" if times == 1 else f" ({times} times)"
        remarks.add("ignored", path, what, f"{why}; not used{often}")


def _unused(robot: Element) -> Counter[tuple[str, str]]:
    """Return the unused elements of URDF, Gazebo and ROS, with reason and number."""
    found: Counter[tuple[str, str]] = Counter()
    for child in robot:
        if not isinstance(child, Element):
            continue
        if child.tag in _CONTROL:
            found[f"element <{child.tag}>", "ROS's, of control"] += 1
        if child.tag == "gazebo":
            tags = (part.tag for part in child if isinstance(part, Element))
            for tag in tags:
                if tag not in _IN_GAZEBO:
                    found[f"element <{shortened(tag)}> of <gazebo>", "Gazebo's"] += 1
        dynamics = child.find("dynamics") if child.tag == "joint" else None
        if dynamics is not None and any(value.strip("0.") for value in dynamics.attrib.values()):
            why = "a rotor's lag is that of its motor, and no other joint moves"
            found["element <dynamics> of <joint>", why] += 1
    return found


def _count(element: Element, owner: str, found: Counter[tuple[str, str]]) -> None:
    """Count the unknown parts of an element and of its descendants."""
    known = _CHILDREN[element.tag].split()
    for child in element:
        if not isinstance(child, Element) or ":" in child.tag:
            continue
        whose = owner
        if child.tag in ("link", "joint"):
            whose = f"{child.tag} '{shortened(child.get('name', ''))}'"
        if child.tag not in known:
            place = f" in <{element.tag}> of {whose}" if element.tag != "robot" else ""
            near = get_close_matches(child.tag, known, n=1)
            hint = f", did you mean <{near[0]}>?" if near else ""
            found[f"element <{shortened(child.tag)}>", place + hint] += 1
            continue
        attributes = _ATTRIBUTES.get(child.tag, "").split()
        for name in child.attrib if attributes else ():
            if name not in attributes and ":" not in name:
                what = f"attribute {shortened(name)} of <{child.tag}>"
                found[what, f" in <{element.tag}> of {whose}"] += 1
        if child.tag in _CHILDREN:
            _count(child, whose, found)


def read_urdf(path: Path, robot: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the model in a URDF.

    Args:
        path: the file, for messages and relative paths.
        robot: its root element.
        finder: of packages and meshes.
        remarks: receives remarks on unused parts.

    Raises:
        WorkbenchError: naming file and element, for invalid content.
    """
    if robot.tag != "robot":
        raise WorkbenchError(
            f"{path}: the root element is <{robot.tag}>, a URDF has <robot>, an MJCF <mujoco>"
        )
    elements = _children(robot, "link")
    collisions = sum(len(_children(link, "collision")) for link in elements)
    visuals = sum(len(_children(link, "visual")) for link in elements)
    refuse_too_many(path, len(elements), visuals + collisions, collisions)
    note_unknown(path, robot, remarks)
    joint_elements = _children(robot, "joint")
    _refuse_twins([*elements])
    _refuse_twins([*joint_elements])
    links = [_name(element) for element in elements]
    ends = [(_end(j, "parent", links), _end(j, "child", links)) for j in joint_elements]
    X_ML = link_poses(
        path,
        links,
        [(*pair, origin(j)) for pair, j in zip(ends, joint_elements, strict=True)],
    )
    colours = read_colours(robot)
    return Model(
        source=path,
        name=robot.get("name") or path.name.partition(".")[0],
        links=tuple(
            Link(
                name=name,
                X_ML=X_ML[name],
                inertial=_inertial(element),
                visuals=tuple(read_shapes(path, element, "visual", colours, finder, remarks)),
                collisions=tuple(read_shapes(path, element, "collision", colours, finder, remarks)),
            )
            for name, element in zip(links, elements, strict=True)
        ),
        joints=tuple(
            _joint(element, *pair, X_ML[pair[1]])
            for element, pair in zip(joint_elements, ends, strict=True)
        ),
        frames=(),
        sensors=tuple(_sensors(path, robot, links, remarks)),
        plugins=tuple(
            plugin for block in _children(robot, "gazebo") for plugin in _children(block, "plugin")
        ),
        properties=tuple(
            (key, value)
            for element in _children(robot, "properties")
            for key, value in element.attrib.items()
        ),
    )


def _children(element: Element, tag: str) -> list[Element]:
    """Return the children with a tag."""
    return [child for child in element if isinstance(child, Element) and child.tag == tag]


def _name(element: Element) -> str:
    name = element.get("name", "")
    if not name:
        raise WorkbenchError(f"{place(element)}: <{element.tag}> without a name: add it")
    return name


def _short(element: Element) -> str:
    """Return the name of an element for a message."""
    return shortened(element.get("name", ""))


def _refuse_twins(elements: list[Element]) -> None:
    """Reject two links or joints with one name."""
    seen: dict[str, Element] = {}
    for element in elements:
        name = _name(element)
        if name in seen:
            raise WorkbenchError(
                f"{place(element)}: there are two {element.tag}s named "
                f"'{shortened(name)}': rename one"
            )
        seen[name] = element


def _end(joint: Element, end: str, links: list[str]) -> str:
    """Return the parent or child link of a joint."""
    element = joint.find(end)
    link = "" if element is None else element.get("link", "")
    if link not in links:
        raise WorkbenchError(
            f"{place(joint)}: joint '{_short(joint)}' has the {end} link '{shortened(link)}', "
            f"which does not exist: links are {listed(links)}"
        )
    return link


def _inertial(link: Element) -> Inertial | None:
    """Return mass and inertia of a link."""
    element = link.find("inertial")
    if not isinstance(element, Element):
        return None
    mass, inertia = element.find("mass"), element.find("inertia")
    if not isinstance(mass, Element):
        raise WorkbenchError(
            f"{place(element)}: link '{_short(link)}' has an <inertial> without <mass>: add it"
        )
    if not isinstance(inertia, Element):
        inertia = Element("inertia")
    xx, yy, zz, xy, xz, yz = (
        number(inertia, name, "0") for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    return Inertial(
        mass=number(mass, "value"),
        X_LI=origin(element),
        moments=(xx, yy, zz),
        products=(xy, xz, yz),
    )


def _joint(element: Element, parent: str, child: str, X_MJ: RigidTransform) -> Joint:
    """Return a joint; its frame is that of the child link."""
    axis = element.find("axis")
    x, y, z = triple(axis, "xyz", "1 0 0") if isinstance(axis, Element) else (1.0, 0.0, 0.0)
    length = float(np.linalg.norm((x, y, z)))
    if length < 1e-9 and element.get("type") == "fixed":  # a fixed joint has no axis
        x, y, z, length = 0.0, 0.0, 1.0, 1.0
    if length < 1e-9:
        raise WorkbenchError(
            f"{place(element)}: joint '{_short(element)}' has the axis 0 0 0: give it a direction"
        )
    return Joint(
        name=_name(element),
        kind=element.get("type", ""),
        parent=parent,
        child=child,
        X_MJ=X_MJ,
        axis_J=(x / length, y / length, z / length),
    )


def _sensors(
    path: Path, robot: Element, links: list[str], remarks: Remarks
) -> Iterator[DeclaredSensor]:
    """Yield the sensors of `<gazebo reference>` blocks."""
    for block in _children(robot, "gazebo"):
        link = block.get("reference", "")
        for sensor in _children(block, "sensor"):
            if link in links:
                X_LS = pose(Node(sensor, path, FRAME_SEMANTICS, "", "").child("pose"))
                yield DeclaredSensor(link, X_LS, sensor)
            else:
                remarks.add(
                    "ignored",
                    path,
                    f"sensor '{sensor.get('name', '')}'",
                    f"its <gazebo> block refers to '{link}', which is not a link",
                )


def link_poses(
    path: Path, links: list[str], joints: list[tuple[str, str, RigidTransform]]
) -> dict[str, RigidTransform]:
    """Return the pose of each link in the frame of its root link.

    Args:
        path: for messages.
        links: names.
        joints: parent, child, and the child's pose in the parent.

    Raises:
        WorkbenchError: if a link is the child of two joints, or joints form a circle.
    """
    above: dict[str, tuple[str, RigidTransform]] = {}
    for parent, child, X_PC in joints:
        if child in above:
            raise WorkbenchError(
                f"{path}: link '{shortened(child)}' is the child of two joints: a URDF is a tree, "
                "so leave one out"
            )
        above[child] = (parent, X_PC)
    poses = {name: RigidTransform() for name in links if name not in above}
    for name in links:
        way = [name]
        while way[-1] not in poses:
            way.append(above[way[-1]][0])
            if len(way) > len(links):
                raise WorkbenchError(
                    f"{path}: the joints above link '{shortened(name)}' form a loop: one link must "
                    "not be the child of a joint"
                )
        for child in reversed(way[:-1]):
            parent, X_PC = above[child]
            poses[child] = poses[parent] @ X_PC
    return poses

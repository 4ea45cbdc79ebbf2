"""Read URDF, with what Gazebo users write into its `<gazebo>` blocks."""

from collections.abc import Iterator
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_node import FRAME_SEMANTICS, Node
from workbench.plant.formats.sdf_values import pose
from workbench.plant.formats.urdf_schema import note_unknown
from workbench.plant.formats.urdf_shapes import read_collisions, read_colours, read_visuals
from workbench.plant.formats.values import listed, number, origin, shortened, triple
from workbench.plant.formats.xml import Element, place
from workbench.plant.model import (
    DeclaredPlugin,
    DeclaredSensor,
    Inertial,
    Joint,
    Link,
    Model,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks


def read_urdf(path: Path, robot: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return what a URDF says.

    Args:
        path: the file, for messages and relative paths.
        robot: its root element.
        finder: of packages and meshes.
        remarks: where to note what is left out.

    Raises:
        WorkbenchError: naming file and element of what cannot be read.
    """
    if robot.tag != "robot":
        raise WorkbenchError(
            f"{path}: the root element is <{robot.tag}>, a URDF has <robot>, an MJCF <mujoco>"
        )
    note_unknown(path, robot, remarks)
    elements = _children(robot, "link")
    joint_elements = _children(robot, "joint")
    _refuse_twins(path, [*elements])
    _refuse_twins(path, [*joint_elements])
    links = [_name(path, element) for element in elements]
    ends = [(_end(path, j, "parent", links), _end(path, j, "child", links)) for j in joint_elements]
    X_ML = link_poses(
        path,
        links,
        [(*pair, origin(path, j)) for pair, j in zip(ends, joint_elements, strict=True)],
    )
    colours = read_colours(path, robot)
    return Model(
        source=path,
        name=robot.get("name") or path.name.partition(".")[0],
        links=tuple(
            Link(
                name=name,
                X_ML=X_ML[name],
                inertial=_inertial(path, element),
                visuals=read_visuals(path, element, name, colours, finder, remarks),
                collisions=read_collisions(path, element, name, finder, remarks),
            )
            for name, element in zip(links, elements, strict=True)
        ),
        joints=tuple(
            _joint(path, element, *pair, X_ML[pair[1]])
            for element, pair in zip(joint_elements, ends, strict=True)
        ),
        frames=(),
        sensors=tuple(_sensors(path, robot, links, remarks)),
        plugins=tuple(
            DeclaredPlugin(path, plugin)
            for block in _children(robot, "gazebo")
            for plugin in _children(block, "plugin")
        ),
        properties=tuple(
            (key, value)
            for element in _children(robot, "properties")
            for key, value in element.attrib.items()
        ),
    )


def _children(element: Element, tag: str) -> list[Element]:
    """Return the children of a tag."""
    return [child for child in element if isinstance(child, Element) and child.tag == tag]


def _name(path: Path, element: Element) -> str:
    name = element.get("name", "")
    if not name:
        raise WorkbenchError(f"{place(path, element)}: <{element.tag}> without a name: add it")
    return name


def _short(element: Element) -> str:
    """Return an element's name for a message."""
    return shortened(element.get("name", ""))


def _refuse_twins(path: Path, elements: list[Element]) -> None:
    """Refuse two links or joints of one name."""
    seen: dict[str, Element] = {}
    for element in elements:
        name = _name(path, element)
        if name in seen:
            raise WorkbenchError(
                f"{place(path, element)}: there are two {element.tag}s named "
                f"'{shortened(name)}': rename one"
            )
        seen[name] = element


def _end(path: Path, joint: Element, end: str, links: list[str]) -> str:
    """Return the parent or child link of a joint."""
    element = joint.find(end)
    link = "" if element is None else element.get("link", "")
    if link not in links:
        raise WorkbenchError(
            f"{place(path, joint)}: joint '{_short(joint)}' has the {end} link "
            f"'{shortened(link)}', which is not there: links are {listed(links)}"
        )
    return link


def _inertial(path: Path, link: Element) -> Inertial | None:
    """Return mass and inertia of a link."""
    element = link.find("inertial")
    if not isinstance(element, Element):
        return None
    mass, inertia = element.find("mass"), element.find("inertia")
    if not isinstance(mass, Element):
        raise WorkbenchError(
            f"{place(path, element)}: link '{_short(link)}' has an <inertial> without <mass>: "
            "add it"
        )
    if not isinstance(inertia, Element):
        inertia = Element("inertia")
    xx, yy, zz, xy, xz, yz = (
        number(path, inertia, name, "0") for name in ("ixx", "iyy", "izz", "ixy", "ixz", "iyz")
    )
    return Inertial(
        mass=number(path, mass, "value"),
        X_LI=origin(path, element),
        moments=(xx, yy, zz),
        products=(xy, xz, yz),
    )


def _joint(path: Path, element: Element, parent: str, child: str, X_MJ: RigidTransform) -> Joint:
    """Return a joint; its frame is the child link's."""
    axis = element.find("axis")
    x, y, z = triple(path, axis, "xyz", "1 0 0") if isinstance(axis, Element) else (1.0, 0.0, 0.0)
    length = float(np.linalg.norm((x, y, z)))
    if length < 1e-9 and element.get("type") == "fixed":  # which has no axis, whatever it says
        x, y, z, length = 0.0, 0.0, 1.0, 1.0
    if length < 1e-9:
        raise WorkbenchError(
            f"{place(path, element)}: joint '{_short(element)}' has the axis 0 0 0: "
            "give it a direction"
        )
    return Joint(
        name=_name(path, element),
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
                yield DeclaredSensor(path, link, X_LS, sensor)
            else:
                remarks.add(
                    "ignored",
                    path,
                    f"sensor '{sensor.get('name', '')}'",
                    f"its <gazebo> block refers to '{link}', which is no link",
                )


def link_poses(
    path: Path, links: list[str], joints: list[tuple[str, str, RigidTransform]]
) -> dict[str, RigidTransform]:
    """Return every link's pose in the frame of the root that it hangs on.

    Args:
        path: for messages.
        links: names.
        joints: parent, child, and the child's pose in the parent.

    Raises:
        WorkbenchError: if a link hangs on two joints, or joints go round in a circle.
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
                    f"{path}: the joints above link '{shortened(name)}' go round in a circle: "
                    "one link must be no joint's child"
                )
        for child in reversed(way[:-1]):
            parent, X_PC = above[child]
            poses[child] = poses[parent] @ X_PC
    return poses

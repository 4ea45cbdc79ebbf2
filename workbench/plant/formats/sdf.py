"""Read SDF: a model with its includes."""

import dataclasses
from collections.abc import Iterable
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_include import SdfFile, SdfFiles, sdf_file
from workbench.plant.formats.sdf_node import (
    FRAME_SEMANTICS,
    Node,
    flag,
    known_names,
    number,
    pose,
    triple,
)
from workbench.plant.formats.sdf_poses import ROOT, WORLD, Poses, joint_end, joint_key
from workbench.plant.formats.sdf_shapes import ShapeReader, solid
from workbench.plant.formats.sdf_tree import SdfTree
from workbench.plant.formats.sdf_world import choose_model, motor_names, same_part
from workbench.plant.formats.solids import Solid, together, unit_moments, volume
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.model import (
    DeclaredSensor,
    Inertial,
    Joint,
    Link,
    Model,
    NamedFrame,
    refuse_too_many,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import RemarkKind, Remarks

_DENSITY = 1000.0
"""Density of water [kg/m³], the default of SDF."""
_DEFAULT = Inertial(1.0, RigidTransform(), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
"""The default of SDF and Gazebo for a link without an inertial."""
_KNOWN: dict[str, frozenset[str]] = {
    parent: frozenset(children.split())
    for parent, children in {
        "model": "allow_auto_disable enable_wind frame gripper include joint link model "
        "model_state plugin pose self_collide static",
        "include": "model_state name namespace placement_frame plugin pose static uri",
        "link": "audio_sink audio_source battery collision enable_wind frame gravity inertial "
        "kinematic light must_be_base_link particle_emitter pose projector self_collide sensor "
        "velocity_decay visual",
        "inertial": "auto_inertia_params density fluid_added_mass frame inertia mass pose",
        "inertia": "ixx ixy ixz iyy iyz izz",
        "visual": "cast_shadows frame geometry laser_retro material meta plugin pose transparency "
        "visibility_flags",
        "collision": "auto_inertia_params density frame geometry laser_retro max_contacts pose "
        "surface",
        "geometry": "box capsule cone cylinder ellipsoid empty heightmap image mesh plane polyline "
        "sphere",
        "joint": "axis axis2 child frame gearbox_ratio gearbox_reference_body parent physics pose "
        "screw_thread_pitch sensor thread_pitch",
        "axis": "dynamics initial_position limit mimic use_parent_model_frame xyz",
        "sensor": "air_pressure air_speed altimeter always_on camera contact enable_metrics "
        "force_torque frame frame_id gps imu lidar logical_camera magnetometer navsat plugin pose "
        "ray rfid rfidtag sonar topic transceiver update_rate visualize",
    }.items()
}
"""Children by parent, of all versions from 1.4 to 1.12; source: sdformat.org/spec."""
_UNUSED: dict[str, dict[str, str]] = {
    "model": {
        "gripper": "no flight has grippers",
        "model_state": "a scenario says how a flight begins",
        "enable_wind": "a scenario says what wind there is",
    },
    "include": {"model_state": "a scenario says how a flight begins"},
    "link": {
        "velocity_decay": "drag is that of body and rotors",
        "enable_wind": "a scenario says what wind there is",
        "kinematic": "every link moves with the body",
        "light": "lights are not drawn",
        "battery": "the battery lasts as long as battery_duration says",
        "particle_emitter": "particles are not drawn",
        "projector": "projectors are not drawn",
    },
    "inertial": {"fluid_added_mass": "no flight has added mass"},
    "collision": {"surface": "friction and stiffness of the ground are those of the workbench"},
    "joint": {"physics": "no joint moves but rotors"},
    "axis": {"dynamics": "a rotor's lag is that of its motor, and no other joint moves"},
}
"""Children that are valid in SDF and not used here, with the reason."""
_NOTHING = ("", "0", "false")
_SENSOR_FRAMES = ("gz_frame_id", "ignition_frame_id")
MOST_REMARKS = 50
"""Largest number of remarks on unknown or unused elements."""
_KINDS = (
    "ball",
    "continuous",
    "fixed",
    "gearbox",
    "prismatic",
    "revolute",
    "revolute2",
    "screw",
    "universal",
)
_WITHOUT_AXIS = ("ball", "fixed")
_AXES_OF_THE_MODEL = (1, 4)
"""The last version in which the axis of a joint is given in the model frame."""
_NAMES = ("jointName", "linkName", "joint_name", "link_name")
"""Elements of plugins that name a joint or link of the model."""


def read_inertial(link: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return mass and inertia of a link.

    Args:
        link: its element.
        poses: of its collisions, from which its inertia may be computed.
        remarks: receives remarks on missing values.

    Raises:
        WorkbenchError: naming file and line, for an invalid number.
    """
    node = link.child("inertial")
    if not node:
        text = "it has no <inertial>; SDF's defaults of 1 kg and 1 kg·m² hold, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return _DEFAULT
    if flag(node, node.attribute("auto")):
        return _from_collisions(link, node, poses, remarks)
    if not node.text_of("mass"):
        text = "its <inertial> gives no mass; SDF's default of 1 kg holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
    inertia = node.child("inertia")
    X_LI = pose(node.child("pose"))
    mass = number(node, "mass", 1.0)
    if not inertia:
        text = "its <inertial> has no <inertia>; SDF's default of 1 kg·m² holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return Inertial(mass, X_LI, _DEFAULT.moments, _DEFAULT.products)
    xx, yy, zz = (number(inertia, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (number(inertia, tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))


def _from_collisions(link: Node, inertial: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return the inertia of `<inertial auto="true">`, from collisions, scaled by `mass`."""
    bodies = []
    density = number(inertial, "density", _DENSITY)
    for node in link.children("collision"):
        shape = solid(node)
        if shape is None:
            text = "automatic inertia leaves out a collision that is not a box, sphere, cylinder, "
            text += "capsule or ellipsoid"
            remarks.add("assumed", link.file, link.title, text)
            continue
        X_LS = poses.X_LF(node, link.full_name)
        mass = number(node, "density", density) * volume(shape)
        bodies.append(Solid(mass, X_LS, unit_moments(shape)))
    total = sum(body.mass for body in bodies)
    if not bodies or min(body.mass for body in bodies) <= 0.0:
        text = "automatic inertia has no collision with a mass; SDF's defaults of 1 kg and 1 kg·m² "
        remarks.add("assumed", link.file, link.title, text + "hold")
        return _DEFAULT
    return together(bodies, number(inertial, "mass", total) / total)


_Strange = tuple[RemarkKind, Path, str, str]
"""Of an element that is unknown or not used: the kind of its remark, its file, what it is, and a
text."""


def note_unknown(sources: Iterable[Node], remarks: Remarks) -> None:
    """Add remarks on unknown and unused elements, one for each file, parent and name.

    Args:
        sources: the `<model>` and `<include>` elements that were read.
        remarks: receives the remarks.
    """
    found: dict[_Strange, list[int]] = {}
    seen: set[int] = set()
    for source in sources:
        _collect(source, seen, found)
    for index, ((kind, file, what, text), lines) in enumerate(found.items()):
        if index == MOST_REMARKS:
            text = f"not in the SDF schema, or not used ({len(found) - index} kinds)"
            remarks.add("ignored", file, "further elements", text)
            break
        where = (
            f"line {lines[0]}"
            if len(lines) == 1
            else f"{len(lines)} times, first in line {lines[0]}"
        )
        remarks.add(kind, file, what, f"{text} ({where})")


def _collect(parent: Node, seen: set[int], found: dict[_Strange, list[int]]) -> None:
    """Collect the unknown and unused descendants of an element, with their lines."""
    if id(parent.element) in seen:  # of a file included twice
        return
    seen.add(id(parent.element))
    for child in parent.children():
        strange = _strange(parent, child)
        if strange:
            found.setdefault(strange, []).append(child.element.line)
        elif child.element.tag in _KNOWN:
            _collect(child, seen, found)


def _strange(parent: Node, child: Node) -> _Strange | None:
    """Return the finding about an element, or None if it is known and used."""
    tag, over = child.element.tag, parent.element.tag
    kind: RemarkKind = "ignored"
    what = f"element <{shortened(tag)}> of <{over}>"
    text = "not in the SDF schema; left out"
    new = child.version >= FRAME_SEMANTICS
    if over == "sensor" and tag in _SENSOR_FRAMES:
        kind = "repaired"
        text = "not in the SDF schema; taken as the sensor's frame, as Gazebo does"
    elif tag == "pose" and new and child.attribute("frame"):
        what = f"attribute frame of <pose> of <{over}>"
        text = "not in the SDF schema since 1.7; left out"
    elif tag == "use_parent_model_frame" and new:
        text = "not in the SDF schema since 1.7; left out"
    elif tag == "pose" and over == "inertial" and child.attribute("relative_to"):
        what = "attribute relative_to of <pose> of <inertial>"
    elif tag == "experimental:params":
        text = "it would change the included model; not applied"
    elif tag in _UNUSED.get(over, {}) and _says_something(child):
        text = f"{_UNUSED[over][tag]}; not used"
    elif tag in _KNOWN[over] or ":" in tag:  # the specification allows custom elements
        return None
    return kind, child.file, what, text


def _says_something(node: Node) -> bool:
    """Return whether an element or a descendant is neither empty, zero nor false."""
    texts = ((element.text or "").strip().lower() for element in node.element.iter())
    return any(text.rstrip("0").rstrip(".") not in _NOTHING for text in texts)


def read_sdf(path: Path, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the model in an SDF file, versions 1.3 to 1.12.

    Names in a nested model that is not merged begin with the name of that model: `child::link`.

    Args:
        path: the file, with a model or a world.
        finder: of included models and meshes.
        remarks: receives remarks on assumptions, repairs and unused parts.

    Raises:
        WorkbenchError: naming file, line and element, for invalid content.
    """
    files = SdfFiles(finder)
    return _read(files.open(path), files, finder, remarks)


def read_expanded_sdf(path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the model in the SDF that a xacro file expands to, see `read_sdf`.

    Args:
        path: the xacro file.
        root: the expanded `<sdf>` element.
        finder: see `read_sdf`.
        remarks: see `read_sdf`.

    Raises:
        WorkbenchError: see `read_sdf`.
    """
    return _read(sdf_file(path, root), SdfFiles(finder), finder, remarks)


def _read(file: SdfFile, files: SdfFiles, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the model in a file and in its includes."""
    tree = choose_model(file, files, remarks)
    if not tree.missing:
        return _model(file.path, tree, finder, remarks)
    try:
        return _model(file.path, _without_missing(tree, remarks), finder, remarks)
    except WorkbenchError as error:  # most likely caused by the missing include
        raise tree.missing[0][1] from error


def _without_missing(tree: SdfTree, remarks: Remarks) -> SdfTree:
    """Return a model without the joints to missing includes.

    Gimbals, cameras and sensors may be missing, but not parts with rotors: then the motor-model
    plugins are missing, too, or name missing links and joints.

    Raises:
        WorkbenchError: if a missing include may have rotors.
    """
    named = motor_names(tree)
    here = {part.full_name for part in (*tree.links, *tree.joints)}
    if not named or not all(any(same_part(name, full) for full in here) for name in named):
        raise tree.missing[0][1]
    for include, _ in tree.missing:
        text = (
            "its file is not found; as it has no rotor, the drone flies without it and its "
            "unknown mass"
        )
        remarks.add(
            "missing", include.file, f"<include> of '{shortened(include.text_of('uri'))}'", text
        )
    poses = Poses(tree, Remarks())
    joints = []
    for joint in tree.joints:
        try:
            for end in ("parent", "child"):
                poses.find(joint, joint_end(joint, end))
        except WorkbenchError:
            remarks.add("ignored", joint.file, joint.title, "it joins a missing part; left out")
        else:
            joints.append(joint)
    return dataclasses.replace(tree, joints=joints)


def _model(path: Path, tree: SdfTree, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the records of a model."""
    visuals, collisions = (
        sum(len(link.children(tag)) for link in tree.links) for tag in ("visual", "collision")
    )
    refuse_too_many(path, len(tree.links), visuals + collisions, collisions)
    note_unknown(tree.sources, remarks)
    if not tree.links:
        raise WorkbenchError(f"{path}: model '{shortened(tree.name)}' has no link: add one")
    poses = Poses(tree, remarks)
    shapes = ShapeReader(poses, finder, remarks)
    for joint in tree.joints:
        for sensor in joint.children("sensor"):
            remarks.add("ignored", sensor.file, sensor.title, "sensors of joints are not used")
    return Model(
        source=path,
        name=tree.name,
        links=tuple(
            Link(
                name=link.full_name,
                X_ML=poses.X_MF(link.full_name),
                inertial=read_inertial(link, poses, remarks),
                visuals=tuple(shapes.shapes(link, "visual")),
                collisions=tuple(shapes.shapes(link, "collision")),
            )
            for link in tree.links
        ),
        joints=tuple(_joint(joint, poses) for joint in tree.joints),
        frames=tuple(_frame(frame, poses) for frame in tree.frames),
        sensors=tuple(
            DeclaredSensor(link.full_name, poses.X_LF(sensor, link.full_name), sensor.element)
            for link in tree.links
            for sensor in link.children("sensor")
        ),
        plugins=tuple(read_plugin(plugin) for plugin in tree.plugins),
    )


def _joint(joint: Node, poses: Poses) -> Joint:
    """Return a joint between two links, or between the world and one."""
    kind = joint.attribute("type")
    if kind not in _KINDS:
        what = f"{joint.title} has the type '{shortened(kind)}'"
        raise joint.fault(f"{what}: {known_names(kind, _KINDS)}")
    parent, child = (
        poses.link_of(poses.find(joint, joint_end(joint, end))) for end in ("parent", "child")
    )
    if parent == child:
        raise joint.fault(f"{joint.title} joins '{shortened(child)}' to itself: name two links")
    if child == WORLD:  # the same joint, as the world cannot be a child
        parent, child = child, parent
    X_MJ = poses.X_MF(joint_key(joint))
    axis_J = (0.0, 0.0, 1.0) if kind in _WITHOUT_AXIS else _axis(joint, X_MJ, poses)
    return Joint(joint.full_name, kind, parent, child, X_MJ, axis_J)


def _axis(joint: Node, X_MJ: RigidTransform, poses: Poses) -> tuple[float, float, float]:
    """Return the unit vector of the axis of a joint in the joint frame."""
    axis = joint.child("axis")
    if not axis:
        return (0.0, 0.0, 1.0)
    xyz = np.array(triple(axis, "xyz", (0.0, 0.0, 1.0)))
    length = float(np.linalg.norm(xyz))
    if length < 1e-9:
        raise axis.fault(f"{joint.title} has an axis without length: give it a direction")
    node = axis.child("xyz") or axis
    frame = node.attribute("expressed_in")
    if not frame and _is_in_model(axis):
        frame = ROOT
    if frame:
        R_MF = poses.X_MF(poses.find(node, frame)).rotation()
        xyz = X_MJ.rotation().inverse() @ R_MF @ xyz
    x, y, z = (xyz / length).tolist()
    return (x, y, z)


def _is_in_model(axis: Node) -> bool:
    """Return whether the axis is given in the model frame, as in old files."""
    if axis.version >= FRAME_SEMANTICS:
        return False
    word = axis.child("use_parent_model_frame")
    return axis.version <= _AXES_OF_THE_MODEL or (word is not None and flag(word, word.text))


def _frame(frame: Node, poses: Poses) -> NamedFrame:
    """Return a `<frame>` on its link."""
    link = poses.link_of(frame.full_name)
    if link == WORLD:
        raise frame.fault(f"{frame.title} is attached to the world: attach it to a link")
    X_LF = poses.X_MF(link).inverse() @ poses.X_MF(frame.full_name)
    return NamedFrame(frame.full_name, link, X_LF)


def read_plugin(plugin: Node) -> Element:
    """Return a plugin, with full names of joints and links."""
    return _with_scope(plugin.element, plugin.scope) if plugin.scope else plugin.element


def _with_scope(element: Element, scope: str) -> Element:
    """Return a copy with a scope before the names of links and joints."""
    copy = element.like(element.attrib)
    copy.text, copy.tail = element.text, element.tail
    if element.tag in _NAMES and (element.text or "").strip():
        copy.text = scope + (element.text or "").strip()
    copy.extend([_with_scope(child, scope) for child in element if isinstance(child, Element)])
    return copy

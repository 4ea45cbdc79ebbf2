"""Read SDF: a model with all that it includes."""

import dataclasses
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.plant.formats.sdf_include import SdfFile, SdfFiles, sdf_file
from workbench.plant.formats.sdf_inertia import read_inertial
from workbench.plant.formats.sdf_node import FRAME_SEMANTICS, Node, known_names
from workbench.plant.formats.sdf_poses import ROOT, WORLD, Poses, joint_end, joint_key
from workbench.plant.formats.sdf_schema import note_unknown
from workbench.plant.formats.sdf_shapes import ShapeReader
from workbench.plant.formats.sdf_tree import SdfTree
from workbench.plant.formats.sdf_values import flag, triple
from workbench.plant.formats.sdf_world import choose_model, motor_names, same_part
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xml import Element
from workbench.plant.model import DeclaredPlugin, DeclaredSensor, Joint, Link, Model, NamedFrame
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks

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
"""The last version in which a joint's axis is given in the model's frame, not in the joint's."""
_NAMES = ("jointName", "linkName", "joint_name", "link_name")
"""Elements of plugins that name a part of the model that the plugin belongs to."""


def read_sdf(path: Path, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return what an SDF file says, versions 1.3 to 1.12.

    Of a model in a model (not merged) the names begin with the inner model's: `child::link`.

    Args:
        path: the file, with a model or a world.
        finder: of included models and meshes.
        remarks: where to note what is assumed, repaired and left out.

    Raises:
        WorkbenchError: naming file, line and element of what cannot be read.
    """
    files = SdfFiles(finder)
    return _read(files.open(path), files, finder, remarks)


def read_expanded_sdf(path: Path, root: Element, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return what the SDF says that a xacro file stands for, see `read_sdf`.

    Args:
        path: the xacro file.
        root: the `<sdf>` element that came of it.
        finder: see `read_sdf`.
        remarks: see `read_sdf`.

    Raises:
        WorkbenchError: see `read_sdf`.
    """
    return _read(sdf_file(path, root), SdfFiles(finder), finder, remarks)


def _read(file: SdfFile, files: SdfFiles, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return what a file says, and those that it includes."""
    tree = choose_model(file, files, remarks)
    if not tree.missing:
        return _model(file.path, tree, finder, remarks)
    try:
        return _model(file.path, _without_missing(tree, remarks), finder, remarks)
    except WorkbenchError as error:  # most likely what is missing is what it lacks
        raise tree.missing[0][1] from error


def _without_missing(tree: SdfTree, remarks: Remarks) -> SdfTree:
    """Return a model without the joints to what it includes and is not here.

    Gimbals, cameras and sensors may be missing. What carries rotors may not: then the motor-model
    plugins are missing too, or they name links and joints that are not here.

    Raises:
        WorkbenchError: if what is missing may carry rotors.
    """
    named = motor_names(tree)
    here = {part.full_name for part in (*tree.links, *tree.joints)}
    if not named or not all(any(same_part(name, full) for full in here) for name in named):
        raise tree.missing[0][1]
    for include, _ in tree.missing:
        text = (
            "its file is not found; it carries no rotor, so that the drone flies without it and "
            "without its mass, which is not known here"
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
            remarks.add("ignored", joint.file, joint.title, "it joins what is missing; left out")
        else:
            joints.append(joint)
    return dataclasses.replace(tree, joints=tuple(joints))


def _model(path: Path, tree: SdfTree, finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the records of a model."""
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
                visuals=tuple(shapes.visuals(link)),
                collisions=tuple(shapes.collisions(link)),
            )
            for link in tree.links
        ),
        joints=tuple(_joint(joint, poses) for joint in tree.joints),
        frames=tuple(_frame(frame, poses) for frame in tree.frames),
        sensors=tuple(
            DeclaredSensor(
                sensor.file, link.full_name, poses.X_LF(sensor, link.full_name), sensor.element
            )
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
    if child == WORLD:  # the same nail, and the world is nobody's child
        parent, child = child, parent
    X_MJ = poses.X_MF(joint_key(joint))
    axis_J = (0.0, 0.0, 1.0) if kind in _WITHOUT_AXIS else _axis(joint, X_MJ, poses)
    return Joint(joint.full_name, kind, parent, child, X_MJ, axis_J)


def _axis(joint: Node, X_MJ: RigidTransform, poses: Poses) -> tuple[float, float, float]:
    """Return the unit vector of a joint's axis in its own frame."""
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
    """Return whether an axis of an old file is given in the model's frame."""
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


def read_plugin(plugin: Node) -> DeclaredPlugin:
    """Return a plugin, with the names in it as names of the whole."""
    element = _with_scope(plugin.element, plugin.scope) if plugin.scope else plugin.element
    return DeclaredPlugin(plugin.file, element)


def _with_scope(element: Element, scope: str) -> Element:
    """Return a copy in which the names of links and joints have the scope in front."""
    copy = Element(element.tag, element.attrib)
    copy.line = element.line
    copy.text, copy.tail = element.text, element.tail
    if element.tag in _NAMES and (element.text or "").strip():
        copy.text = scope + (element.text or "").strip()
    copy.extend([_with_scope(child, scope) for child in element if isinstance(child, Element)])
    return copy

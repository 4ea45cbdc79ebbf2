"""Read SDF: a model with its includes."""

import dataclasses
from collections.abc import Sequence
from pathlib import Path

from pydrake.geometry import CalcVolume
from pydrake.math import RigidTransform

from workbench.common.errors import WorkbenchError
from workbench.extras.formats.detachable_joint import with_detachable_loads
from workbench.extras.formats.sdf_include import SdfFile, SdfFiles, sdf_file
from workbench.extras.formats.sdf_joint import read_sdf_joint
from workbench.extras.formats.sdf_node import (
    Node,
    node_pose,
    sdf_number,
)
from workbench.extras.formats.sdf_poses import (
    MODEL_FRAME_NAME,
    SDF_WORLD_FRAME,
    Poses,
    joint_end,
)
from workbench.extras.formats.sdf_shapes import link_shapes, part_solid
from workbench.extras.formats.sdf_tree import SdfTree, build_sdf_tree
from workbench.extras.formats.sdf_words import note_unknown_sdf
from workbench.extras.formats.sdf_world import (
    choose_model,
    motor_names,
    same_part,
    world_element,
    world_of,
)
from workbench.extras.formats.solids import solid_inertial, unit_moments
from workbench.plant.formats.sdf_pose import sdf_flag
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xml import Element
from workbench.plant.gathered import whole_inertial
from workbench.plant.model import (
    DeclaredSensor,
    Inertial,
    Link,
    Model,
    NamedFrame,
    inertial_of,
    refuse_too_many,
)
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remarks
from workbench.plant.worlds.geometry import drake_shape

_SDF_DENSITY_KG_M3 = 1000.0
"""Density of water [kg/m³], the default of SDF."""
_DEFAULT_INERTIAL = Inertial(1.0, RigidTransform(), (1.0, 1.0, 1.0), (0.0, 0.0, 0.0))
"""The default of SDF and Gazebo for a link without an inertial."""
_PART_NAME_TAGS = ("jointName", "linkName", "joint_name", "link_name", "parent_link")
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
        return _DEFAULT_INERTIAL
    if sdf_flag(node.element, node.attribute("auto")):
        return _from_collisions(link, node, poses, remarks)
    if not node.text_of("mass"):
        text = "its <inertial> gives no mass; SDF's default of 1 kg holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
    inertia = node.child("inertia")
    X_LI = node_pose(node.child("pose"))
    mass = sdf_number(node, "mass", 1.0)
    if not inertia:
        text = "its <inertial> has no <inertia>; SDF's default of 1 kg·m² holds, as in Gazebo"
        remarks.add("assumed", link.file, link.title, text)
        return Inertial(mass, X_LI, _DEFAULT_INERTIAL.moments, _DEFAULT_INERTIAL.products)
    xx, yy, zz = (sdf_number(inertia, tag, 1.0) for tag in ("ixx", "iyy", "izz"))
    xy, xz, yz = (sdf_number(inertia, tag, 0.0) for tag in ("ixy", "ixz", "iyz"))
    return Inertial(mass, X_LI, (xx, yy, zz), (xy, xz, yz))


def _from_collisions(link: Node, inertial: Node, poses: Poses, remarks: Remarks) -> Inertial:
    """Return the inertia of `<inertial auto="true">`, from collisions, scaled by `mass`."""
    solids = []
    density = sdf_number(inertial, "density", _SDF_DENSITY_KG_M3)
    for node in link.children("collision"):
        shape = part_solid(node)
        if shape is None:
            text = "automatic inertia leaves out a collision that is not a box, sphere, cylinder, "
            text += "capsule or ellipsoid"
            remarks.add("assumed", link.file, link.title, text)
            continue
        X_LS = poses.X_LF(node, link.full_name)
        mass = sdf_number(node, "density", density) * CalcVolume(drake_shape(shape))
        solids.append(solid_inertial(mass, X_LS, unit_moments(shape)))
    weighs = bool(solids) and min(solid.mass for solid in solids) > 0.0
    whole = whole_inertial([(RigidTransform(), each) for each in solids]) if weighs else None
    if whole is None:
        text = "automatic inertia has no collision with a mass; SDF's defaults of 1 kg and 1 kg·m² "
        remarks.add("assumed", link.file, link.title, text + "hold")
        return _DEFAULT_INERTIAL
    mass = sdf_number(inertial, "mass", whole.mass)
    return inertial_of(mass, whole.X_LI, mass / whole.mass * whole.matrix)


def read_sdf(
    path: Path, finder: PackageFinder, remarks: Remarks, root: Element | None = None
) -> Model:
    """Return the model in an SDF file, versions 1.3 to 1.12.

    Names in a nested model that is not merged begin with the name of that model: `child::link`.

    Args:
        path: the file, with a model or a world.
        finder: of included models and meshes.
        remarks: receives remarks on assumptions, repairs and unused parts.
        root: its root element, if that is known, as of a file that xacro expanded.

    Raises:
        WorkbenchError: naming file, line and element, for invalid content.
    """
    files = SdfFiles(finder)
    file = files.open(path) if root is None else sdf_file(path, root)
    return _read_sdf_model(file, files, finder, remarks)


def _read_sdf_model(
    file: SdfFile, files: SdfFiles, finder: PackageFinder, remarks: Remarks
) -> Model:
    """Return the model in a file and its includes, with the models that it holds."""
    top, tree, held = choose_model(file, files, remarks)
    try:
        whole = _without_missing(tree, remarks) if tree.missing else tree
        model = _model(file.path, whole, finder, remarks)
    except WorkbenchError as error:
        if not tree.missing:
            raise
        raise tree.missing[0][1] from error  # most likely caused by the missing include
    if held:
        model = _with_models(model, file, top, held, files, finder, remarks)
    return with_detachable_loads(model, remarks)


def _with_models(
    model: Model,
    file: SdfFile,
    top: Node,
    others: Sequence[Node],
    files: SdfFiles,
    finder: PackageFinder,
    remarks: Remarks,
) -> Model:
    """Return a model with others of its world, where they are relative to it.

    Args:
        model: that flies.
        file: of the world.
        top: the element of the model.
        others: the elements of the other models.
        files: finds included ones.
        finder: of meshes.
        remarks: receives remarks on the others.
    """
    world = dataclasses.replace(top, element=world_element(file))
    drone, *trees = [build_sdf_tree(file, each, files, ()) for each in (top, *others)]
    for tree in trees:
        tree.check_complete()
    poses = Poses(world_of(file, world, [drone, *trees]), Remarks())
    X_MW = poses.X_MF(f"{drone.name}::{MODEL_FRAME_NAME}").inverse()
    more = _model(file.path, world_of(file, world, trees), finder, remarks)
    links = [dataclasses.replace(each, X_ML=X_MW @ each.X_ML) for each in more.links]
    joints = [dataclasses.replace(each, X_MJ=X_MW @ each.X_MJ) for each in more.joints]
    return dataclasses.replace(
        model,
        links=(*model.links, *links),
        joints=(*model.joints, *joints),
        frames=(*model.frames, *more.frames),
        sensors=(*model.sensors, *more.sensors),
    )


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
            "missing",
            include.file,
            f"<include> of '{shortened_text(include.text_of('uri'))}'",
            text,
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
    note_unknown_sdf(tree.sources, remarks)
    if not tree.links:
        raise WorkbenchError(f"{path}: model '{shortened_text(tree.name)}' has no link: add one")
    poses = Poses(tree, remarks)
    for joint in tree.joints:
        for sensor in joint.children("sensor"):
            remarks.add("ignored", sensor.file, sensor.title, "sensors of joints are not used")
    carrier = next((each.carrier for each in tree.models if each.name == MODEL_FRAME_NAME), "")
    return Model(
        source=path,
        name=tree.name,
        links=tuple(
            Link(
                name=link.full_name,
                X_ML=poses.X_MF(link.full_name),
                inertial=read_inertial(link, poses, remarks),
                visuals=tuple(link_shapes(link, "visual", poses, finder, remarks)),
                collisions=tuple(link_shapes(link, "collision", poses, finder, remarks)),
            )
            for link in tree.links
        ),
        joints=tuple(read_sdf_joint(joint, poses, remarks) for joint in tree.joints),
        frames=tuple(_sdf_named_frame(frame, poses) for frame in tree.frames),
        sensors=tuple(
            DeclaredSensor(link.full_name, poses.X_LF(sensor, link.full_name), sensor.element)
            for link in tree.links
            for sensor in link.children("sensor")
        ),
        plugins=tuple(read_plugin(plugin) for plugin in tree.plugins),
        canonical_link=poses.link_of(MODEL_FRAME_NAME) if carrier else "",
    )


def _sdf_named_frame(frame: Node, poses: Poses) -> NamedFrame:
    """Return a `<frame>` on its link."""
    link = poses.link_of(frame.full_name)
    if link == SDF_WORLD_FRAME:
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
    if element.tag in _PART_NAME_TAGS and (element.text or "").strip():
        copy.text = scope + (element.text or "").strip()
    copy.extend([_with_scope(child, scope) for child in element if isinstance(child, Element)])
    return copy

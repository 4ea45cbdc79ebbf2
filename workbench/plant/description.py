"""Read links, rotors, sensors and remarks from a description in xacro, URDF or an added format."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.common.vectors import float_triple
from workbench.plant.battery_pack import is_battery_plugin, read_battery_pack
from workbench.plant.drawable import with_drawable_meshes
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.template import refuse_template
from workbench.plant.formats.urdf import read_urdf
from workbench.plant.formats.values import shortened_text
from workbench.plant.formats.xacro import expand_xacro, is_xacro
from workbench.plant.formats.xml import Element, parse_xml, read_xml
from workbench.plant.gathered import body_roots
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.readers import (
    URDF_SUFFIXES,
    RotorDialect,
    format_of_root,
    format_of_suffix,
    missing_reader,
    rotor_dialects,
)
from workbench.plant.remarks import DescriptionRemark, Remarks
from workbench.plant.repaired_inertia import repair_inertias, with_stated_body
from workbench.plant.rotor_sources.mount import spin_joints
from workbench.plant.rotor_sources.names import same_name
from workbench.plant.rotor_sources.plugins import (
    is_motor_plugin,
    is_velocity_plugin,
    read_motor_plugins,
    read_velocity_plugin,
    velocity_plugin_joints,
)
from workbench.plant.rotor_sources.sidecar import (
    find_sidecar,
    read_sidecar,
    states_rotors,
)
from workbench.plant.rotors import Rotor
from workbench.plant.sensor_reader import read_sensors
from workbench.plant.sensors import Sensor
from workbench.plant.servo_sources.classic_plugins import has_classic_servos
from workbench.plant.servo_sources.plugins import joint_plugin_class
from workbench.plant.servos import with_servos
from workbench.plant.tilt import Tilt
from workbench.plant.tilting import with_tilts
from workbench.plant.tree import (
    find_base_link,
    flying_tree,
    without_floating_root,
)
from workbench.plant.vehicle import BatteryPack

_ADDED_FORMATS = {"sdf": "SDF", "mujoco": "MJCF"}
"""Formats by root element that a shipped package reads."""
_PYBULLET_COEFFICIENTS = ("kf", "km")
"""Properties with which gym-pybullet-drones describes rotors; a shipped package reads them."""


@dataclass(frozen=True)
class Description:
    """A drone description as interpreted; Drake accepts all of it.

    Attributes:
        source: the file that was read.
        name: the robot's name.
        base_link: the link that is not the child of a joint, or what carries the rotors below it;
            its frame is the body frame.
        model: links and joints as one tree, with meshes that Drake can draw.
        rotors: in the order in which every thrust or speed vector of the project lists them.
        sensors: the supported ones.
        remarks: on what was repaired, assumed, missing or ignored.
        battery: None if not stated; the rotors weaken with its voltage.
        tilts: joints with servos that tilt rotors, where the rotors alone cannot control it.
    """

    source: Path
    name: str
    base_link: str
    model: Model
    rotors: tuple[Rotor, ...]
    sensors: tuple[Sensor, ...]
    remarks: tuple[DescriptionRemark, ...]
    battery: BatteryPack | None = None
    tilts: tuple[Tilt, ...] = ()

    def undrawn(self) -> "Description":
        """Return the description without visual shapes, for a flight without pictures.

        Drake moves every shape at every physics step: 40 shapes take an eighth of the step. A drone
        is invisible to its own sensors.
        """
        links = tuple(dataclasses.replace(link, visuals=()) for link in self.model.links)
        return dataclasses.replace(self, model=dataclasses.replace(self.model, links=links))


def expands(path: Path) -> bool:
    """Return whether a description is expanded by xacro.

    Raises:
        WorkbenchError: if it is not XML, and no installed package reads it.
    """
    if path.suffix == ".xacro":
        return True
    return format_of_suffix(path.suffix) is None and is_xacro(read_xml(path))


def read_description(
    path: Path | str,
    args: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    rotors: Path | str = "",
) -> Description:
    """Read a `.xacro` or `.urdf` file, one that an installed package reads, or a folder.

    Args:
        path: the file, or the folder of a model.
        args: values for a xacro file's arguments.
        packages: folders of ROS packages and Gazebo models by name, in addition to those found near
            the file and through the environment.
        rotors: a sidecar, "" for the one beside the description, if any.

    Raises:
        WorkbenchError: if it cannot be read, or is ambiguous.
    """
    path = description_file(Path(path))
    if args and format_of_suffix(path.suffix):
        raise WorkbenchError(f"{path}: only a xacro file takes arguments ({', '.join(args)})")
    finder = PackageFinder(path, packages)
    remarks = Remarks()
    model = _read_model(path, args or {}, finder, remarks)
    model.refuse_long_names()
    model = dataclasses.replace(model, name=plain_name(model.name))
    model = without_floating_root(model)
    base_link = _body_of_rotors(model, Path(rotors) if rotors else None, remarks)
    # before links without mass become frames
    read = read_rotors(model, base_link, remarks, Path(rotors) if rotors else None)
    found = tuple(_with_lifting_direction(path, rotor, remarks) for rotor in read)
    spinning = spin_joints(model, base_link, found)
    model = flying_tree(model, base_link, spinning, remarks)
    sidecar = Path(rotors) if rotors else find_sidecar(path)
    model = with_servos(model, spinning, sidecar, remarks)
    model, tilts = with_tilts(model, base_link, found, remarks)
    model = repair_inertias(model, remarks)
    model = with_stated_body(model, base_link, Path(rotors) if rotors else None, remarks)
    battery = read_battery_pack(model, Path(rotors) if rotors else None, remarks)
    sensors = read_sensors(model, base_link, remarks)
    _note_plugins(model, remarks)
    return Description(
        source=path,
        name=model.name,
        base_link=base_link,
        model=with_drawable_meshes(model, base_link, found, remarks),
        rotors=found,
        sensors=sensors,
        remarks=tuple(remarks.found),
        battery=battery,
        tilts=tilts,
    )


def _root_of_rotors(model: Model, sidecar: Path | None) -> str:
    """Return the base link; of trees that no joint connects, that of the tree with the rotors.

    Raises:
        WorkbenchError: as `find_base_link` and `read_rotors` do, and for rotors on several trees.
    """
    root = find_base_link(model)
    links = {link.name for link in model.links}
    if _connected_links(model, root) >= links:
        return root
    carriers = [each.link for each in read_rotors(model, root, Remarks(), sidecar)]
    carriers = [link for link in carriers if link in links]
    if not carriers:
        return root
    names = _connected_links(model, carriers[0])
    if not names.issuperset(carriers):
        apart = shortened_text(next(link for link in carriers if link not in names))
        raise WorkbenchError(
            f"{model.source}: no joint connects the links '{shortened_text(carriers[0])}' and "
            f"'{apart}', which both carry rotors: connect them, or give the file of one drone"
        )
    own = tuple(link for link in model.links if link.name in names)
    joints = tuple(joint for joint in model.joints if joint.child in names)
    return find_base_link(dataclasses.replace(model, links=own, joints=joints))


def _connected_links(model: Model, link: str) -> set[str]:
    """Return the names of the links that joints connect with a link, and its own."""
    names, joints = {link}, [each for each in model.joints if each.parent != "world"]
    while near := {
        name
        for joint in joints
        for name in (joint.parent, joint.child)
        if len(names & {joint.parent, joint.child}) == 1 and name not in names
    }:
        names |= near
    return names


def _body_of_rotors(model: Model, sidecar: Path | None, remarks: Remarks) -> str:
    """Return the base link: the root, or what is below it on joints, carries all rotors and weighs
    more, as the body of a drone whose camera is described as its root.

    Raises:
        WorkbenchError: as `find_base_link`, `read_rotors` and `flying_tree` do.
    """
    root = _root_of_rotors(model, sidecar)
    if not any(joint.moves for joint in model.joints):
        return root
    rotors, unsaid = read_rotors(model, root, Remarks(), sidecar), Remarks()
    tree = flying_tree(model, root, spin_joints(model, root, rotors), unsaid)
    bodies = body_roots(tree, root)
    carriers = {bodies.get(rotor.link, root) for rotor in rotors}
    masses = dict.fromkeys(bodies.values(), 0.0)
    for link in tree.links:
        masses[bodies[link.name]] += link.inertial.mass if link.inertial else 0.0
    if len(carriers) != 1 or masses[body := carriers.pop()] <= masses[root]:
        return root
    text = (
        f"'{shortened_text(body)}', which carries the rotors; the root '{shortened_text(root)}' is "
        "lighter, and on a joint"
    )
    remarks.add("assumed", model.source, "base link", text)
    return body


def _read_model(
    path: Path, args: Mapping[str, str], finder: PackageFinder, remarks: Remarks
) -> Model:
    """Return the model in a file; the root element determines the format if the name does not."""
    if known := format_of_suffix(path.suffix):
        return known.read(path, None, finder, remarks)
    if path.suffix not in URDF_SUFFIXES:  # before it is found to be no XML
        refuse_template(path)
    root = None if path.suffix == ".xacro" else read_xml(path)
    expands = root is None or is_xacro(root)
    if path.suffix == ".urdf" and not expands:  # expressions of xacro may have such braces
        refuse_template(path)
    if root is None or expands:
        root = parse_xml(expand_xacro(path, args, finder), path)
    elif args:
        raise WorkbenchError(f"{path}: only a xacro file takes arguments ({', '.join(args)})")
    if root.tag == "robot":
        return read_urdf(path, root, finder, remarks)
    added = format_of_root(root.tag)
    if added:
        return added.read(path, root, finder, remarks)
    if root.tag in _ADDED_FORMATS:
        raise missing_reader(path, f"{_ADDED_FORMATS[root.tag]} (<{root.tag}>)")
    raise WorkbenchError(
        f"{path}: the root element is <{shortened_text(root.tag)}>, a URDF has <robot>, an MJCF "
        "<mujoco>"
    )


def _with_lifting_direction(path: Path, rotor: Rotor, remarks: Remarks) -> Rotor:
    """Return a rotor with the direction for hover, and note if it has to turn backwards.

    A fixed propeller that turns backwards pushes the other way, and Gazebo's motor models turn
    backwards for a negative speed. Rotors that point down fly this way, such as four of the eight
    of an omnicopter. Thrust and torque are assumed equally large in both directions. A rotor that
    turns counter-clockwise seen from one tip of its axis does so backwards seen from the other.
    Rotors that push sideways stay at rest.
    """
    backwards = dataclasses.replace(rotor, axis_B=float_triple(-np.array(rotor.axis_B)))
    if not rotor.lifts and not backwards.lifts:
        text = "it does not lift along the body's z; it stays at rest"
        remarks.add("ignored", path, f"rotor '{rotor.name}'", text)
    if rotor.lifts or not backwards.lifts:
        return rotor
    text = "it points down; it turns backwards and pushes up, with the same constants"
    remarks.add("assumed", path, f"rotor '{rotor.name}'", text)
    return backwards


def _note_plugins(model: Model, remarks: Remarks) -> None:
    """Note plugins that say nothing about rotors, servos or battery; they need Gazebo's code."""
    unread = [
        each
        for each in model.plugins
        if not (_is_read(each) or is_battery_plugin(each) or joint_plugin_class(each))
        and not has_classic_servos(each)
    ]
    dialects = rotor_dialects() if unread else ()
    for plugin in unread:
        if not any(each.reads_plugin(plugin) for each in dialects):
            name, filename = (plugin.get(key, "") for key in ("name", "filename"))
            remarks.add(
                "ignored",
                plugin.file,
                f"plugin '{name}'",
                f"its code ({filename}) runs in Gazebo only",
            )


def read_rotors(
    model: Model, base_link: str, remarks: Remarks, sidecar: Path | None = None
) -> tuple[Rotor, ...]:
    """Return the rotors declared by a description or its sidecar, if any.

    The first of these sources counts: sidecar, motor-model plugins, the paper's plugin block,
    dialects of installed packages.

    Args:
        model: what the description says.
        base_link: its frame is the body frame B.
        remarks: receives remarks on assumptions, and on declarations not used.
        sidecar: a requested one, instead of the one beside the description.

    Raises:
        WorkbenchError: with file and line, if rotors are declared and cannot be read.
    """
    sidecar = sidecar or find_sidecar(model.source)
    if sidecar and states_rotors(sidecar):
        if any(map(_is_read, model.plugins)) or _declaring_dialects(model):
            text = f"they are those of {sidecar.name}; its own are not used"
            remarks.add("ignored", model.source, "rotors", text)
        return read_sidecar(sidecar, model, base_link, remarks)
    blocks = [plugin for plugin in model.plugins if is_velocity_plugin(plugin)]
    rotors = read_motor_plugins(model, base_link, remarks)
    if len(blocks) > 1:
        text = "there are several; only the first is used"
        remarks.add("ignored", blocks[1].file, "velocity plugin", text)
    if rotors:
        _note_others(model, rotors, blocks[:1], remarks)
        return rotors
    if blocks:
        return read_velocity_plugin(model, blocks[0], base_link, remarks)
    for dialect in rotor_dialects():
        if dialect.declares(model):
            return dialect.read(model, base_link, remarks)
    if any(key in _PYBULLET_COEFFICIENTS for key, _ in model.properties):
        raise missing_reader(model.source, "a description of gym-pybullet-drones (<properties>)")
    return ()


def _is_read(plugin: Element) -> bool:
    """Return whether a plugin has rotors that the core reads."""
    return is_motor_plugin(plugin) or is_velocity_plugin(plugin)


def _declaring_dialects(model: Model) -> list[RotorDialect]:
    """Return the dialects in which a model has rotors, besides those that the core reads."""
    if not model.actuators and not model.properties and all(map(_is_read, model.plugins)):
        return []  # most descriptions, which need not wait until packages are searched
    return [each for each in rotor_dialects() if each.declares(model)]


def _note_others(
    model: Model, rotors: tuple[Rotor, ...], blocks: list[Element], remarks: Remarks
) -> None:
    """Note declarations of rotors that differ from the motor-model plugins."""
    for block in blocks:
        named = velocity_plugin_joints(block)
        if not all(any(same_name(name, rotor.joint) for rotor in rotors) for name in named):
            text = "it names joints that no motor-model plugin turns; the plugins are used"
            remarks.add("ignored", block.file, "velocity plugin", text)
    for dialect in _declaring_dialects(model):
        text = "they describe rotors, and so do motor-model plugins, which are used instead"
        remarks.add("ignored", model.source, dialect.element, text)

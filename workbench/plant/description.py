"""Read links, rotors, sensors and remarks from a description in xacro, URDF, SDF or MJCF."""

import dataclasses
import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np
from pydrake.math import RigidTransform, RotationMatrix

from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name
from workbench.plant.drawable import with_drawable_meshes
from workbench.plant.formats.block import Block
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.urdf import read_urdf
from workbench.plant.formats.values import shortened
from workbench.plant.formats.xacro import expand_xacro, is_xacro
from workbench.plant.formats.xml import Element, parse_xml, read_xml
from workbench.plant.model import Inertial, Link, Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remark, Remarks
from workbench.plant.rotor_sources.mjcf_actuators import read_mjcf_actuators
from workbench.plant.rotor_sources.mount import triple
from workbench.plant.rotor_sources.names import same_name
from workbench.plant.rotor_sources.plugins import (
    is_motor_plugin,
    is_velocity_plugin,
    read_motor_plugins,
    read_velocity_plugin,
    velocity_plugin_joints,
)
from workbench.plant.rotor_sources.pybullet import is_pybullet, read_pybullet
from workbench.plant.rotor_sources.sidecar import (
    BatteryRows,
    find_sidecar,
    load_sidecar,
    read_sidecar,
)
from workbench.plant.rotors import Rotor
from workbench.plant.sensor_reader import read_sensors
from workbench.plant.sensors import Sensor
from workbench.plant.tree import find_base_link, flying_tree
from workbench.plant.vehicle import BatteryPack

_ROUNDING = 1e-6
"""Moments of a flat plate meet the triangle inequality exactly. A violation up to this share of the
largest moment comes from the few digits written, and needs no remark."""
_EXACT = 1e-15
"""For a violation above this share, Drake uses a very different inertia."""
_BATTERY_KIND = "battery plugin"
_BATTERY_FILE = "linear-battery"
_BATTERY_CLASS = "::LinearBatteryPlugin"
_HOVER, _SAG = "hoverDuration", "sagCompensation"
"""Our own elements of that plugin."""
_HOUR = 3600.0


@dataclass(frozen=True)
class Description:
    """A drone description as interpreted; Drake accepts all of it.

    Attributes:
        source: the file that was read.
        name: the robot's name.
        base_link: the link that is not the child of a joint; its frame is the body frame.
        model: links and joints as one tree, with meshes that Drake can draw.
        rotors: in the order in which every thrust or speed vector of the project lists them.
        sensors: the supported ones.
        remarks: on what was repaired, assumed, missing or ignored.
        battery: None if not stated; the rotors weaken with its voltage.
    """

    source: Path
    name: str
    base_link: str
    model: Model
    rotors: tuple[Rotor, ...]
    sensors: tuple[Sensor, ...]
    remarks: tuple[Remark, ...]
    battery: BatteryPack | None = None

    def undrawn(self) -> "Description":
        """Return the description without visual shapes, for a flight without pictures.

        Drake moves every shape at every physics step: 40 shapes take an eighth of the step. A drone
        is invisible to its own sensors.
        """
        links = tuple(dataclasses.replace(link, visuals=()) for link in self.model.links)
        return dataclasses.replace(self, model=dataclasses.replace(self.model, links=links))

    def held(self) -> "Description":
        """Return the description with all joints held at zero, as one rigid body."""
        joints = tuple(dataclasses.replace(joint, kind="fixed") for joint in self.model.joints)
        return dataclasses.replace(self, model=dataclasses.replace(self.model, joints=joints))


def read_description(
    path: Path | str,
    args: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    rotors: Path | str = "",
) -> Description:
    """Read a `.xacro`, `.urdf`, `.sdf` or MuJoCo `.xml` file, or a folder.

    Args:
        path: the file, or the folder of a Gazebo model.
        args: values for a xacro file's arguments.
        packages: folders of ROS packages and Gazebo models by name, in addition to those found near
            the file and through the environment.
        rotors: a sidecar, "" for the one beside the description, if any.

    Raises:
        WorkbenchError: if it cannot be read, or is ambiguous.
    """
    path = description_file(Path(path))
    if args and path.suffix == ".sdf":
        raise WorkbenchError(f"{path}: only a xacro file takes arguments ({', '.join(args)})")
    finder = PackageFinder(path, packages)
    remarks = Remarks()
    model = _read(path, args or {}, finder, remarks)
    model.refuse_long_names()
    model = dataclasses.replace(model, name=plain_name(model.name))
    base_link = find_base_link(model)
    # before links without mass become frames
    read = read_rotors(model, base_link, remarks, Path(rotors) if rotors else None)
    found = tuple(_lifting(path, rotor, remarks) for rotor in read)
    model = flying_tree(model, base_link, {rotor.joint for rotor in found}, remarks)
    model = repair_inertias(model, remarks)
    model = with_stated_body(model, base_link, Path(rotors) if rotors else None, remarks)
    battery = read_battery(model, Path(rotors) if rotors else None, remarks)
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
    )


def _read(path: Path, args: Mapping[str, str], finder: PackageFinder, remarks: Remarks) -> Model:
    """Return the model in a file; the root element determines the format if the name does not.

    The readers of the other formats take a tenth of Drake's time to load.
    """
    from workbench.plant.formats.sdf_include import refuse_template

    if path.suffix == ".sdf":
        from workbench.plant.formats.sdf import read_sdf

        return read_sdf(path, finder, remarks)
    if path.suffix not in (".xacro", ".urdf"):  # before it is found to be no XML
        refuse_template(path)
    root = None if path.suffix == ".xacro" else read_xml(path)
    expands = root is None or is_xacro(root)
    if path.suffix == ".urdf" and not expands:  # expressions of xacro may have such braces
        refuse_template(path)
    if root is None or expands:
        root = parse_xml(expand_xacro(path, args, finder), path)
        if root.tag == "sdf":
            from workbench.plant.formats.sdf import read_expanded_sdf

            return read_expanded_sdf(path, root, finder, remarks)
    elif args:
        raise WorkbenchError(f"{path}: only a xacro file takes arguments ({', '.join(args)})")
    elif root.tag == "sdf":
        from workbench.plant.formats.sdf import read_sdf

        return read_sdf(path, finder, remarks)
    elif root.tag == "mujoco":
        from workbench.plant.formats.mjcf import read_mjcf

        return read_mjcf(path, root, finder, remarks)
    return read_urdf(path, root, finder, remarks)


def _lifting(path: Path, rotor: Rotor, remarks: Remarks) -> Rotor:
    """Return a rotor with the direction for hover, and note if it has to turn backwards.

    A fixed propeller that turns backwards pushes the other way, and Gazebo's motor models turn
    backwards for a negative speed. Rotors that point down fly this way, such as four of the eight
    of an omnicopter. Thrust and torque are assumed equally large in both directions. A rotor that
    turns counter-clockwise seen from one tip of its axis does so backwards seen from the other.
    Rotors that push sideways stay at rest.
    """
    backwards = dataclasses.replace(rotor, axis_B=triple(-np.array(rotor.axis_B)))
    if not rotor.lifts and not backwards.lifts:
        text = "it does not lift along the body's z; it stays at rest"
        remarks.add("ignored", path, f"rotor '{rotor.name}'", text)
    if rotor.lifts or not backwards.lifts:
        return rotor
    text = "it points down; it turns backwards and pushes up, with the same constants"
    remarks.add("assumed", path, f"rotor '{rotor.name}'", text)
    return backwards


def _note_plugins(model: Model, remarks: Remarks) -> None:
    """Note plugins that say nothing about rotors or battery; they need Gazebo's code."""
    read = (is_motor_plugin, is_velocity_plugin, is_battery_plugin)
    for plugin in model.plugins:
        if not any(is_read(plugin) for is_read in read):
            name, filename = (plugin.get(key, "") for key in ("name", "filename"))
            remarks.add(
                "ignored",
                plugin.file,
                f"plugin '{name}'",
                f"its code ({filename}) runs in Gazebo only",
            )


def repair_inertias(model: Model, remarks: Remarks) -> Model:
    """Return the model with physically possible inertias, and remark on those that were not.

    A link without mass becomes a frame. A largest moment above the sum of the other two is
    impossible, and is lowered to that sum. This changes one number, for a drone that of yaw.
    Products of inertia too large for their moments are set to zero.

    Raises:
        WorkbenchError: for a negative mass or moment, as its meaning is unclear.
    """
    links = tuple(
        link
        if link.inertial is None
        else dataclasses.replace(link, inertial=_repaired(model, link, link.inertial, remarks))
        for link in model.links
    )
    return dataclasses.replace(model, links=links)


def _repaired(model: Model, link: Link, inertial: Inertial, remarks: Remarks) -> Inertial | None:
    """Return a physically possible inertia of a link, None for a link without mass."""
    element = f"inertia of link '{shortened(link.name)}'"
    if inertial.mass < 0.0:
        raise WorkbenchError(
            f"{model.source}: link '{shortened(link.name)}' has the mass {inertial.mass:g}: "
            "give it a mass of 0 kg or more"
        )
    if min(inertial.moments) < 0.0:
        raise WorkbenchError(
            f"{model.source}: link '{shortened(link.name)}' has a negative moment of inertia "
            f"({_listed_numbers(inertial.moments)}): give it moments of 0 kg m^2 or more"
        )
    if inertial.mass == 0.0:
        text = "its mass is 0; taken as a frame without inertia"
        remarks.add("repaired", model.source, element, text)
        return None
    principal, axes = np.linalg.eigh(inertial.matrix)  # the smallest moment first
    if principal[0] < -_ROUNDING * principal[2]:
        text = (
            f"products ({_listed_numbers(inertial.products)}) too large for the moments; left out"
        )
        remarks.add("repaired", model.source, element, text)
        inertial = dataclasses.replace(inertial, products=(0.0, 0.0, 0.0))
        principal, axes = np.linalg.eigh(inertial.matrix)  # the smallest moment first
    small, middle, large = principal
    excess = large - small - middle
    if excess > _ROUNDING * large:
        text = (
            f"no body has principal moments of {_listed_numbers(principal)} kg m^2, the largest "
            f"more than the other two together; it is taken as {small + middle:.3g}"
        )
        remarks.add("repaired", model.source, element, text)
    if excess > _EXACT * large:
        return _turned_inertial(inertial, np.array([small, middle, small + middle]), axes)
    if principal[2] == 0.0:
        remarks.add("repaired", model.source, element, "it is 0; taken as a point mass")
    return inertial


def _turned_inertial(inertial: Inertial, principal: np.ndarray, axes: np.ndarray) -> Inertial:
    """Return an inertia with other principal moments about the same axes."""
    if np.linalg.det(axes) < 0.0:
        axes = axes * np.array([1.0, 1.0, -1.0])
    turn = RigidTransform(RotationMatrix.ProjectToRotationMatrix(axes), np.zeros(3))
    xx, yy, zz = (float(moment) for moment in principal)
    return dataclasses.replace(
        inertial, X_LI=inertial.X_LI @ turn, moments=(xx, yy, zz), products=(0.0, 0.0, 0.0)
    )


def _listed_numbers(values: Iterable[float]) -> str:
    return ", ".join(f"{float(value):.3g}" for value in values)


def read_rotors(
    model: Model, base_link: str, remarks: Remarks, sidecar: Path | None = None
) -> tuple[Rotor, ...]:
    """Return the rotors declared by a description or its sidecar, if any.

    The first of these sources counts: sidecar, motor-model plugins, the paper's plugin block,
    gym-pybullet-drones' properties, MuJoCo's actuators.

    Args:
        model: what the description says.
        base_link: its frame is the body frame B.
        remarks: receives remarks on assumptions, and on declarations not used.
        sidecar: a requested one, instead of the one beside the description.

    Raises:
        WorkbenchError: with file and line, if rotors are declared and cannot be read.
    """
    sidecar = sidecar or find_sidecar(model.source)
    if sidecar:
        if _declares_rotors(model):
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
    if is_pybullet(model):
        return read_pybullet(model, base_link, remarks)
    return read_mjcf_actuators(model, base_link, remarks)


def _declares_rotors(model: Model) -> bool:
    return (
        bool(model.actuators)
        or is_pybullet(model)
        or any(is_motor_plugin(plugin) or is_velocity_plugin(plugin) for plugin in model.plugins)
    )


def _note_others(
    model: Model, rotors: tuple[Rotor, ...], blocks: list[Element], remarks: Remarks
) -> None:
    """Note declarations of rotors that differ from the motor-model plugins."""
    for block in blocks:
        named = velocity_plugin_joints(block)
        if not all(any(same_name(name, rotor.joint) for rotor in rotors) for name in named):
            text = "it names joints that no motor-model plugin turns; the plugins are used"
            remarks.add("ignored", block.file, "velocity plugin", text)
    if is_pybullet(model):
        text = "they describe rotors, and so do motor-model plugins, which are used instead"
        remarks.add("ignored", model.source, "properties", text)


def with_stated_body(model: Model, base_link: str, sidecar: Path | None, remarks: Remarks) -> Model:
    """Return a model with the body that a sidecar states, if any.

    All mass then is in the base link, and the centre of mass is given in its frame. The motion of a
    rigid body stays the same.

    Args:
        model: its links make up the drone.
        base_link: its frame is the body frame.
        sidecar: a requested one, instead of the one beside the description.
        remarks: receives a remark.

    Raises:
        WorkbenchError: with file and line, for impossible numbers.
    """
    path = sidecar or find_sidecar(model.source)
    if not path:
        return model
    file, sidecar_rows = load_sidecar(path)
    rows = sidecar_rows.body
    if not rows or not file.data["body"]:
        return model

    def refuse(key: str, reason: str) -> WorkbenchError:
        return WorkbenchError(f"{file.where('body', key)}body.{key} {reason}")

    if not 0.0 < rows.mass < math.inf:
        raise refuse("mass", "should be a positive number of kg")
    if len(rows.center_of_mass) != 3 or not np.isfinite(rows.center_of_mass).all():
        raise refuse("center_of_mass", "should be three numbers: x, y, z in m")
    if len(rows.inertia) != 6 or not np.isfinite(rows.inertia).all():
        raise refuse("inertia", "should be six numbers: xx, yy, zz, xy, xz, yz in kg m²")
    xx, yy, zz, xy, xz, yz = rows.inertia
    whole = Inertial(
        mass=rows.mass,
        X_LI=RigidTransform(rows.center_of_mass),
        moments=(xx, yy, zz),
        products=(xy, xz, yz),
    )
    if np.linalg.eigvalsh(whole.matrix)[0] <= 0.0:
        raise refuse("inertia", "does not fit any body: its moments have to be positive")
    remarks.add("assumed", file.path, "body", "mass, centre and inertia are those of this file")
    links = tuple(
        dataclasses.replace(link, inertial=whole if link.name == base_link else None)
        for link in model.links
    )
    return repair_inertias(dataclasses.replace(model, links=links), remarks)


def is_battery_plugin(plugin: Element) -> bool:
    """Return whether a plugin is gz-sim's linear battery, by its file or class name."""
    name, file = (plugin.get(key, "").strip() for key in ("name", "filename"))
    return name.endswith(_BATTERY_CLASS) or _BATTERY_FILE in file


def read_battery(model: Model, sidecar: Path | None, remarks: Remarks) -> BatteryPack | None:
    """Return the battery of the sidecar, else that of gz-sim's LinearBatteryPlugin, else None.

    The open-circuit voltage of the plugin is E0 + E1 (1 - q/c) with the state of charge q/c (see
    its LinearBatteryPlugin.cc). Our element `openCircuitVoltage` in it, pairs of share and voltage,
    takes precedence. `hoverDuration` [s] and `sagCompensation` are ours, too.

    Args:
        model: with the plugins.
        sidecar: a requested one, instead of the one beside the description.
        remarks: receives a remark on an incomplete plugin.

    Raises:
        WorkbenchError: with file and line, for impossible numbers.
    """
    path = sidecar or find_sidecar(model.source)
    if path:
        file, stated = load_sidecar(path)
        if (rows := stated.battery) and file.data["battery"]:
            where = file.where("battery").removesuffix(": ")
            return _checked_battery(rows, where)
    plugins = [plugin for plugin in model.plugins if is_battery_plugin(plugin)]
    for plugin in plugins[1:]:
        text = "there are several; only the first is used"
        remarks.add("ignored", plugin.file, _BATTERY_KIND, text)
    return _battery_of_plugin(plugins[0], remarks) if plugins else None


def _battery_of_plugin(plugin: Element, remarks: Remarks) -> BatteryPack | None:
    tags = Block(_BATTERY_KIND, plugin)
    constant, linear = "open_circuit_voltage_constant_coef", "open_circuit_voltage_linear_coef"
    if not tags.has("capacity") or not (tags.has("openCircuitVoltage") or tags.has(constant)):
        text = f"it has no <capacity>, or no <{constant}>; not used"
        remarks.add("ignored", plugin.file, _BATTERY_KIND, text)
        return None
    if tags.has("openCircuitVoltage"):
        values = tags.numbers("openCircuitVoltage")
        points = [values[i : i + 2] for i in range(0, len(values), 2)]
    else:
        full = tags.positive(constant)
        slope = tags.numbers(linear)[0] if tags.has(linear) else 0.0
        points = [[0.0, full + slope], [1.0, full]]
    rows = BatteryRows(
        _HOUR * tags.positive("capacity"),
        tags.non_negative("resistance", 0.0),
        points,
        tags.positive(_HOVER) if tags.has(_HOVER) else None,
        tags.non_negative(_SAG, 0.0) if tags.has(_SAG) else None,
    )
    return _checked_battery(rows, tags.where())


def _checked_battery(rows: BatteryRows, where: str) -> BatteryPack:
    """Return a battery with possible numbers.

    Raises:
        WorkbenchError: for an impossible number.
    """
    capacity, resistance, points = rows.capacity, rows.resistance, rows.open_circuit_voltage
    hover, sag = rows.hover_duration, rows.sag_compensation
    if not (0.0 < capacity < math.inf and 0.0 <= resistance < math.inf):
        raise WorkbenchError(
            f"{where}: a battery has a positive capacity and a resistance of 0 or more"
        )
    shares = [point[0] for point in points if len(point) == 2]
    voltages = [point[1] for point in points if len(point) == 2]
    rising = all(one < other for one, other in pairwise(shares))
    falls = any(one > other for one, other in pairwise(voltages))
    if (
        len(shares) != len(points)
        or len(points) < 2
        or not rising
        or falls
        or (shares[0], shares[-1]) != (0.0, 1.0)
        or not 0.0 < voltages[0] <= voltages[-1] < math.inf
    ):
        raise WorkbenchError(
            f"{where}: the battery's open-circuit voltage is pairs of charge and V, both rising, "
            "from charge 0 to charge 1"
        )
    if not (hover is None or 0.0 < hover < math.inf):
        raise WorkbenchError(f"{where}: a battery hovers for a positive time")
    if not (sag is None or 0.0 <= sag <= 1.0):
        raise WorkbenchError(f"{where}: the compensated share of a battery's sag is 0 to 1")
    return BatteryPack(
        float(capacity),
        float(resistance),
        tuple((float(share), float(voltage)) for share, voltage in points),
        None if hover is None else float(hover),
        None if sag is None else float(sag),
    )

"""Read a drone description: xacro, URDF, SDF or MJCF in; links, rotors, sensors and remarks out."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.plant.battery import BatteryPack
from workbench.plant.battery_reader import is_battery_plugin, read_battery
from workbench.plant.body_reader import with_stated_body
from workbench.plant.drawable import with_drawable_meshes
from workbench.plant.formats.model_folder import description_file
from workbench.plant.formats.urdf import read_urdf
from workbench.plant.formats.xacro import expand_xacro, is_xacro
from workbench.plant.formats.xml import parse_xml, read_xml
from workbench.plant.inertia_repair import repair_inertias
from workbench.plant.model import Model
from workbench.plant.packages import PackageFinder
from workbench.plant.remarks import Remark, Remarks
from workbench.plant.rotor_reader import read_rotors
from workbench.plant.rotor_sources.motor_plugins import is_motor_plugin
from workbench.plant.rotor_sources.mount import triple
from workbench.plant.rotor_sources.velocity_plugin import is_velocity_plugin
from workbench.plant.rotors import Rotor
from workbench.plant.sensor_reader import read_sensors
from workbench.plant.sensors import Sensor
from workbench.plant.tree import find_base_link, one_body


@dataclass(frozen=True)
class Description:
    """A drone description as understood: nothing in it is refused by Drake any more.

    Attributes:
        source: the file that was read.
        name: the robot's name.
        base_link: the link that no joint has as its child; its frame is the body frame.
        model: links and joints, one tree, with meshes that Drake draws.
        rotors: in the order in which every thrust or speed vector of the project lists them.
        sensors: those that are used.
        remarks: what was repaired, assumed, missing or left unused.
        battery: where it is stated; its voltage weakens the rotors.
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
        """Return it without what is only drawn, for a flight that nobody watches.

        Drake moves every shape at every physics step: 40 of them take an eighth of one. A drone's
        own sensors do not see it.
        """
        links = tuple(dataclasses.replace(link, visuals=()) for link in self.model.links)
        return dataclasses.replace(self, model=dataclasses.replace(self.model, links=links))


def read_description(
    path: Path | str,
    args: Mapping[str, str] | None = None,
    packages: Mapping[str, str] | None = None,
    rotors: Path | str = "",
) -> Description:
    """Read a `.xacro`, `.urdf`, `.sdf` or MuJoCo's `.xml` file (or another with one), or a folder.

    Args:
        path: the file, or the folder of a Gazebo model.
        args: values for a xacro file's arguments.
        packages: folders of ROS packages and Gazebo models by name, besides those that are found
            above and beside the file and through the environment.
        rotors: a YAML file of rotors, "" for those in the description or beside it.

    Raises:
        WorkbenchError: if it cannot be read, or its meaning is not plain.
    """
    path = description_file(Path(path))
    if args and path.suffix == ".sdf":
        raise WorkbenchError(f"{path}: only a xacro file takes arguments ({', '.join(args)})")
    finder = PackageFinder(path, packages)
    remarks = Remarks()
    model = _read(path, args or {}, finder, remarks)
    base_link = find_base_link(model)
    # before links without mass become mere frames
    read = read_rotors(model, base_link, remarks, Path(rotors) if rotors else None)
    found = tuple(_lifting(path, rotor, remarks) for rotor in read)
    model = one_body(model, base_link, {rotor.joint for rotor in found}, remarks)
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
    """Return what a file says: its root element tells the format, where its name does not.

    What reads the others of the formats takes a tenth of Drake's time to load.
    """
    if path.suffix == ".sdf":
        from workbench.plant.formats.sdf import read_sdf

        return read_sdf(path, finder, remarks)
    if path.suffix not in (".xacro", ".urdf"):
        from workbench.plant.formats.sdf_include import refuse_template

        refuse_template(path)
    if path.suffix == ".xacro" or is_xacro(root := read_xml(path)):
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
    """Return a rotor as it takes part in hovering, and note where it has to turn backwards.

    A fixed propeller that turns backwards pushes the other way, and Gazebo's motor models turn
    backwards for a negative speed: so fly those that point down, as four of an omnicopter's eight
    do. Thrust and torque are taken to be as large that way. Turning ccw seen from one tip of the
    axis, backwards is ccw seen from the other. Those that push across are left at rest.
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
    """Note plugins that tell nothing of rotors or battery: their code is Gazebo's."""
    read = (is_motor_plugin, is_velocity_plugin, is_battery_plugin)
    for plugin in model.plugins:
        if not any(is_read(plugin) for is_read in read):
            name, filename = (plugin.element.get(key, "") for key in ("name", "filename"))
            remarks.add(
                "ignored",
                plugin.file,
                f"plugin '{name}'",
                f"its code ({filename}) runs in Gazebo only",
            )

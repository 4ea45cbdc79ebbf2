"""`workbench inspect`: show the interpretation of a drone description."""

import argparse
import dataclasses
import math
from collections.abc import Iterator
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_model
from workbench.commands.description_tables import print_description, print_parts
from workbench.commands.options import (
    MODEL_HELP,
    Subcommands,
    add_command,
    add_description_options,
    add_json_option,
    add_rotors_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_result
from workbench.common.errors import WorkbenchError
from workbench.plant.remarks import DescriptionRemark

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.servo import Servo
    from workbench.plant.vehicle import Vehicle


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "inspect",
        "Show what the workbench reads from a drone description: mass, rotors, sensors, frames, "
        "repairs, and unused parts.",
        "workbench inspect my_drone.urdf.xacro --arg mass:=2.1 --package my_drone=../my_drone",
        run,
    )
    parser.add_argument(
        "model",
        metavar="NAME|PATH",
        help=MODEL_HELP,
    )
    add_description_options(parser)
    add_rotors_option(parser)
    parser.add_argument(
        "--write",
        type=Path,
        metavar="DIR",
        help="store the resolved model there, as one URDF that Drake reads, with its meshes",
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print the interpretation, and write the resolved model if requested."""
    from workbench.plant.loading import make_vehicle
    from workbench.plant.plausible import implausible_values
    from workbench.scenario.configured import read_configured

    description = _with_lack(read_configured(chosen_model(args)))
    try:
        vehicle = make_vehicle(description)
    except WorkbenchError:
        if not args.json:  # show the parts, as they explain why it cannot fly
            print_parts(description)
        raise
    files = _write(description, args.write) if args.write else []
    unlikely = implausible_values(vehicle)
    result, shown = _json(description, vehicle, unlikely), (description, vehicle, unlikely)
    print_result(args, result, print_description, *shown, files=files)
    return ExitCode.DONE


def _with_lack(description: "Description") -> "Description":
    """Return a description with a remark if the kernel does not hold the processes that read it."""
    from workbench.ipc.sandbox import missing_protections

    missing = missing_protections()
    if not missing:
        return description
    text = (
        f"this kernel has no {' and no '.join(missing)}: a fault in a reader of xacro files or "
        "meshes could reach your files and the network"
    )
    remark = DescriptionRemark("missing", description.source, "limits of the kernel", text)
    return dataclasses.replace(description, remarks=(*description.remarks, remark))


def _write(description: "Description", folder: Path) -> list[Path]:
    """Write the model completely or not at all."""
    from workbench.plant.formats.urdf_writer import stored_files

    with Outputs() as outputs:
        for relative, data in stored_files(description):
            target = folder / relative
            draft = outputs.add(target)  # refuses what is no name of a file
            if target.is_symlink() or target.parent.is_symlink() and target.parent != folder:
                raise WorkbenchError(f"{target}: is a link: name an empty folder")
            if target.exists() and target.samefile(description.source):
                raise WorkbenchError(f"{target}: is the description itself: name another folder")
            draft.write_bytes(data)
    return outputs.files


_ROTOR_ATTRIBUTES = (
    "name joint link direction time_constant_up time_constant_down rotor_drag_coefficient "
    "rolling_moment_coefficient inertia inflow_coefficient ground_effect_coefficient "
    "propeller_radius linear_motor_constant"
)
"""Attributes of a rotor that --json has under their names."""


def _json(description: "Description", vehicle: "Vehicle", unlikely: list[str]) -> dict[str, Any]:
    """Return the vehicle in standard terms: all numbers of its plant, and more."""
    from workbench.parameters.parameter_table import flight_table
    from workbench.plant.drag import drag_area
    from workbench.plant.gravity import AIR_DENSITY, GRAVITY

    hover = vehicle.hover_speeds
    return {
        **pick(vehicle, "name source base_link mass thrust_to_weight ground_clearance battery"),
        "com": vehicle.p_BoBcm_B,
        "inertia": vehicle.I_BBcm_B,
        "gravity": GRAVITY,
        "air_density": AIR_DENSITY,
        "drag_area": drag_area(vehicle.mass),
        "rotors": [
            {
                **pick(rotor, _ROTOR_ATTRIBUTES),
                "position": rotor.p_BR,
                "axis": rotor.axis_B,
                "thrust_coefficient": rotor.motor_constant,
                "moment_coefficient": rotor.moment_constant,
                "max_speed": rotor.max_rot_velocity,
                "hover_speed": float(speed),
            }
            for rotor, speed in zip(vehicle.rotors, hover, strict=True)
        ],
        "joints": list(_joints(description, vehicle)),
        "loads": list(description.model.loads),
        "cables": description.model.cables,
        "battery_duration": (vehicle.battery and vehicle.battery.hover_duration)
        or flight_table().find("battery_duration").default,
        "not_flown": [],  # everything read is used; programs may expect the key
        "sensors": [
            {
                **pick(sensor, "type name frame rate link"),
                "position": sensor.p_BS,
                "rotation": sensor.R_BS,
                "noise": {
                    name: [dataclasses.asdict(each) for each in values]
                    for name, values in sensor.stated_noises.items()
                },
            }
            for sensor in vehicle.sensors
        ],
        "frames": [
            {"name": frame.name, "position": frame.p_BF, "rotation": frame.R_BF}
            for frame in vehicle.frames
        ],
        "warnings": [
            *map(str, description.remarks),
            *(f"{vehicle.source}: {doubt}" for doubt in unlikely),
        ],
    }


def _joints(description: "Description", vehicle: "Vehicle") -> Iterator[dict[str, Any]]:
    """Yield the joints that move, but those of loads, all at zero.

    Position and axes are in the base link.
    """
    import numpy as np

    base = description.model.link(description.base_link)
    for joint in vehicle.joints:
        declared = description.model.joint(joint.name)
        assert base and declared
        if declared.is_free:
            continue
        X_BJ = base.X_ML.InvertAndCompose(declared.X_MJ)
        axes = [X_BJ.rotation().multiply(np.array(each.axis_J)) for each in declared.freedoms]
        yield {
            **dataclasses.asdict(joint),
            "position": X_BJ.translation().tolist(),
            "axes": [axis.tolist() for axis in axes],
            **{
                name: [getattr(each, name) for each in declared.freedoms]
                for name in ("lower", "upper", "damping", "friction", "stiffness", "start")
            },
            "mimic": declared.mimic
            and {name: getattr(declared.mimic, name) for name in ("joint", "multiplier", "offset")},
            "servos": [
                servo and _servo(servo)
                for servo in (
                    next((each.servo for each in vehicle.servos if each.joint == name), None)
                    for name in declared.freedom_names
                )
            ],
        }


def _servo(servo: "Servo") -> dict[str, Any]:
    """Return the numbers of a servo, None for no limit."""
    return {
        name: value if isinstance(value, str) or math.isfinite(value or 0.0) else None
        for name, value in dataclasses.asdict(servo).items()
    }

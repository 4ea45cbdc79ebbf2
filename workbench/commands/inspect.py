"""`workbench inspect`: what is understood of a drone description."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    MODEL_HELP,
    add_command,
    add_description_options,
    add_json_option,
    add_rotors_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, say_written
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.plant.description import Description
    from workbench.plant.vehicle import Vehicle


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "inspect",
        "Say what is understood of a drone description: mass, rotors, sensors, frames, and what "
        "was repaired or left unused.",
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
    """Print what was understood; write the resolved model where that is asked for."""
    from workbench.commands.inspect_text import print_description, print_parts
    from workbench.plant.loading import make_vehicle
    from workbench.plant.plausible import doubts
    from workbench.scenario.configured import read_configured
    from workbench.scenario.scenario import VehicleConfig

    config = VehicleConfig(args.model, dict(args.arg), dict(args.package), args.rotors)
    description = read_configured(config)
    try:
        vehicle = make_vehicle(description)
    except WorkbenchError:
        if not args.json:  # who asks why it cannot fly wants to see what there is
            print_parts(description)
        raise
    files = _write(description, args.write) if args.write else []
    unlikely = doubts(vehicle)
    if args.json:
        print_json(_json(description, vehicle, unlikely) | ({"files": files} if files else {}))
    else:
        print_description(description, vehicle, unlikely)
    if files:
        say_written(files)
    return ExitCode.DONE


def _write(description: "Description", folder: Path) -> list[Path]:
    """Store the model, all of it or nothing."""
    from workbench.plant.store import stored_files

    with Outputs() as outputs:
        for relative, data in stored_files(description):
            target = folder / relative
            if target.is_symlink() or target.parent.is_symlink() and target.parent != folder:
                raise WorkbenchError(f"{target}: is a link: name an empty folder")
            if target.exists() and target.samefile(description.source):
                raise WorkbenchError(f"{target}: is the description itself: name another folder")
            outputs.add(target).write_bytes(data)
    return outputs.files


def _json(description: "Description", vehicle: "Vehicle", unlikely: list[str]) -> dict[str, Any]:
    """Return the vehicle in the field's plain words: all that its plant flies with, and more."""
    from workbench.plant.drag import AIR_DENSITY, drag_area
    from workbench.plant.gravity import GRAVITY
    from workbench.scenario.parameters import parameter_table

    hover = vehicle.hover_speeds
    return {
        "name": vehicle.name,
        "source": vehicle.source,
        "base_link": vehicle.base_link,
        "mass": vehicle.mass,
        "com": vehicle.p_BoBcm_B,
        "inertia": vehicle.I_BBcm_B,
        "thrust_to_weight": vehicle.thrust_to_weight,
        "gravity": GRAVITY,
        "air_density": AIR_DENSITY,
        "drag_area": drag_area(vehicle.mass),
        "ground_clearance": vehicle.ground_clearance,
        "rotors": [
            {
                "name": rotor.name,
                "joint": rotor.joint,
                "link": rotor.link,
                "position": rotor.p_BR,
                "axis": rotor.axis_B,
                "direction": rotor.direction,
                "thrust_coefficient": rotor.motor_constant,
                "moment_coefficient": rotor.moment_constant,
                "time_constant_up": rotor.time_constant_up,
                "time_constant_down": rotor.time_constant_down,
                "max_speed": rotor.max_rot_velocity,
                "rotor_drag_coefficient": rotor.rotor_drag_coefficient,
                "rolling_moment_coefficient": rotor.rolling_moment_coefficient,
                "inertia": rotor.inertia,
                "inflow_coefficient": rotor.inflow_coefficient,
                "ground_effect_coefficient": rotor.ground_effect_coefficient,
                "propeller_radius": rotor.propeller_radius,
                "linear_motor_constant": rotor.linear_motor_constant,
                "hover_speed": float(speed),
            }
            for rotor, speed in zip(vehicle.rotors, hover, strict=True)
        ],
        "battery": vehicle.battery,
        "battery_duration": parameter_table().find("battery_duration").default,
        "not_flown": [],  # all that is read flies; programs may look the key up
        "sensors": [
            {
                "type": sensor.type,
                "name": sensor.name,
                "frame": sensor.frame,
                "rate": sensor.rate,
                "link": sensor.link,
                "position": sensor.p_BS,
                "rotation": sensor.R_BS,
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

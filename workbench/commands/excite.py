"""`workbench excite`: the flight plan that identifies a vehicle best."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    MODEL_HELP,
    add_command,
    add_controller_option,
    add_description_options,
    add_json_option,
    add_rotors_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, say_written


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "excite",
        "Write the flight that identifies a vehicle best, as a scenario: sweeps of doublets on "
        "throttle, roll, pitch and yaw within limits.",
        "workbench excite --model dh_drone --output excite.yaml",
        run,
    )
    parser.add_argument(
        "--model", default="dh_drone", metavar="NAME|PATH", help=f"{MODEL_HELP} (default: dh_drone)"
    )
    add_description_options(parser)
    add_rotors_option(parser)
    add_controller_option(parser)
    parser.add_argument(
        "--duration",
        type=float,
        default=60.0,
        metavar="T",
        help="of the flight, in s (default: 60)",
    )
    parser.add_argument("--speed", type=float, metavar="V", help="largest level speed, in m/s")
    parser.add_argument("--climb", type=float, metavar="V", help="largest climb rate, in m/s")
    parser.add_argument("--yaw-rate", type=float, metavar="W", help="largest yaw rate, in rad/s")
    parser.add_argument(
        "--output",
        type=Path,
        default=Path("excite.yaml"),
        metavar="FILE",
        help="scenario to write (default: excite.yaml)",
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Plan and write."""
    from workbench.common.resources import find_file, find_model
    from workbench.design.identify.plan import Limits, excitation, usual_limits
    from workbench.plant.loading import load_vehicle
    from workbench.scenario.scenario import save_scenario

    rotors = find_file(args.rotors) if args.rotors else ""
    vehicle = load_vehicle(find_model(args.model), dict(args.arg), dict(args.package), rotors)
    usual = usual_limits(vehicle)
    limits = Limits(
        usual.speed if args.speed is None else args.speed,
        usual.climb if args.climb is None else args.climb,
        usual.yaw_rate if args.yaw_rate is None else args.yaw_rate,
    )
    scenario = excitation(vehicle, args.model, limits, args.duration, args.controller)
    scenario.vehicle.args = dict(args.arg)
    scenario.vehicle.packages = dict(args.package)
    scenario.vehicle.rotors = args.rotors
    with Outputs() as outputs:
        save_scenario(scenario, outputs.add(args.output))
    if args.json:
        print_json({"duration": scenario.duration, "limits": limits, "file": args.output})
    else:
        print(
            f"{scenario.duration:g} s within {limits.speed:g} m/s, climb {limits.climb:.2g} m/s, "
            f"yaw {limits.yaw_rate:g} rad/s; fly it: workbench fly {args.output} --csv flight.csv"
        )
    say_written(outputs.files)
    return ExitCode.DONE

"""`workbench params`: the table of live parameters."""

import argparse
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.printing import print_json, print_table

_COLUMNS = ("name", "value", "unit", "min", "max", "default", "help")


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "params",
        "List every live parameter with its value for a model, its unit, its limits and its use.",
        "workbench params --model dh_drone",
        run,
    )
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print the table."""
    from workbench.gains.gains import flight_gains
    from workbench.plant.loading import make_vehicle
    from workbench.scenario.configured import read_configured
    from workbench.scenario.parameters import parameter_table, vehicle_parameters
    from workbench.scenario.scenario import Scenario, flown_controller

    scenario = with_vehicle(Scenario(), args)
    config, law = scenario.vehicle, flown_controller(scenario)
    vehicle = make_vehicle(read_configured(config))
    values = flight_gains(vehicle, config.gains, dict(args.set), law)
    rows = [
        (row.name, values[row.name], row.unit, row.minimum, row.maximum, row.default, row.help)
        for row in vehicle_parameters(vehicle, parameter_table(law))
    ]
    if args.json:
        print_json({"parameters": [dict(zip(_COLUMNS, row, strict=True)) for row in rows]})
        return ExitCode.DONE
    texts = [[f"{x:g}" if isinstance(x, float) else x for x in row] for row in rows]
    print_table([_COLUMNS, *texts], left=(0, 2, 6))
    return ExitCode.DONE

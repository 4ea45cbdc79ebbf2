"""`workbench graph`: the block diagram as a picture, or as the DOT text that Graphviz draws."""

import argparse
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_vehicle_options,
    chosen_scenario,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_result, print_table, say

if TYPE_CHECKING:
    from pydrake.systems.framework import Diagram

    from workbench.design.block_graph import Net


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "graph",
        "Draw the diagram that flies: its systems as boxes, its signals as lines.",
        "workbench graph --output diagram.svg",
        run,
    )
    parser.add_argument(
        "--output",
        type=Path,
        metavar="FILE",
        help=".svg, .pdf or .png, which Graphviz draws, or .dot for its text (default: "
        "out/diagram.svg, and out/diagram.dot where Graphviz is not installed)",
    )
    parser.add_argument(
        "--core", action="store_true", help="the continuous flight core, as linearised, instead"
    )
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Build the diagram, draw it and list its signals."""
    from workbench.design.block_graph import (
        INSTALL,
        check_drawable,
        draw_blocks,
        has_graphviz,
        read_block_graph,
    )

    drawn = args.output or Path("out/diagram.svg" if has_graphviz() else "out/diagram.dot")
    with Outputs() as outputs:
        file = outputs.add(drawn)
        check_drawable(drawn)
        graph = read_block_graph(_diagram(args))
        draw_blocks(graph, file)
    if args.output is None and not has_graphviz():
        say(f"{drawn} is text, since Graphviz is not installed: for a picture, {INSTALL}")
    show = partial(print_table, left=(0, 2, 3))
    print_result(args, graph, show, [_line(net) for net in graph.nets], files=outputs.files)
    return ExitCode.DONE


def _diagram(args: argparse.Namespace) -> "Diagram":
    """Return the diagram of a vehicle."""
    from workbench.diagram.core import make_flight_core
    from workbench.gains.gains import flight_gains
    from workbench.plant.loading import make_vehicle
    from workbench.scenario.configured import read_configured
    from workbench.scenario.scenario import flown_controller
    from workbench.session.session import Session

    scenario = chosen_scenario(args)
    if not args.core:
        return Session(scenario, dict(args.set)).diagram
    description = read_configured(scenario.vehicle)
    vehicle = make_vehicle(description)
    law = flown_controller(scenario)
    values = flight_gains(vehicle, scenario.vehicle.gains, dict(args.set), law)
    return make_flight_core(law, description, vehicle, values)


def _line(net: "Net") -> tuple[str, str, str, str]:
    """Return a signal's row: from where, how many numbers, to where."""
    size = str(net.size) if net.size else "-"
    sinks = ", ".join(f"{sink.block}.{sink.port}" for sink in net.sinks)
    return (f"{net.source.block}.{net.source.port}", size, "->", sinks)

"""`workbench pin`: hold a step to what it is now, as a spec that `regress` and pytest fly."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.printing import print_json, say_written
from workbench.commands.progress import progress_bar
from workbench.commands.step import LOADS

AXIS = "x"
"""Of a step that nobody has chosen."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "pin",
        "Fly a step and write a spec that holds later flights to it: limits, curves, margins.",
        "workbench pin my_quad.spec.yaml --model my_quad.urdf.xacro --gains my_gains.yaml --axis x",
        run,
    )
    parser.add_argument(
        "spec",
        type=Path,
        metavar="NAME.spec.yaml",
        help="to be written, with NAME.gains.yaml and NAME.baseline beside it",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument("--axis", choices=("x", "y", "z", "yaw"), help="of the step (default: x)")
    what.add_argument(
        "--load", choices=LOADS, help="of a step of a load in hover, see `workbench step --help`"
    )
    parser.add_argument(
        "--amplitude",
        type=float,
        default=1.0,
        metavar="A",
        help="of the step [m/s], for yaw [rad/s], of a load [N], [N·m] or [m/s] (default: 1)",
    )
    parser.add_argument(
        "--duration",
        type=float,
        default=3.0,
        metavar="T",
        help="flown after the command's edge [s] (default: 3)",
    )
    parser.add_argument(
        "--acts",
        type=float,
        metavar="T",
        help="for how long the load acts [s] (default: to the end, a gust for 1)",
    )
    parser.add_argument(
        "--no-margins", action="store_true", help="leave the loops' margins at hover free"
    )
    parser.add_argument("--force", action="store_true", help="replace files that are there")
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, write and prove the spec."""
    from workbench.design.pin import pin_step
    from workbench.scenario.scenario import Scenario

    scenario = with_vehicle(Scenario(), args)
    axis = args.axis or AXIS
    with progress_bar("flying and proving a step") as progress:
        pinned = pin_step(
            args.spec,
            scenario,
            dict(args.set),
            args.load or axis,
            args.amplitude,
            duration=args.duration,
            acts=args.acts,
            margins=not args.no_margins,
            overwrite=args.force,
            progress=progress,
        )
    if args.json:
        print_json(pinned)
    else:
        loops = f", margins of {pinned.loops} loops" if pinned.loops else ""
        print(
            f"held to what they are now: {pinned.limits} numbers and {pinned.curves} curves of a "
            f"step {args.load or f'along {axis}'}{loops}"
        )
        print(f"\nnext: workbench regress {args.spec}, or pytest {args.spec}")
    say_written([pinned.spec, pinned.gains, pinned.baseline])
    return ExitCode.DONE

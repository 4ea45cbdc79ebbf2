"""`workbench pin`: hold a step to what it is now, as a spec that `regress` and pytest fly."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    add_command,
    add_json_option,
    add_mapping_option,
    add_order_option,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.printing import print_json, say_written
from workbench.commands.progress import progress_bar
from workbench.commands.step import LOADS
from workbench.common.errors import WorkbenchError

AXIS = "x"
"""Of a step that nobody has chosen."""


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "pin",
        "Fly a step, or take a log, and write a spec that holds later flights to it.",
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
    what.add_argument("--log", type=Path, metavar="LOG", help=f"take a flight: {LOG_HELP}")
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
    log = parser.add_argument_group("of a log")
    log.add_argument(
        "--loop",
        default="",
        metavar="LOOP",
        help="whose response is held: roll_rate, roll, v_x, x, ... or SETPOINT:RESPONSE of any two "
        "signals",
    )
    log.add_argument(
        "--span", type=float, nargs=2, default=[], metavar=("FROM", "TO"), help="part of it [s]"
    )
    add_order_option(log)
    add_mapping_option(log)
    parser.add_argument("--force", action="store_true", help="replace files that are there")
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Fly or read, write and prove the spec."""
    if args.log:
        return _pin_log(args)
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
        if args.gains:
            print(f"it flies {pinned.gains.name}: pin again where {args.gains} has changed")
        print(f"\nnext: workbench regress {args.spec}, or pytest {args.spec}")
    say_written([pinned.spec, pinned.gains, pinned.baseline])
    return ExitCode.DONE


def _pin_log(args: argparse.Namespace) -> int:
    """Write the spec of a log."""
    given = [option for option in ("set", "gains", "controller") if getattr(args, option, None)]
    if given:
        raise WorkbenchError(
            f"--{given[0]} belongs to a step that is flown: a log has flown already"
        )
    with progress_bar(f"pinning and proving {args.log.name}") as progress:
        from workbench.design.pin import pin_log
        from workbench.design.regress.running import regress
        from workbench.design.regress.spec import LogConfig
        from workbench.logs.judged_log import read_case
        from workbench.scenario.scenario import Scenario

        vehicle = with_vehicle(Scenario(), args).vehicle
        log = LogConfig(
            file=str(args.log),
            mapping=str(args.mapping or ""),
            order=args.order,
            span=list(args.span),
        )
        pinned = pin_log(args.spec, vehicle, log, args.loop, read_case, overwrite=args.force)
        progress(0.5)
        results = regress([pinned.spec], read_log=read_case)
    failures = [said for each in results for said in each.failures]
    if failures:
        raise WorkbenchError(f"{pinned.spec}: what was pinned is not green: {failures[0]}")
    if args.json:
        print_json(pinned)
    else:
        print(f"held to what they are now: {pinned.limits} numbers of {args.log}")
        if not args.model:
            print(f"taken for a {vehicle.model}: give --model where another drone flew")
        for name, reason in pinned.left_out.items():
            print(f"left out: {name}: {reason}")
        print(f"\nnext: workbench regress {args.spec}, or pytest {args.spec}")
    say_written([pinned.spec])
    return ExitCode.DONE

"""`workbench linearize`: exact linear models, for python-control and for people."""

import argparse
import math
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.judge import print_modes
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_vehicle_options,
    flown_with,
    with_vehicle,
)
from workbench.commands.printing import print_json, say

if TYPE_CHECKING:
    from workbench.design.linear.model import Matrices


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "linearize",
        "Give the exact linear model of the closed loop, the vehicle, or an opened loop, at a trim "
        "point: its order and poles, or with --json its matrices with the names of all signals.",
        "workbench linearize --at vx=5 --loop pitch --minimal",
        run,
    )
    add_vehicle_options(parser)
    parser.add_argument(
        "--at",
        default="hover",
        metavar="POINT",
        help="hover, or as vx=5,vz=-1,yaw_rate=0.2, in m/s and rad/s; ax, ay, az [m/s²] for an "
        "instant of an accelerated flight; hold=1 while a place is held (default: hover)",
    )
    parser.add_argument(
        "--loop",
        default="closed",
        metavar="NAME",
        help="closed, vehicle, or the loop to open: velocity_x, velocity_y, velocity_z, roll, "
        "pitch, yaw_rate, position_x, position_y, position_z (default: closed)",
    )
    parser.add_argument(
        "--cut", default="actuator", metavar="PLACE", help="open it at its actuator or its error"
    )
    parser.add_argument(
        "--time",
        default="sampled",
        metavar="KIND",
        help="sampled, with hold and delay as they fly, or continuous (default: sampled)",
    )
    parser.add_argument(
        "--inputs", metavar="NAME[,NAME]", help="inputs wanted (default: what the pilot asks for)"
    )
    parser.add_argument(
        "--outputs", metavar="NAME[,NAME]", help="outputs wanted (default: velocity and yaw rate)"
    )
    parser.add_argument(
        "--minimal", action="store_true", help="leave out what plays no part between them"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Linearise and print."""
    from workbench.design.linear.linearize import linear_matrices
    from workbench.scenario.scenario import Scenario, flown_controller

    scenario = with_vehicle(Scenario(), args)
    law = flown_controller(scenario)
    if law.derivatives != "AutoDiff":
        say(f"{law.name} does not convert to AutoDiffXd: its derivatives are {law.derivatives}")
    system = linear_matrices(
        scenario,
        at=args.at,
        loop=args.loop,
        cut=args.cut,
        time=args.time,
        inputs=_names(args.inputs),
        outputs=_names(args.outputs),
        gains=dict(args.set),
        minimal=args.minimal,
    )
    if args.json:
        print_json(
            {
                "at": args.at,
                "loop": args.loop,
                "period": float(system.dt),
                "states": list(system.state_labels),
                "inputs": list(system.input_labels),
                "outputs": list(system.output_labels),
                **{name: getattr(system, name).tolist() for name in "ABCD"},
            }
        )
    else:
        _print(system, args)
    return ExitCode.DONE


def _print(system: "Matrices", args: argparse.Namespace) -> None:
    """Print order and poles, fast ones last, in the words of `control.damp`."""
    from workbench.design.judge.loop_response import INTEGRATOR
    from workbench.design.judge.modes import modes_of, natural_poles

    kind = f"sampled each {1e3 * system.dt:.4g} ms" if system.dt else "continuous"
    print(f"{args.loop} at {args.at}, {kind}, {flown_with(args)}: {len(system.A)} states")
    print(f"inputs:  {', '.join(system.input_labels)}")
    print(f"outputs: {', '.join(system.output_labels)}")
    poles = system.poles
    modes = [mode for mode in modes_of(poles, system.dt) if not mode.gone_after(system.dt)]
    print_modes(modes)
    integrators = int((abs(natural_poles(poles, system.dt)) <= INTEGRATOR).sum())
    # a pair is one mode of two poles; a lone sampled pole at negative z swings at half the rate
    pairs = sum(0.0 < mode.imaginary < _half_rate(system.dt) for mode in modes)
    gone = len(system.A) - integrators - len(modes) - pairs
    if integrators:
        print(f"{integrators} {'integrator' if integrators == 1 else 'integrators'}")
    if gone:
        print(f"{gone} more {'dies' if gone == 1 else 'die'} out within a sample")


def _half_rate(period: float) -> float:
    """Return the highest frequency that samples show [rad/s], less rounding."""
    return 0.999999 * math.pi / period if period else math.inf


def _names(text: str | None) -> list[str] | None:
    """Return the names of a list separated by commas, None for none."""
    return [name.strip() for name in text.split(",")] if text else None

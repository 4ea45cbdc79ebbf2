"""`workbench judge`: margins, modes, steps and rates of the closed loop that flies."""

import argparse
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.judge_text import (
    map_result,
    print_judgement,
    print_map,
    print_sensitivities,
    result,
    sensitivity_result,
)
from workbench.commands.options import (
    add_command,
    add_json_option,
    add_output_options,
    add_vehicle_options,
    with_vehicle,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.control.controller import find_loop

if TYPE_CHECKING:
    from workbench.design.linear.model import LinearModel
    from workbench.design.linear.operating_point import OperatingPoint
    from workbench.scenario.scenario import Scenario

_PICTURES = "workbench.design.judge.plots"
"""What draws the pictures."""
DESCRIPTION_OF_MAP = "speed, tilt, climb, yaw_rate, payload"


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "judge",
        "Judge the closed loop: every loop's margins, modes, steps, and the slowest safe rate.",
        "workbench judge --loop pitch --at vx=5\n"
        "  workbench judge --sensitivity --axis x\n"
        "  workbench judge --map speed,payload",
        run,
    )
    parser.add_argument(
        "--loop",
        metavar="NAME",
        help="draw all of one loop, as velocity_x, roll, yaw_rate: Bode, Nyquist, gang of four, "
        "root locus, poles and step",
    )
    parser.add_argument(
        "--at",
        default="hover",
        metavar="POINT",
        help="operating point: hover, or as vx=5,vz=-1,yaw_rate=0.2,ax=3 (default: hover)",
    )
    parser.add_argument(
        "--cut",
        choices=("actuator", "error"),
        default="actuator",
        help="where loops are opened for table and pictures (default: actuator)",
    )
    what = parser.add_mutually_exclusive_group()
    what.add_argument(
        "--sensitivity",
        action="store_true",
        help="instead: what every gain does to every number of a step",
    )
    what.add_argument(
        "--map",
        metavar="A,B",
        help=f"instead: margins and damping over two of {DESCRIPTION_OF_MAP}",
    )
    parser.add_argument(
        "--axis",
        choices=("x", "y", "z", "yaw"),
        help="of the step for --sensitivity (default: x)",
    )
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Judge, print, write pictures; 1 if a mode grows."""
    from workbench.design.linear.operating_point import OperatingPoint, parse_point
    from workbench.scenario.scenario import Scenario, flown_controller

    point = parse_point(args.at)
    scenario = with_vehicle(Scenario(), args)
    law = flown_controller(scenario)
    if args.loop and law.loop(args.loop).hold and point != OperatingPoint():
        raise WorkbenchError(f"the loop {args.loop} is closed at hover only: leave --at out")
    if args.axis and not args.sensitivity:
        raise WorkbenchError("--axis is that of the step for --sensitivity: give both or neither")
    if (args.sensitivity or args.map) and (args.at != "hover" or args.loop):
        raise WorkbenchError("--sensitivity and --map begin at hover: leave --at and --loop out")
    if args.sensitivity:
        return _sensitivity(args, scenario)
    if args.map:
        return _map(args, scenario)
    return _judge(args, scenario, point)


def _judge(args: argparse.Namespace, scenario: "Scenario", point: "OperatingPoint") -> int:
    """Judge one operating point."""
    from workbench.commands.drawer import Drawer
    from workbench.design.judge.report import judge

    with Outputs() as outputs, ExitStack() as stack:
        drawer = None
        if not args.no_plots:
            name = f"judge-{args.loop}.png" if args.loop else "judge-loops.png"
            plot = outputs.add(args.output / name)
            rates = outputs.add(args.output / "judge-rates.png")
            phase = outputs.add(args.output / "judge-phase.png")
            drawer = stack.enter_context(Drawer(_PICTURES))

        def draw_loops(steering: "LinearModel", holding: "LinearModel | None") -> None:
            if drawer and not args.loop:  # while the rest is judged
                drawer.begin(plot, _PICTURES, "plot_loops", steering, holding, cut=args.cut)

        with progress_bar("judging the loops") as progress:
            found = judge(
                scenario,
                point=point,
                settings=dict(args.set),
                progress=progress,
                modelled=draw_loops,
            )
        if drawer:
            if args.loop:
                loop = find_loop(args.loop, found.steering.controller)
                model = (found.holding if loop.hold else None) or found.steering
                drawer.begin(plot, _PICTURES, "plot_loop", model, loop, found.steps, cut=args.cut)
            title = f"{found.vehicle}: how slow the law may run"
            drawer.begin(rates, _PICTURES, "plot_rates", found.slowest, title)
            title = f"{found.vehicle}: where the phase went"
            drawer.begin(phase, _PICTURES, "plot_phase", found.phase, title)
            drawer.finish()
    if args.json:
        print_json(result(found) | {"files": outputs.files})
    else:
        print_judgement(found, args.cut)
    if outputs.files:
        say_written(outputs.files)
    if found.unstable:
        say(f"unstable: a mode grows through {' and '.join(found.unstable)}")
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


def _sensitivity(args: argparse.Namespace, scenario: "Scenario") -> int:
    """Say what the gains do to a step."""
    from workbench.design.judge.sensitivity import step_sensitivity
    from workbench.design.judge.step_pair import STEPS
    from workbench.scenario.axes import find_axis

    axis = args.axis or "x"
    amplitude = dict(STEPS)[axis]
    title = f"step of {amplitude:g} {find_axis(axis).unit} along {axis}"
    with Outputs() as outputs:
        name = f"judge-sensitivity-{axis}.png"
        plot = None if args.no_plots else outputs.add(args.output / name)
        with progress_bar("flying a step with its derivatives") as progress:
            found = step_sensitivity(
                axis,
                amplitude,
                scenario=scenario,
                settings=dict(args.set),
                progress=progress,
            )
        if plot:
            from workbench.design.judge.plots import plot_sensitivity
            from workbench.design.plots import write_png

            write_png(plot_sensitivity(found, title), plot)
    if args.json:
        print_json(sensitivity_result(axis, amplitude, found) | {"files": outputs.files})
    else:
        print_sensitivities(title, found)
    if outputs.files:
        say_written(outputs.files)
    return ExitCode.DONE


def _map(args: argparse.Namespace, scenario: "Scenario") -> int:
    """Draw the operating map."""
    from workbench.design.judge.operating_map import find_direction, operating_map

    names = [name.strip() for name in args.map.split(",")]
    if len(names) != 2:
        raise WorkbenchError(
            f"a map goes along two directions: write --map A,B with two of {DESCRIPTION_OF_MAP}"
        )
    first, second = (find_direction(name).name for name in names)
    if first == second:
        raise WorkbenchError(f"a map goes along two directions: name another one beside {first}")
    with Outputs() as outputs:
        table = outputs.add(args.output / f"judge-map-{first}-{second}.csv")
        plot = None
        if not args.no_plots:
            plot = outputs.add(args.output / f"judge-map-{first}-{second}.png")
        with progress_bar("judging over the map") as progress:
            found = operating_map(
                first, second, scenario=scenario, settings=dict(args.set), progress=progress
            )
        found.write_csv(table)
        if plot:
            from workbench.design.judge.plots import plot_map
            from workbench.design.plots import write_png

            write_png(plot_map(found), plot)
    if args.json:
        print_json(map_result(found) | {"files": outputs.files})
    else:
        print_map(found)
    say_written(outputs.files)
    return ExitCode.DONE

"""`workbench judge`: margins, modes, steps and rates of the closed loop that flies."""

import argparse
import math
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_setup
from workbench.commands.judgement_tables import print_judgement, print_map, print_sensitivities
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flier_options,
    add_flight_options,
    add_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_message, print_result
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import find_loop

if TYPE_CHECKING:
    from workbench.design.judge.operating_map import OperatingMap
    from workbench.design.judge.report import Judgement
    from workbench.design.linear.model import LinearModel
    from workbench.design.linear.operating_point import OperatingPoint
    from workbench.setup import Setup


_JUDGE_PLOT_MODULE = "workbench.design.judge.plots"
"""The module that draws the figures."""
MAP_DIRECTION_NAMES = "speed, tilt, climb, yaw_rate, payload"


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "margins",
        "Analyse the closed loop: every loop's margins, modes, steps, and the slowest safe rate.",
        "workbench margins --loop pitch --at vx=5\n"
        "  workbench margins --sensitivity --axis x\n"
        "  workbench margins --map speed,payload",
        run,
        other_name="judge",
    )
    parser.add_argument(
        "--loop",
        metavar="NAME",
        help="draw all plots of one loop, as velocity_x, roll, yaw_rate: Bode, Nyquist, gang of "
        "four, root locus, poles and step",
    )
    add_option(
        parser,
        "--at",
        "POINT",
        "operating point: hover, or as vx=5,vz=-1,yaw_rate=0.2,ax=3",
        "hover",
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
        help="instead: the effect of every gain on every number of a step",
    )
    what.add_argument(
        "--map",
        metavar="A,B",
        help=f"instead: margins and damping over two of {MAP_DIRECTION_NAMES}",
    )
    parser.add_argument(
        "--axis",
        choices=("x", "y", "z", "yaw"),
        help="of the step for --sensitivity (default: x)",
    )
    add_flight_options(parser)
    add_flier_options(parser)


def run(args: argparse.Namespace) -> int:
    """Judge, print, write pictures; 1 if a mode grows."""
    from workbench.design.linear.operating_point import parse_point

    point = parse_point(args.at)
    if args.axis and not args.sensitivity:
        raise WorkbenchError("--axis is that of the step for --sensitivity: give both or neither")
    if (args.sensitivity or args.map) and (args.at != "hover" or args.loop):
        raise WorkbenchError("--sensitivity and --map begin at hover: leave --at and --loop out")
    if args.sensitivity:
        return _sensitivity(args, chosen_setup(args))
    if args.map:
        return _map(args, chosen_setup(args))
    return _judge(args, point)


def _judge(args: argparse.Namespace, point: "OperatingPoint") -> int:
    """Judge one operating point."""
    from workbench.commands.drawer import Drawer

    with Outputs() as outputs, ExitStack() as stack:
        drawer = None if args.no_plots else stack.enter_context(Drawer(_JUDGE_PLOT_MODULE))
        setup = chosen_setup(args)  # loads numpy, while the other process loads matplotlib
        from workbench.design.judge.report import judge
        from workbench.design.linear.operating_point import HOVER_POINT

        law = setup.controller
        if args.loop and law.loop(args.loop).hold and point != HOVER_POINT:
            raise WorkbenchError(f"the loop {args.loop} is closed at hover only: leave --at out")
        if not law.loops:
            print_message(
                f"{law.name} states no LOOPS, so none is judged or drawn: see docs/controllers.md"
            )
        elif drawer:
            name = f"judge-{args.loop}.png" if args.loop else "judge-loops.png"
            plot = outputs.add(args.output / name)
            phase = outputs.add(args.output / "judge-phase.png")
        if drawer:
            rates = outputs.add(args.output / "judge-rates.png")

        def draw_loops(steering: "LinearModel", holding: "LinearModel | None") -> None:
            if drawer and law.loops and not args.loop:  # during the rest of the judgement
                drawer.begin(
                    plot, _JUDGE_PLOT_MODULE, "plot_loops", steering, holding, cut=args.cut
                )

        with progress_bar("judging the loops") as progress:
            found = judge(
                setup,
                point=point,
                progress=progress,
                modelled=draw_loops,
            )
        if drawer:
            if args.loop:
                loop = find_loop(args.loop, found.steering.controller)
                model = (found.holding if loop.hold else None) or found.steering
                drawer.begin(
                    plot,
                    _JUDGE_PLOT_MODULE,
                    "plot_loop",
                    model,
                    loop,
                    found.steps,
                    cut=args.cut,
                    named=found.modes_holding if model is found.holding else found.modes,
                )
            title = f"{found.vehicle}: how slow the law may run"
            drawer.begin(rates, _JUDGE_PLOT_MODULE, "plot_rates", found.slowest, title)
            if law.loops:
                title = f"{found.vehicle}: where the phase went"
                drawer.begin(phase, _JUDGE_PLOT_MODULE, "plot_phase", found.phase, title)
            drawer.finish()
    result = judgement_result(found)
    print_result(args, result, print_judgement, found, args.cut, files=outputs.files)
    if found.unstable:
        print_message(f"unstable: a mode grows through {' and '.join(found.unstable)}")
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


def _sensitivity(args: argparse.Namespace, setup: "Setup") -> int:
    """Print the sensitivities of a step to the gains."""
    from workbench.design.judge.sensitivity import step_sensitivity
    from workbench.design.judge.step_pair import PAPER_STEPS
    from workbench.scenario.axes import find_axis

    axis = args.axis or "x"
    amplitude = dict(PAPER_STEPS)[axis]
    title = f"step of {amplitude:g} {find_axis(axis).unit} along {axis}"
    with Outputs() as outputs:
        name = f"judge-sensitivity-{axis}.png"
        plot = outputs.picture(args, name)
        with progress_bar("flying a step with its derivatives") as progress:
            found = step_sensitivity(
                axis,
                amplitude,
                scenario=setup,
                progress=progress,
            )
        if plot:
            from workbench.design.judge.plots_map import plot_sensitivity
            from workbench.design.plots import write_png

            write_png(plot_sensitivity(found, title), plot)
    result = {"axis": axis, "amplitude": amplitude, "sensitivities": found}
    print_result(args, result, print_sensitivities, title, found, files=outputs.files)
    return ExitCode.DONE


def _map(args: argparse.Namespace, setup: "Setup") -> int:
    """Draw the operating map."""
    from workbench.design.judge.operating_map import find_direction, operating_map

    names = [name.strip() for name in args.map.split(",")]
    if len(names) != 2:
        raise WorkbenchError(
            f"a map goes along two directions: write --map A,B with two of {MAP_DIRECTION_NAMES}"
        )
    first, second = (find_direction(name).name for name in names)
    if first == second:
        raise WorkbenchError(f"a map goes along two directions: name another one beside {first}")
    with Outputs() as outputs:
        table = outputs.add(args.output / f"judge-map-{first}-{second}.csv")
        plot = outputs.picture(args, f"judge-map-{first}-{second}.png")
        with progress_bar("judging over the map") as progress:
            found = operating_map(first, second, scenario=setup, progress=progress)
        found.write_csv(table)
        if plot:
            from workbench.design.judge.plots_map import plot_map
            from workbench.design.plots import write_png

            write_png(plot_map(found), plot)
    print_result(args, map_result(found), print_map, found, files=outputs.files)
    return ExitCode.DONE


def judgement_result(found: "Judgement") -> dict[str, Any]:
    """Return a judgement for JSON; margins in degrees, other angles in rad."""
    return {
        **pick(found, "vehicle period loops plant_input plant_input_holding modes modes_holding"),
        **pick(found, "slowest phase noise"),
        "point": found.point.label,
        "stable": not found.unstable,
        "unstable_loops": found.unstable,
        "steps": [
            pick(step, "axis amplitude linear flown difference broken") for step in found.steps
        ],
    }


def map_result(found: "OperatingMap") -> dict[str, Any]:
    """Return a map for JSON."""
    return {
        "vehicle": found.vehicle,
        "first": {"name": found.first.name, "unit": found.first.unit},
        "second": {"name": found.second.name, "unit": found.second.unit},
        "first_values": found.first_values.tolist(),
        "second_values": found.second_values.tolist(),
        "phase_margin_deg": (found.phase_margin * math.degrees(1.0)).tolist(),
        "disk_margin": found.disk_margin.tolist(),
        "damping": found.damping.tolist(),
        "weakest_loop": found.weakest,
    }

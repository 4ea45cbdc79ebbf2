"""`workbench judge`: margins, modes, steps and rates of the closed loop that flies."""

import argparse
import math
from collections.abc import Sequence
from contextlib import ExitStack
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_flier_options,
    add_flight_options,
    add_option,
    chosen_scenario,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_result, print_table, say
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.control.controller import find_loop

if TYPE_CHECKING:
    from workbench.design.judge.margins import LoopMargins
    from workbench.design.judge.modes import Mode
    from workbench.design.judge.operating_map import Direction, OperatingMap
    from workbench.design.judge.report import Judgement
    from workbench.design.judge.sampled_stability import SlowestRate
    from workbench.design.judge.sensitivity import Sensitivity
    from workbench.design.linear.model import LinearModel
    from workbench.design.linear.operating_point import OperatingPoint
    from workbench.design.response_metrics import StepMetrics
    from workbench.scenario.scenario import Scenario


_PICTURES = "workbench.design.judge.plots"
"""The module that draws the figures."""
DESCRIPTION_OF_MAP = "speed, tilt, climb, yaw_rate, payload"
_HEAD = (
    "loop",
    "gain margin",
    "down to",
    "phase",
    "delay",
    "disk",
    "Ms",
    "bandwidth",
    "crossover",
)
_UNITS = ("", "[factor]", "[factor]", "[deg]", "[ms]", "[1]", "[1]", "[rad/s]", "[rad/s]")
_FAINT = 0.005
"""Gains that change no metric by this much are left out [% per %]."""
_NOTHING = 1e-6
"""Smaller values of a metric, in its unit or percent, are rounding errors."""


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
        help=f"instead: margins and damping over two of {DESCRIPTION_OF_MAP}",
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
        return _sensitivity(args, chosen_scenario(args))
    if args.map:
        return _map(args, chosen_scenario(args))
    return _judge(args, point)


def _judge(args: argparse.Namespace, point: "OperatingPoint") -> int:
    """Judge one operating point."""
    from workbench.commands.drawer import Drawer

    with Outputs() as outputs, ExitStack() as stack:
        drawer = None if args.no_plots else stack.enter_context(Drawer(_PICTURES))
        scenario = chosen_scenario(args)  # loads numpy, while the other process loads matplotlib
        from workbench.design.judge.report import judge
        from workbench.design.linear.operating_point import HOVER
        from workbench.scenario.scenario import flown_controller

        law = flown_controller(scenario)
        if args.loop and law.loop(args.loop).hold and point != HOVER:
            raise WorkbenchError(f"the loop {args.loop} is closed at hover only: leave --at out")
        if not law.loops:
            say(f"{law.name} states no LOOPS, so none is judged or drawn: see docs/controllers.md")
        elif drawer:
            name = f"judge-{args.loop}.png" if args.loop else "judge-loops.png"
            plot = outputs.add(args.output / name)
            phase = outputs.add(args.output / "judge-phase.png")
        if drawer:
            rates = outputs.add(args.output / "judge-rates.png")

        def draw_loops(steering: "LinearModel", holding: "LinearModel | None") -> None:
            if drawer and law.loops and not args.loop:  # during the rest of the judgement
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
            if law.loops:
                title = f"{found.vehicle}: where the phase went"
                drawer.begin(phase, _PICTURES, "plot_phase", found.phase, title)
            drawer.finish()
    result = judgement_result(found)
    print_result(args, result, print_judgement, found, args.cut, files=outputs.files)
    if found.unstable:
        say(f"unstable: a mode grows through {' and '.join(found.unstable)}")
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


def _sensitivity(args: argparse.Namespace, scenario: "Scenario") -> int:
    """Print the sensitivities of a step to the gains."""
    from workbench.design.judge.sensitivity import step_sensitivity
    from workbench.design.judge.step_pair import STEPS
    from workbench.scenario.axes import find_axis

    axis = args.axis or "x"
    amplitude = dict(STEPS)[axis]
    title = f"step of {amplitude:g} {find_axis(axis).unit} along {axis}"
    with Outputs() as outputs:
        name = f"judge-sensitivity-{axis}.png"
        plot = outputs.picture(args, name)
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
    result = {"axis": axis, "amplitude": amplitude, "sensitivities": found}
    print_result(args, result, print_sensitivities, title, found, files=outputs.files)
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
        plot = outputs.picture(args, f"judge-map-{first}-{second}.png")
        with progress_bar("judging over the map") as progress:
            found = operating_map(
                first, second, scenario=scenario, settings=dict(args.set), progress=progress
            )
        found.write_csv(table)
        if plot:
            from workbench.design.judge.plots import plot_map
            from workbench.design.plots import write_png

            write_png(plot_map(found), plot)
    print_result(args, map_result(found), print_map, found, files=outputs.files)
    return ExitCode.DONE


def judgement_result(found: "Judgement") -> dict[str, Any]:
    """Return a judgement for JSON; angles in rad."""
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


def print_judgement(found: "Judgement", cut: str) -> None:
    """Print the loops, with a row for each, then modes, steps and rates."""
    law = found.steering.controller
    how = "" if law is None or law.derivatives == "AutoDiff" else f", by {law.derivatives}"
    print(f"{found.vehicle} at {found.point.label}, law at {1.0 / found.period:g} Hz{how}")
    if found.loops:
        print(f"\nloops, opened at the {cut}:")
        rows: list[tuple[str, ...]] = [_HEAD, _UNITS]
        rows += [(loop.loop, *_cells(getattr(loop, cut))) for loop in found.loops]
        print_table(rows)
    _print_phase(found)
    _print_plant_input(found)
    _print_noise(found)
    if not found.holding:
        print("position loops and steps are left out: the position is held in hover only")
    _print_modes("modes while the pilot steers", found.modes, found.period)
    if found.modes_holding:
        slow = found.modes_holding[:4]
        _print_modes("slowest modes while the position is held", slow, found.period)
    _print_steps(found)
    print(f"\nthe law runs at {1.0 / found.period:g} Hz; {_rates(found.slowest)}")


def _print_phase(found: "Judgement") -> None:
    """Print the phase budget of each loop at its crossover."""
    from workbench.design.judge.phase_budget import PARTS  # it loads Drake

    if not found.phase:
        return
    parts = [part for part in PARTS if any(abs(getattr(each, part)) > 1e-9 for each in found.phase)]
    print("\nwhere the phase went, at the crossover [deg]:")
    rows = [("loop", "at [rad/s]", "at [Hz]", *parts, "phase of L")]
    for each in found.phase:
        turned = (math.degrees(getattr(each, part)) for part in parts)
        at = (f"{each.crossover:.3g}", f"{each.crossover / (2.0 * math.pi):.3g}")
        rows.append(
            (each.loop, *at, *(f"{x:.1f}" for x in turned), f"{math.degrees(each.phase):.1f}")
        )
    print_table(rows)


def _print_noise(found: "Judgement") -> None:
    """Print the effect of the noise of each sensor on attitude and commands."""
    if not found.noise:
        return
    print("\nwhat the noise of sensors does while the position is held, rms:")
    rows: list[tuple[str, ...]] = [
        ("", "roll [deg]", "pitch [deg]", "yaw [deg]", "commands [% of their mean]")
    ]
    for each in found.noise:
        angles = (f"{math.degrees(angle):.2g}" for angle in each.attitude)
        rows.append((each.sensor, *angles, f"{100.0 * each.worst_command:.2g}"))
    print_table(rows)


def _print_plant_input(found: "Judgement") -> None:
    """Print the margin of force and moments all at once."""
    print("\nat the plant's input, force and moments all at once:")
    rows = [("", "disk", "gains within", "at [rad/s]", "alone:", *found.plant_input.alone)]
    for what, each in (
        ("while the pilot steers", found.plant_input),
        ("while the position is held", found.plant_input_holding),
    ):
        if each is not None:
            low = (2.0 - each.disk_margin) / (2.0 + each.disk_margin)
            alone = (_number(margin, ".2f") for margin in each.alone.values())
            gains = f"{low:.2f} .. {1.0 / low:.2f}" if 0.0 < each.disk_margin < 2.0 else "-"
            disk, frequency = _number(each.disk_margin, ".2f"), _number(each.frequency, ".3g")
            rows.append((what, disk, gains, frequency, "", *alone))
    print_table(rows)


def print_sensitivities(title: str, found: "tuple[Sensitivity, ...]") -> None:
    """Print the sensitivity of every metric to every gain."""
    print(f"{title}: percent that a number changes per percent of a gain\n")
    names = [
        name
        for name in found[0].elasticities
        if any(abs(each.elasticities[name]) > _FAINT for each in found)
    ]
    rows = [("", "value", *names)]
    rows += [
        (each.metric, f"{each.value:.4g}", *(_number(each.elasticities[n], "+.2f") for n in names))
        for each in found
    ]
    print_table(rows)
    rest = [name for name in found[0].elasticities if name not in names]
    print(f"\nwithout effect: {', '.join(rest) or 'none'}")


def print_map(found: "OperatingMap") -> None:
    """Print the weakest point of a map, and the smallest disk margin at every point."""
    first, second = found.first, found.second
    print(f"{found.vehicle}: smallest disk margin, {first.name} across, {second.name} down\n")
    rows = [[f"{second.name} [{second.unit}]", *(f"{x:.3g}" for x in found.first_values)]]
    rows += [
        [f"{value:.3g}", *(_number(x, ".2f") for x in line)]
        for value, line in zip(found.second_values, found.disk_margin.tolist(), strict=True)
    ]
    print_table(rows)
    known = [
        (found.disk_margin[row, column], row, column)
        for row in range(len(found.second_values))
        for column in range(len(found.first_values))
        if math.isfinite(found.disk_margin[row, column])
    ]
    if known:
        disk, row, column = min(known)
        print(
            f"\nweakest: {found.weakest[row][column]} at "
            f"{_place(first, found.first_values[column])} and "
            f"{_place(second, found.second_values[row])}: disk margin {disk:.2f}"
        )
    holes = found.disk_margin.size - len(known)
    if holes:
        print(f"{holes} of {found.disk_margin.size} points cannot be flown")


def map_result(found: "OperatingMap") -> dict[str, Any]:
    """Return a map for JSON; angles in rad."""
    return {
        "vehicle": found.vehicle,
        "first": {"name": found.first.name, "unit": found.first.unit},
        "second": {"name": found.second.name, "unit": found.second.unit},
        "first_values": found.first_values.tolist(),
        "second_values": found.second_values.tolist(),
        "phase_margin": found.phase_margin.tolist(),
        "disk_margin": found.disk_margin.tolist(),
        "damping": found.damping.tolist(),
        "weakest_loop": found.weakest,
    }


def _cells(margins: "LoopMargins") -> tuple[str, ...]:
    """Return the numbers of a loop as texts."""
    if not margins.stable:
        return ("unstable", *["-"] * 7)
    return (
        _number(margins.gain_margin, ".3g"),
        _number(margins.gain_reduction_margin or math.nan, ".3g"),
        _number(math.degrees(margins.phase_margin), ".1f"),
        _number(1e3 * margins.delay_margin, ".1f"),
        _number(margins.disk_margin, ".2f"),
        _number(margins.peak_sensitivity, ".2f"),
        _number(margins.bandwidth, ".3g"),
        _number(margins.crossover, ".3g"),
    )


def _print_modes(title: str, found: "tuple[Mode, ...]", period: float) -> None:
    """Print poles in the terms of python-control's `damp`, without those faster than sampling."""
    print(f"\n{title}:")
    shown = [mode for mode in found if not mode.gone_after(period)]
    print_modes(shown)
    if len(shown) < len(found):
        print(f"{len(found) - len(shown)} more die out within a sample")


def print_modes(shown: "Sequence[Mode]") -> None:
    """Print a table of modes in the terms of python-control's `damp`."""
    rows = [("pole [1/s]", "damping", "frequency [rad/s]", "time constant [s]")]
    rows += [
        (
            f"{mode.real:.4g}" + (f" ± {mode.imaginary:.4g}i" if mode.imaginary else ""),
            _number(mode.damping, ".3f"),
            f"{mode.frequency:.4g}",
            _number(mode.time_constant, ".3g"),
        )
        for mode in shown
    ]
    print_table(rows, left=())


def _print_steps(found: "Judgement") -> None:
    """Print linear and flown metrics side by side."""
    from workbench.design.response_metrics import NUMBERS

    if not found.steps:
        return
    print("\nsteps from hover, linear and flown:")
    rows = [("", *(word for step in found.steps for word in (f"{step.axis} linear", "flown")))]
    for name in NUMBERS:
        pairs = [metrics for step in found.steps for metrics in (step.linear, step.flown)]
        rows.append((name, *(_metric(metrics, name) for metrics in pairs)))
    print_table(rows)
    if any(step.linear is None for step in found.steps):
        print("a mode grows, so the linear model has no numbers")
    for step in found.steps:
        if step.broken:
            print(f"the {step.axis} step has no numbers: {step.broken}")
        for kind, metrics in (("linear", step.linear), ("flown", step.flown)):
            if metrics is not None and metrics.withheld:
                print(f"{step.axis} {kind}: numbers shown as - are withheld: {metrics.withheld}")


def _metric(metrics: "StepMetrics | None", name: str) -> str:
    """Return a metric as text; rounding errors count as 0."""
    value = math.nan if metrics is None else getattr(metrics, name)
    return _number(0.0 if abs(value) < _NOTHING else value, ".4g")


def _number(value: float, form: str) -> str:
    return format(value, form) if math.isfinite(value) else "-"


def _place(direction: "Direction", value: float) -> str:
    unit = "" if direction.unit == "1" else f" {direction.unit}"
    return f"{direction.name} {value:.3g}{unit}"


def _rates(slowest: "SlowestRate") -> str:
    """Print the slowest rates of the law."""
    if not math.isfinite(slowest.stable_period):
        fastest = 1.0 / slowest.samples[0].period
        return f"with these gains a mode grows even at {fastest:g} Hz, at every physics step"
    limit = ", the slowest there is," if slowest.at_limit else ""
    stable = f"it is stable down to {1.0 / slowest.stable_period:.1f} Hz{limit}"
    if not math.isfinite(slowest.safe_period):
        return f"{stable} but no rate has 30 deg of phase margin"
    return f"{stable} and keeps 30 deg of phase margin down to {1.0 / slowest.safe_period:.1f} Hz"

"""`workbench sweep`: fly many candidates, with results in a table and on a map."""

import argparse
import math
from collections.abc import Callable, Iterable
from contextlib import ExitStack
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_executor, chosen_setup, flown_with
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flight_options,
    add_option,
    add_scheduler_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_message, print_result, print_table
from workbench.commands.progress import progress_bar
from workbench.commands.stopping import StopFlag, stop_on_interrupt
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor
    from workbench.design.metrics import Metric
    from workbench.design.sweep.best import BestCandidate
    from workbench.design.sweep.table import SweepTable


_SWEEP_PLOT_MODULE = "workbench.design.sweep.plot_sweep"
_OWN_LOOP = "axis"
"""Value of --margins without a name."""
_NO_BEST_MESSAGE = "no best is chosen: the best candidates were lost on the full diagram"
_RANGE_KEYS = "name low high points log"
"""Keys of a range in JSON."""


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "sweep",
        "Fly a step with many values of any parameters, and write a table and a map of a metric.",
        "workbench sweep kp_velocity_x=2..8:25 kp_pitch=100..400:25 --axis x --metric overshoot",
        run,
    )
    parser.add_argument(
        "ranges",
        nargs="+",
        metavar="NAME=LOW..HIGH[:POINTS][:log]",
        help="what is swept: a gain, a filter, a setting of the estimator or another live "
        "parameter; vary.mass, vary.inertia, vary.rotor_lag, vary.sensing_delay or "
        "vary.command_delay, which the controller does not know of; or seed, of turbulence and "
        "noise; as kp_roll=100..400:9",
    )
    parser.add_argument(
        "--axis",
        choices=("x", "y", "z", "yaw"),
        help="of the step (default: the one that the first gain acts on: x for kp_pitch, y for "
        "kp_roll, yaw for kp_yaw_rate; else z)",
    )
    parser.add_argument(
        "--amplitude",
        type=float,
        metavar="A",
        help="of the command [m/s], for yaw [rad/s] (default: the paper's: 2, 2, 1, 0.2)",
    )
    parser.add_argument(
        "--duration",
        type=float,
        metavar="T",
        help="flown after the command's edge [s] (default: until each candidate has settled by "
        "the linear model, at least 5)",
    )
    add_option(
        parser,
        "--metric",
        "NAME",
        "that is drawn, and by which the best is chosen",
        "settling_time",
    )
    add_option(parser, "--method", "NAME", "grid, random, or sobol, which spreads evenly", "grid")
    add_option(parser, "--samples", "N", "of random and sobol", 256)
    add_option(parser, "--seed", "N", "of both", 0)
    parser.add_argument(
        "--margins",
        nargs="?",
        const=_OWN_LOOP,
        default="",
        metavar="LOOP",
        help="compute margins too, of the axis's own loop or of this one, as pitch",
    )
    parser.add_argument(
        "--full",
        action="store_true",
        help="fly every candidate on the full diagram, a second each, instead of the compiled one",
    )
    add_scheduler_option(parser)
    parser.add_argument(
        "--table",
        type=Path,
        metavar="FILE",
        help="the table, .csv or .parquet (default: sweep-AXIS.csv in the output folder)",
    )
    add_flight_options(parser)


def run(args: argparse.Namespace) -> int:
    """Sweep, prove the best, print it, write table and picture."""
    from workbench.commands.drawer import Drawer
    from workbench.control.controller_file import load_controller
    from workbench.control.installed_laws import DEFAULT_CONTROLLER
    from workbench.design.executor.executor import all_cores
    from workbench.design.metrics import MARGIN_METRICS, SWEPT_METRICS, find_metric
    from workbench.design.sweep.best import prove_best
    from workbench.design.sweep.case import default_axis
    from workbench.design.sweep.kept_flights import UNFINISHED_SUFFIX
    from workbench.design.sweep.table import check_table_path, write_sweep_table

    if find_metric(args.metric, SWEPT_METRICS) in MARGIN_METRICS and not args.margins:
        raise WorkbenchError(f"{args.metric} is not measured: add --margins")
    names = [text.partition("=")[0].strip() for text in args.ranges]
    args.axis = args.axis or default_axis(
        names, load_controller(args.controller or DEFAULT_CONTROLLER)
    )
    table_path = args.table or args.output / f"sweep-{args.axis}.csv"
    check_table_path(table_path)
    kept = table_path.with_name(f"{table_path.name}{UNFINISHED_SUFFIX}")
    with Outputs() as outputs, stop_on_interrupt() as stopped, ExitStack() as stack:
        log = outputs.add(table_path)
        drawer = None
        if not args.no_plots:
            plot = outputs.add(args.output / f"sweep-{args.axis}.png")
            drawer = stack.enter_context(Drawer(_SWEEP_PLOT_MODULE))
        with (
            chosen_executor(args.scheduler, all_cores()) as executor,
            progress_bar(f"sweeping {', '.join(names)}") as progress,
        ):
            table = _sweep(args, executor, progress, stopped, kept)
        if not len(table):
            raise KeyboardInterrupt  # there is nothing to write
        best = prove_best(table, args.metric)
        if drawer:
            drawer.begin(plot, _SWEEP_PLOT_MODULE, "plot_sweep", table, args.metric, best)
        write_sweep_table(table, log)
        if drawer:
            drawer.finish()
    if len(table) == table.planned:
        kept.unlink(missing_ok=True)
    shown = (table, best, args.metric)
    result = sweep_result(*shown)
    print_result(args, result, print_sweep, *shown, flown_with(args), files=outputs.files)
    if len(table) < table.planned:
        again = "; the same command flies the others" if kept.exists() else ""
        print_message(
            f"interrupted after {len(table)} of {table.planned} candidates; those are in the table"
            f"{again}"
        )
        return stopped.exit_code
    return ExitCode.DONE


def _sweep(
    args: argparse.Namespace,
    executor: "Executor",
    progress: Callable[[float], None],
    stopped: StopFlag,
    kept: Path,
) -> "SweepTable":
    """Fly the sweep from the command line."""
    from workbench.design.reproduce import PAPER_COMMANDS
    from workbench.design.sweep.case import axis_loop
    from workbench.design.sweep.compiled_flights import fly_fastest
    from workbench.design.sweep.full_flights import fly_full
    from workbench.design.sweep.sweep import sweep

    setup = chosen_setup(args)
    return sweep(
        args.ranges,
        method=args.method,
        samples=args.samples,
        seed=args.seed,
        axis=args.axis,
        amplitude=PAPER_COMMANDS[args.axis] if args.amplitude is None else args.amplitude,
        duration=args.duration,
        scenario=setup,
        loop=axis_loop(args.axis, setup.controller) if args.margins == _OWN_LOOP else args.margins,
        fly=partial(fly_full, executor=executor)
        if args.full
        else partial(fly_fastest, cluster=executor if args.scheduler else None),
        progress=progress,
        stop=stopped,
        kept=kept,
    )


def sweep_result(table: "SweepTable", best: "BestCandidate | None", metric: str) -> dict[str, Any]:
    """Return everything as JSON has it: margins in degrees, other angles in rad."""
    import numpy as np

    from workbench.design.metrics import FLOWN_METRICS
    from workbench.design.sweep.best import why_no_best

    swept = [each.name for each in table.ranges]
    measured = [each.file_name for each in table.metrics]
    factors = [each.file_factor for each in table.metrics]
    return {
        **pick(table, "vehicle method seed planned"),
        **pick(table.case, "axis amplitude duration"),
        "set": table.case.settings,
        "variation": table.case.scenario.vehicle.variation,
        "ranges": [pick(each, _RANGE_KEYS) for each in table.ranges],
        "flown": len(table),
        "diverged": int(np.isfinite(table.diverged_at).sum()),
        "metric": metric,
        "present": _named(swept, table.present) | _named(measured, table.present_values * factors),
        "no_best": "" if best else why_no_best(table, metric) or _NO_BEST_MESSAGE,
        "unmoved": table.unmoved(metric),
        "withheld": int(table.withheld.sum()),
        "missed": int(table.missed.sum()),
        "best": None
        if best is None
        else {
            "row": best.index,
            **_named(swept, best.parameters),
            **_named(measured, best.values * factors),
            "on_full_diagram": _named([each.name for each in FLOWN_METRICS], best.flown),
            "difference": _named([each.name for each in FLOWN_METRICS], best.difference),
            "refused_rows": best.refused,
            "present_is_better": table.present_is_better(metric, best.index),
        },
        "columns": dict(zip(table.file_names, table.file_units, strict=True)),
        "candidates": [_named(table.file_names, row) for row in table.file_rows],
    }


def print_sweep(
    table: "SweepTable", best: "BestCandidate | None", metric: str, flown_with: str
) -> None:
    """Print the best candidate, the present values, and its flight on the full diagram."""
    import numpy as np

    from workbench.common.quantity import display_unit
    from workbench.design.metrics import FLOWN_METRICS
    from workbench.design.sweep.best import unaffected_numbers_text, why_no_best
    from workbench.design.sweep.table import MAX_ARRIVED_ERROR_PCT
    from workbench.scenario.axes import find_axis

    case = table.case
    lost = int(np.isfinite(table.diverged_at).sum())
    unit = find_axis(case.axis).unit
    print(
        f"{len(table)} candidates, {case.axis} step of {case.amplitude:g} {unit}, "
        f"{table.vehicle} {flown_with}: {lost} diverged"
    )
    note = unaffected_numbers_text(table, metric)
    withheld = int(table.withheld.sum())
    if withheld:
        within = "" if case.duration is None else f" within {case.duration:g} s"
        hint = within and "; without --duration each flies until it settles"
        print_message(
            f"{withheld} have no numbers, as they did not settle{within} or did not begin at "
            f"rest{hint}"
        )
    if best is None:
        why = why_no_best(table, metric) or _NO_BEST_MESSAGE
        print(why)
        if note and note not in why:
            print_message(note)
        return
    flew = dict(zip((each.name for each in FLOWN_METRICS), best.flown, strict=True))
    rows = [("", "present", "best", "full diagram", "")]
    rows += [
        (
            each.name,
            f"{now:.4g}",
            "any" if each.name in best.unmoved else f"{value:.4g}",
            "",
            display_unit(each.unit).symbol,
        )
        for each, now, value in zip(table.ranges, table.present, best.parameters, strict=True)
    ]
    columns = zip(table.metrics, table.present_values, best.values, strict=True)
    units = table.units[len(table.ranges) :]
    for (each, now, value), unit in zip(columns, units, strict=False):
        checked = _text(each, flew[each.name]) if each.name in flew else ""
        rows.append(
            (
                f"{each.name} *" if each.name == metric else each.name,
                _text(each, now),
                _text(each, value),
                checked,
                display_unit(unit).symbol,
            )
        )
    print_table(rows, left=(0, 4))
    if note:
        print_message(note)
    if table.present_is_better(metric, best.index):
        print_message(
            f"the present values are better by {metric}: keep them, or sweep other ranges"
        )
    if missed := int(table.missed.sum()):
        print_message(
            f"{missed} rank last, as they settle more than {MAX_ARRIVED_ERROR_PCT:g} % from the "
            "command"
        )
    if best.refused:
        print_message(f"{len(best.refused)} that ranked before it diverged on the full diagram")
    error = best.values[[each.name for each in table.metrics].index("steady_state_error")]
    if not error <= MAX_ARRIVED_ERROR_PCT:
        print_message(f"no candidate comes within {MAX_ARRIVED_ERROR_PCT:g} % of the command")


def _named(names: Iterable[str], values: Iterable[float]) -> dict[str, float]:
    return dict(zip(names, map(float, values), strict=True))


def _text(metric: "Metric", value: float) -> str:
    from workbench.common.quantity import display_unit

    scaled = display_unit(metric.unit).factor * value
    return "—" if math.isnan(scaled) else f"{scaled:.4g}"

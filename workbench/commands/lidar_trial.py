"""`workbench lidar-trial`: the paper's trial of the lidar, flown between obstacles and judged."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.lidar_trial_text import missed_demands, print_trial, trial_result
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

if TYPE_CHECKING:
    from typing import Any

    from workbench.design.lidar_trial import TrialReport
    from workbench.scenario.scenario import Scenario

SCENARIO = "lidar-trial"


def add_parser(commands: "Any") -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "lidar-trial",
        "Fly between obstacles and judge the lidar by the paper's criteria: accuracy of distances, "
        "speed of detection, responsiveness.",
        "workbench lidar-trial --output out",
        run,
    )
    parser.add_argument(
        "--scenario",
        metavar="NAME|PATH",
        default=SCENARIO,
        help=f"fly this one, shipped or a .yaml file (default: {SCENARIO})",
    )
    parser.add_argument("--seed", type=int, metavar="N", help="of the sensors' noise")
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE",
        help="flight and cloud in 3-D, as one page that any browser plays, without a server",
    )
    add_output_options(parser)
    add_vehicle_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Fly, print the tables, write picture and log; 1 if something is not as demanded."""
    scenario = _scenario(args)
    with Outputs() as outputs:
        log = outputs.add(args.output / "lidar-trial.csv")
        plot = None if args.no_plots else outputs.add(args.output / "lidar-trial.png")
        page = outputs.add(args.html) if args.html else None
        with progress_bar("flying the trial twice") as progress:
            report = _fly(scenario, args, page, progress)
        report.flight.recording.write_csv(log)
        if plot:
            from workbench.design.plots import write_png
            from workbench.design.plots_lidar import plot_trial

            name = report.flight.recording.vehicle.name
            title = f"{name}: {scenario.title or args.scenario}"
            write_png(plot_trial(report, title), plot)
    if args.json:
        print_json(trial_result(report, scenario, outputs.files))
    else:
        print_trial(report)
    say_written(outputs.files)
    missed = missed_demands(report)
    if missed:
        say(f"not as demanded: {'; '.join(missed)}")
        return ExitCode.NOT_AS_DEMANDED
    return ExitCode.DONE


def _scenario(args: argparse.Namespace) -> "Scenario":
    """Return what the command line asks to be flown."""
    from workbench.common.resources import find_scenario
    from workbench.scenario.scenario import load_scenario

    if args.seed is not None and args.seed < 0:
        raise WorkbenchError(f"--seed is {args.seed}: give it a whole number, 0 or more")
    scenario = with_vehicle(load_scenario(find_scenario(args.scenario)), args)
    if args.seed is not None:
        scenario.sensors.seed = args.seed
    return scenario


def _fly(
    scenario: "Scenario", args: argparse.Namespace, page: Path | None, progress: "Any"
) -> "TrialReport":
    """Fly the trial; `page` is the 3-D one to write."""
    from workbench.design.lidar_trial import fly_trial

    if page is None:
        return fly_trial(scenario, dict(args.set), progress)
    from workbench.design.lidar_trial_page import fly_and_film_trial

    return fly_and_film_trial(scenario, dict(args.set), page, progress)

"""`workbench lidar-trial`: fly the lidar trial of the paper, and print its report."""

import argparse
import dataclasses
import math
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands.chosen_vehicle import chosen_scenario
from workbench.commands.options import (
    Subcommands,
    add_command,
    add_flight_options,
    add_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_result, print_table, report_unmet
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.design.lidar_accuracy import RangeErrors
    from workbench.design.lidar_trial import TrialReport
    from workbench.design.metrics import Demand
    from workbench.design.obstacle_detection import Detection
    from workbench.scenario.scenario import Scenario


_DEMAND_SCALES = {"m": (1000.0, "mm"), "s": (1000.0, "ms"), "": (1.0, "")}
"""Factor and unit to print demands, by their unit."""
TRIAL_SCENARIO = "lidar-trial"


def print_trial(report: "TrialReport") -> None:
    """Print the lidar, a table for each criterion, and the demands."""
    flight = report.flight
    lidar, vehicle = flight.lidar, flight.recording.vehicle
    print(
        f"{vehicle.name}, sensor '{lidar.name}': {lidar.vertical.samples} layers of "
        f"{lidar.horizontal.samples} rays, {lidar.min_range:g} .. {lidar.max_range:g} m, noise "
        f"{1000.0 * lidar.noise.stddev:g} mm; {len(flight.scans)} scans in "
        f"{flight.recording.time[-1]:.1f} s"
    )
    _print_accuracy(report)
    _print_detection(report)
    _print_response(report)
    print("\ndemanded")
    table = [["", "found", "at most", "", ""], *map(_demand_line, report.demands)]
    print_table(table, left=(0, 3, 4))


def _print_accuracy(report: "TrialReport") -> None:
    """Print the statistics of errors, by obstacle and over all."""
    names = [each.name for each in report.flight.obstacles]
    print("\naccuracy: measured less closed form [mm]; `exact` is flown without noise")
    heads = ["", "returns", "bias", "rmse", "95 %", "largest", "exact: largest", "missed"]
    rows = [
        [*_errors(name, errors), _mm(exact.maximum), str(missed)]
        for name, errors, exact, missed in zip(
            names,
            report.accuracy.by_obstacle,
            report.exact.by_obstacle,
            report.accuracy.missed,
            strict=True,
        )
    ]
    total = report.accuracy.total
    rows.append(
        [
            *_errors("all", total),
            _mm(report.exact.total.maximum),
            str(sum(report.accuracy.missed)),
        ]
    )
    print_table([heads, *rows])
    print(
        f"false returns: {report.accuracy.false}; rays that pass an edge within 1 mm and are not "
        f"judged: {report.accuracy.at_edges}"
    )


def _print_detection(report: "TrialReport") -> None:
    """Print the detection of each obstacle."""
    from workbench.design.obstacle_detection import slowest_detection

    print("\nspeed of detection: from coming into view to the first return delivered")
    rows = [["", "in view", "at", "first return", "at", "after"]]
    rows += [_detection_line(each) for each in report.detections]
    print_table(rows)
    bound = 1000.0 * slowest_detection(report.flight)
    print(f"bound: a scan period, the latency and a control period, {bound:.1f} ms")


def _detection_line(found: "Detection") -> list[str]:
    """Return one line of the table of detections."""
    if math.isnan(found.entered):
        return [found.obstacle, "never", "", "", "", ""]
    return [
        found.obstacle,
        "from the start" if found.from_start else f"{found.entered:.3f} s",
        f"{found.entered_distance:.2f} m",
        "never" if math.isnan(found.returned) else f"{found.returned:.3f} s",
        "" if math.isnan(found.returned) else f"{found.returned_distance:.2f} m",
        "" if math.isnan(found.returned) else f"{1000.0 * found.delay:.1f} ms",
    ]


def _print_response(report: "TrialReport") -> None:
    """Print the punctuality of scans."""
    response, flight = report.response, report.flight
    print("\nresponsiveness: age of a scan at the control update that can read it first")
    print(
        f"age: median {1000.0 * response.median_age:.1f} ms, most "
        f"{1000.0 * response.maximum_age:.1f} ms\n"
        f"on time: {response.delivered - response.late} of {response.expected} scans "
        f"({100.0 * response.share_on_time:.1f} %)\n"
        f"rate: {response.rate:.3f} Hz, where {flight.asked_rate:g} Hz is asked for"
    )
    if not math.isnan(flight.computing_time):
        print(
            f"to compute a scan takes {1000.0 * flight.computing_time:.1f} ms on this machine now"
        )
    nearest = report.clearance
    if nearest.obstacle:
        way = f"{nearest.distance:.2f} m of {nearest.obstacle} (base link, at {nearest.time:.1f} s)"
        touched = f"touched {nearest.obstacle}: it " if report.reach > 0.0 else ""
        print(f"\nthe flight {touched}came within {way}")


def trial_result(report: "TrialReport", scenario: "Scenario") -> dict[str, Any]:
    """Return the results for JSON, in SI units."""
    flight, lidar = report.flight, report.flight.lidar
    return {
        "vehicle": flight.recording.vehicle.name,
        "scenario": scenario.title,
        "world": scenario.world,
        "seed": scenario.sensors.seed,
        "duration": float(flight.recording.time[-1]),
        "lidar": {
            "name": lidar.name,
            "layers": lidar.vertical.samples,
            "steps": lidar.horizontal.samples,
            "noise": lidar.noise.stddev,
            **pick(lidar, "min_range max_range"),
            **pick(flight, "asked_rate period latency"),
        },
        "accuracy": {
            **dataclasses.asdict(report.accuracy.total),
            "without_noise": report.exact.total,
            "missed": sum(report.accuracy.missed),
            "false": report.accuracy.false,
            "at_edges": report.accuracy.at_edges,
            "displacement_by_pose": report.accuracy.displacement,
            "obstacles": [
                {"name": obstacle.name, **dataclasses.asdict(errors), "missed": missed}
                for obstacle, errors, missed in zip(
                    flight.obstacles,
                    report.accuracy.by_obstacle,
                    report.accuracy.missed,
                    strict=True,
                )
            ],
        },
        "detection": [
            {**dataclasses.asdict(each), "delay": each.delay} for each in report.detections
        ],
        "response": {
            **dataclasses.asdict(report.response),
            "share_on_time": report.response.share_on_time,
            "computing_time": flight.computing_time,
        },
        "clearance": report.clearance,
        "demands": [
            {"criterion": each.criterion, **pick(each, "quantity unit value limit met")}
            for each in report.demands
        ],
        "met": all(each.met for each in report.demands),
    }


def _sentence(demand: "Demand") -> str:
    name, value, limit, unit, _ = _demand_line(demand)
    return f"{name} is {value} {unit} (at most {limit} {unit})".replace(" )", ")").replace(
        "  ", " "
    )


def _demand_line(demand: "Demand") -> list[str]:
    """Return one line of the table of demands."""
    scale, unit = _DEMAND_SCALES[demand.unit]
    digits = ".0f" if not demand.unit else ".3f"
    return [
        f"{demand.criterion}: {demand.quantity.replace('_', ' ')}",
        format(scale * demand.value, digits),
        format(scale * demand.limit, digits),
        unit,
        "ok" if demand.met else "not ok",
    ]


def _errors(name: str, errors: "RangeErrors") -> list[str]:
    """Return the first columns of a line of the table of errors."""
    return [
        name,
        str(errors.returns),
        *map(_mm, (errors.bias, errors.rmse, errors.percentile_95, errors.maximum)),
    ]


def _mm(length: float) -> str:
    """Return a length in mm, nothing if unknown."""
    return "" if math.isnan(length) else f"{1000.0 * length:z.3f}"


def add_trial(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "lidar-trial",
        "Fly between obstacles and judge the lidar by the paper's criteria: accuracy of distances, "
        "speed of detection, responsiveness.",
        "workbench lidar-trial --output out",
        run_trial,
    )
    add_option(
        parser, "--scenario", "NAME|PATH", "fly this one, shipped or a .yaml file", TRIAL_SCENARIO
    )
    parser.add_argument("--seed", type=int, metavar="N", help="of the sensors' noise")
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE",
        help="flight and cloud in 3-D, as one page that any browser plays, without a server",
    )
    add_flight_options(parser)


def run_trial(args: argparse.Namespace) -> int:
    """Fly, print the tables, write picture and log; 1 if something is not as demanded."""
    scenario = _scenario(args)
    with Outputs() as outputs:
        log = outputs.add(args.output / "lidar-trial.csv")
        plot = outputs.picture(args, "lidar-trial.png")
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
    print_result(args, trial_result(report, scenario), print_trial, report, files=outputs.files)
    return report_unmet([_sentence(demand) for demand in report.demands if not demand.met])


def _scenario(args: argparse.Namespace) -> "Scenario":
    """Return the scenario from the command line."""
    from workbench.common.resources import find_scenario
    from workbench.scenario.scenario_file import load_scenario

    if args.seed is not None and args.seed < 0:
        raise WorkbenchError(f"--seed is {args.seed}: give it a whole number, 0 or more")
    scenario = load_scenario(find_scenario(args.scenario), args.controller, args.estimator)
    scenario = chosen_scenario(args, scenario)
    if args.seed is not None:
        scenario.sensors.seed = args.seed
    return scenario


def _fly(
    scenario: "Scenario", args: argparse.Namespace, page: Path | None, progress: "Any"
) -> "TrialReport":
    """Fly the trial; `page` is the 3-D page to write."""
    from workbench.design.lidar_trial import fly_trial

    if page is None:
        return fly_trial(scenario, dict(args.set), progress)
    from workbench.design.plots_lidar import fly_and_film_trial

    return fly_and_film_trial(scenario, dict(args.set), page, progress)

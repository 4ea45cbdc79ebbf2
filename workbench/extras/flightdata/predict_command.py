"""Predictions of logged flights: `workbench predict` and `what-if`."""

import argparse
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_model
from workbench.commands.options import (
    LAW_NAMES,
    LOG_HELP,
    MODEL_HELP,
    Subcommands,
    add_command,
    add_json_option,
    add_log_options,
    add_model_options,
    add_output_options,
    add_repeated,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    pick,
    print_message,
    print_remarks,
    print_result,
    print_table,
    remark_rows,
)
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.resources import existing_path, find_file
from workbench.parameters.parameter_table import split_setting

if TYPE_CHECKING:
    from workbench.common.flight import Flight
    from workbench.control.controller import Controller
    from workbench.extras.flightdata.predict.motion import LoggedMotion
    from workbench.extras.flightdata.predict.prediction import FlightPrediction, Predictor
    from workbench.extras.flightdata.predict.prediction_summary import Summary
    from workbench.plant.vehicle import Vehicle


DEFAULT_LOG_LAW = "crazyflie"
"""Default law for logs that do not state it."""
PREDICTION_EFFECTS = ("thrust", "memory", "moment", "estimate", "tilt")


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "predict",
        "Predict logged flights from many of their instants, with a model and a control law that "
        "fly from the logged setpoints, and report the errors beside those of simple predictions.",
        "workbench predict flights/ --model my_quad.urdf --horizon 0.5",
        run,
    )
    parser.add_argument(
        "logs", nargs="+", type=Path, metavar="LOG", help=f"{LOG_HELP}; or a folder of logs"
    )
    add_model_options(parser, f"the drone: {MODEL_HELP}", required=True)
    parser.add_argument(
        "--controller",
        metavar="NAME|FILE",
        default="",
        help=f"control law that flew: {LAW_NAMES}, or a .py file of your "
        f"own, which runs (default: what the log says, or {DEFAULT_LOG_LAW})",
    )
    parser.add_argument("--gains", metavar="FILE", default="", help="gain file (YAML) of the law")
    add_repeated(
        parser,
        "--set",
        "NAME=VALUE",
        split_setting,
        "value of one of the law's gains; may be repeated",
    )
    parser.add_argument(
        "--horizon", type=float, default=0.5, metavar="S", help="how far ahead (default: 0.5 s)"
    )
    parser.add_argument(
        "--every", type=float, default=0.1, metavar="S", help="between two starts (default: 0.1 s)"
    )
    add_repeated(
        parser,
        "--without",
        "EFFECT",
        str,
        "knowledge of the past to leave out, to see its effect: thrust (its scale and level "
        "force), memory (of the law), moment (of the air, held by the law), estimate (its error at "
        "the start), tilt (that it goes on to take drag for tilt); may be repeated",
    )
    add_log_options(parser)
    add_output_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Read the flights, predict them, print and draw the errors."""
    from workbench.common.resources import find_model

    if not (0.02 <= args.horizon <= 60.0 and 0.01 <= args.every <= 60.0):
        raise WorkbenchError("--horizon and --every are seconds, from 0.02 and 0.01 up to 60")
    for name in args.without:
        if name not in PREDICTION_EFFECTS:
            raise unknown_name("effect", name, PREDICTION_EFFECTS)
    find_model(args.model)
    for name in filter(None, (args.rotors, args.gains)):
        find_file(name)
    paths = found_logs(args.logs)
    with Outputs() as outputs:
        table = outputs.add(args.output / "predict.csv")
        picture = outputs.picture(args, "predict.png")
        vehicle = read_vehicle(args)
        records, motions = _motions(paths, args, vehicle)
        predictors = {law: predictor(vehicle, law, args) for law, _ in motions}
        _print_doubts(vehicle, predictors, motions)
        predictions = _predicted(predictors, motions, args)
        from workbench.extras.flightdata.predict.prediction_summary import summarized

        summary = summarized(predictions)
        _write(predictions, table)
        if picture:
            from workbench.design.plots import write_png
            from workbench.extras.flightdata.predict.plots_predict import plot_predictions

            title = f"{vehicle.name}: {summary.flights} flights, {summary.windows} predictions"
            write_png(plot_predictions(predictions, title), picture)
    said = _predictions_as_json(args, predictions, summary) | {"remarks": remark_rows(records)}
    print_result(args, said, print_summary, summary, files=outputs.files)
    return ExitCode.DONE


def found_logs(paths: Sequence[Path]) -> list[Path]:
    """Return logs, including those in folders.

    Raises:
        WorkbenchError: if a folder has none.
    """
    from workbench.logs.readers.log_reader import log_endings

    found: list[Path] = []
    endings = log_endings()
    for path in paths:
        there = existing_path(str(path))
        if there is None or there.is_file():
            found.append(path)
            continue
        inside = sorted(p for p in path.iterdir() if p.name.lower().endswith(endings))
        inside = [p for p in inside if p.name != "index.csv"]
        if not inside:
            raise WorkbenchError(f"{path}: this folder has no logs: name logs, or their folder")
        found += inside
    return found


def read_vehicle(args: argparse.Namespace) -> "Vehicle":
    """Return the vehicle from the command line."""
    from workbench.plant.loading import make_vehicle
    from workbench.scenario.configured import log_remarks, read_configured

    description = read_configured(chosen_model(args))
    vehicle = make_vehicle(description)
    log_remarks(description, vehicle)
    return vehicle


def check_gains(names: Iterable[str], law: "Controller") -> None:
    """Check that names are gains of a law.

    Raises:
        WorkbenchError: if a name is unknown; it suggests a similar one.
    """
    own, table = {row.name for row in law.parameters}, law.table
    for name in names:
        if name not in table or any(row.name not in own for row in table.sets(name)):
            raise unknown_name(f"parameter of {law.name}", name, own)


def predictor(vehicle: "Vehicle", law: str, args: argparse.Namespace) -> "Predictor":
    """Return the predictor for a law."""
    from workbench.control.controller_file import load_controller
    from workbench.extras.flightdata.predict.flown import DEFAULT_LAW_PERIOD_S
    from workbench.extras.flightdata.predict.past import ALL_EFFECTS
    from workbench.extras.flightdata.predict.prediction import Predictor
    from workbench.gains.gain_choice import flight_gains

    controller = load_controller(law)
    check_gains(dict(args.set), controller)
    gains = flight_gains(vehicle, args.gains, dict(args.set), controller)
    effects = ALL_EFFECTS._replace(**dict.fromkeys(args.without, False))
    return Predictor(
        vehicle, controller, dict(gains), controller.period or DEFAULT_LAW_PERIOD_S, None, effects
    )


def _motions(
    paths: Sequence[Path], args: argparse.Namespace, vehicle: "Vehicle"
) -> tuple[list["Flight"], list[tuple[str, "LoggedMotion"]]]:
    """Return the flights, and the law and motion of each."""
    from workbench.extras.flightdata.predict.logged import flown_law_name, motion_of
    from workbench.logs.flight_reader import read_flight

    records: list[Flight] = []
    found: list[tuple[str, LoggedMotion]] = []
    left_out: list[WorkbenchError] = []
    with progress_bar("reading logs") as progress:
        for number, path in enumerate(paths):
            try:
                flight = read_flight(path, args.mapping, log_number=args.log_number)
                print_remarks(flight)
                law = args.controller or flown_law_name(flight) or DEFAULT_LOG_LAW
                found.append((law, motion_of(flight, vehicle)))
                records.append(flight)
            except WorkbenchError as error:
                left_out.append(error)
            progress((number + 1) / len(paths))
    if not found:
        raise left_out[0]
    for each in left_out:
        print_message(f"left out: {each}")
    return records, found


def _print_doubts(
    vehicle: "Vehicle",
    predictors: dict[str, "Predictor"],
    motions: list[tuple[str, "LoggedMotion"]],
) -> None:
    """Print why predictions may be wrong: the first log of each reason, and how many there are."""
    from workbench.extras.flightdata.predict.past import thrust_doubt, voltage_doubt

    for texts in (
        [thrust_doubt(motion, vehicle) for _, motion in motions],
        [voltage_doubt(motion, predictors[law].gains) for law, motion in motions],
    ):
        doubts = list(filter(None, texts))
        for doubt in doubts[:1]:  # it is the same drone for all
            print_message(f"{doubt} ({len(doubts)} of {len(motions)} logs)")


def _predicted(
    predictors: dict[str, "Predictor"],
    motions: list[tuple[str, "LoggedMotion"]],
    args: argparse.Namespace,
) -> "list[FlightPrediction]":
    from workbench.extras.flightdata.predict.prediction import predict_flights

    with progress_bar("predicting") as progress:
        found = predict_flights(predictors, motions, args.horizon, args.every, progress)
    flown = {each.flight for each in found}
    short = [motion.name for _, motion in motions if motion.name not in flown]
    if short:
        print_message(
            f"left out, as they are in the air for less time than a prediction: {', '.join(short)}"
        )
    if not found:
        raise WorkbenchError("all of these flights are in the air for less time than a prediction")
    return found


def print_summary(summary: "Summary") -> None:
    """Print errors of the methods, and of whole flights."""
    print(
        f"{summary.flights} flights, {summary.windows} predictions, RMS errors "
        f"{summary.horizon:g} s ahead"
    )
    rows: list[tuple[str, ...]] = [("", "position [m]", "velocity [m/s]", "attitude [deg]")]
    for row in summary.methods:
        numbers = (
            f"{value:.{digits}f}" if math.isfinite(value) else "-"
            for value, digits in (
                (row.position, 4),
                (row.velocity, 4),
                (math.degrees(row.attitude), 2),
            )
        )
        rows.append((row.method, *numbers))
    print_table(rows)
    lag = summary.lag_difference  # not known if no setpoint moves
    told = f"; lag {1000.0 * lag:+.0f} ms" if math.isfinite(lag) else ""
    print(
        f"whole flights from setpoints: {summary.whole:.3f} m RMSE (median), the setpoint, late "
        f"{summary.whole_late:.3f} m{told}"
    )


def _predictions_as_json(
    args: argparse.Namespace, predictions: "list[FlightPrediction]", summary: "Summary"
) -> dict[str, Any]:
    from workbench.extras.flightdata.predict.prediction_summary import rms

    flights = [
        {
            "flight": each.flight,
            "windows": len(each.starts),
            "whole": pick(each.whole, "rmse late_rmse lags real_lags"),
            "methods": {
                errors.method: {"ahead": errors.ahead.tolist()}
                | {
                    name: [rms(column) for column in values.T]
                    for name, values in pick(errors, "position velocity attitude").items()
                }
                for errors in each.errors
            },
        }
        for each in predictions
    ]
    return {"model": args.model, "without": args.without, "summary": summary, "flights": flights}


def _write(predictions: "list[FlightPrediction]", path: Path) -> None:
    """Write a row for each prediction: flight, start, and errors of each method at the horizon."""
    import csv

    methods = [errors.method for errors in predictions[0].errors]
    fields = ("position [m]", "velocity [m/s]", "attitude [rad]")
    lines = [["flight", "start [s]", *(f"{m}: {f}" for m in methods for f in fields)]]
    for each in predictions:
        for number, start in enumerate(each.starts):
            errors = [
                f"{values[number, -1]:.6g}"
                for method in each.errors
                for values in (method.position, method.velocity, method.attitude)
            ]
            lines.append([each.flight, f"{start:.3f}", *errors])
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows(lines)

"""Predictions of logged flights: `workbench predict` and `what-if`."""

import argparse
import math
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    MODEL_HELP,
    add_command,
    add_json_option,
    add_log_options,
    add_model_options,
    add_option,
    add_output_options,
    add_repeated,
    chosen_model,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    pick,
    print_remarks,
    print_result,
    print_table,
    remark_rows,
    say,
)
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError, unknown_name
from workbench.common.plain_text import file_stem
from workbench.common.resources import existing, find_file
from workbench.control.controller import SHIPPED
from workbench.scenario.parameters import split_setting

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.design.predict.motion import Motion
    from workbench.design.predict.prediction import Prediction, Predictor, Summary
    from workbench.design.predict.what_if import Law, WhatIf
    from workbench.logs.flight_record import FlightRecord
    from workbench.plant.vehicle import Vehicle


DEFAULT = "crazyflie"
"""Default law for logs that do not state it."""
EFFECTS = ("thrust", "memory", "moment", "estimate", "tilt")
MOST_DRAWS = 1000


def add_parser(commands: Any) -> None:
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
        help=f"control law that flew: {', '.join(SHIPPED)}, or a .py file of your own, which runs "
        f"(default: what the log says, or {DEFAULT})",
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
    from workbench.common.resources import find_file, find_model

    if not (0.02 <= args.horizon <= 60.0 and 0.01 <= args.every <= 60.0):
        raise WorkbenchError("--horizon and --every are seconds, from 0.02 and 0.01 up to 60")
    for name in args.without:
        if name not in EFFECTS:
            raise unknown_name("effect", name, EFFECTS)
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
        predictions = _predicted(predictors, motions, args)
        from workbench.design.predict.prediction import summarized

        summary = summarized(predictions)
        _write(predictions, table)
        if picture:
            from workbench.design.plots import write_png
            from workbench.design.plots_predict import plot_predictions

            title = f"{vehicle.name}: {summary.flights} flights, {summary.windows} predictions"
            write_png(plot_predictions(predictions, title), picture)
    said = _said(args, predictions, summary) | {"remarks": remark_rows(records)}
    print_result(args, said, print_summary, summary, files=outputs.files)
    return ExitCode.DONE


def found_logs(paths: Sequence[Path]) -> list[Path]:
    """Return logs, including those in folders.

    Raises:
        WorkbenchError: if a folder has none.
    """
    from workbench.logs.flight_record import LOG_ENDINGS

    found: list[Path] = []
    for path in paths:
        there = existing(str(path))
        if there is None or there.is_file():
            found.append(path)
            continue
        inside = sorted(p for p in path.iterdir() if p.name.lower().endswith(LOG_ENDINGS))
        inside = [p for p in inside if p.name != "index.csv"]
        if not inside:
            raise WorkbenchError(f"{path}: this folder has no logs: name logs, or their folder")
        found += inside
    return found


def read_vehicle(args: argparse.Namespace) -> "Vehicle":
    """Return the vehicle from the command line."""
    from workbench.plant.loading import make_vehicle
    from workbench.scenario.configured import read_configured, tell_remarks

    description = read_configured(chosen_model(args))
    vehicle = make_vehicle(description)
    tell_remarks(description, vehicle)
    return vehicle


def check_gains(names: Iterable[str], law: "Controller") -> None:
    """Check that names are gains of a law.

    Raises:
        WorkbenchError: if a name is unknown; it suggests a similar one.
    """
    from workbench.scenario.parameters import parameter_table

    own, table = {row.name for row in law.parameters}, parameter_table(law)
    for name in names:
        if name not in table or any(row.name not in own for row in table.sets(name)):
            raise unknown_name(f"gain of {law.name}", name, own)


def predictor(vehicle: "Vehicle", law: str, args: argparse.Namespace) -> "Predictor":
    """Return the predictor for a law."""
    from workbench.control.controller import load_controller
    from workbench.design.predict.flown import PERIOD
    from workbench.design.predict.past import ALL
    from workbench.design.predict.prediction import Predictor
    from workbench.gains.gains import flight_gains

    controller = load_controller(law)
    check_gains(dict(args.set), controller)
    gains = flight_gains(vehicle, args.gains, dict(args.set), controller)
    effects = ALL._replace(**dict.fromkeys(args.without, False))
    return Predictor(vehicle, controller, dict(gains), controller.period or PERIOD, None, effects)


def _motions(
    paths: Sequence[Path], args: argparse.Namespace, vehicle: "Vehicle"
) -> tuple[list["FlightRecord"], list[tuple[str, "Motion"]]]:
    """Return the flights, and the law and motion of each."""
    from workbench.design.predict.past import thrust_doubt
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.motion import law_name, motion_of

    records: list[FlightRecord] = []
    found: list[tuple[str, Motion]] = []
    left_out: list[WorkbenchError] = []
    with progress_bar("reading logs") as progress:
        for number, path in enumerate(paths):
            try:
                flight = read_flight(path, args.mapping, log_number=args.log_number)
                print_remarks(flight)
                law = args.controller or law_name(flight) or DEFAULT
                found.append((law, motion_of(flight, vehicle)))
                records.append(flight)
            except WorkbenchError as error:
                left_out.append(error)
            progress((number + 1) / len(paths))
    if not found:
        raise left_out[0]
    for each in left_out:
        say(f"left out: {each}")
    doubts = list(filter(None, (thrust_doubt(motion, vehicle) for _, motion in found)))
    for doubt in doubts[:1]:  # it is the same drone for all
        say(f"{doubt} ({len(doubts)} of {len(found)} logs)")
    return records, found


def _predicted(
    predictors: dict[str, "Predictor"],
    motions: list[tuple[str, "Motion"]],
    args: argparse.Namespace,
) -> "list[Prediction]":
    from workbench.design.predict.prediction import predict_flights

    with progress_bar("predicting") as progress:
        found = predict_flights(predictors, motions, args.horizon, args.every, progress)
    flown = {each.flight for each in found}
    short = [motion.name for _, motion in motions if motion.name not in flown]
    if short:
        say(f"left out, as they are in the air for less time than a prediction: {', '.join(short)}")
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
    print(
        f"whole flights from setpoints: {summary.whole:.3f} m RMSE (median), the setpoint, late "
        f"{summary.whole_late:.3f} m; lag {1000.0 * summary.lag_difference:+.0f} ms"
    )


def _said(
    args: argparse.Namespace, predictions: "list[Prediction]", summary: "Summary"
) -> dict[str, Any]:
    from workbench.design.predict.prediction import rms

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


def _write(predictions: "list[Prediction]", path: Path) -> None:
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


def add_what_if(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "what-if",
        "Fly a logged flight again with other gains or another law. What the model cannot explain "
        "acts again as a disturbance, and a band shows the uncertainty.",
        "workbench what-if flight.mcap --model my_quad.urdf --set kp_velocity_x=2",
        run_what_if,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    add_model_options(parser, f"the drone: {MODEL_HELP}", required=True)
    parser.add_argument(
        "--flown",
        metavar="NAME|FILE",
        default="",
        help=f"control law that flew (default: what the log says, or {DEFAULT})",
    )
    parser.add_argument(
        "--controller",
        metavar="NAME|FILE",
        default="",
        help=f"law that is flown instead: {', '.join(SHIPPED)}, or a .py file of your own, which "
        "runs (default: the one that flew)",
    )
    parser.add_argument(
        "--gains", metavar="FILE", default="", help="gain file (YAML) that is flown instead"
    )
    add_repeated(
        parser, "--set", "NAME=VALUE", split_setting, "gain that is flown instead; may be repeated"
    )
    add_option(parser, "--draws", "N", "vehicles that are sampled for the band", 40)
    parser.add_argument("--seed", type=int, default=0, help="of the sample (default: 0)")
    add_log_options(parser)
    add_output_options(parser)
    add_json_option(parser)


def run_what_if(args: argparse.Namespace) -> int:
    """Read the flight, fly it again, print and draw the difference."""
    from workbench.common.resources import find_model
    from workbench.design.predict.what_if import Explained
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.motion import motion_of

    if not 2 <= args.draws <= MOST_DRAWS:
        raise WorkbenchError(f"--draws is {args.draws}: sample 2 to {MOST_DRAWS} vehicles")
    find_model(args.model)
    for name in filter(None, (args.rotors, args.gains)):
        find_file(name)
    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress, args.log_number)
    print_remarks(flight)
    with Outputs() as outputs:
        table = outputs.add(args.output / f"{file_stem(flight.name)}-what-if.csv")
        picture = outputs.picture(args, f"{file_stem(flight.name)}-what-if.png")
        vehicle = read_vehicle(args)
        flown, other = _laws(args, flight, vehicle)
        flights = []
        with progress_bar(f"flying {flight.name} again") as progress:
            motion = motion_of(flight, vehicle)
            explained = Explained(motion, vehicle, flown, draws=args.draws, seed=args.seed)
            for states in explained.flights(other):
                flights.append(states)
                progress(len(flights) / explained.drawn)
            found = explained.compare(flights)
        _write_what_if(found, table)
        if picture:
            from workbench.design.plots import write_png
            from workbench.design.plots_predict import plot_what_if

            title = f"{flight.name}: {other.controller.name} {_changed(args)}".strip()
            write_png(plot_what_if(found, title), picture)
    if explained.doubt:
        say(explained.doubt)
    if found.lost:
        say(f"{found.lost} of {found.drawn} sampled vehicles do not stay in the air with it")
    rows = _rows(found)
    result = {
        "log": args.log,
        "flown": flown.controller.name,
        "other": other.controller.name,
        "gains": {k: v for k, v in other.gains.items() if flown.gains.get(k) != v},
        "seconds": found.time[-1] - found.time[0],
        **pick(found, "lost drawn"),
        "difference": rows,
        "remarks": remark_rows([flight]),
    }
    print_result(args, result, _print_what_if, found, rows, files=outputs.files)
    return ExitCode.DONE


def _laws(
    args: argparse.Namespace, flight: "FlightRecord", vehicle: "Vehicle"
) -> "tuple[Law, Law]":
    """Return the law that flew, with the gains known from the log, and the other one."""
    from workbench.control.controller import load_controller
    from workbench.design.predict.what_if import Law
    from workbench.gains.gains import flight_gains, load_gains
    from workbench.logs.motion import flown_law, law_name
    from workbench.scenario.parameters import parameter_table

    name = args.flown or law_name(flight) or DEFAULT
    flown = flown_law(flight, vehicle, name)
    if args.controller and args.controller != name:
        other = load_controller(args.controller)
        check_gains(dict(args.set), other)
        return flown, Law(other, flight_gains(vehicle, args.gains, dict(args.set), other))
    controller, changed = flown.controller, dict(flown.gains)
    check_gains(dict(args.set), controller)
    if args.gains:
        changed |= load_gains(find_file(args.gains), controller).gains
    changed |= parameter_table(controller).checked(dict(args.set))
    return flown, Law(controller, changed)


def _changed(args: argparse.Namespace) -> str:
    return " ".join(f"{name}={value:g}" for name, value in args.set)


def _rows(found: "WhatIf") -> list[dict[str, float | str]]:
    """Return the difference from the log along each axis, and the width of the band [m, m/s].

    For positions it also has the deviations of log and other flight from the setpoint.
    """
    import numpy as np

    names = ("x", "y", "z", "v_x", "v_y", "v_z")
    rows: list[dict[str, float | str]] = [
        {
            "signal": name,
            "unit": "m" if index < 3 else "m/s",
            "rms": float(np.sqrt(np.mean(found.difference[:, index] ** 2))),
            "largest": float(np.abs(found.difference[:, index]).max()),
            "band": float(np.mean(found.high[:, index] - found.low[:, index])),
        }
        for index, name in enumerate(names)
    ]
    for row, before, after in zip(rows, *found.off_setpoint.tolist(), strict=False):
        row |= {"off_setpoint_before": before, "off_setpoint_after": after}
    return rows


def _print_what_if(found: "WhatIf", rows: list[dict[str, float | str]]) -> None:
    print(f"{found.flight}: {found.time[-1] - found.time[0]:.2f} s, other flight less the log")
    columns = ("rms", "largest", "band", "off_setpoint_before", "off_setpoint_after")
    table: list[tuple[str, ...]] = [
        ("", "RMS", "largest", "band", "off the setpoint: log", "other", "")
    ]
    table += [
        (
            str(row["signal"]),
            *(f"{row[name]:.4f}" if name in row else "-" for name in columns),
            str(row["unit"]),
        )
        for row in rows
    ]
    print_table(table, left=(0, 6))


def _write_what_if(found: "WhatIf", path: Path) -> None:
    """Write log, other flight, band and disturbance, with a row for each update."""
    import csv

    names = ("x [m]", "y [m]", "z [m]", "v_x [m/s]", "v_y [m/s]", "v_z [m/s]")
    pushes = ("f_x [N]", "f_y [N]", "f_z [N]", "m_x [N*m]", "m_y [N*m]", "m_z [N*m]")
    heads = [f"{of}.{name}" for of in ("logged", "other", "low", "high") for name in names]
    places = [4, 5, 6, 10, 11, 12]
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["t [s]", *heads, *(f"disturbance.{name}" for name in pushes)])
        for k, time in enumerate(found.time):
            parts = (found.logged[k, places], found.other[k, places], found.low[k], found.high[k])
            numbers = [value for part in (*parts, found.disturbance[k]) for value in part]
            writer.writerow([f"{time:.6f}", *(f"{value:.7g}" for value in numbers)])

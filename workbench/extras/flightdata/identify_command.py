"""Identify a vehicle from its logs: `workbench identify`, and `excite` to plan flights for it."""

import argparse
import shlex
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.chosen_vehicle import chosen_model
from workbench.commands.options import (
    LOG_HELP,
    MODEL_HELP,
    Subcommands,
    add_command,
    add_controller_option,
    add_json_option,
    add_log_options,
    add_model_options,
    add_option,
    add_order_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import (
    print_message,
    print_remarks,
    print_result,
    print_table,
    remark_rows,
)
from workbench.commands.progress import progress_bar
from workbench.commands.stopping import stop_on_interrupt
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import file_stem
from workbench.extras.flightdata.predict_command import found_logs

if TYPE_CHECKING:
    import numpy as np

    from workbench.common.flight import Flight
    from workbench.extras.flightdata.identify.report import IdentificationReport
    from workbench.extras.flightdata.identify.trim import RotorTrim
    from workbench.plant.vehicle import Vehicle


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "identify",
        "Estimate a vehicle's thrust, lag, inertia and drag from logs of its flights, each with "
        "its interval, and write a sidecar with rotors and body.",
        "workbench identify flight.csv --model dh_drone --sidecar flown.rotors.yaml",
        run,
    )
    parser.add_argument(
        "logs", nargs="+", type=Path, metavar="LOG", help=f"{LOG_HELP}; or a folder of logs"
    )
    model_help = f"{MODEL_HELP}: geometry and mass are taken from it"
    add_model_options(parser, model_help, required=True)
    parser.add_argument(
        "--mass", type=float, metavar="KG", help="as weighed (default: the description's)"
    )
    add_order_option(parser)
    for name, what in (("accel", "accelerometer"), ("gyro", "gyro")):
        parser.add_argument(
            f"--{name}-lowpass",
            type=float,
            metavar="HZ",
            help=f"cut-off of the {what}'s low-pass of second order, 0 for none (default: the "
            "firmware's where it is known)",
        )
    parser.add_argument(
        "--sidecar",
        type=Path,
        metavar="FILE",
        help="where to write the sidecar, for --rotors (default: DIR/MODEL.rotors.yaml)",
    )
    add_option(parser, "--output", "DIR", "folder for sidecar and picture", Path("out"))
    parser.add_argument("--no-plots", action="store_true", help="write the sidecar only")
    add_log_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Identify, print, and write sidecar and picture."""
    from workbench.extras.flightdata.identify.measured import has_imu
    from workbench.logs.flight_reader import read_flight

    vehicle = _vehicle(args)
    args.logs = found_logs(args.logs)
    records = []
    for path in args.logs:
        with progress_bar(f"reading {path.name}") as progress:
            records.append(read_flight(path, args.mapping, progress, args.log_number))
        print_remarks(records[-1])
    blind = [record for record in records if not has_imu(record)]
    if blind:
        return _report_trims(args, vehicle, records)
    trims = _trims(vehicle, records, args.order)
    report = _identified(args, vehicle, records)
    with Outputs() as outputs:
        sidecar = args.sidecar or args.output / f"{file_stem(vehicle.name)}.rotors.yaml"
        outputs.add(sidecar).write_text(report.sidecar, encoding="utf-8")
        if not args.no_plots:
            from workbench.extras.flightdata.identify.plots_identified import draw_identified

            print_message("drawing")
            draw_identified(
                report, outputs.add(args.output / f"{file_stem(vehicle.name)}-identified.png")
            )
    result = report.as_dictionary() | {"trim": trims, "remarks": remark_rows(records)}
    print_result(args, result, _print, report, trims, files=outputs.files)
    return ExitCode.DONE


def _vehicle(args: argparse.Namespace) -> "Vehicle":
    import dataclasses
    import math

    from workbench.scenario.configured import configured_vehicle

    if args.mass is not None and not 0.0 < args.mass < math.inf:
        raise WorkbenchError(f"the mass is {args.mass:g} kg: give a positive number")
    vehicle = configured_vehicle(chosen_model(args))
    return dataclasses.replace(vehicle, mass=args.mass) if args.mass else vehicle


def _identified(
    args: argparse.Namespace, vehicle: "Vehicle", records: "list[Flight]"
) -> "IdentificationReport":
    from workbench.extras.flightdata.identify.measured import measured_flight
    from workbench.extras.flightdata.identify.report import make_report

    flights = [
        measured_flight(
            record, len(vehicle.rotors), args.order, args.accel_lowpass, args.gyro_lowpass
        )
        for record in records
    ]
    with (
        stop_on_interrupt(keeps="the best so far") as stopped,
        progress_bar("identifying") as progress,
    ):
        return make_report(vehicle, flights, args.logs, progress, stopped)


def _hover_commands(
    vehicle: "Vehicle", record: "Flight", order: list[int]
) -> "tuple[np.ndarray, np.ndarray, float]":
    """Return times and motor commands of a log, and the exponent of thrust over them."""
    from workbench.extras.flightdata.identify.trim import SHARE_THRUST_EXPONENT
    from workbench.logs.motor_commands import ROTOR_SPEED_COMMANDS, motor_commands

    time, commands, kind = motor_commands(record, len(vehicle.rotors), order)
    return time, commands, 2.0 if kind == ROTOR_SPEED_COMMANDS else SHARE_THRUST_EXPONENT


def _trims(vehicle: "Vehicle", records: "list[Flight]", order: list[int]) -> "list[RotorTrim]":
    """Return the state of rotors in the hover of the first log, or nothing if unknown."""
    from workbench.extras.flightdata.identify.trim import trim

    commands = _hover_commands(vehicle, records[0], order)
    try:
        return trim(vehicle, *commands)
    except WorkbenchError as reason:
        print_message(f"single rotors are not judged: {reason}")
        return []


def _report_trims(args: argparse.Namespace, vehicle: "Vehicle", records: "list[Flight]") -> int:
    """Report only on rotors, for logs without an IMU."""
    from workbench.extras.flightdata.identify.trim import trim

    told = []
    for record in records:
        commands = _hover_commands(vehicle, record, args.order)
        try:
            told.append((record, trim(vehicle, *commands)))
        except WorkbenchError as error:
            raise WorkbenchError(f"{record.source}: {error}") from None
    reason = "the log has no gyro and accelerometer: it shows only the rotors' shares in hover"
    result = [
        {"log": record.source, "refused": {"all else": reason}, "trim": rows}
        for record, rows in told
    ]
    print_result(args, result, _print_trims, told, reason)
    return ExitCode.DONE


def _print_trims(told: "list[tuple[Flight, list[RotorTrim]]]", reason: str) -> None:
    """Print the rotors of each log."""
    print_message(reason)
    for record, rows in told:
        print(record.name)
        table = [["  rotor", "thrust over mean", "over that across", "pair over others"]]
        for row in rows:
            shares = (row.share, row.over_opposite, row.pair_over_others)
            table.append([f"  {row.name}", *(f"{share:.2f}" for share in shares)])
        print_table(table)
        _print_findings(rows)


def _print_findings(rows: "list[RotorTrim]") -> None:
    findings = [row for row in rows if row.finding]
    for row in findings:
        print(f"  {row.name}: {row.finding}")
    if findings:
        print("  some normal drones differ as much: look at the rotor and the place of the battery")
    if rows and not findings:
        print("  no rotor stands out")


def _print(report: "IdentificationReport", trims: "list[RotorTrim]") -> None:
    """Print the table, and remarks on it."""
    from workbench.extras.flightdata.identify.identified_number import (
        NOT_DETERMINED,
        NOT_ENOUGH_MOTION,
        ROUGHLY_KNOWN,
    )

    print(f"{report.vehicle.name}, {report.seconds:.0f} s of free flight, intervals of 95 %")
    table = [["", "value", "from", "to", "described", "unit", ""]]
    for row in report.rows:
        numbers = (row.value, row.low, row.high, row.described)
        narrowed = row.verdict in (ROUGHLY_KNOWN, NOT_DETERMINED, NOT_ENOUGH_MOTION)
        verdict = f"{row.verdict}: fly {row.flight}" if narrowed else row.verdict
        cells = ("-" if number is None else f"{number:.4g}" for number in numbers)
        table.append([row.name, *cells, row.unit, verdict])
    print_table(table, left=(0, 5, 6))
    for sentence in report.sentences:
        print(sentence)
    _print_findings(trims)


def add_excite(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "excite",
        "Write the flight that identifies a vehicle best, as a scenario: sweeps of doublets on "
        "throttle, roll, pitch and yaw within limits.",
        "workbench excite --model dh_drone --save excite.yaml",
        run_excite,
    )
    add_model_options(parser, default="dh_drone")
    add_controller_option(parser)
    add_option(parser, "--duration", "T", "of the flight [s]", 60.0)
    parser.add_argument("--speed", type=float, metavar="V", help="largest level speed [m/s]")
    parser.add_argument("--climb", type=float, metavar="V", help="largest climb rate [m/s]")
    parser.add_argument("--yaw-rate", type=float, metavar="W", help="largest yaw rate [rad/s]")
    add_option(parser, "--save", "FILE", "scenario to write", Path("excite.yaml"))
    add_json_option(parser)


def run_excite(args: argparse.Namespace) -> int:
    """Plan and write."""
    from workbench.control.controller_file import load_controller
    from workbench.extras.flightdata.identify.flight import PlanLimits, excitation, usual_limits
    from workbench.scenario.configured import configured_vehicle
    from workbench.scenario.scenario_file import save_scenario

    if args.controller:
        load_controller(args.controller)
    config = chosen_model(args)
    vehicle = configured_vehicle(config)
    usual = usual_limits(vehicle)
    limits = PlanLimits(
        usual.speed if args.speed is None else args.speed,
        usual.climb if args.climb is None else args.climb,
        usual.yaw_rate if args.yaw_rate is None else args.yaw_rate,
    )
    scenario = excitation(vehicle, args.model, limits, args.duration, args.controller)
    scenario.vehicle = config
    with Outputs() as outputs:
        save_scenario(scenario, outputs.add(args.save))
    name = shlex.quote(str(args.save))
    text = (
        f"{scenario.duration:g} s within {limits.speed:g} m/s, climb {limits.climb:.2g} m/s, "
        f"yaw {limits.yaw_rate:g} rad/s; fly it: workbench fly {name} --csv flight.csv"
    )
    result = {"duration": scenario.duration, "limits": limits, "file": args.save}
    print_result(args, result, print, text, files=outputs.files)
    return ExitCode.DONE

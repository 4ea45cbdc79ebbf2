"""`workbench what-if`: what a flight would have been with other gains, another law or vehicle."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.options import (
    LAW_NAMES,
    LOG_HELP,
    MODEL_HELP,
    Subcommands,
    add_command,
    add_json_option,
    add_log_options,
    add_model_options,
    add_option,
    add_output_options,
    add_repeated,
    read_asked_flight,
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
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import file_stem
from workbench.common.resources import find_file
from workbench.extras.flightdata.predict_command import DEFAULT_LOG_LAW, check_gains, read_vehicle
from workbench.parameters.parameter_table import split_setting

if TYPE_CHECKING:
    from workbench.common.flight import Flight
    from workbench.extras.flightdata.predict.what_if import Law, WhatIf
    from workbench.plant.vehicle import Vehicle


MAX_WHAT_IF_DRAWS = 1000


def add_what_if(commands: Subcommands) -> None:
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
        help=f"control law that flew (default: what the log says, or {DEFAULT_LOG_LAW})",
    )
    parser.add_argument(
        "--controller",
        metavar="NAME|FILE",
        default="",
        help=f"law that is flown instead: {LAW_NAMES}, or a .py file of "
        "your own, which runs (default: the one that flew)",
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
    from workbench.extras.flightdata.predict.logged import motion_of
    from workbench.extras.flightdata.predict.what_if import Explained

    if not 2 <= args.draws <= MAX_WHAT_IF_DRAWS:
        raise WorkbenchError(f"--draws is {args.draws}: sample 2 to {MAX_WHAT_IF_DRAWS} vehicles")
    find_model(args.model)
    for name in filter(None, (args.rotors, args.gains)):
        find_file(name)
    flight = read_asked_flight(args)
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
            from workbench.extras.flightdata.predict.plots_predict import plot_what_if

            title = f"{flight.name}: {other.controller.name} {_changed(args)}".strip()
            write_png(plot_what_if(found, title), picture)
    for doubt in filter(None, (explained.doubt, found.doubt)):
        print_message(doubt)
    if found.lost:
        print_message(
            f"{found.lost} of {found.drawn} sampled vehicles do not stay in the air with it"
        )
    if found.grounded:
        print_message(f"{found.grounded} of {found.drawn} vehicles would reach the ground")
    if found.stays < len(found.time):
        print_message(
            f"the described vehicle is lost at {found.time[found.stays]:.1f} s of the log: its "
            "numbers and curves end there"
        )
    rows = _rows(found)
    result = {
        "log": args.log,
        "flown": flown.controller.name,
        "other": other.controller.name,
        "gains": {k: v for k, v in other.gains.items() if flown.gains.get(k) != v},
        "seconds": found.time[-1] - found.time[0],
        **pick(found, "lost grounded drawn"),
        "saturated": dict(zip(("log", "own", "other"), found.saturated, strict=True)),
        "difference": rows,
        "remarks": remark_rows([flight]),
    }
    print_result(args, result, _print_what_if, found, rows, files=outputs.files)
    return ExitCode.DONE


def _laws(args: argparse.Namespace, flight: "Flight", vehicle: "Vehicle") -> "tuple[Law, Law]":
    """Return the law that flew, with the gains known from the log, and the other one."""
    from workbench.control.controller_file import load_controller
    from workbench.extras.flightdata.predict.logged import flown_law, flown_law_name
    from workbench.extras.flightdata.predict.what_if import Law
    from workbench.gains.gain_choice import flight_gains
    from workbench.gains.gains import load_gains

    name = args.flown or flown_law_name(flight) or DEFAULT_LOG_LAW
    flown = flown_law(flight, vehicle, name)
    if args.controller and args.controller != name:
        other = load_controller(args.controller)
        check_gains(dict(args.set), other)
        return flown, Law(other, flight_gains(vehicle, args.gains, dict(args.set), other))
    controller, changed = flown.controller, dict(flown.gains)
    check_gains(dict(args.set), controller)
    if args.gains:
        changed |= load_gains(find_file(args.gains), controller).gains
    changed |= controller.table.checked(dict(args.set))
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
            "band": float(np.nanmean(found.high[:, index] - found.low[:, index])),
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

    from workbench.extras.flightdata.predict.motion import POSITION_VELOCITY_ROWS

    names = ("x [m]", "y [m]", "z [m]", "v_x [m/s]", "v_y [m/s]", "v_z [m/s]")
    pushes = ("f_x [N]", "f_y [N]", "f_z [N]", "m_x [N*m]", "m_y [N*m]", "m_z [N*m]")
    heads = [f"{of}.{name}" for of in ("logged", "other", "low", "high") for name in names]
    places = list(POSITION_VELOCITY_ROWS)
    with path.open("w", newline="", encoding="utf-8") as file:
        writer = csv.writer(file)
        writer.writerow(["t [s]", *heads, *(f"disturbance.{name}" for name in pushes)])
        for k, time in enumerate(found.time):
            parts = (found.logged[k, places], found.other[k, places], found.low[k], found.high[k])
            numbers = [value for part in (*parts, found.disturbance[k]) for value in part]
            writer.writerow([f"{time:.6f}", *(f"{value:.7g}" for value in numbers)])

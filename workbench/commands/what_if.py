"""`workbench what-if`: a logged flight, flown again with other gains or another law."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    MODEL_HELP,
    add_command,
    add_description_options,
    add_json_option,
    add_mapping_option,
    add_output_options,
    add_rotors_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.predict import DEFAULT, check_gains, read_vehicle
from workbench.commands.printing import print_json, print_table, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_file
from workbench.control.controller import SHIPPED
from workbench.scenario.parameters import split_setting

if TYPE_CHECKING:
    from workbench.design.predict.what_if import Law, WhatIf
    from workbench.logs.flight_record import FlightRecord
    from workbench.plant.vehicle import Vehicle

MOST_DRAWS = 1000


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "what-if",
        "Fly a logged flight again with other gains or another law: what the model cannot explain "
        "of the log acts again, and a band says how sure the answer is.",
        "workbench what-if flight.mcap --model my_quad.urdf --set kp_velocity_x=2",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument(
        "--model", required=True, metavar="NAME|PATH", help=f"the drone: {MODEL_HELP}"
    )
    add_description_options(parser)
    add_rotors_option(parser)
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
    parser.add_argument(
        "--set",
        action="append",
        type=split_setting,
        default=[],
        metavar="NAME=VALUE",
        help="gain that is flown instead; may be repeated",
    )
    parser.add_argument(
        "--draws",
        type=int,
        default=40,
        metavar="N",
        help="vehicles that are sampled for the band (default: 40)",
    )
    parser.add_argument("--seed", type=int, default=0, help="of the sample (default: 0)")
    add_mapping_option(parser)
    add_output_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
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
        flight = read_flight(args.log, args.mapping, progress)
    with Outputs() as outputs:
        table = outputs.add(args.output / f"{flight.name}-what-if.csv")
        picture = None
        if not args.no_plots:
            picture = outputs.add(args.output / f"{flight.name}-what-if.png")
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
        _write(found, table)
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
    if args.json:
        print_json(
            {
                "log": args.log,
                "flown": flown.controller.name,
                "other": other.controller.name,
                "gains": {k: v for k, v in other.gains.items() if flown.gains.get(k) != v},
                "seconds": found.time[-1] - found.time[0],
                "lost": found.lost,
                "drawn": found.drawn,
                "difference": rows,
                "files": outputs.files,
            }
        )
    else:
        _print(found, rows)
    say_written(outputs.files)
    return ExitCode.DONE


def _laws(
    args: argparse.Namespace, flight: "FlightRecord", vehicle: "Vehicle"
) -> "tuple[Law, Law]":
    """Return the law that flew, with its gains as far as the log tells, and the other one."""
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
    """Return the difference from the log of each axis, and the band's width [m, m/s].

    And how far log and other flight are off the setpoint, of positions.
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


def _print(found: "WhatIf", rows: list[dict[str, float | str]]) -> None:
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


def _write(found: "WhatIf", path: Path) -> None:
    """Write log, other flight, band and disturbance, a row an update."""
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

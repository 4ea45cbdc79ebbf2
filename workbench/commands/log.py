"""`workbench log`: what is in a log, whoever wrote it."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    MODEL_HELP,
    add_command,
    add_json_option,
    add_mapping_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, print_table, say_written
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.logs.flight_contents import FlightContents
    from workbench.logs.flight_record import FlightRecord


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "log",
        "Say what is in a log: signals, rates, gaps, clocks, and what can be identified from it.",
        "workbench log flight.ulg --html flight.html",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument(
        "--all", action="store_true", help="list signals without a name of the workbench, too"
    )
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE.html",
        help="write the flown path and attitude in 3-D, as a page that plays in any browser",
    )
    parser.add_argument(
        "--model",
        default="dh_drone",
        metavar="NAME|PATH",
        help=f"drone that the page shows: {MODEL_HELP} (default: dh_drone)",
    )
    add_mapping_option(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Say what is in the log."""
    from workbench.logs.flight_contents import contents_of
    from workbench.logs.flight_reader import read_flight

    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress)
    contents = contents_of(flight)
    files: list[Path] = []
    if args.html:
        files = _film(args, flight)
    if args.json:
        print_json(_said(flight, contents) | {"files": files})
    else:
        _print(flight, contents, args.all)
    if files:
        say_written(files)
    return ExitCode.DONE


def _film(args: argparse.Namespace, flight: "FlightRecord") -> list[Path]:
    from workbench.common.resources import find_model
    from workbench.logs.flight_film import film_flight
    from workbench.plant.description import read_description

    with Outputs() as outputs, progress_bar(f"filming {flight.name}") as progress:
        page = outputs.add(args.html)
        film_flight(flight, read_description(find_model(args.model)), page, progress)
    return outputs.files


def _said(flight: "FlightRecord", contents: "FlightContents") -> dict[str, Any]:
    signals = [
        {
            "name": signal.name,
            "unit": signal.unit,
            "samples": len(signal.time),
            "rate": signal.rate,
            "delay": signal.delay,
            "begin": signal.time[0] if len(signal.time) else None,
            "end": signal.time[-1] if len(signal.time) else None,
            "gaps": signal.gaps,
        }
        for signal in flight.signals.values()
    ]
    return {
        "log": flight.source,
        "name": flight.name,
        "format": flight.format,
        "firmware": flight.firmware,
        "end": flight.end,
        "remarks": flight.remarks,
        **asdict(contents),
        "signals": signals,
        "parameters": dict(flight.parameters),
    }


def _print(flight: "FlightRecord", contents: "FlightContents", everything: bool) -> None:
    print(f"{flight.name}: {flight.format}, {flight.firmware or 'firmware not known'}")
    print(f"{flight.end:.2f} s, {len(flight.signals)} signals, {len(flight.parameters)} parameters")
    if contents.turning == contents.turning:  # there are commands
        limit = ""
        if contents.saturated == contents.saturated:  # commands are shares of the full one
            limit = f", one of them at its limit in {100.0 * contents.saturated:.0f} % of it"
        print(f"motors turn for {contents.turning:.1f} s{limit}")
    for remark in flight.remarks:
        print(f"- {remark}")
    shown = [each for each in flight.signals.values() if each.unit or everything]
    streams: dict[tuple[str, ...], list[str]] = {}
    for signal in shown:
        topic, _, field = signal.name.partition(".")
        row = (
            topic,
            signal.unit,
            f"{signal.rate:.1f}",
            f"{signal.time[0]:.2f}" if len(signal.time) else "",
            f"{signal.time[-1]:.2f}" if len(signal.time) else "",
            str(len(signal.gaps)),
            f"{max((end - begin for begin, end in signal.gaps), default=0.0):.2f}",
        )
        streams.setdefault(row, []).append(field)
    rows = [(row[0], " ".join(fields), *row[1:]) for row, fields in streams.items()]
    print()
    heads = ("topic", "fields", "unit", "rate [Hz]", "from [s]", "to [s]", "gaps", "longest [s]")
    print_table([heads, *rows], left=(0, 1, 2))
    left = len(flight.signals) - len(shown)
    if left:
        print(f"and {left} under the log's own names: --all lists them")
    if contents.offsets:
        print()
        offsets = [
            (each.later, each.earlier, f"{1000.0 * each.offset:+.0f}", f"{each.correlation:.2f}")
            for each in contents.offsets
        ]
        print_table([("stream", "behind", "by [ms]", "correlation"), *offsets], left=(0, 1))
    print()
    found = [(each.what, "yes" if each.can else "no", each.why) for each in contents.findable]
    print_table([("can be identified", "", "because of"), *found], left=(0, 1, 2))
    if contents.loops:
        print(f"step responses: {', '.join(contents.loops)}")

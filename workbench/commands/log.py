"""Logs of any source: `workbench log`, `export`, `replay` and `plot`."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    MODEL_HELP,
    Subcommands,
    add_command,
    add_controller_option,
    add_estimator_option,
    add_json_option,
    add_log_options,
    add_option,
    asked_log,
    read_asked_flight,
)
from workbench.commands.outputs import Outputs, check_writable
from workbench.commands.printing import (
    pick,
    print_message,
    print_result,
    print_table,
)
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name, plain_text

if TYPE_CHECKING:
    from workbench.common.flight import Flight
    from workbench.logs.flight_contents import FlightContents
    from workbench.logs.replay import ReplayResult


EXPORT_FORMATS = ("csv", "parquet")
REPLAY_DIFFERENCE_UNITS = {
    "orientation": "",
    "position": " m",
    "velocity": " m/s",
    "angular velocity": " rad/s",
}


def add_parser(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "log",
        "Show what is in a log: signals, rates, gaps, clocks, and what can be identified from it.",
        "workbench log flight.ulg --html flight.html",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument(
        "--all", action="store_true", help="also list signals that have no name in the workbench"
    )
    parser.add_argument(
        "--html",
        type=Path,
        metavar="FILE.html",
        help="write the flown path and attitude in 3-D, as a page that plays in any browser",
    )
    add_option(
        parser, "--model", "NAME|PATH", f"drone that the page shows: {MODEL_HELP}", "dh_drone"
    )
    add_log_options(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Print the contents of the log."""
    from workbench.logs.flight_contents import contents_of_flight

    if args.html:
        check_writable(args.html)
    flight = read_asked_flight(args)
    contents = contents_of_flight(flight)
    files: list[Path] = []
    if args.html:
        files = _film(args, flight)
    said = _log_as_json(flight, contents)
    print_result(args, said, _print, flight, contents, args.all, files=files)
    return ExitCode.DONE


def _film(args: argparse.Namespace, flight: "Flight") -> list[Path]:
    from workbench.common.resources import find_model
    from workbench.logs.flight_film import film_flight
    from workbench.plant.description import read_description

    with Outputs() as outputs, progress_bar(f"filming {flight.name}") as progress:
        page = outputs.add(args.html)
        film_flight(flight, read_description(find_model(args.model)), page, progress)
    return outputs.files


def _log_as_json(flight: "Flight", contents: "FlightContents") -> dict[str, Any]:
    signals = [
        {
            **pick(signal, "name unit rate delay gaps"),
            "samples": len(signal.time),
            "begin": signal.time[0] if len(signal.time) else None,
            "end": signal.time[-1] if len(signal.time) else None,
        }
        for signal in flight.signals.values()
    ]
    return {
        "log": flight.source,
        **pick(flight, "name format firmware end remarks logs"),
        "remark_details": flight.remark_details(),
        **asdict(contents),
        "signals": signals,
        "parameters": dict(flight.parameters),
    }


def _print(flight: "Flight", contents: "FlightContents", everything: bool) -> None:
    firmware = plain_name(flight.firmware) or "firmware not known"
    print(f"{plain_name(flight.name)}: {flight.format}, {firmware}")
    print(f"{flight.end:.2f} s, {len(flight.signals)} signals, {len(flight.parameters)} parameters")
    if contents.turning == contents.turning:  # there are commands
        limit = ""
        if contents.saturated == contents.saturated:  # commands are shares of the full one
            limit = f", one of them at its limit in {100.0 * contents.saturated:.0f} % of it"
        print(f"motors turn for {contents.turning:.1f} s{limit}")
    for remark in flight.remarks:
        print(f"- {plain_text(remark)}")
    shown = [each for each in flight.signals.values() if each.unit or everything]
    streams: dict[tuple[str, ...], list[str]] = {}
    for signal in shown:
        topic, _, field = signal.name.partition(".")
        row = (
            plain_name(topic),
            plain_name(signal.unit),
            f"{signal.rate:.1f}",
            f"{signal.time[0]:.2f}" if len(signal.time) else "",
            f"{signal.time[-1]:.2f}" if len(signal.time) else "",
            str(len(signal.gaps)),
            f"{max((end - begin for begin, end in signal.gaps), default=0.0):.2f}",
        )
        streams.setdefault(row, []).append(plain_name(field))
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
        print(f"step responses: {', '.join(map(plain_name, contents.loops))}")


def add_export(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "export",
        "Write a log as tables: one file for each topic, with units in the headings, and one for "
        "the points of lidar clouds.",
        "workbench export flight.mcap --format csv --output tables/",
        run_export,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument(
        "--format", choices=EXPORT_FORMATS, default="csv", help="of the tables (default: csv)"
    )
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="folder of the tables (default: out/LOG)"
    )
    add_log_options(parser)
    add_json_option(parser)


def run_export(args: argparse.Namespace) -> int:
    """Write the tables."""
    from workbench.design.sweep.table import check_table_path
    from workbench.logs.flight_reader import log_topics
    from workbench.logs.table_file import topic_tables, write_columns
    from workbench.plant.sensors import free_name

    folder = args.output or Path("out") / args.log.stem
    suffix = f".{args.format}"
    check_table_path(folder / f"{args.log.stem}{suffix}")
    check_writable(folder / f"{args.log.stem}{suffix}")
    with progress_bar(f"reading {args.log.name}") as progress:
        topics, remark = log_topics(asked_log(args), progress)
    if remark:
        print_message(f"{args.log}: {remark}")
    if not topics:
        raise WorkbenchError(f"{args.log}: has no messages, so there is nothing to export")
    with Outputs() as outputs, progress_bar(f"exporting {args.log.name}") as progress:
        found: list[dict[str, object]] = []
        taken: set[str] = set()
        for number, topic in enumerate(topics, start=1):
            for name, columns in topic_tables(topic).items():
                folded = name.casefold()  # file systems of Windows and macOS ignore case
                free = free_name(taken, folded)
                taken.add(free)
                file = folder / f"{name}{free.removeprefix(folded)}{suffix}"
                write_columns(columns, outputs.add(file))
                found.append({"topic": topic.name, "file": file, "rows": len(columns["t"].values)})
            progress(number / len(topics))
    result = {"log": args.log, "remark": remark, "tables": found}
    print_result(args, result, files=outputs.files)
    return ExitCode.DONE


def add_replay(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "replay",
        "Fly a log again and say whether every state is equal to the bit; the exit code is 1 if "
        "not.",
        "workbench replay flight.mcap",
        run_replay,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="log of a flight (.mcap)")
    add_controller_option(parser, "log")
    add_estimator_option(parser, "log")
    add_json_option(parser)


def run_replay(args: argparse.Namespace) -> int:
    """Replay the log and compare; return 1 if a state differs."""
    from workbench.logs.record import read_log
    from workbench.logs.replay import replay

    with progress_bar(f"reading {args.log.name}"):
        record = read_log(args.log)
    if record.remark:
        print_message(f"{args.log}: {record.remark}")
    with progress_bar(f"flying {args.log.name} again") as progress:
        replayed = replay(record, progress, args.controller, args.estimator)
    result = {"log": args.log, "remark": record.remark}
    result |= pick(replayed, "equal states duration first changed")
    print_result(args, result, print, _sentence(replayed))
    return ExitCode.DONE if replayed.equal else ExitCode.NOT_AS_DEMANDED


def _sentence(replayed: "ReplayResult") -> str:
    first = replayed.first
    if first is None:
        changed = "; ".join(replayed.changed)
        since = f", although something has changed: {changed}" if changed else ""
        return (
            f"equal: all {replayed.states} states over {replayed.duration:.3f} s are the same to "
            f"the bit{since}"
        )
    why = "the scenario's files, or the workbench itself, may have changed since"
    if replayed.changed:
        why = f"the likely reason: {'; '.join(replayed.changed)}"
    return (
        f"not equal: the first difference is at {first.time:.3f} s, of {first.size:.3g}"
        f"{REPLAY_DIFFERENCE_UNITS[first.part]} in the {first.part}; {why}"
    )

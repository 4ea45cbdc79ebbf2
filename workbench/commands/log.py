"""Logs, whoever wrote them: `workbench log`, `import`, `export` and `replay`."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    MODEL_HELP,
    add_command,
    add_controller_option,
    add_estimator_option,
    add_json_option,
    add_mapping_option,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, print_result, print_table, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.logs.flight_contents import FlightContents
    from workbench.logs.flight_record import FlightRecord
    from workbench.logs.replay import Replayed

FORMATS = ("csv", "parquet")
UNITS = {"orientation": "", "position": " m", "velocity": " m/s", "angular velocity": " rad/s"}


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
    print_result(
        args,
        _said(flight, contents) | {"files": files},
        _print,
        flight,
        contents,
        args.all,
        files=files,
    )
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


def add_import(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "import",
        "Store a log from elsewhere as a log of the workbench, under the workbench's names.",
        "workbench import flight.ulg --output flight.mcap",
        run_import,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    add_mapping_option(parser)
    parser.add_argument(
        "--output", type=Path, metavar="FILE.mcap", help="the log (default: out/LOG.mcap)"
    )
    add_json_option(parser)


def run_import(args: argparse.Namespace) -> int:
    """Read the log and write it."""
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.imported import write_flight

    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress)
    output = args.output or Path("out") / f"{flight.name}.mcap"
    if output.suffix != ".mcap":
        raise WorkbenchError(f"{output}: a log is MCAP: let its name end in .mcap")
    if output.exists() and output.samefile(args.log):
        raise WorkbenchError(f"{output}: is the log itself: name another file")
    for remark in flight.remarks:
        say(f"{args.log}: {remark}")
    with Outputs() as outputs:
        write_flight(flight, outputs.add(output))
    if args.json:
        print_json(
            {
                "log": args.log,
                "format": flight.format,
                "signals": list(flight.signals),
                "remarks": flight.remarks,
                "files": outputs.files,
            }
        )
    say_written(outputs.files)
    return ExitCode.DONE


def add_export(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "export",
        "Write a log as tables, one file a topic, with units in their headings; the points of a "
        "lidar's clouds in one of their own.",
        "workbench export flight.mcap --format csv --output tables/",
        run_export,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument("--format", choices=FORMATS, default="csv", help="(default: csv)")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="folder of the tables (default: out/LOG)"
    )
    add_mapping_option(parser)
    add_json_option(parser)


def run_export(args: argparse.Namespace) -> int:
    """Write the tables."""
    from workbench.design.sweep.table import check_table_path
    from workbench.logs.flight_reader import open_log
    from workbench.logs.table_file import tables, write_table

    folder = args.output or Path("out") / args.log.stem
    suffix = f".{args.format}"
    check_table_path(folder / f"{args.log.stem}{suffix}")
    record = open_log(args.log, args.mapping)
    if record.remark:
        say(f"{args.log}: {record.remark}")
    if not record.topics:
        raise WorkbenchError(f"{args.log}: has no messages, so there is nothing to export")
    with Outputs() as outputs, progress_bar(f"exporting {args.log.name}") as progress:
        found = []
        for number, topic in enumerate(record.topics.values(), start=1):
            for name, columns in tables(topic).items():
                write_table(columns, outputs.add(folder / f"{name}{suffix}"))
                file = folder / f"{name}{suffix}"
                found.append({"topic": topic.name, "file": file, "rows": len(columns["t"].values)})
            progress(number / len(record.topics))
    if args.json:
        print_json({"log": args.log, "remark": record.remark, "tables": found})
    say_written(outputs.files)
    return ExitCode.DONE


def add_replay(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "replay",
        "Fly a log again and say whether every state is equal to the bit; exit code 1 if not.",
        "workbench replay flight.mcap",
        run_replay,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="log of a flight (.mcap)")
    add_controller_option(parser, "log")
    add_estimator_option(parser, "log")
    add_json_option(parser)


def run_replay(args: argparse.Namespace) -> int:
    """Fly the log again and compare; 1 if a state differs."""
    from workbench.logs.record import read_log
    from workbench.logs.replay import replay

    record = read_log(args.log)
    if record.remark:
        say(f"{args.log}: {record.remark}")
    with progress_bar(f"flying {args.log.name} again") as progress:
        replayed = replay(record, progress, args.controller, args.estimator)
    if args.json:
        found = {"log": args.log, "equal": replayed.equal, "remark": record.remark}
        print_json(
            found
            | {
                "states": replayed.states,
                "duration": replayed.duration,
                "first": replayed.first,
                "changed": replayed.changed,
            }
        )
    else:
        print(_sentence(replayed))
    return ExitCode.DONE if replayed.equal else ExitCode.NOT_AS_DEMANDED


def _sentence(replayed: "Replayed") -> str:
    first = replayed.first
    if first is None:
        changed = "; ".join(replayed.changed)
        since = f", though not all is as it was: {changed}" if changed else ""
        return (
            f"equal: all {replayed.states} states over {replayed.duration:.3f} s are the same to "
            f"the bit{since}"
        )
    why = "the scenario's files, or the workbench itself, may have changed since"
    if replayed.changed:
        why = f"the likely reason: {'; '.join(replayed.changed)}"
    return (
        f"not equal: the first difference is at {first.time:.3f} s, of {first.size:.3g}"
        f"{UNITS[first.part]} in the {first.part}; {why}"
    )

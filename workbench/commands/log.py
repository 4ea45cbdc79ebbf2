"""Logs of any source: `workbench log`, `import`, `export`, `replay` and `plot`."""

import argparse
from dataclasses import asdict
from functools import partial
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
    add_log_options,
    add_option,
    add_repeated,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import pick, print_remarks, print_result, print_table, say
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import file_stem, plain_name, plain_text

if TYPE_CHECKING:
    from workbench.logs.flight_contents import FlightContents
    from workbench.logs.flight_record import FlightRecord
    from workbench.logs.record import LogRecord
    from workbench.logs.replay import Replayed


FORMATS = ("csv", "parquet")
UNITS = {"orientation": "", "position": " m", "velocity": " m/s", "angular velocity": " rad/s"}
_COLUMNS = ("field", "unit", "messages")


def add_parser(commands: Any) -> None:
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
    from workbench.logs.flight_contents import contents_of
    from workbench.logs.flight_reader import read_flight

    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress, args.log_number)
    contents = contents_of(flight)
    files: list[Path] = []
    if args.html:
        files = _film(args, flight)
    said = _said(flight, contents)
    print_result(args, said, _print, flight, contents, args.all, files=files)
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


def _print(flight: "FlightRecord", contents: "FlightContents", everything: bool) -> None:
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


def add_import(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "import",
        "Convert a log of another program to a log of the workbench, with the workbench's names.",
        "workbench import flight.ulg --output flight.mcap",
        run_import,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    add_log_options(parser)
    parser.add_argument(
        "--output", type=Path, metavar="FILE.mcap", help="the log (default: out/LOG.mcap)"
    )
    add_json_option(parser)


def run_import(args: argparse.Namespace) -> int:
    """Read the log and write it."""
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.imported import write_flight

    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress, args.log_number)
    output = args.output or Path("out") / f"{file_stem(flight.name)}.mcap"
    if output.suffix != ".mcap":
        raise WorkbenchError(f"{output}: a log is MCAP: let its name end in .mcap")
    if output.exists() and output.samefile(args.log):
        raise WorkbenchError(f"{output}: is the log itself: name another file")
    for remark in flight.remarks:
        say(f"{args.log}: {remark}")
    with Outputs() as outputs:
        write_flight(flight, outputs.add(output))
    result = {
        "log": args.log,
        "signals": list(flight.signals),
        **pick(flight, "format remarks logs"),
        "remark_details": flight.remark_details(),
    }
    print_result(args, result, files=outputs.files)
    return ExitCode.DONE


def add_export(commands: Any) -> None:
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
    parser.add_argument("--format", choices=FORMATS, default="csv", help="(default: csv)")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="folder of the tables (default: out/LOG)"
    )
    add_log_options(parser)
    add_json_option(parser)


def run_export(args: argparse.Namespace) -> int:
    """Write the tables."""
    from workbench.design.sweep.table import check_table_path
    from workbench.logs.flight_reader import open_log
    from workbench.logs.table_file import tables, write_table

    folder = args.output or Path("out") / args.log.stem
    suffix = f".{args.format}"
    check_table_path(folder / f"{args.log.stem}{suffix}")
    with progress_bar(f"reading {args.log.name}") as progress:
        record = open_log(args.log, args.mapping, progress, args.log_number)
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
    result = {"log": args.log, "remark": record.remark, "tables": found}
    print_result(args, result, files=outputs.files)
    return ExitCode.DONE


def add_replay(commands: Any) -> None:
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
        say(f"{args.log}: {record.remark}")
    with progress_bar(f"flying {args.log.name} again") as progress:
        replayed = replay(record, progress, args.controller, args.estimator)
    result = {"log": args.log, "remark": record.remark}
    result |= pick(replayed, "equal states duration first changed")
    print_result(args, result, print, _sentence(replayed))
    return ExitCode.DONE if replayed.equal else ExitCode.NOT_AS_DEMANDED


def _sentence(replayed: "Replayed") -> str:
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
        f"{UNITS[first.part]} in the {first.part}; {why}"
    )


def add_plot(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "plot",
        "Draw a log: an overview, the fields that are named, or a loop's step response.",
        "workbench plot flight.mcap velocity_data.v_x command_velocity.v_x --output v_x.png",
        run_plot,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument(
        "fields",
        nargs="*",
        metavar="TOPIC.FIELD",
        help="what to draw, as velocity_data.v_x; TOPIC alone means all its fields; or an "
        'expression of fields with its unit, as "deg(roll) [deg]" (default: an overview)',
    )
    add_repeated(
        parser,
        "--over",
        "LOG",
        Path,
        "draw the same fields of another log over them; may be given several times",
    )
    parser.add_argument(
        "--spectrum",
        action="store_true",
        help="draw power spectral densities (Welch: Hann windows, the mean removed)",
    )
    add_option(
        parser,
        "--averages",
        "N",
        "segments, overlapping by half, that a spectrum is averaged over",
        8,
    )
    parser.add_argument(
        "--span",
        type=float,
        nargs=2,
        metavar=("FROM", "TO"),
        help="draw this part of the log alone [s]",
    )
    parser.add_argument(
        "--step-response",
        metavar="LOOP",
        help="draw the step response of a loop as the flight shows it: roll_rate, roll, v_x, x, "
        "... or SETPOINT:RESPONSE of any two signals",
    )
    parser.add_argument("--list", action="store_true", help="list all fields and stop")
    add_log_options(parser)
    parser.add_argument(
        "--output", type=Path, metavar="FILE.png", help="the picture (default: out/LOG.png)"
    )
    add_json_option(parser)


def run_plot(args: argparse.Namespace) -> int:
    """Draw the log, or list its fields."""
    from workbench.logs.flight_reader import open_log

    output = args.output or Path("out") / f"{args.log.stem}.png"
    if output.suffix != ".png":
        raise WorkbenchError(f"{output}: a plot is a PNG: let its name end in .png")
    if args.spectrum and not args.fields:
        raise WorkbenchError("--spectrum needs fields: name some; --list lists them")
    if args.over and (args.spectrum or not args.fields):
        raise WorkbenchError("--over draws fields over time: name some, and leave out --spectrum")
    if args.averages < 1:
        raise WorkbenchError(f"--averages is {args.averages}: average over 1 segment at least")
    if args.span and not args.span[0] < args.span[1]:
        raise WorkbenchError(
            f"--span goes from {args.span[0]:g} to {args.span[1]:g} s: let it end after it begins"
        )
    if args.step_response:
        if args.fields or args.spectrum or args.over or args.list or args.span:
            raise WorkbenchError(
                "--step-response draws a picture of its own: leave out the other options"
            )
        return _step_response(args, output)
    with progress_bar(f"reading {args.log.name}") as progress:
        record = open_log(args.log, args.mapping, progress, args.log_number)
        others = [open_log(path) for path in args.over]
    if record.remark:
        say(f"{args.log}: {record.remark}")
    if args.list:
        _list(args, record)
        return ExitCode.DONE
    from workbench.design.plots import write_png
    from workbench.logs.plots import plot_fields, plot_overview, plot_spectra
    from workbench.logs.spectrum import Welch

    if args.span:
        record = record.between(*args.span)
        others = [other.between(*args.span) for other in others]
    with Outputs() as outputs:
        path = outputs.add(output)
        if args.spectrum:
            figure = plot_spectra(record, args.fields, Welch(averages=args.averages))
        elif args.fields:
            figure = plot_fields(record, args.fields, others)
        else:
            figure = plot_overview(record)
        write_png(figure, path)
    print_result(args, {"log": args.log, "remark": record.remark}, files=outputs.files)
    return ExitCode.DONE


def _step_response(args: argparse.Namespace, output: Path) -> int:
    """Draw the step response of a loop, and report doubts; return 1 if there are any."""
    from workbench.design.plots import write_png
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.plots import plot_step_response
    from workbench.logs.step_response import step_response

    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress, args.log_number)
    print_remarks(flight)
    estimate = step_response(flight, args.step_response)
    with Outputs() as outputs:
        write_png(plot_step_response(flight, estimate), outputs.add(output))
    text = (
        f"{estimate.name}: {estimate.setpoint} to {estimate.response}, {estimate.windows} "
        f"windows, coherence {estimate.coherence:.2f}\n"
        f"rise time {estimate.rise:.3f} s, overshoot {100.0 * estimate.overshoot:.0f} %, "
        f"settles at {estimate.final:.2f} ({estimate.low[-1]:.2f} .. {estimate.high[-1]:.2f})"
    )
    result = {"log": args.log, "trusted": estimate.trusted, **asdict(estimate)}
    result |= pick(flight, "remarks") | {"remark_details": flight.remark_details()}
    for doubt in estimate.doubts:
        say(f"{args.log}: not reliable: {doubt}")
    print_result(args, result, print, text, files=outputs.files)
    return ExitCode.DONE if estimate.trusted else ExitCode.NOT_AS_DEMANDED


def _list(args: argparse.Namespace, record: "LogRecord") -> None:
    rows = [
        (series.name, series.unit, len(series.time))
        for topic in record.topics.values()
        for series in topic.columns.values()
    ]
    found = {"fields": [dict(zip(_COLUMNS, row, strict=True)) for row in rows]}
    texts = [_COLUMNS, *(tuple(plain_name(str(each)) for each in row) for row in rows)]
    print_result(args, found, partial(print_table, texts, left=(0, 1)))

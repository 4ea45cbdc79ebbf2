"""`workbench plot`: a log drawn, as an overview, field by field, or as a loop's step response."""

import argparse
from dataclasses import asdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    add_command,
    add_json_option,
    add_mapping_option,
    add_repeated,
)
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, print_table, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.logs.record import LogRecord

_COLUMNS = ("field", "unit", "messages")


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "plot",
        "Draw a log: an overview, the fields that are named, or a loop's step response.",
        "workbench plot flight.mcap velocity_data.v_x command_velocity.v_x --output v_x.png",
        run,
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
        help="draw power spectral densities (Welch: Hann windows, the mean taken off)",
    )
    parser.add_argument(
        "--averages",
        type=int,
        default=8,
        metavar="N",
        help="segments, half over each other, that a spectrum is averaged over (default: 8)",
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
    add_mapping_option(parser)
    parser.add_argument(
        "--output", type=Path, metavar="FILE.png", help="the picture (default: out/LOG.png)"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Draw the log, or list its fields."""
    from workbench.logs.flight_reader import open_log

    output = args.output or Path("out") / f"{args.log.stem}.png"
    if output.suffix != ".png":
        raise WorkbenchError(f"{output}: a plot is a PNG: let its name end in .png")
    if args.spectrum and not args.fields:
        raise WorkbenchError("--spectrum is of fields: name some; --list lists them")
    if args.over and (args.spectrum or not args.fields):
        raise WorkbenchError("--over draws fields over time: name some, and leave out --spectrum")
    if args.averages < 1:
        raise WorkbenchError(f"--averages is {args.averages}: average over 1 segment at least")
    if args.span and not args.span[0] < args.span[1]:
        raise WorkbenchError(f"--span goes from {args.span[0]:g} to {args.span[1]:g} s: no time")
    if args.step_response:
        if args.fields or args.spectrum or args.over or args.list or args.span:
            raise WorkbenchError("--step-response is a picture of its own: leave out the rest")
        return _step_response(args, output)
    with progress_bar(f"reading {args.log.name}") as progress:
        record = open_log(args.log, args.mapping, progress)
        others = [open_log(path) for path in args.over]
    if record.remark:
        say(f"{args.log}: {record.remark}")
    if args.list:
        _list(record, args.json)
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
    if args.json:
        print_json({"log": args.log, "remark": record.remark, "files": outputs.files})
    say_written(outputs.files)
    return ExitCode.DONE


def _step_response(args: argparse.Namespace, output: Path) -> int:
    """Draw a loop's step response, and say how far it is to be trusted; 1 if it is not."""
    from workbench.design.plots import write_png
    from workbench.logs.flight_reader import read_flight
    from workbench.logs.plots import plot_step_response
    from workbench.logs.step_response import step_response

    with progress_bar(f"reading {args.log.name}") as progress:
        flight = read_flight(args.log, args.mapping, progress)
    estimate = step_response(flight, args.step_response)
    with Outputs() as outputs:
        write_png(plot_step_response(flight, estimate), outputs.add(output))
    if args.json:
        print_json(
            {"log": args.log, "trusted": estimate.trusted, **asdict(estimate)}
            | {"files": outputs.files}
        )
    else:
        print(
            f"{estimate.name}: {estimate.setpoint} to {estimate.response}, {estimate.windows} "
            f"windows, coherence {estimate.coherence:.2f}\n"
            f"rise time {estimate.rise:.3f} s, overshoot {100.0 * estimate.overshoot:.0f} %, "
            f"settles at {estimate.final:.2f} ({estimate.low[-1]:.2f} .. {estimate.high[-1]:.2f})"
        )
    for doubt in estimate.doubts:
        say(f"{args.log}: not to be trusted: {doubt}")
    say_written(outputs.files)
    return ExitCode.DONE if estimate.trusted else ExitCode.NOT_AS_DEMANDED


def _list(record: "LogRecord", json: bool) -> None:
    rows = [
        (series.name, series.unit, len(series.time))
        for topic in record.topics.values()
        for series in topic.columns.values()
    ]
    if json:
        print_json({"fields": [dict(zip(_COLUMNS, row, strict=True)) for row in rows]})
        return
    print_table([_COLUMNS, *((*row[:2], str(row[2])) for row in rows)], left=(0, 1))

"""`workbench plot`: a log drawn, as an overview or field by field."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import add_command, add_json_option
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
        "Draw a log: an overview, or the fields that are named.",
        "workbench plot flight.mcap velocity_data.v_x command_velocity.v_x --output v_x.png",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="log of a flight (.mcap)")
    parser.add_argument(
        "fields",
        nargs="*",
        metavar="TOPIC.FIELD",
        help="what to draw, as velocity_data.v_x; TOPIC alone means all its fields; or an "
        'expression of fields with its unit, as "deg(roll) [deg]" (default: an overview)',
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
    parser.add_argument("--list", action="store_true", help="list all fields and stop")
    parser.add_argument(
        "--output", type=Path, metavar="FILE.png", help="the picture (default: out/LOG.png)"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Draw the log, or list its fields."""
    from workbench.logs.record import read_log

    output = args.output or Path("out") / f"{args.log.stem}.png"
    if output.suffix != ".png":
        raise WorkbenchError(f"{output}: a plot is a PNG: let its name end in .png")
    if args.spectrum and not args.fields:
        raise WorkbenchError("--spectrum is of fields: name some; --list lists them")
    if args.averages < 1:
        raise WorkbenchError(f"--averages is {args.averages}: average over 1 segment at least")
    with progress_bar(f"reading {args.log.name}") as progress:
        record = read_log(args.log, progress)
    if record.remark:
        say(f"{args.log}: {record.remark}")
    if args.list:
        _list(record, args.json)
        return ExitCode.DONE
    from workbench.design.plots import write_png
    from workbench.logs.plots import plot_fields, plot_overview, plot_spectra
    from workbench.logs.spectrum import Welch

    with Outputs() as outputs:
        path = outputs.add(output)
        if args.spectrum:
            figure = plot_spectra(record, args.fields, Welch(averages=args.averages))
        else:
            figure = plot_fields(record, args.fields) if args.fields else plot_overview(record)
        write_png(figure, path)
    if args.json:
        print_json({"log": args.log, "remark": record.remark, "files": outputs.files})
    say_written(outputs.files)
    return ExitCode.DONE


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

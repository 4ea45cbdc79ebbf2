"""`workbench plot`: plot signals of a log, or the step response that it shows."""

import argparse
from dataclasses import asdict
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    Subcommands,
    add_command,
    add_json_option,
    add_log_options,
    add_option,
    add_repeated,
    asked_log,
    read_asked_flight,
)
from workbench.commands.outputs import Outputs, check_writable
from workbench.commands.printing import (
    pick,
    print_message,
    print_remarks,
    print_result,
    print_table,
)
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import plain_name

if TYPE_CHECKING:
    from workbench.common.flight import Flight


_FIELD_COLUMNS = ("field", "unit", "messages")


def add_plot(commands: Subcommands) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "plot",
        "Draw a log: an overview, the fields that are named, or a loop's step response.",
        "workbench plot flight.mcap velocity_data.v_x command_velocity.v_x --save v_x.png",
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
        "--save", type=Path, metavar="FILE.png", help="the picture (default: out/LOG.png)"
    )
    add_json_option(parser)


def run_plot(args: argparse.Namespace) -> int:
    """Draw the log, or list its fields."""
    from workbench.logs.flight_reader import open_log

    output = args.save or Path("out") / f"{args.log.stem}.png"
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
    if not args.list:
        check_writable(output)
    if args.step_response:
        if args.fields or args.spectrum or args.over or args.list or args.span:
            raise WorkbenchError(
                "--step-response draws a picture of its own: leave out the other options"
            )
        return _step_response(args, output)
    with progress_bar(f"reading {args.log.name}") as progress:
        flight = open_log(asked_log(args), progress)
        others = [open_log(path) for path in args.over]
    if flight.remark:
        print_message(f"{args.log}: {flight.remark}")
    if args.list:
        _list(args, flight)
        return ExitCode.DONE
    from workbench.design.plots import write_png
    from workbench.logs.plots import plot_fields, plot_overview, plot_spectra
    from workbench.logs.spectrum import WelchSettings

    if args.span:
        flight = flight.between(*args.span)
        others = [other.between(*args.span) for other in others]
    with Outputs() as outputs:
        path = outputs.add(output)
        if args.spectrum:
            figure = plot_spectra(flight, args.fields, WelchSettings(averages=args.averages))
        elif args.fields:
            figure = plot_fields(flight, args.fields, others)
        else:
            figure = plot_overview(flight)
        write_png(figure, path)
    print_result(args, {"log": args.log, "remark": flight.remark}, files=outputs.files)
    return ExitCode.DONE


def _step_response(args: argparse.Namespace, output: Path) -> int:
    """Draw the step response of a loop, and report doubts; return 1 if there are any."""
    from workbench.design.plots import write_png
    from workbench.logs.plots import plot_step_response
    from workbench.logs.step_response import identify_step_response

    flight = read_asked_flight(args)
    print_remarks(flight)
    estimate = identify_step_response(flight, args.step_response)
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
        print_message(f"{args.log}: not reliable: {doubt}")
    print_result(args, result, print, text, files=outputs.files)
    return ExitCode.DONE if estimate.trusted else ExitCode.NOT_AS_DEMANDED


def _list(args: argparse.Namespace, flight: "Flight") -> None:
    rows = [(series.name, series.unit, len(series.time)) for series in flight.signals.values()]
    found = {"fields": [dict(zip(_FIELD_COLUMNS, row, strict=True)) for row in rows]}
    texts = [_FIELD_COLUMNS, *(tuple(plain_name(str(each)) for each in row) for row in rows)]
    print_result(args, found, partial(print_table, texts, left=(0, 1)))

"""`workbench import`: a log of another program becomes a log of the workbench."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    LOG_HELP,
    add_command,
    add_json_option,
    add_log_options,
    read_asked_flight,
)
from workbench.commands.outputs import Outputs, check_writable
from workbench.commands.printing import pick, print_message, print_result
from workbench.common.errors import WorkbenchError
from workbench.common.plain_text import file_stem


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "import",
        "Convert a log of another program to a log of the workbench, with the workbench's names.",
        "workbench import flight.ulg --save flight.mcap",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    add_log_options(parser)
    parser.add_argument(
        "--save", type=Path, metavar="FILE.mcap", help="the log (default: out/LOG.mcap)"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Read the log and write it."""
    from workbench.extras.flightdata.importing import write_flight

    output = args.save or Path("out") / f"{file_stem(args.log.name)}.mcap"
    if output.suffix != ".mcap":
        raise WorkbenchError(f"{output}: a log is MCAP: let its name end in .mcap")
    check_writable(output)
    flight = read_asked_flight(args)
    output = args.save or output.with_name(f"{file_stem(flight.name)}.mcap")
    if output.exists() and output.samefile(args.log):
        raise WorkbenchError(f"{output}: is the log itself: name another file")
    for remark in flight.remarks:
        print_message(f"{args.log}: {remark}")
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

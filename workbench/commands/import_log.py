"""`workbench import`: a log from elsewhere, stored as one of ours."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import LOG_HELP, add_command, add_json_option, add_mapping_option
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "import",
        "Store a log from elsewhere as a log of the workbench, under the workbench's names.",
        "workbench import flight.ulg --output flight.mcap",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    add_mapping_option(parser)
    parser.add_argument(
        "--output", type=Path, metavar="FILE.mcap", help="the log (default: out/LOG.mcap)"
    )
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
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

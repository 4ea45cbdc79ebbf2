"""`workbench export`: a log as tables, one file a topic."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import LOG_HELP, add_command, add_json_option, add_mapping_option
from workbench.commands.outputs import Outputs
from workbench.commands.printing import print_json, say, say_written
from workbench.commands.progress import progress_bar
from workbench.common.errors import WorkbenchError

FORMATS = ("csv", "parquet")


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "export",
        "Write a log as tables, one file a topic, with units in their headings; the points of a "
        "lidar's clouds in one of their own.",
        "workbench export flight.mcap --format csv --output tables/",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help=LOG_HELP)
    parser.add_argument("--format", choices=FORMATS, default="csv", help="(default: csv)")
    parser.add_argument(
        "--output", type=Path, metavar="DIR", help="folder of the tables (default: out/LOG)"
    )
    add_mapping_option(parser)
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
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

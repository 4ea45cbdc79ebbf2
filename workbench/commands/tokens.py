"""`workbench tokens`: a file with which others may watch and command."""

import argparse
from pathlib import Path
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import add_command, add_json_option
from workbench.commands.printing import print_json, say


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "tokens",
        "Make a file of two tokens, to watch and to command; only its owner can read it.",
        "workbench tokens tokens.txt",
        run,
    )
    parser.add_argument("file", type=Path, metavar="FILE", help="to be made; none is overwritten")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
    """Write the file."""
    from workbench.link.authentication import write_tokens

    write_tokens(args.file)
    if args.json:
        print_json({"files": [args.file]})
    say(f"wrote {args.file}: give others its second word of a line, and keep the file yourself")
    return ExitCode.DONE

"""`workbench replay`: a log flown again, and whether it is the same flight to the bit."""

import argparse
from pathlib import Path
from typing import TYPE_CHECKING, Any

from workbench.commands import ExitCode
from workbench.commands.options import (
    add_command,
    add_controller_option,
    add_estimator_option,
    add_json_option,
)
from workbench.commands.printing import print_json, say
from workbench.commands.progress import progress_bar

if TYPE_CHECKING:
    from workbench.logs.replay import Replayed

UNITS = {"orientation": "", "position": " m", "velocity": " m/s", "angular velocity": " rad/s"}


def add_parser(commands: Any) -> None:
    """Add the command."""
    parser = add_command(
        commands,
        "replay",
        "Fly a log again and say whether every state is equal to the bit; exit code 1 if not.",
        "workbench replay flight.mcap",
        run,
    )
    parser.add_argument("log", type=Path, metavar="LOG", help="log of a flight (.mcap)")
    add_controller_option(parser, "log")
    add_estimator_option(parser, "log")
    add_json_option(parser)


def run(args: argparse.Namespace) -> int:
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

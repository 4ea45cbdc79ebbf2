"""`workbench gui`: the app."""

import argparse
from typing import Any

from workbench.commands import ExitCode
from workbench.commands.options import add_command
from workbench.commands.printing import say


def add_parser(commands: Any) -> None:
    """Add the command."""
    add_command(
        commands,
        "gui",
        "Open the app: fly, watch and tune (comes with a later version).",
        "workbench gui",
        run,
    )


def run(args: argparse.Namespace) -> int:
    """Say where the screens are."""
    say(
        "the app's screens come with a later version; meanwhile `workbench reproduce` flies the "
        "published steps and plots them"
    )
    return ExitCode.DONE

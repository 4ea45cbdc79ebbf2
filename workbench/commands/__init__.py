"""The commands of the console script, one a file.

Each has `add_parser(commands)`, which loads nothing heavy, and `run(args)`, which imports what it
needs and returns an exit code.
"""

from enum import IntEnum


class ExitCode(IntEnum):
    """What a command returns; bad input is a `WorkbenchError`, which ends as 2."""

    DONE = 0
    NOT_AS_DEMANDED = 1
    INTERRUPTED = 130

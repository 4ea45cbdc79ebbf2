"""The commands of the console script: those of one subject are in one file.

Each has a function that adds it to the parser and loads nothing heavy, `add_parser(commands)` or
`add_NAME(commands)`, and one that runs it, imports what it needs and returns an exit code.
"""

from enum import IntEnum


class ExitCode(IntEnum):
    """What a command returns; bad input is a `WorkbenchError`, which ends as 2."""

    DONE = 0
    NOT_AS_DEMANDED = 1
    INTERRUPTED = 130

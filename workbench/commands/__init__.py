"""The commands of the console script, with one file for each subject.

Each command has a fast function that adds it to the parser, `add_parser(commands)` or
`add_NAME(commands)`, and one that runs it, with its own imports, and returns an exit code.
"""

from enum import IntEnum


class ExitCode(IntEnum):
    """Exit codes of commands; bad input is a `WorkbenchError`, which leads to 2."""

    DONE = 0
    NOT_AS_DEMANDED = 1

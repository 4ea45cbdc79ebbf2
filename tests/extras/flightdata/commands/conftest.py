"""Commands are run as in the tests of the core's."""

from tests.commands.conftest import (
    _files_here,
    _no_progress,
    log,
    logged,
    out,
    pictures_here,
    refused,
    run,
    write,
)

__all__ = [
    "_files_here",
    "_no_progress",
    "log",
    "logged",
    "out",
    "pictures_here",
    "refused",
    "run",
    "write",
]

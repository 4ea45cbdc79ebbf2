"""The fixtures of the core's tests of commands."""

from tests.commands.conftest import (  # noqa: F401
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

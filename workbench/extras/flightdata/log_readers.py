"""The formats of logs that this package reads: `LOG_READER` of each module of `readers`.

A library is imported when a log needs it.
"""

from importlib import import_module
from pkgutil import iter_modules

from workbench.extras.flightdata import readers
from workbench.logs.readers.log_reader import LogReader


def _log_readers() -> tuple[LogReader, ...]:
    """Return the readers of all modules that have one; the others are what these share."""
    names = (each.name for each in iter_modules(readers.__path__))
    modules = [import_module(f"{readers.__name__}.{name}") for name in names]
    return tuple(each.LOG_READER for each in modules if hasattr(each, "LOG_READER"))


LOG_READERS = _log_readers()

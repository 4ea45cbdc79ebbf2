"""Where readers of logs imported `Flight` from in version 1.0, as `FlightRecord`."""

import warnings
from typing import Any

from workbench.common.flight import Flight


def __getattr__(name: str) -> Any:
    if name != "FlightRecord":
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
    said = "workbench.logs.flight_record.FlightRecord is now workbench.Flight"
    warnings.warn(said, DeprecationWarning, stacklevel=2)
    return Flight

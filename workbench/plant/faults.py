"""Faults of a sensor, chosen by its live parameter."""

from enum import IntEnum

FAULT_NOISE_FACTOR = 10.0
"""Factor on the standard deviation of a noisy sensor."""


class Fault(IntEnum):
    """An injected fault, with the numbers of the parameter table's `..._fault` rows."""

    NONE = 0
    """No fault."""
    FROZEN = 1
    """It repeats the values of its last sample."""
    NOISY = 2
    """Its noise is `FAULT_NOISE_FACTOR` times as large."""
    SILENT = 3
    """It sends no samples."""

"""What can be wrong with a sensor, as its live parameter says."""

from enum import IntEnum

NOISE_FACTOR = 10.0
"""So many times its deviation has the noise of a noisy sensor."""


class Fault(IntEnum):
    """A fault to order; the numbers are those of the parameter table's `..._fault` rows."""

    NONE = 0
    """It works."""
    FROZEN = 1
    """It goes on sending the values of its last sample."""
    NOISY = 2
    """Its noise is `NOISE_FACTOR` times as large."""
    SILENT = 3
    """It sends nothing."""

"""Values as colours of a perceptually uniform map, also for colour-blind users and in grey."""

import numpy as np
from pyqtgraph import colormap

COLOUR_TABLE_SIZE = 256


def colour_table(first: float = 0.0, last: float = 1.0) -> np.ndarray:
    """Return red, green and blue bytes (256, 3) from a part of the colour map "viridis".

    Args:
        first: start of the part; 0 is dark blue.
        last: end of the part; 1 is yellow.
    """
    table: np.ndarray = colormap.get("viridis").getLookupTable(
        first, last, COLOUR_TABLE_SIZE, alpha=False
    )
    return table


def colours_of(values: np.ndarray, low: float, high: float, table: np.ndarray) -> np.ndarray:
    """Return the colours (..., 3) of values between two ends; values beyond are clipped."""
    span = max(high - low, 1e-9)
    places = np.clip((values - low) * ((COLOUR_TABLE_SIZE - 1) / span), 0, COLOUR_TABLE_SIZE - 1)
    colours: np.ndarray = table[places.astype(np.intp)]
    return colours

"""A colour map whose equal steps look equally large, also to the colour-blind and in grey."""

import numpy as np

_ANCHORS = (
    (0x44, 0x01, 0x54),
    (0x48, 0x28, 0x78),
    (0x3E, 0x49, 0x89),
    (0x31, 0x68, 0x8E),
    (0x26, 0x82, 0x8E),
    (0x1F, 0x9E, 0x89),
    (0x35, 0xB7, 0x79),
    (0x6E, 0xCE, 0x58),
    (0xB5, 0xDE, 0x2B),
    (0xFD, 0xE7, 0x25),
)
STEPS = 256


def colour_table(first: float = 0.0, last: float = 1.0) -> np.ndarray:
    """Return 256 colours as 0xffrrggbb (256), of a part of the map.

    Args:
        first: where it begins, 0 is dark blue.
        last: where it ends, 1 is yellow.
    """
    places = np.linspace(first, last, STEPS) * (len(_ANCHORS) - 1)
    parts = [
        np.interp(places, np.arange(len(_ANCHORS)), [anchor[part] for anchor in _ANCHORS])
        for part in range(3)
    ]
    red, green, blue = (np.rint(part).astype(np.uint32) for part in parts)
    table: np.ndarray = np.uint32(0xFF000000) | red << 16 | green << 8 | blue
    return table


def colours_of(values: np.ndarray, low: float, high: float, table: np.ndarray) -> np.ndarray:
    """Return the colours of values between two ends, which values beyond are taken for."""
    span = max(high - low, 1e-9)
    places = np.clip((values - low) * ((STEPS - 1) / span), 0, STEPS - 1)
    return table[places.astype(np.intp)]

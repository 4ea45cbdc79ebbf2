"""A scale of colours whose lightness rises evenly, so that equal steps look equal."""

import numpy as np

# Points along viridis, which is free for any use; between them it is straight enough.
_POINTS = np.array(
    [
        (68, 1, 84),
        (71, 44, 122),
        (59, 81, 139),
        (44, 113, 142),
        (33, 144, 141),
        (39, 173, 129),
        (92, 200, 99),
        (170, 220, 50),
        (253, 231, 37),
    ],
    dtype=float,
)


def scale_colours(shares: np.ndarray) -> np.ndarray:
    """Return colours for shares 0 .. 1 of the scale, dark to light, (..., 3) of 0 .. 255."""
    places = np.clip(shares, 0.0, 1.0) * (len(_POINTS) - 1)
    lanes = [np.interp(places, np.arange(len(_POINTS)), lane) for lane in _POINTS.T]
    return np.stack(lanes, axis=-1).round().astype(np.uint8)

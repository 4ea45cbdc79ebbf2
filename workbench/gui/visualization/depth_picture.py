"""A depth image as colours, and what one pixel of it says."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.gui.charts.colour_scale import colours_of
from workbench.gui.charts.ticks import number_text, round_step

TOO_NEAR = 0xFF000000
BEYOND = 0xFF8A8F98


@dataclass(frozen=True)
class DepthScale:
    """What the colours of a depth image stand for.

    Attributes:
        low: depth of the first colour [m].
        high: of the last one [m].
    """

    low: float
    high: float


def scale_of(depth: np.ndarray) -> DepthScale:
    """Return round ends around the depths that were measured."""
    finite = depth[np.isfinite(depth)]
    if len(finite) == 0:
        return DepthScale(0.0, 1.0)
    low, high = float(finite.min()), float(finite.max())
    step = round_step(max(high - low, 0.5), 6)
    return DepthScale(step * math.floor(low / step), step * math.ceil(high / step))


def depth_colours(depth: np.ndarray, scale: DepthScale, table: np.ndarray) -> np.ndarray:
    """Return a depth image as colours 0xffrrggbb: grey beyond range, black where too near."""
    colours = colours_of(
        np.where(np.isfinite(depth), depth, scale.low), scale.low, scale.high, table
    )
    colours[np.isposinf(depth) | np.isnan(depth)] = BEYOND
    colours[np.isneginf(depth)] = TOO_NEAR
    return colours


def depth_text(depth: float) -> str:
    """Return what a pixel says."""
    if math.isnan(depth):
        return "no measurement"
    if math.isinf(depth):
        return "nothing within range" if depth > 0.0 else "nearer than it measures"
    return f"{number_text(depth, 2)} m"

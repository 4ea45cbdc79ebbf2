"""Where a loop's margins are on its curves."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.gui.tuning.drawn_loop import DrawnLoop


@dataclass(frozen=True)
class Mark:
    """A margin on the curve: its frequency [rad/s], and the curve's value there [dB] or [rad]."""

    frequency: float
    value: float


def decibel(response: np.ndarray) -> np.ndarray:
    """Return the size of a response [dB]."""
    size: np.ndarray = 20.0 * np.log10(np.maximum(np.abs(response), 1e-12))
    return size


def unwrapped(frequency: np.ndarray, response: np.ndarray, crossover: float) -> np.ndarray:
    """Return the phase of a response without jumps (F) [rad].

    Args:
        frequency: (F), rising [rad/s].
        response: (F); NaN where it is not known.
        crossover: where it lies from -270 to 90 degrees; NaN for the first frequency.
    """
    phase = np.angle(response)
    known = np.isfinite(phase)
    if not known.any():
        return phase
    phase[known] = np.unwrap(phase[known])
    at = frequency[known][0] if math.isnan(crossover) else crossover
    there = float(np.interp(at, frequency[known], phase[known]))
    turns = round((there + math.pi) / (2.0 * math.pi) - 0.25)
    return phase - 2.0 * math.pi * turns


def phase_margin_mark(loop: DrawnLoop) -> Mark | None:
    """Return where |L| is 1 and the phase is a phase margin from -180 degrees; None for none."""
    if loop.margins is None or not loop.margins.stable or math.isinf(loop.margins.phase_margin):
        return None
    margin = loop.margins.phase_margin
    phase = unwrapped(loop.frequency, loop.open_loop, loop.crossover)
    found = [
        Mark(frequency, float(np.interp(frequency, loop.frequency, phase)))
        for frequency in _crossings(loop.frequency, decibel(loop.open_loop))
    ]
    off = (abs(abs(math.remainder(each.value - math.pi, math.tau)) - margin) for each in found)
    return min(zip(off, found, strict=True), key=lambda pair: pair[0], default=(0.0, None))[1]


def gain_margin_mark(loop: DrawnLoop, factor: float) -> Mark | None:
    """Return where the phase is -180 degrees and a factor makes |L| 1; None for none."""
    if loop.margins is None or not loop.margins.stable:
        return None
    if not math.isfinite(factor) or factor <= 0.0:
        return None
    size = decibel(loop.open_loop)
    phase = unwrapped(loop.frequency, loop.open_loop, loop.crossover)
    found = []
    for turns in range(-2, 2):
        level = -math.pi + 2.0 * math.pi * turns
        for frequency in _crossings(loop.frequency, phase - level):
            found.append(Mark(frequency, float(np.interp(frequency, loop.frequency, size))))
    wanted = -20.0 * math.log10(factor)
    nearest = min(found, key=lambda each: abs(each.value - wanted), default=None)
    return nearest if nearest is not None and abs(nearest.value - wanted) < 1.0 else None


def peak(frequency: np.ndarray, response: np.ndarray) -> Mark:
    """Return the largest size of a response, and its frequency [rad/s]."""
    place = int(np.nanargmax(np.abs(response)))
    return Mark(float(frequency[place]), float(np.abs(response[place])))


def _crossings(frequency: np.ndarray, values: np.ndarray) -> list[float]:
    """Return the frequencies [rad/s] at which values (F) change their sign."""
    places = np.flatnonzero((values[1:] > 0.0) != (values[:-1] > 0.0))
    log = np.log(frequency)
    share = values[places] / (values[places] - values[places + 1])
    found: list[float] = np.exp(log[places] + share * (log[places + 1] - log[places])).tolist()
    return found

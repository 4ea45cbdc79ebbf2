"""Metrics of many flown steps at once, for a search.

`step_metrics` gives times as whole samples. A search needs numbers that change smoothly with the
gains: here crossings are interpolated, and a sample is added, so that the times are never shorter
than those of `step_metrics`. Gains that meet a limit here meet it there, too.
"""

from typing import NamedTuple

import numpy as np

SETTLED = 0.02
"""Settling band as a share of the steady state, as in python-control."""


class FlightNumbers(NamedTuple):
    """Metrics of N steps, each (N); infinite if not reached, or if the flight diverged."""

    rise_time: np.ndarray
    settling_time: np.ndarray
    overshoot: np.ndarray
    steady_state_error: np.ndarray


def flight_numbers(
    time: np.ndarray, response: np.ndarray, command: float, diverged: np.ndarray
) -> FlightNumbers:
    """Return the metrics of steps.

    Args:
        time: (M) from the edge of the command on [s].
        response: (N, M). Rise, settling and overshoot are relative to its value at the edge, as a
            drone heavier than known to its controller sinks in the hover before.
        command: their target.
        diverged: (N) whether a response diverged, and has no metrics.
    """
    begin = response[:, 0]
    steady = np.where(diverged, np.nan, response[:, -1])
    with np.errstate(invalid="ignore"):  # the wrong direction counts as not reached
        steady = np.where((steady - begin) * command > 0.0, steady, np.nan)
        share = (response - begin[:, None]) / (steady - begin)[:, None]
        sample = time[1] - time[0]
        rise = _first_above(time, share, 0.9) - _first_above(time, share, 0.1) + sample
        settling = _last_outside(time, share) + sample
        overshoot = np.maximum(0.0, 100.0 * (share.max(axis=1) - 1.0))
        error = 100.0 * np.abs(steady / command - 1.0)
    return FlightNumbers(*map(_or_infinite, (rise, settling, overshoot, error)))


def _first_above(time: np.ndarray, share: np.ndarray, level: float) -> np.ndarray:
    """Return when each row first reaches a level (N) [s]."""
    at = np.argmax(share >= level, axis=1)
    return _crossing(time, share, at, np.full(len(share), level))


def _last_outside(time: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return when each row finally enters the settling band (N) [s]."""
    outside = np.abs(share - 1.0) >= SETTLED
    at = len(time) - np.argmax(outside[:, ::-1], axis=1)  # the first sample that stays inside
    late = at >= len(time)
    at = np.where(late, 0, at)
    before = share[np.arange(len(share)), np.maximum(at - 1, 0)]
    settled = _crossing(time, share, at, 1.0 + SETTLED * np.sign(before - 1.0))
    return np.where(late, np.inf, settled)


def _crossing(time: np.ndarray, share: np.ndarray, at: np.ndarray, level: np.ndarray) -> np.ndarray:
    """Return when each row crosses its level just before sample `at` (N) [s]."""
    rows, before = np.arange(len(share)), np.maximum(at - 1, 0)
    low, high = share[rows, before], share[rows, at]
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.where(high == low, 1.0, (level - low) / (high - low))
    return time[before] + np.clip(part, 0.0, 1.0) * (time[at] - time[before])


def _or_infinite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, np.inf)

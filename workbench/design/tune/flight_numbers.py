"""The numbers of many flown steps between samples, for a search.

`step_metrics` gives times as whole samples, as python-control does. A search needs numbers that
change smoothly with the gains: here crossings are interpolated, and a sample is added, so that the
times are never shorter than those of `step_metrics`. Gains that meet a limit here meet it there,
too.
"""

import numpy as np

from workbench.design.response_metrics import crossing_times
from workbench.design.step_metrics import RISE_SHARES, SETTLING_BAND, StepMetrics

SEARCHED_NUMBERS = ("rise_time", "settling_time", "overshoot", "steady_state_error")
"""Names of what `flight_numbers` measures."""


def flight_numbers(
    time: np.ndarray, response: np.ndarray, command: float, diverged: np.ndarray
) -> StepMetrics:
    """Return `SEARCHED_NUMBERS` (N) of steps; infinite if not reached, or if a flight diverged.

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
        start, end = (crossing_times(time, share, x) for x in RISE_SHARES)
        return StepMetrics(
            rise_time=_or_infinite(end - start + sample),
            settling_time=_or_infinite(_settling_times(time, share) + sample),
            overshoot=_or_infinite(np.maximum(0.0, 100.0 * (share.max(axis=1) - 1.0))),
            steady_state_error=_or_infinite(100.0 * np.abs(steady / command - 1.0)),
        )


def _settling_times(time: np.ndarray, share: np.ndarray) -> np.ndarray:
    """Return when each row finally enters the settling band (N) [s], NaN if it does not."""
    outside = np.abs(share - 1.0) >= SETTLING_BAND
    at = len(time) - np.argmax(outside[:, ::-1], axis=1)  # the first sample that stays inside
    late = at >= len(time)
    rows, after = np.arange(len(share)), np.where(late, 1, at)
    low, high = share[rows, after - 1], share[rows, after]
    edge = 1.0 + SETTLING_BAND * np.sign(low - 1.0)
    with np.errstate(invalid="ignore", divide="ignore"):
        part = np.clip((edge - low) / (high - low), 0.0, 1.0)
    entered = time[after - 1] + part * (time[after] - time[after - 1])
    return np.where(late, np.nan, entered)


def _or_infinite(values: np.ndarray) -> np.ndarray:
    return np.where(np.isfinite(values), values, np.inf)

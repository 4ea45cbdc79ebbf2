"""Numbers of responses to any setpoint: crossings, lag, noise."""

import math

import numpy as np

TRIED_LAGS_S = np.arange(0.0, 1.2, 0.01)
"""That a position may have [s]."""
NOISE_FROM_HZ = 20.0
"""What of a signal is faster is noise [Hz]: the rate loops of the shipped drones end below it."""
_FILTER_EDGE_S = 0.1
"""Of a stretch, that the filter needs to begin and to end [s]."""


def crossing_times(time: np.ndarray, response: np.ndarray, level: float) -> np.ndarray:
    """Return when responses (N, M) first reach a level (either sign), (N) [s], NaN if never."""
    reached = response * np.sign(level) >= abs(level)
    index = reached.argmax(axis=1)
    before = np.maximum(index - 1, 0)
    rows = np.arange(len(response))
    low, high = response[rows, before], response[rows, index]
    with np.errstate(divide="ignore", invalid="ignore"):
        part = np.where(index > 0, (level - low) / (high - low), 0.0)
    crossed = time[before] + part * (time[index] - time[before])
    return np.where(reached.any(axis=1), crossed, np.nan)


def crossing_time(time: np.ndarray, response: np.ndarray, level: float) -> float:
    """Return when a response first reaches `level` (either sign) [s], or NaN if it never does."""
    return float(crossing_times(time, np.asarray(response)[None, :], level)[0])


def response_lag(
    time: np.ndarray, setpoint: np.ndarray, response: np.ndarray, lags: np.ndarray = TRIED_LAGS_S
) -> float:
    """Return by how much a response (k) is late [s], by least squares with a gain and an offset.

    NaN where less than three samples are left behind the longest lag.

    Args:
        time: (k) [s].
        setpoint: (k).
        response: (k).
        lags: that are tried, rising from 0 [s].
    """
    known = time > time[0] + lags[-1]
    if known.sum() < 3:
        return math.nan
    found = []
    flown = response[known] - response[known].mean()
    for late in lags:
        past = np.interp(time[known] - late, time, setpoint)
        past = past - past.mean()
        power = float(past @ past)
        explained = float(past @ flown) ** 2 / power if power > 0.0 else 0.0
        found.append((-explained, float(late)))
    return min(found)[1]


def noise_rms(time: np.ndarray, values: np.ndarray) -> float:
    """Return the root mean square of what of a signal is faster than `NOISE_FROM_HZ`.

    A Butterworth high-pass of order 4, run forwards and backwards over each stretch without a gap.
    NaN where samples come too slowly for that, or no stretch is half a second long.

    Args:
        time: (k), rising [s].
        values: (k).
    """
    from scipy.signal import butter, sosfiltfilt  # slow to load

    if len(time) < 2:
        return math.nan
    period = float(np.median(np.diff(time)))
    if not period < 0.45 / NOISE_FROM_HZ:
        return math.nan
    sections = butter(4, NOISE_FROM_HZ, "highpass", fs=1.0 / period, output="sos")
    edge = max(1, round(_FILTER_EDGE_S / period))
    gaps = np.flatnonzero(np.diff(time) > 1.5 * period) + 1
    rest = [
        sosfiltfilt(sections, stretch)[edge:-edge]
        for stretch in np.split(values, gaps)
        if len(stretch) >= 5 * edge
    ]
    return float(np.sqrt(np.mean(np.concatenate(rest) ** 2))) if rest else math.nan

"""Numbers of step responses, many at once, by python-control's definitions.

They equal `control.step_info`, which takes one response at a time, and which comes with all of
scipy.signal: half a second to load.
"""

from dataclasses import dataclass

import numpy as np

LOWER, UPPER = 0.1, 0.9
"""Shares of the steady state between which the response rises."""
SETTLED = 0.02
"""It has settled within this share of the steady state."""


@dataclass(frozen=True)
class ResponseMetrics:
    """What `StepMetrics` has of one response, for N of them; (N) each.

    NaN for a response that does not reach the end; its peak is infinite, as python-control has it.

    Attributes:
        rise_time: from 10 % to 90 % of the steady state [s].
        settling_time: until it stays within 2 % of the steady state [s].
        overshoot: above the steady state [% of it].
        undershoot: to the wrong side of where it began [% of the steady state].
        peak: largest absolute value.
        peak_time: when [s].
        steady_state_value: value at the end.
        steady_state_error: of the steady state against the command [% of it].
        t90: when it first reaches 90 % of the command [s]; NaN if it never does.
    """

    rise_time: np.ndarray
    settling_time: np.ndarray
    overshoot: np.ndarray
    undershoot: np.ndarray
    peak: np.ndarray
    peak_time: np.ndarray
    steady_state_value: np.ndarray
    steady_state_error: np.ndarray
    t90: np.ndarray


def response_metrics(time: np.ndarray, response: np.ndarray, command: float) -> ResponseMetrics:
    """Return the metrics of responses to a command given at time 0.

    Args:
        time: (M) from 0 [s].
        response: (N, M), at rest at 0.
        command: what they should come to, in their unit; not zero.
    """
    steady = response[:, -1]
    ends = np.isfinite(steady)
    sign = np.sign(steady)
    forward = sign[:, None] * response
    with np.errstate(divide="ignore", invalid="ignore"):
        outside = np.abs(response / steady[:, None] - 1.0) >= SETTLED
        above = np.abs(forward.max(axis=1)) - np.abs(steady)
        overshoot = np.where(above > 0.0, np.abs(100.0 * above / steady), 0.0)
        lowest = np.take_along_axis(response, forward.argmin(axis=1)[:, None], axis=1)[:, 0]
        undershoot = np.where(sign * lowest < 0.0, -100.0 * lowest / steady, 0.0)
        peaks = np.abs(response).argmax(axis=1)
        peak = np.abs(np.take_along_axis(response, peaks[:, None], axis=1)[:, 0])
    begin = _first(sign[:, None] * (response - LOWER * steady[:, None]) >= 0.0)
    end = _first(sign[:, None] * (response - UPPER * steady[:, None]) >= 0.0)
    size = len(time)
    settled = np.where(outside.any(axis=1), size - outside[:, ::-1].argmax(axis=1), 0)
    settling = np.where(settled < size, time[np.minimum(settled, size - 1)], np.nan)

    def known(values: np.ndarray, otherwise: float = np.nan) -> np.ndarray:
        return np.where(ends, values, otherwise)

    return ResponseMetrics(
        rise_time=known(time[end] - time[begin]),
        settling_time=known(settling),
        overshoot=known(overshoot),
        undershoot=known(undershoot),
        peak=known(peak, np.inf),
        peak_time=known(time[peaks], np.inf),
        steady_state_value=known(steady),
        steady_state_error=known(100.0 * np.abs(steady - command) / abs(command)),
        t90=crossing_times(time, response, UPPER * command),
    )


def _first(true: np.ndarray) -> np.ndarray:
    """Return the index of the first true value of each row."""
    return true.argmax(axis=1)


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

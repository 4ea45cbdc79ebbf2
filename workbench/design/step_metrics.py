"""Numbers of a step response, in python-control's words and by its definitions."""

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class StepMetrics:
    """What `control.step_info` says of a response, and its distance from the command.

    Attributes:
        rise_time: from 10 % to 90 % of the steady state [s].
        settling_time: until it stays within 2 % of the steady state [s].
        overshoot: above the steady state [% of it].
        undershoot: to the wrong side of where it began [% of the steady state].
        peak: largest absolute value.
        peak_time: when [s].
        steady_state_value: value at the end.
        steady_state_error: of the steady state against the command [% of it].
    """

    rise_time: float
    settling_time: float
    overshoot: float
    undershoot: float
    peak: float
    peak_time: float
    steady_state_value: float
    steady_state_error: float


def step_metrics(time: np.ndarray, response: np.ndarray, command: float) -> StepMetrics:
    """Return the metrics of a response to a command given at time 0.

    Args:
        time: (N) from 0 [s].
        response: (N), at rest at 0.
        command: what it should come to, in the response's unit; not zero.
    """
    import control  # takes a second to load, which only steps should pay

    info = control.step_info(response, T=time)
    steady = float(info["SteadyStateValue"])
    return StepMetrics(
        rise_time=float(info["RiseTime"]),
        settling_time=float(info["SettlingTime"]),
        overshoot=float(info["Overshoot"]),
        undershoot=float(info["Undershoot"]),
        peak=float(info["Peak"]),
        peak_time=float(info["PeakTime"]),
        steady_state_value=steady,
        steady_state_error=100.0 * abs(steady - command) / abs(command),
    )


def crossing_time(time: np.ndarray, response: np.ndarray, level: float) -> float:
    """Return when a response first reaches `level` (either sign) [s], or NaN if it never does."""
    return float(crossing_times(time, np.asarray(response)[None, :], level)[0])


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

"""Numbers of a step response, in python-control's words and by its definitions."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.design.response_metrics import crossing_times, response_metrics, why_withheld


@dataclass(frozen=True)
class StepMetrics:
    """What `control.step_info` says of a response, and its distance from the command.

    NaN for what depends on beginning at rest or on settling, where the step did not.

    Attributes:
        rise_time: from 10 % to 90 % of the steady state [s].
        settling_time: until it stays within 2 % of the steady state [s].
        overshoot: above the steady state [% of it].
        undershoot: to the wrong side of where it began [% of the steady state].
        peak: largest absolute value.
        peak_time: when [s].
        steady_state_value: value at the end.
        steady_state_error: of the steady state against the command [% of it].
        withheld: why some are NaN, as a sentence; "" if none is for such a reason.
    """

    rise_time: float
    settling_time: float
    overshoot: float
    undershoot: float
    peak: float
    peak_time: float
    steady_state_value: float
    steady_state_error: float
    withheld: str = ""

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return {name: getattr(self, name) for name in NUMBERS}


NUMBERS = (
    "rise_time",
    "settling_time",
    "overshoot",
    "undershoot",
    "peak",
    "peak_time",
    "steady_state_value",
    "steady_state_error",
)
"""Names of what `StepMetrics` measures."""


def step_metrics(time: np.ndarray, response: np.ndarray, command: float) -> StepMetrics:
    """Return the metrics of a response to a command given at time 0.

    Args:
        time: (N) from 0 [s].
        response: (N), at rest at 0.
        command: what it should come to, in the response's unit; not zero.
    """
    many = response_metrics(time, np.asarray(response, dtype=float)[None, :], command)
    duration = float(time[-1])
    kept = many.withheld(duration, command)
    return StepMetrics(
        **{name: float(getattr(kept, name)[0]) for name in NUMBERS},
        withheld=why_withheld(many, duration, command),
    )


def number(value: float, form: str) -> str:
    """Return a number in a format such as ".3f", a dash where there is none."""
    return "—" if math.isnan(value) else format(value, form)


def crossing_time(time: np.ndarray, response: np.ndarray, level: float) -> float:
    """Return when a response first reaches `level` (either sign) [s], or NaN if it never does."""
    return float(crossing_times(time, np.asarray(response)[None, :], level)[0])

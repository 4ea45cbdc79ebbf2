"""Numbers of a flown step, by the definitions that all of the workbench shares."""

import math

from workbench.analyst.replies import StepNumbers
from workbench.gui.tuning.rounds import StepPart
from workbench.gui.tuning.trace import Trace
from workbench.response_metrics import response_metrics

FEWEST = 8
"""Samples of a step that has numbers."""
SAME = 1e-6
"""Times that differ by less are the same [s]."""


def measure_step(trace: Trace, part: StepPart) -> StepNumbers | None:
    """Return the numbers of a step; None before it is over, or where it is too short.

    Args:
        trace: of the round, from its edge on.
        part: the step in it.
    """
    if not len(trace) or trace.time[-1] < part.end - SAME:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    rise = flown.response - part.before
    found = response_metrics(flown.time, rise[None, :], part.jump)
    return StepNumbers(
        rise_time=float(found.rise_time[0]),
        settling_time=float(found.settling_time[0]),
        overshoot=float(found.overshoot[0]),
        steady_state_error=float(found.steady_state_error[0]),
        peak_rotor_use=float(flown.rotor_use.max()),
    )


def is_finite(numbers: StepNumbers) -> bool:
    """Return whether the step came to rise at all."""
    return math.isfinite(numbers.rise_time)

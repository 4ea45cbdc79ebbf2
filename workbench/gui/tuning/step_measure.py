"""Numbers of a flown step of a command or a load, by the definitions of all of the workbench."""

import math

from workbench.analysis.replies import StepNumbers, load_numbers
from workbench.design.response_metrics import load_metrics, response_metrics, why_withheld
from workbench.gui.tuning.rounds import StepPart
from workbench.gui.tuning.trace import Trace

FEWEST = 8
"""Samples of a step that has numbers."""
SAME = 1e-6
"""Times that differ by less are the same [s]."""
SAMPLED = 1 / 128
"""The last sample of a round may be so much before its end [s]."""


def measure_step(trace: Trace, part: StepPart, *, changed: bool = False) -> StepNumbers | None:
    """Return the numbers of a step; None before it is over, or where it is too short.

    Args:
        trace: of the round, from its edge on.
        part: the step in it.
        changed: whether gains changed while it was flown.
    """
    if not len(trace) or trace.time[-1] < part.end - SAME:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    rise = flown.response - part.before
    duration = float(flown.time[-1])
    found = response_metrics(flown.time, rise[None, :], part.jump)
    kept = found.withheld(duration, part.jump)
    names = ("rise_time", "settling_time", "overshoot", "steady_state_error")
    return StepNumbers(
        **{name: math.nan if changed else float(getattr(kept, name)[0]) for name in names},
        peak_rotor_use=float(flown.rotor_use.max()),
        withheld=why_withheld(found, duration, part.jump, changed=changed),
    )


def measure_load(trace: Trace, part: StepPart, *, changed: bool = False) -> StepNumbers | None:
    """Return the numbers of a step of a load; None before it is over, or where it is too short.

    Args: as of `measure_step`.
    """
    if not len(trace) or trace.time[-1] < part.end - SAMPLED:
        return None
    flown = trace.until(part.end).since(part.begin)
    if len(flown) < FEWEST or part.jump == 0.0:
        return None
    found = load_metrics(flown.time, flown.response - flown.response[0], changed=changed)
    return load_numbers(found, float(flown.rotor_use.max()))

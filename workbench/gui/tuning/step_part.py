"""The steps within a round of an excitation, its command, and the numbers of each step."""

from dataclasses import dataclass

import numpy as np

from workbench.design.load_metrics import LoadMetrics, load_metrics
from workbench.design.step_metrics import StepMetrics, step_metrics
from workbench.gui.tuning.round_trace import RoundTrace
from workbench.scenario.attitude_axes import AttitudeAxis
from workbench.scenario.excitation import Excitation, Shape
from workbench.scenario.loads import Load

CHIRP_CURVE_POINTS = 400
"""Number of points of a chirp."""
MIN_MEASURED_SAMPLES = 8
"""Least number of samples of a step with numbers."""
EQUAL_TIME_TOLERANCE_S = 1e-6
"""Times that differ by less are equal [s]."""
MAX_LAST_SAMPLE_GAP_S = 1 / 128
"""Largest time between a round's last sample and its end [s]."""


@dataclass(frozen=True)
class StepPart:
    """A step within a round, from one level of the command to another.

    Attributes:
        begin: time from the round's edge on [s].
        end: time at which the command changes again [s].
        before: previous level, in the unit of the excitation's amplitude.
        level: commanded level.
    """

    begin: float
    end: float
    before: float
    level: float

    @property
    def duration(self) -> float:
        """Duration of the commanded level [s]."""
        return self.end - self.begin

    @property
    def jump(self) -> float:
        """Change of the command."""
        return self.level - self.before


def step_parts(excitation: Excitation, *, again: bool = False) -> tuple[StepPart, ...]:
    """Return the steps of a round in order, except the return to rest; a chirp has none.

    Args:
        excitation: the flown excitation.
        again: whether an equal round was flown just before.
    """
    size, period = excitation.amplitude, excitation.period
    half = 0.5 * period
    match excitation.shape:
        case Shape.STEP:
            return (StepPart(0.0, period, 0.0, size),)
        case Shape.PULSE:  # the effect of a load ends when the drone is back
            over = excitation.round_time if isinstance(excitation.row, Load) else period
            return (StepPart(0.0, over, 0.0, size),)
        case Shape.DOUBLET:
            return (StepPart(0.0, half, 0.0, size), StepPart(half, period, size, -size))
        case Shape.SQUARE:
            first = StepPart(0.0, half, -size if again else 0.0, size)
            return (first, StepPart(half, period, size, -size))
        case Shape.CHIRP:
            return ()


def shown_length(excitation: Excitation) -> float:
    """Return how much of a round is shown [s]: after an attitude's steps, other loops fly back."""
    parts = step_parts(excitation)
    if isinstance(excitation.row, AttitudeAxis) and parts:
        return parts[-1].end
    return excitation.round_time


def measure_step(
    trace: RoundTrace,
    part: StepPart,
    *,
    decay: float = 0.0,
    changed: bool = False,
    rests: bool = True,
    unsteady: str = "",
) -> StepMetrics | None:
    """Return the numbers of a step; None before its end, or if it is too short.

    Args:
        trace: signals of the round, from its edge on.
        part: the step in it.
        decay: time by which its transient has decayed [s], 0 if unknown; see `step_metrics`.
        changed: whether gains changed during it.
        rests: whether nothing swung before, as far as the response does not tell.
        unsteady: why there is no steady state, see `step_metrics`.
    """
    flown = _flown_part(trace, part, EQUAL_TIME_TOLERANCE_S)
    if flown is None:
        return None
    return step_metrics(
        flown.time,
        flown.response - part.before,
        part.jump,
        decay=decay,
        changed=changed,
        rests=rests,
        unsteady=unsteady,
        peak_rotor_use=float(flown.rotor_use.max()),
    )


def measure_load(
    trace: RoundTrace, part: StepPart, *, changed: bool = False, rests: bool = True
) -> LoadMetrics | None:
    """Return the numbers of a step of a load; None before its end, or if it is too short.

    Args: as for `measure_step`.
    """
    flown = _flown_part(trace, part, MAX_LAST_SAMPLE_GAP_S)
    if flown is None:
        return None
    return load_metrics(
        flown.time,
        flown.response - flown.response[0],
        changed=changed,
        rests=rests,
        peak_rotor_use=float(flown.rotor_use.max()),
    )


def _flown_part(trace: RoundTrace, part: StepPart, tolerance: float) -> RoundTrace | None:
    """Return what was flown of a step; None before its end less some time [s], or if too short."""
    if not len(trace) or trace.time[-1] < part.end - tolerance:
        return None
    flown = trace.part(part.begin, part.end)
    return None if len(flown) < MIN_MEASURED_SAMPLES or part.jump == 0.0 else flown


def command_curve(excitation: Excitation, *, again: bool = False) -> tuple[np.ndarray, np.ndarray]:
    """Return times from the edge on [s] and commanded values of a round.

    Args:
        excitation: the flown excitation.
        again: whether an equal round was flown just before.
    """
    length = excitation.round_time
    if excitation.shape is Shape.CHIRP:
        time = np.linspace(0.0, length, CHIRP_CURVE_POINTS, endpoint=False)
        return time, np.array([excitation.command(float(each)) for each in time])
    times, values = [0.0], [0.0]
    parts = step_parts(excitation, again=again)
    values[0] = parts[0].before
    for part in parts:
        times += [part.begin, part.end]
        values += [part.level, part.level]
    if parts[-1].end < length:
        times += [parts[-1].end, length]
        values += [0.0, 0.0]
    return np.array(times), np.array(values)

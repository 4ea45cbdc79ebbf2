"""Numbers of the response to a step of a load."""

import math
from dataclasses import dataclass

import numpy as np

from workbench.design.step_metrics import SETTLED_LAST_SHARE, StepMetrics, step_info_json

LOAD_SETTLING_BAND = 0.05
"""Share of the peak within which it has settled."""


@dataclass(frozen=True)
class LoadMetrics:
    """What is measured of one response to a load; NaN where it has not settled.

    Attributes:
        peak: largest deviation, in the response's unit.
        peak_time: when [s].
        settling_time: until it stays within 5 % of the peak of its steady state [s].
        steady_state_error: deviation at the end [% of the peak].
        withheld: why some are NaN, as a sentence; "" if none is.
        peak_rotor_use: largest share of its speed limit at which any rotor ran, 0 .. 1; NaN if it
            was not measured.
    """

    peak: float
    peak_time: float
    settling_time: float
    steady_state_error: float
    withheld: str = ""
    peak_rotor_use: float = math.nan

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return {name: getattr(self, name) for name in LOAD_NUMBERS}

    def to_json(self) -> dict[str, float | str]:
        """Return the numbers for JSON, by the names of python-control's `step_info`."""
        return step_info_json(self.numbers, self.withheld)


LOAD_NUMBERS = ("peak", "peak_time", "settling_time", "steady_state_error")
"""Names of what `LoadMetrics` measures."""


ResponseMetrics = StepMetrics | LoadMetrics
"""The numbers of a step of a command, or of a load."""


def load_metrics(
    time: np.ndarray,
    response: np.ndarray,
    *,
    changed: bool = False,
    rests: bool = True,
    peak_rotor_use: float = math.nan,
) -> LoadMetrics:
    """Return the metrics of a response to a load that begins at time 0.

    Args:
        time: (N) from 0 [s].
        response: (N) deviation from where it was at 0.
        changed: whether parameters changed while it was flown.
        rests: whether nothing swung before.
        peak_rotor_use: largest share of its speed limit at which any rotor ran.
    """
    size = np.abs(response)
    place = int(size.argmax())
    peak, duration = float(size[place]), float(time[-1])
    outside = np.flatnonzero(np.abs(response - response[-1]) > LOAD_SETTLING_BAND * peak)
    first = outside[-1] + 1 if len(outside) else 0
    said = ""
    if changed:
        said = "parameters changed while the load acted; fly it again"
    elif not rests:
        said = "the load did not begin at rest; let the drone settle first"
    elif not math.isfinite(peak):
        said = "the drone was lost"
    elif peak == 0.0 or time[first] > (1.0 - SETTLED_LAST_SHARE) * duration:
        said = f"the drone has not settled within {duration:.3g} s; let the load act for longer"
    return LoadMetrics(
        peak=peak if rests and not changed else math.nan,
        peak_time=float(time[place]) if rests and not changed else math.nan,
        settling_time=math.nan if said else float(time[first]),
        steady_state_error=math.nan if said else 100.0 * float(size[-1]) / peak,
        withheld=said,
        peak_rotor_use=peak_rotor_use,
    )

"""Numbers of a response to a step of a load: how far it goes, and when it is back.

With x the deviation from where it was before the load: the peak is the largest |x|, the settling
time that from which on x stays within 5 % of the peak of its steady state, and the steady-state
error what then is left of x. A law with integral action leaves nothing: there the settling time is
that until the drone is back within 5 % of the peak.
"""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from workbench.design.response_metrics import LAST_PART

BACK = 0.05
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
    """

    peak: float
    peak_time: float
    settling_time: float
    steady_state_error: float
    withheld: str = ""

    @property
    def numbers(self) -> dict[str, float]:
        """The numbers by name."""
        return {name: getattr(self, name) for name in LOAD_NUMBERS}


LOAD_NUMBERS = tuple(field.name for field in dataclasses.fields(LoadMetrics))[:-1]
"""Names of what `LoadMetrics` measures."""


def load_metrics(time: np.ndarray, response: np.ndarray, *, changed: bool = False) -> LoadMetrics:
    """Return the metrics of a response to a load that begins at time 0.

    Args:
        time: (N) from 0 [s].
        response: (N) deviation from where it was at 0.
        changed: whether parameters changed while it was flown.
    """
    size = np.abs(response)
    place = int(size.argmax())
    peak, duration = float(size[place]), float(time[-1])
    outside = np.flatnonzero(np.abs(response - response[-1]) > BACK * peak)
    first = outside[-1] + 1 if len(outside) else 0
    said = ""
    if changed:
        said = "parameters changed while the load acted; fly it again"
    elif not math.isfinite(peak):
        said = "the drone was lost"
    elif peak == 0.0 or time[first] > (1.0 - LAST_PART) * duration:
        said = f"the drone has not settled within {duration:.3g} s; let the load act for longer"
    return LoadMetrics(
        peak=math.nan if changed else peak,
        peak_time=math.nan if changed else float(time[place]),
        settling_time=math.nan if said else float(time[first]),
        steady_state_error=math.nan if said else 100.0 * float(size[-1]) / peak,
        withheld=said,
    )

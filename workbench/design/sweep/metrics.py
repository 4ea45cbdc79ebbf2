"""What a sweep measures of each candidate, and which way is better."""

import math
from typing import NamedTuple

import numpy as np

from workbench.common.errors import find_row

ARRIVED = 5.0
"""A step that is farther from its command in the end did not get there [%]."""
SAME = 5e-4
"""Values that differ by a smaller share read alike with the digits that are shown, and count as
equal."""
_LEAST = {"s": 1e-4, "%": 0.01, "": 1e-4, "1": 1e-4, "rad": 1e-4}
"""So do those that differ by less than this, by unit; of the command's unit as share of the
command. An overshoot of 1e-14 % is rounding."""


class SweepMetric(NamedTuple):
    """A number of a candidate.

    Attributes:
        name: as python-control has it.
        unit: of its values; "" for that of the command.
        better: -1 if smaller is better, 1 if larger is, 0 if nearer to the command is.
    """

    name: str
    unit: str
    better: int = -1


FLOWN: tuple[SweepMetric, ...] = (
    SweepMetric("rise_time", "s"),
    SweepMetric("settling_time", "s"),
    SweepMetric("overshoot", "%"),
    SweepMetric("undershoot", "%"),
    SweepMetric("peak", "", 0),
    SweepMetric("peak_time", "s"),
    SweepMetric("steady_state_value", "", 0),
    SweepMetric("steady_state_error", "%"),
    SweepMetric("peak_rotor_use", "1"),
)
"""Of the flight."""
MARGINS: tuple[SweepMetric, ...] = (
    SweepMetric("phase_margin", "rad", 1),
    SweepMetric("gain_margin", "1", 1),
    SweepMetric("delay_margin", "s", 1),
    SweepMetric("disk_margin", "1", 1),
)
"""Of the linear model's loop."""


def find_metric(name: str) -> SweepMetric:
    """Return the metric of a name.

    Raises:
        WorkbenchError: if there is none.
    """
    return find_row("metric", name, (*FLOWN, *MARGINS))


def cost(metric: SweepMetric, values: np.ndarray, command: float) -> np.ndarray:
    """Return values as costs: the smaller the better, infinite where there is no value."""
    far = np.abs(np.abs(values) - abs(command))
    costs = -metric.better * values if metric.better else far
    return np.where(np.isnan(costs), np.inf, costs)


def resolution(metric: SweepMetric, values: np.ndarray, command: float) -> float:
    """Return the smallest difference between values of a metric that means something."""
    finite = np.abs(values[np.isfinite(values)])
    least = _LEAST[metric.unit] * (abs(command) if metric.unit == "" else 1.0)
    return max(least, SAME * float(finite.max(initial=0.0)))


def for_people(unit: str) -> tuple[float, str]:
    """Return what a value is multiplied by to be shown, and its unit then; angles in degrees."""
    if unit == "rad":
        return math.degrees(1.0), "deg"
    return 1.0, "" if unit == "1" else unit

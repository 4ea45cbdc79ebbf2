"""Ranges of gains in which a loop is stable."""

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from workbench.analysis.queries import FindRanges
from workbench.analysis.subject import AnalysedVehicle
from workbench.analysis.work import Work, Working
from workbench.common.parameter import Parameter
from workbench.design.judge.loop_judgement import opened_to_steer
from workbench.design.judge.loop_response import closed_poles, growing_poles
from workbench.design.linear.model import LinearModel

RANGE_SCAN_POINTS = 8
"""Number of values tried between a gain's own and each limit."""
MIN_TRIED_SHARE = 1e-3
"""Smallest value tried, as a share of the limit; 0 has no logarithm."""
RANGE_END_TOLERANCE = 2e-3
"""Relative accuracy of a range's ends."""
RangeSearch = Iterator[tuple[float, float] | None]


def find_ranges(subject: AnalysedVehicle, question: FindRanges, work: Work) -> Working:
    """Compute the stable range of each gain, by the eigenvalues of the closed loop.

    A gain without a stable value within its limits is left out. If its own value is unstable, the
    range is the nearest stable one that a coarse search finds.
    """
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    found: dict[str, tuple[float, float]] = {}
    loops = subject.controller.loops
    # parameters that affect the loops' stability
    for name in dict.fromkeys(name for loop in loops for name in loop.gains):
        row = subject.table.find(name)
        for span in _stable_span(row, gains[name], _stability_test(subject, gains, name)):
            work.check()
            if span is not None:
                found[names.get(name, name)] = span
            yield None
    yield found


def is_stable(holding: LinearModel) -> bool:
    """Return whether a closed loop is stable, both while it holds a place and while steered."""
    return not any(
        growing_poles(closed_poles(model), model.period).any()
        for model in (opened_to_steer(holding), holding)
    )


def _stability_test(
    subject: AnalysedVehicle, gains: Mapping[str, float], name: str
) -> Callable[[float], bool]:
    """Return a function that tells whether the loop is stable with a value of a gain."""
    return lambda value: is_stable(subject.model({**gains, name: value}))


def _stable_span(row: Parameter, own: float, stable: Callable[[float], bool]) -> RangeSearch:
    """Yield None for each value tried, then the range of stable values, if there is one."""
    values = [own, *_trial_values(row, own)]
    looked: dict[float, bool] = {}
    for value in values:
        looked[value] = stable(value)
        yield None
    grid = sorted(looked)
    inside = [value for value in grid if looked[value]]
    if not inside:
        return
    start = grid.index(
        min(
            inside, key=lambda value: abs(_slider_position(row, value) - _slider_position(row, own))
        )
    )
    first = last = start
    while first > 0 and looked[grid[first - 1]]:
        first -= 1
    while last < len(grid) - 1 and looked[grid[last + 1]]:
        last += 1
    ends = []
    for inner, outer in ((first, first - 1), (last, last + 1)):
        good = grid[inner]
        if 0 <= outer < len(grid):
            bad = grid[outer]
            while abs(bad - good) > RANGE_END_TOLERANCE * max(good, MIN_TRIED_SHARE * row.maximum):
                middle = 0.5 * (good + bad)
                good, bad = (middle, bad) if stable(middle) else (good, middle)
                yield None
        ends.append(good)
    yield ends[0], ends[1]


def _trial_values(row: Parameter, own: float) -> list[float]:
    """Return the first values to try, from limit to limit, evenly spaced in their logarithm."""
    least = max(row.minimum, MIN_TRIED_SHARE * row.maximum)
    middle = min(max(own, least), row.maximum)
    below = np.geomspace(least, middle, RANGE_SCAN_POINTS + 1)
    above = np.geomspace(middle, row.maximum, RANGE_SCAN_POINTS + 1)
    return [row.minimum, *below[:-1].tolist(), *above[1:-1].tolist(), row.maximum]


def _slider_position(row: Parameter, value: float) -> float:
    """Return a value's position on a logarithmic slider."""
    return math.log(max(value, MIN_TRIED_SHARE * row.maximum))

"""Within which values of each gain the loop is stable, the others as they are."""

import math
from collections.abc import Callable, Iterator, Mapping

import numpy as np

from workbench.analysis.judging import opened_to_steer
from workbench.analysis.questions import FindRanges
from workbench.analysis.replies import Ranges
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.design.judge.loop_response import INTEGRATOR, closed_poles, growth_rate
from workbench.design.linear.model import LinearModel
from workbench.scenario.parameters import Parameter

COARSE = 8
"""Values looked at between a gain's own and its limit, each way."""
LEAST = 1e-3
"""The smallest of them, as share of the largest allowed; 0 has no logarithm."""
EXACT = 2e-3
"""How exact the border is, as share of the value there."""

Search = Iterator[tuple[float, float] | None]


def find_ranges(subject: Subject, question: FindRanges, work: Work) -> Working:
    """Answer between which values each gain may lie, by the eigenvalues of the closed loop.

    A gain with which nothing is stable within its limits is left out. Where its own value is not,
    the range is the nearest one that is, as far as a coarse look finds it.
    """
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    found: dict[str, tuple[float, float]] = {}
    loops = subject.table.controller.loops
    # what the loops' stability depends on
    for name in dict.fromkeys(name for loop in loops for name in loop.gains):
        row = subject.table.find(name)
        for span in _stable_span(row, gains[name], _test(subject, gains, name)):
            work.check()
            if span is not None:
                found[names.get(name, name)] = span
            yield None
    yield Ranges(question.gains, found)


def is_stable(holding: LinearModel) -> bool:
    """Return whether a closed loop is, holding a place and steered."""
    return all(
        growth_rate(closed_poles(model), model.period) < INTEGRATOR
        for model in (opened_to_steer(holding), holding)
    )


def _test(subject: Subject, gains: Mapping[str, float], name: str) -> Callable[[float], bool]:
    """Return what tells whether a gain may have a value."""
    return lambda value: is_stable(subject.models.model({**gains, name: value}))


def _stable_span(row: Parameter, own: float, stable: Callable[[float], bool]) -> Search:
    """Give None for every look, and the span of stable values in the end, if there is one."""
    values = [own, *_spread(row, own)]
    looked: dict[float, bool] = {}
    for value in values:
        looked[value] = stable(value)
        yield None
    grid = sorted(looked)
    inside = [value for value in grid if looked[value]]
    if not inside:
        return
    start = grid.index(min(inside, key=lambda value: abs(_place(row, value) - _place(row, own))))
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
            while abs(bad - good) > EXACT * max(good, LEAST * row.maximum):
                middle = 0.5 * (good + bad)
                good, bad = (middle, bad) if stable(middle) else (good, middle)
                yield None
        ends.append(good)
    yield ends[0], ends[1]


def _spread(row: Parameter, own: float) -> list[float]:
    """Return values to look at first, from limit to limit, as dense as their logarithms are."""
    least = max(row.minimum, LEAST * row.maximum)
    middle = min(max(own, least), row.maximum)
    below = np.geomspace(least, middle, COARSE + 1)
    above = np.geomspace(middle, row.maximum, COARSE + 1)
    return [row.minimum, *below[:-1].tolist(), *above[1:-1].tolist(), row.maximum]


def _place(row: Parameter, value: float) -> float:
    """Return where a value lies, as a slider's logarithm has it."""
    return math.log(max(value, LEAST * row.maximum))

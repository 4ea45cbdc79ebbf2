"""Stability of the hover with given gains: margins, poles, and stable ranges of gains."""

import math
from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from workbench.analysis.questions import (
    DrawFrequency,
    FindRanges,
    Judge,
    JudgePlantInput,
    PlanMeasurement,
)
from workbench.analysis.replies import (
    FrequencyCurves,
    Judged,
    JudgedLoop,
    JudgedPlantInput,
    MeasurementPlanned,
    Ranges,
)
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.design.judge.gang_of_four import gang_of_four
from workbench.design.judge.loop_judgement import growing_loops
from workbench.design.judge.loop_measurement import loop_injection
from workbench.design.judge.loop_response import INTEGRATOR, closed_poles, growth_rate
from workbench.design.judge.margins import LoopMargins, all_margins
from workbench.design.judge.modes import natural_poles
from workbench.design.judge.multiloop import multiloop_margin
from workbench.design.judge.phase_budget import PARTS
from workbench.design.linear.model import LinearModel
from workbench.design.linear.operating_point import HOLDING, HOVER
from workbench.scenario.parameters import Parameter

COARSE = 8
"""Number of values tried between a gain's own and each limit."""
Turned = tuple[tuple[str, float], ...]
"""Phase by the name of its cause [rad]."""
LEAST = 1e-3
"""Smallest value tried, as a share of the limit; 0 has no logarithm."""
EXACT = 2e-3
"""Relative accuracy of a range's ends."""
Search = Iterator[tuple[float, float] | None]
FORGOTTEN = 0.05
"""A smaller sampled pole is left out: it decays within two samples, and rounding moves it."""


def find_ranges(subject: Subject, question: FindRanges, work: Work) -> Working:
    """Answer the stable range of each gain, by the eigenvalues of the closed loop.

    A gain without a stable value within its limits is left out. If its own value is unstable, the
    range is the nearest stable one that a coarse search finds.
    """
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    found: dict[str, tuple[float, float]] = {}
    loops = subject.table.controller.loops
    # parameters that affect the loops' stability
    for name in dict.fromkeys(name for loop in loops for name in loop.gains):
        row = subject.table.find(name)
        for span in _stable_span(row, gains[name], _test(subject, gains, name)):
            work.check()
            if span is not None:
                found[names.get(name, name)] = span
            yield None
    yield Ranges(question, found)


def is_stable(holding: LinearModel) -> bool:
    """Return whether a closed loop is stable, both while it holds a place and while steered."""
    return all(
        growth_rate(closed_poles(model), model.period) < INTEGRATOR
        for model in (opened_to_steer(holding), holding)
    )


def _test(subject: Subject, gains: Mapping[str, float], name: str) -> Callable[[float], bool]:
    """Return a function that tells whether the loop is stable with a value of a gain."""
    return lambda value: is_stable(subject.model({**gains, name: value}))


def _stable_span(row: Parameter, own: float, stable: Callable[[float], bool]) -> Search:
    """Yield None for each value tried, then the range of stable values, if there is one."""
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
    """Return the first values to try, from limit to limit, evenly spaced in their logarithm."""
    least = max(row.minimum, LEAST * row.maximum)
    middle = min(max(own, least), row.maximum)
    below = np.geomspace(least, middle, COARSE + 1)
    above = np.geomspace(middle, row.maximum, COARSE + 1)
    return [row.minimum, *below[:-1].tolist(), *above[1:-1].tolist(), row.maximum]


def _place(row: Parameter, value: float) -> float:
    """Return a value's position on a logarithmic slider."""
    return math.log(max(value, LEAST * row.maximum))


def judge(subject: Subject, question: Judge, _: Work) -> Working:
    """Answer the stability with given gains, as `live_margins` does.

    Poles are those of the sampled loop that flies, in continuous terms, s = ln(z) / period, while
    the place is held: then every gain affects some of them.
    """
    holding = subject.model(subject.gains(question.gains))
    steering = opened_to_steer(holding)
    margins = _margins(steering, hold=False) | _margins(holding, hold=True)
    stable = all(each.stable for each in margins.values())
    steered = () if stable else growing_loops(steering)
    held = () if stable or steered else growing_loops(holding)
    growing = steered + held
    turned = _turned(subject, (steering, holding), margins, question.gains) if stable else {}
    yield Judged(
        asked=question,
        loops=tuple(
            JudgedLoop(
                **vars(margins[each.name]),
                name=each.name,
                growing=each.name in growing,
                turned=turned.get(each.name, ()),
            )
            for each in holding.loops
        ),
        poles=shown_poles(holding),
        stable=stable,
        said=_said(steered, held),
    )


def judge_plant_input(subject: Subject, question: JudgePlantInput, _: Work) -> Working:
    """Answer the disk margin of simultaneous force and moments, as `workbench judge` does."""
    gains = subject.linear_gains(question.gains)
    found = []
    for point in (HOVER, HOLDING):
        found.append(multiloop_margin(subject.study.plant_input(point, gains)).disk_margin)
        yield None
    yield JudgedPlantInput(question, *found)


def draw_frequency(subject: Subject, question: DrawFrequency, _: Work) -> Working:
    """Answer the frequency response of one loop, of the model that margins are computed with.

    For a loop that holds a place, the place is held; for all others the pilot steers.
    """
    loop = subject.table.controller.loop(question.loop)
    holding = subject.model(subject.gains(question.gains))
    found = gang_of_four(holding if loop.hold else opened_to_steer(holding), loop, question.cut)
    yield FrequencyCurves(**vars(found), asked=question)


def plan_measurement(subject: Subject, question: PlanMeasurement, _: Work) -> Working:
    """Answer the injection that a loop tolerates, by a model of the flight."""
    loop = subject.table.controller.loop(question.loop)
    gains, point = subject.linear_gains(question.gains), HOLDING if loop.hold else HOVER
    model = subject.study.sampled(point, gains)
    injection = loop_injection(model, loop, subject.study.vehicle, question.cut)
    yield MeasurementPlanned(question, injection, loop.hold)


def opened_to_steer(holding: LinearModel) -> LinearModel:
    """Return a closed loop with its position loops opened, as while a pilot steers."""
    steering = holding.opened([loop.error for loop in holding.loops if loop.hold])
    return replace(steering, trim=replace(steering.trim, point=HOVER))


def shown_poles(model: LinearModel) -> np.ndarray:
    """Return a closed loop's poles in continuous terms [1/s], except those that decay at once.

    Poles on the negative real axis of z appear at half the sampling rate.
    """
    poles = closed_poles(model)
    return natural_poles(poles[np.abs(poles) > FORGOTTEN], model.period)


def _margins(model: LinearModel, *, hold: bool) -> dict[str, LoopMargins]:
    """Return the margins of the loops that close only while a place is held, or of the rest."""
    loops = [loop for loop in model.loops if loop.hold is hold]
    found = all_margins(model, [loop.point("actuator") for loop in loops])
    return {loop.name: margins for loop, margins in zip(loops, found, strict=True)}


def _turned(
    subject: Subject,
    models: tuple[LinearModel, LinearModel],
    margins: Mapping[str, LoopMargins],
    asked: Mapping[str, float],
) -> dict[str, Turned]:
    """Return the causes of phase lag and lead of each loop."""
    crossovers = {name: each.crossover for name, each in margins.items()}
    gains = subject.linear_gains(asked)
    return {
        budget.loop: tuple((part, getattr(budget, part)) for part in PARTS)
        for model in models
        for budget in subject.phases.budgets(model, crossovers, gains)
    }


def _said(steered: tuple[str, ...], held: tuple[str, ...]) -> str:
    """Return a sentence about what is unstable, "" if all is stable."""
    if steered:
        return f"unstable: a swing grows through {_listed(steered)}"
    return f"holding a place is unstable: a swing grows through {_listed(held)}" if held else ""


def _listed(names: tuple[str, ...]) -> str:
    words = [name.replace("_", " ") for name in names]
    return " and ".join([", ".join(words[:-1]), words[-1]] if len(words) > 1 else words)

"""A metric of a step over two gains around those in use, drawn band by band."""

import numpy as np

from workbench.analysis.predicting import check_short, ready_engine
from workbench.analysis.questions import DrawMap
from workbench.analysis.replies import Mapped
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.common.errors import unknown_name
from workbench.design.metrics import find_metric
from workbench.design.sweep.ranges import SweepRange
from workbench.design.sweep.sweep import gain_map
from workbench.scenario.axes import find_axis

POINTS = 25
"""Along each axis; odd, so that the gains themselves are in the middle."""
BAND = 2
"""Rows that are flown before something more urgent is looked for; a range has two values."""
LONGEST = 10.0
"""Of the steps: a band of them takes 20 ms then, for which margins would have to wait [s]."""
FACTOR = 2.0
"""The map reaches from a gain over this to this times the gain, within its limits."""
SHARE = 0.1
"""Of a gain's largest value, to which a map goes from a gain of 0."""


def draw_map(subject: Subject, question: DrawMap, work: Work) -> Working:
    """Answer what a metric is around gains, by a compiled flight for each point."""
    step = question.step
    check_short(step, LONGEST)
    gains = subject.gains(question.gains)
    names = (subject.flown.gain_of(name) for name in (question.x, question.y))
    x, y = (_around(subject, name, gains) for name in names)
    engine = yield from ready_engine(subject)
    values = np.full((y.points, x.points), np.nan)
    for first in range(0, y.points, BAND):
        work.check()
        start = min(first, y.points - BAND)  # the last band has a row of the one before
        low, *_, high = y.grid[start : start + BAND]
        band = gain_map(
            engine,
            gains,
            x,
            SweepRange(y.name, float(low), float(high), BAND, log=y.log),
            metric=question.metric,
            axis=step.axis,
            amplitude=step.amplitude,
            duration=step.duration,
            heading=step.heading,
        )
        assert band is not None  # nothing stops it
        values[start : start + BAND] = band.values
        yield None
    unit = find_metric(question.metric).unit_for(find_axis(step.axis).unit)
    yield Mapped(question, x.grid, y.grid, values, unit)


def _around(subject: Subject, name: str, gains: dict[str, float]) -> SweepRange:
    """Return the values of a gain around its own."""
    if name not in subject.law:
        raise unknown_name("gain", name, subject.law)
    row, own = subject.table.find(name), gains[name]
    if own <= 0.0:
        return SweepRange(name, row.minimum, SHARE * row.maximum, POINTS)
    low, high = max(own / FACTOR, row.minimum), min(own * FACTOR, row.maximum)
    return SweepRange(name, low, high, POINTS, log=True)

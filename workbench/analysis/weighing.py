"""Which gain moves the numbers of a step most: exact derivatives, carried in flight."""

import math
from dataclasses import replace

from workbench.analysis.predicting import check_short
from workbench.analysis.questions import Weigh
from workbench.analysis.replies import Weighed, Weight
from workbench.analysis.subject import Subject
from workbench.analysis.work import Work, Working
from workbench.design.judge.sensitivity import Sensitivity, step_sensitivity

PERCENT = 0.01
NOTHING = 1e-6
"""A slope of this share of the strongest is rounding."""


def weigh(subject: Subject, question: Weigh, work: Work) -> Working:
    """Answer what a percent more of each gain does to each metric of a step."""
    step = question.step
    check_short(step)
    found = step_sensitivity(
        step.axis,
        step.amplitude,
        duration=step.duration,
        heading=step.heading,
        scenario=subject.judged,
        settings=subject.gains(question.gains),
        progress=work.check,
    )
    gains, names = subject.gains(question.gains), subject.asked_names(question.gains)
    weights = {
        each.metric: tuple(
            replace(weight, gain=names.get(weight.gain, weight.gain))
            for weight in _weights(each, gains)
        )
        for each in found
    }
    yield Weighed(question.gains, step, weights)


def _weights(sensitivity: Sensitivity, gains: dict[str, float]) -> tuple[Weight, ...]:
    """Return what gains do to a metric, the strongest first, without those that do nothing.

    A metric of 0, as the undershoot of what never turns back, has none: its slope is rounding.
    """
    if not sensitivity.value:
        return ()
    slopes = [
        Weight(name, PERCENT * gains[name] * slope)
        for name, slope in sensitivity.derivatives.items()
    ]
    known = [each for each in slopes if math.isfinite(each.slope)]
    least = NOTHING * max((abs(each.slope) for each in known), default=0.0)
    acting = [each for each in known if abs(each.slope) > least]
    return tuple(sorted(acting, key=lambda each: -abs(each.slope)))

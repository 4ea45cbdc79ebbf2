"""Differences of the loops of two control laws."""

import dataclasses
import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import response_margins
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.forms import form_of

PLANT_INPUT_CHANNELS = (
    ("z", "force"),
    ("roll", "moment_x"),
    ("pitch", "moment_y"),
    ("yaw", "moment_z"),
)
COMPARED_DECADE_RATIO = 30.0
"""Ratio of the crossover to the lowest frequency."""
COMPARED_FREQUENCIES = 200
STEERING_POINT = OperatingPoint()


@dataclass(frozen=True)
class LoopDifference:
    """The difference between loops of two laws, opened at the plant input.

    Attributes:
        channel: z, roll, pitch or yaw.
        crossover: of the first [rad/s].
        other: crossover of the second [rad/s].
        largest: of |L2 / L1 - 1| from a thirtieth of the crossover up to it.
        at: frequency of the largest difference [rad/s].
    """

    channel: str
    crossover: float
    other: float
    largest: float
    at: float


def loop_differences(
    old: LinearStudy,
    new: LinearStudy,
    values: Mapping[str, float],
    others: Mapping[str, float],
) -> tuple[LoopDifference, ...]:
    """Compare the loops of two laws in hover, while the pilot steers.

    Args:
        old: study of the vehicle with the first law.
        new: study of the same vehicle with the second law.
        values: of the first law's parameters.
        others: of the second's.
    """
    found = []
    names = [signal for _, signal in PLANT_INPUT_CHANNELS]
    loops = [
        loop_responses(study.plant_input(STEERING_POINT, gains), names)
        for study, gains in ((old, values), (new, others))
    ]
    margins = [response_margins(each) for each in loops]
    for k, (channel, _) in enumerate(PLANT_INPUT_CHANNELS):
        crossover, other = (each[k].crossover for each in margins)
        largest = at = math.nan
        if math.isfinite(crossover):
            grid = np.geomspace(crossover / COMPARED_DECADE_RATIO, crossover, COMPARED_FREQUENCIES)
            one, two = (each.at(grid)[k] for each in loops)
            apart = np.abs(two / one - 1.0)
            worst = int(np.argmax(apart))
            largest, at = float(apart[worst]), float(grid[worst])
        found.append(LoopDifference(channel, crossover, other, largest, at))
    return tuple(found)


def gains_alone(
    old: LinearStudy,
    new: LinearStudy,
    values: Mapping[str, float],
    others: Mapping[str, float],
) -> tuple[LoopDifference, ...]:
    """Compare with both laws at the shorter of their periods, without own filters and slower parts.

    Arguments are those of `loop_differences`.
    """
    period = min(study.scenario.rates.control_period for study in (old, new))
    return loop_differences(
        _at_period(old, period),
        _at_period(new, period),
        {**values, **dict.fromkeys(form_of(old.controller).filters, 0.0)},
        {**others, **dict.fromkeys(form_of(new.controller).filters, 0.0)},
    )


def _at_period(study: LinearStudy, period: float) -> LinearStudy:
    """Return a study with the law at a period, if it has none of its own, and all parts in each."""
    scenario, law = study.scenario, study.controller
    if law.period is None and scenario.rates.control_period != period:
        rates = dataclasses.replace(scenario.rates, control_period=period)
        scenario = dataclasses.replace(scenario, rates=rates)
    elif not law.dividers:
        return study
    return study.like(scenario, dataclasses.replace(law, dividers=(1,) * len(law.dividers)))

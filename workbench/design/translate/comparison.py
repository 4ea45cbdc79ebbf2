"""How much the loops of two laws differ on one vehicle, at the place that every law has."""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from workbench.design.judge.loop_response import loop_responses
from workbench.design.judge.margins import response_margins
from workbench.design.linear.operating_point import OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.design.translate.forms import form_of
from workbench.scenario.scenario import Rates, Scenario

CHANNELS = (("z", "force"), ("roll", "moment_x"), ("pitch", "moment_y"), ("yaw", "moment_z"))
BELOW = 30.0
"""Frequencies reach so many times below the crossover."""
COUNT = 200
STEERING = OperatingPoint()


@dataclass(frozen=True)
class Difference:
    """By how much a loop of one law is not that of another, opened at the plant's input.

    Attributes:
        channel: z, roll, pitch or yaw.
        crossover: of the first [rad/s].
        other: crossover of the second [rad/s].
        largest: of |L2 / L1 - 1| from a thirtieth of the crossover up to it.
        at: where that is [rad/s].
    """

    channel: str
    crossover: float
    other: float
    largest: float
    at: float


def differences(
    old: LinearStudy,
    new: LinearStudy,
    values: Mapping[str, float],
    others: Mapping[str, float],
) -> tuple[Difference, ...]:
    """Compare the loops of two laws in hover, while the pilot steers.

    Args:
        old: of the vehicle with the first law.
        new: of the same vehicle with the second.
        values: of the first law's parameters.
        others: of the second's.
    """
    found = []
    names = [signal for _, signal in CHANNELS]
    loops = [
        loop_responses(study.plant_input(STEERING, gains), names)
        for study, gains in ((old, values), (new, others))
    ]
    margins = [response_margins(each) for each in loops]
    for k, (channel, _) in enumerate(CHANNELS):
        crossover = margins[0][k].crossover
        if not np.isfinite(crossover):
            found.append(Difference(channel, crossover, margins[1][k].crossover, np.nan, np.nan))
            continue
        grid = np.geomspace(crossover / BELOW, crossover, COUNT)
        one, other = (each.at(grid)[k] for each in loops)
        apart = np.abs(other / one - 1.0)
        worst = int(np.argmax(apart))
        found.append(
            Difference(
                channel,
                crossover,
                margins[1][k].crossover,
                float(apart[worst]),
                float(grid[worst]),
            )
        )
    return tuple(found)


def gains_alone(
    old: LinearStudy,
    new: LinearStudy,
    values: Mapping[str, float],
    others: Mapping[str, float],
) -> tuple[Difference, ...]:
    """Compare with both laws at the shorter of their periods, and without the laws' own filters.

    Arguments are those of `differences`.
    """
    period = min(study.scenario.rates.control_period for study in (old, new))
    return differences(
        _at_period(old, period),
        _at_period(new, period),
        {**values, **dict.fromkeys(form_of(old.controller).filters, 0.0)},
        {**others, **dict.fromkeys(form_of(new.controller).filters, 0.0)},
    )


def _at_period(study: LinearStudy, period: float) -> LinearStudy:
    """Return a study whose law runs at a period, where it has none of its own."""
    scenario: Scenario = study.scenario
    if study.controller.period is not None or scenario.rates.control_period == period:
        return study
    rates: Rates = replace(scenario.rates, control_period=period)
    return study.like(replace(scenario, rates=rates))

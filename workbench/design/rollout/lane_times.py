"""Times and delays of the flights in the lanes of the compiled code."""

import math
from typing import NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.lanes import LANES

SAME_TIME_S = 1e-9
"""Events this near to each other are at the same time [s]."""


class PeriodClock(NamedTuple):
    """When things happen in every flight, and what they have in common.

    Attributes:
        step: of physics, of which periods are multiples [s].
        period: of control [s].
        mode_period: between updates of the flight mode [s].
        estimate: see `acceleration_estimate.sampled_estimate`.
        sags: whether a battery weakens the rotors.
        battery_period: between its updates [s].
        used: charge that an update takes, over power [N^-3/2].
        charges: of the curve of the voltage without load, upwards.
        voltages: of that curve.
    """

    step: float
    period: float
    mode_period: float
    estimate: tuple[float, float]
    sags: bool
    battery_period: float
    used: float
    charges: np.ndarray
    voltages: np.ndarray


class LaneTimes(NamedTuple):
    """Of 16 lanes in a control period, all (16).

    Attributes:
        now: of each flight [s].
        end: of its control period [s].
        spans: how far each goes to its next event [s].
        sizes: of the integrator's steps [s].
        third: whether they are of third order.
    """

    now: np.ndarray
    end: np.ndarray
    spans: np.ndarray
    sizes: np.ndarray
    third: np.ndarray


def make_lane_times() -> LaneTimes:
    """Return places for the times of 16 lanes."""
    now, end, spans, sizes = np.zeros((4, LANES))
    return LaneTimes(now, end, spans, sizes, np.zeros(LANES, dtype=bool))


class DelayRings(NamedTuple):
    """What is on its way in m flights where sensing or commands have a delay.

    Attributes:
        states: (m, periods, 13) on their way to the law, a ring of control periods.
        commands: (m, periods, n) on their way to the rotors [rad/s].
    """

    states: np.ndarray
    commands: np.ndarray


@register_jitable(forceinline=True, allocates=False)
def is_multiple(now: float, period: float) -> bool:
    """Return whether a time is a multiple of a period."""
    return abs(now - period * math.floor(now / period + 0.5)) < SAME_TIME_S


@register_jitable(forceinline=True, allocates=False)
def next_multiple(now: float, period: float) -> float:
    """Return the next multiple of a period after a time."""
    return period * (math.floor((now + SAME_TIME_S) / period) + 1.0)


@register_jitable(allocates=False)
def next_event(flight: np.record, clock: PeriodClock, now: float) -> float:
    """Return when something next happens to a flight, besides its sensors' samples [s]."""
    begin, found = flight.count * clock.period, flight.mode_updates * clock.mode_period
    found = min(found, flight.battery_updates * clock.battery_period)
    if begin + flight.sensing_offset > now + SAME_TIME_S:
        found = min(found, begin + flight.sensing_offset)
    if begin + flight.command_offset > now + SAME_TIME_S:
        found = min(found, begin + flight.command_offset)
    return found

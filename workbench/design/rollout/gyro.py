"""The truth as laws know it: the angular velocity is that of a filtered gyro, see `flight_imu`."""

import math

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.fields import fetch, store
from workbench.design.rollout.period import Knowing
from workbench.design.rollout.record import MOTION
from workbench.dynamics.motion_between import body_rate, motion_between, point_motion
from workbench.estimation.gyro import (
    at_rest,
    body_rates,
    filtered_rates,
    sensed,
    stepped_filters,
)

ORIGIN = (0.0, 0.0, 0.0)
SAMPLE_TOLERANCE = 1e-6
"""Share of the time between two samples of the gyro by which one may be off its time."""


@register_jitable
def _know(flight, clock, sensors):
    """Write the state that the law knows at a control update."""
    state = fetch(flight, "state")
    if flight.gyro_filters > 0.0:
        rates, states = body_rates(state), at_rest(body_rates(state))
        if flight.sampled > 0.0:
            rates, states = _filter_samples(flight, clock, state, clock.period)
        else:
            coefficients = fetch(flight, "gyro_filter")
            states = stepped_filters(coefficients, states, rates)
        store(flight, "rates", rates)
        store(flight, "gyro_states", states)
        store(flight, "motion", point_motion(state, ORIGIN))
        flight.sampled = 1.0
        state = sensed(state, rates)
    store(flight, "known", state)


@register_jitable
def _look(flight, clock, sensors, passed):
    """Return the state (13) as the gyro tells it between two control updates."""
    state = fetch(flight, "state")
    if flight.gyro_filters == 0.0:
        return state
    rates, _ = _filter_samples(flight, clock, state, passed)
    return sensed(state, rates)


@register_jitable
def _filter_samples(flight, clock, state, passed):
    """Return the filtered angular velocity in B (3) [rad/s], and the states of the filters (12).

    They are those after the samples since the last update; the motion between is `motion_between`.

    Args:
        flight: its record, of which nothing changes; an update has been before.
        clock: see `Clock`.
        state: of the body now (13).
        passed: time since the last update [s].
    """
    period = flight.gyro_every * clock.step
    count = math.floor(passed / period + SAMPLE_TOLERANCE)
    coefficients, states = fetch(flight, "gyro_filter"), fetch(flight, "gyro_states")
    rates, now, between = fetch(flight, "rates"), np.empty(MOTION), np.empty(MOTION)
    motion = point_motion(state, ORIGIN)
    for k in range(MOTION):
        now[k] = motion[k]
    for number in range(1, count + 1):
        motion_between(flight.motion, now, passed, number * period / passed, between)
        sample = body_rate(between)
        rates = filtered_rates(coefficients, states, sample)
        states = stepped_filters(coefficients, states, sample)
    return rates, states


@register_jitable(forceinline=True)
def _mode_state(flight):
    return fetch(flight, "state")


@register_jitable(forceinline=True)
def _never(sensors, now):
    return math.inf


@register_jitable(forceinline=True)
def _no_sample(flight, sensors, now):
    """Do nothing: no other sensor is heard."""


KNOW_TRUTH = Knowing(_know, _look, _mode_state, _never, _no_sample, "truth")

"""The true state, with the angular velocity of a filtered gyro, see `flight_imu`."""

import math

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.design.rollout.fields import get_field, set_field
from workbench.design.rollout.lane_times import PeriodClock
from workbench.design.rollout.period import StateSource
from workbench.design.rollout.record import IMU_MOTION_SIZE
from workbench.design.rollout.sensor_set import EstimatorInputs
from workbench.dynamics.motion_between import body_rate, motion_between, point_motion
from workbench.estimation.gyro import (
    filtered_rates,
    state_body_rates,
    steady_gyro_states,
    stepped_filters,
    with_sensed_rates,
)

BODY_ORIGIN = (0.0, 0.0, 0.0)
SAMPLE_TOLERANCE = 1e-6
"""Share of the time between two samples of the gyro by which one may be off its time."""


@register_jitable
def _write_true_state(
    flight: np.record, clock: PeriodClock, sensors: EstimatorInputs | None
) -> None:
    """Write the state that the law knows at a control update."""
    state = get_field(flight, "state")
    if flight.gyro_filters > 0.0:
        rates, states = state_body_rates(state), steady_gyro_states(state_body_rates(state))
        if flight.sampled > 0.0:
            rates, states = _filter_samples(flight, clock, state, clock.period)
        else:
            coefficients = get_field(flight, "gyro_filter")
            states = stepped_filters(coefficients, states, rates)
        set_field(flight, "rates", rates)
        set_field(flight, "gyro_states", states)
        set_field(flight, "motion", point_motion(state, BODY_ORIGIN))
        flight.sampled = 1.0
        state = with_sensed_rates(state, rates)
    set_field(flight, "known", state)


@register_jitable
def _gyro_state(
    flight: np.record, clock: PeriodClock, sensors: EstimatorInputs | None, passed: float
) -> tuple[float, ...]:
    """Return the state (13) as the gyro tells it between two control updates."""
    state = get_field(flight, "state")
    if flight.gyro_filters == 0.0:
        return state
    rates, _ = _filter_samples(flight, clock, state, passed)
    return with_sensed_rates(state, rates)


@register_jitable
def _filter_samples(
    flight: np.record, clock: PeriodClock, state: Numbers, passed: float
) -> tuple[Vector3, tuple[float, ...]]:
    """Return the filtered angular velocity in B (3) [rad/s], and the states of the filters (12).

    They are those after the samples since the last update; the motion between is `motion_between`.

    Args:
        flight: its record, of which nothing changes; an update has been before.
        clock: see `PeriodClock`.
        state: of the body now (13).
        passed: time since the last update [s].
    """
    period = flight.gyro_every * clock.step
    count = math.floor(passed / period + SAMPLE_TOLERANCE)
    coefficients, states = get_field(flight, "gyro_filter"), get_field(flight, "gyro_states")
    rates, now, between = (
        get_field(flight, "rates"),
        np.empty(IMU_MOTION_SIZE),
        np.empty(IMU_MOTION_SIZE),
    )
    motion = point_motion(state, BODY_ORIGIN)
    for k in range(IMU_MOTION_SIZE):
        now[k] = motion[k]
    for number in range(1, count + 1):
        motion_between(flight.motion, now, passed, number * period / passed, between)
        sample = body_rate(between)
        rates = filtered_rates(coefficients, states, sample)
        states = stepped_filters(coefficients, states, sample)
    return rates, states


@register_jitable(forceinline=True)
def _mode_truth(flight: np.record) -> tuple[float, ...]:
    return get_field(flight, "state")


@register_jitable(forceinline=True)
def _never_due(sensors: EstimatorInputs | None, now: float) -> float:
    return math.inf


@register_jitable(forceinline=True)
def _no_sample(flight: np.record, sensors: EstimatorInputs | None, now: float) -> None:
    """Do nothing: the truth needs no sensor."""


TRUE_STATE = StateSource(
    _write_true_state, _gyro_state, _mode_truth, _never_due, _no_sample, "truth"
)

"""The truth that laws know, its angular velocity from the gyro: loops over a block's candidates."""

from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.rows import (
    GYRO,
    GYRO_EVERY,
    GYRO_FILTER,
    LANES,
    STATE,
    put,
    put3,
    put4,
    take,
    take3,
    take4,
    take13,
    take18,
)
from workbench.estimation.gyro import (
    COEFFICIENTS,
    STATES,
    at_rest,
    body_rates,
    filtered_axis,
    filters_gyro,
    gyro_filter,
    sample_steps,
    sensed,
    stepped_axis,
)

RATES = GYRO + STATES
"""Angular velocity in B of the last sample (3)."""


class Knowing(NamedTuple):
    """How laws come to know the motion: functions that compile.

    What is called at every physics step takes few arrays: each call counts who holds them.

    Attributes:
        begin: whether IMUs take samples, what they remember at the start, what the other sensors
            and the estimators do, steps between the samples of each, and the rows that `sense`
            reads; of block, candidates, hearing and schedule.
        sample: lets IMUs take their samples; of block, what they remember, number of the physics
            step and its place in the control period.
        know: what the estimators do at an instant; of what they remember, the instant and the
            control period [s].
        sense: puts what a law knows now into a state that stands somewhere from a row on, which
            holds the true one; of block, candidate, place, row and the rows that it reads.
        is_due: whether any sensor measures before a physics step; of the steps between samples, and
            its number.
        measure: lets them do so; of block, what they remember, number of the step and its length.
        rests: whether a drone that hovers without moving goes on doing so.
    """

    begin: Callable[..., Any]
    sample: Callable[..., None]
    know: Callable[..., None]
    sense: Callable[..., None]
    is_due: Callable[..., bool]
    measure: Callable[..., None]
    rests: bool


@register_jitable
def fill_gyro(block, i, settings, schedule):
    """Fill a candidate's rows, once its state is there."""
    every = sample_steps(settings[0], schedule.step, schedule.steps)
    works = filters_gyro(settings, every * schedule.step)
    put(block, GYRO_EVERY, i, 1.0 * every if works else 0.0)
    coefficients = gyro_filter(settings, every * schedule.step)
    for k in range(COEFFICIENTS):
        put(block, GYRO_FILTER + k, i, coefficients[k])
    w_B = body_rates(take13(block, STATE, i))
    states = at_rest(w_B)
    for k in range(STATES):
        put(block, GYRO + k, i, states[k])
    put3(block, RATES, i, w_B)


@register_jitable
def _begin(block, candidates, hearing, schedule):
    """Return at which steps of a period each gyro that filters takes a sample (steps, 16)."""
    due = np.zeros((schedule.steps, LANES), dtype=np.bool_)
    for step in range(schedule.steps):
        for i in range(LANES):
            every = int(take(block, GYRO_EVERY, i))
            due[step, i] = every > 0 and step % every == 0
    return due.any(), due, None, None, block


@register_jitable
def _sample(block, gyros, number, step):
    """Let those take a sample for whom it is due."""
    due = gyros[step]
    for i in range(LANES):
        w_B = body_rates(take13(block, STATE, i))
        rates = take3(block, RATES, i)
        put3(block, RATES, i, w_B if due[i] else rates)
    for axis in range(3):
        row = GYRO + 4 * axis
        for i in range(LANES):
            coefficients, x = take18(block, GYRO_FILTER, i), take4(block, row, i)
            w = take(block, RATES + axis, i)
            found, after = filtered_axis(coefficients, x, w), stepped_axis(coefficients, x, w)
            put(block, RATES + axis, i, found if due[i] else w)
            put4(block, row, i, after if due[i] else x)


@register_jitable(forceinline=True)
def _sense(block, i, places, row, told):
    if take(block, GYRO_EVERY, i) > 0.0:
        state = sensed(take13(places, row, i), take3(block, RATES, i))
        put3(places, row + 7, i, state[7:10])


@register_jitable
def _know(sensors, instant, period):
    """Do nothing: what is known is true."""


@register_jitable
def _is_due(every, number):
    return False


@register_jitable
def _measure(block, sensors, number, step):
    """Do nothing: no sensor is asked."""


KNOW_TRUTH = Knowing(_begin, _sample, _know, _sense, _is_due, _measure, rests=True)
"""Of laws that fly on the true motion."""

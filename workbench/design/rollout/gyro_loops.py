"""The gyro of a block: loops over its candidates around the filters' own functions."""

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


@register_jitable
def fill_gyro(block, i, settings, schedule):  # type: ignore[no-untyped-def]
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
def due_samples(block, steps):  # type: ignore[no-untyped-def]
    """Return at which steps of a period each gyro that filters takes a sample (steps, 16)."""
    due = np.zeros((steps, LANES), dtype=np.bool_)
    for step in range(steps):
        for i in range(LANES):
            every = int(take(block, GYRO_EVERY, i))
            due[step, i] = every > 0 and step % every == 0
    return due


@register_jitable
def sample_gyro(block, due):  # type: ignore[no-untyped-def]
    """Let those take a sample for whom it is due."""
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
def sense(block, i, places, row):  # type: ignore[no-untyped-def]
    """Put what the gyro gives into a state that stands somewhere from a row on."""
    if take(block, GYRO_EVERY, i) > 0.0:
        state = sensed(take13(places, row, i), take3(block, RATES, i))
        put3(places, row + 7, i, state[7:10])

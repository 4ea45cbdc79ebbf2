"""The IMUs of a block: loops over its candidates around the functions of `estimation.imu`."""

import math
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.rows import (
    LANES,
    LAST,
    STATE,
    put,
    put3,
    put4,
    put6,
    take,
    take3,
    take4,
    take6,
    take9,
    take13,
    take18,
)
from workbench.dynamics.air.normals import COUNT, draw_normals
from workbench.estimation import imu
from workbench.estimation.filters import after, lowpass, output
from workbench.estimation.gyro import (
    at_rest,
    body_rates,
    filtered_axis,
    filters_gyro,
    gyro_filter,
    sample_steps,
    stepped_axis,
)
from workbench.estimation.samples import SAMPLES

BIAS, DRIFT, DRAWN, SCALE, EVERY, GYRO_FILTER, GYRO, RATES = 0, 6, 12, 18, 19, 20, 38, 50
ACCEL_FILTER, ACCEL, SAMPLE, SUMS, ELAPSED, NEW = 53, 62, 68, 74, 80, 81
DUE = NEW + 6
MOTION = DUE + 1
Z = MOTION + 19
ESTIMATE = Z + SAMPLES
"""Rows of the block of an IMU: its biases and their drift, normal numbers of a step, factor on the
deviations, steps between samples, coefficients and states of the gyro's filters and what comes out
of them, the same of the accelerometer's, sample before, integral since it was read and the steps
that it took, -1 before the first, sample of this step, whether one is due (0, 1), a copy of the
body's state and of its acceleration before, as loops over one array are the quickest; what the
estimator gets, see
`estimation.samples`; and the motion that the law knows (13)."""
ROWS = ESTIMATE + 13


class Imus(NamedTuple):
    """The IMUs of a block.

    Attributes:
        rows: see `ROWS`.
        due: 1 at steps of a control period at which one takes a sample, else 0 (steps, 16).
        works: whether any filter of gyro or accelerometer does.
        noises: what their noise starts from (m).
        alike: whether that is the same for all.
        p_BS: their place (3) [m].
        R_BS: their orientation, row by row (9).
        deviation: of a sample a physics step (6).
        drawn: places for normal numbers (6).
    """

    rows: Any
    due: Any
    works: Any
    noises: Any
    alike: Any
    p_BS: Any
    R_BS: Any
    deviation: Any
    drawn: Any


@register_jitable
def begin_imus(block, candidates, hearing, schedule):  # type: ignore[no-untyped-def]
    """Return the IMUs at the start."""
    rows, due = np.zeros(ROWS * LANES), np.zeros((schedule.steps, LANES))
    works, bias, noise = False, np.empty(6), hearing.imu_noise
    for i in range(LANES):
        c = min(i, len(candidates.gains) - 1)
        settings = candidates.gyros[c]
        every = sample_steps(settings[0], schedule.step, schedule.steps)
        period = every * schedule.step
        works = works or filters_gyro(settings, period) or settings[5] > 0.0
        for step in range(schedule.steps):
            due[step, i] = 1.0 if step % every == 0 else 0.0
        put(rows, EVERY, i, 1.0 * every)
        put(rows, SCALE, i, 1.0 / math.sqrt(every))
        coefficients = gyro_filter(settings, period)
        for k in range(18):
            put(rows, GYRO_FILTER + k, i, coefficients[k])
        section = lowpass(settings[5], settings[6], period)
        for k in range(9):
            put(rows, ACCEL_FILTER + k, i, section[k])
        w_B = body_rates(take13(block, STATE, i))
        states = at_rest(w_B)
        for k in range(12):
            put(rows, GYRO + k, i, states[k])
        put3(rows, RATES, i, w_B)
        imu.drawn_bias(noise.mean, noise.spread, candidates.noises[c, 0], bias)
        for k in range(6):
            put(rows, BIAS + k, i, bias[k])
        put(rows, ELAPSED, i, -1.0)
    seeds = candidates.noises[:, 0].copy()
    alike = (candidates.noises == candidates.noises[0]).all()
    return Imus(rows, due, works, seeds, alike, hearing.p_BS, hearing.R_BS, noise.deviation, bias)


@register_jitable(forceinline=True)
def sample_imus(block, imus, number, step):  # type: ignore[no-untyped-def]
    """Let those IMUs take a sample for which it is due at a step of physics.

    Args:
        block: of the candidates.
        imus: see `Imus`.
        number: of the step.
        step: its place in the control period.
    """
    rows, due, works, noises, alike, p_BS, R_BS, deviation, drawn = imus
    _draw(rows, noises, alike, 2 * number, drawn)
    for i in range(LANES):
        rows[DUE * LANES + i] = due[step, i]
    for i in range(13 * LANES):
        rows[MOTION * LANES + i] = block[STATE * LANES + i]
    for i in range(6 * LANES):
        rows[(MOTION + 13) * LANES + i] = block[LAST * LANES + i]
    for i in range(LANES):
        exact = imu.measured(take13(rows, MOTION, i), take6(rows, MOTION + 13, i), p_BS)
        bias, drifted = take6(rows, BIAS, i), take6(rows, DRIFT, i)
        random, scale = take6(rows, DRAWN, i), take(rows, SCALE, i)
        noise = (
            bias[0] + drifted[0] + scale * deviation[0] * random[0],
            bias[1] + drifted[1] + scale * deviation[1] * random[1],
            bias[2] + drifted[2] + scale * deviation[2] * random[2],
            bias[3] + drifted[3] + scale * deviation[3] * random[3],
            bias[4] + drifted[4] + scale * deviation[4] * random[4],
            bias[5] + drifted[5] + scale * deviation[5] * random[5],
        )
        put6(rows, NEW, i, imu.with_noise(exact, noise, R_BS))
    if works:
        _filter(rows)
    else:
        for i in range(LANES):
            here = take(rows, DUE, i) > 0.0
            put3(rows, RATES, i, _chosen(here, take3(rows, NEW, i), take3(rows, RATES, i)))
            sums, new = take3(rows, SUMS + 3, i), take3(rows, NEW + 3, i)
            share = take(rows, EVERY, i) if here else 0.0
            put3(rows, SUMS + 3, i, _added(sums, new, share))
    for i in range(LANES):
        w, before = take3(rows, NEW, i), take3(rows, SAMPLE, i)
        here = take(rows, DUE, i) > 0.0
        half = 0.5 * take(rows, EVERY, i) if here else 0.0
        sums = _added(_added(take3(rows, SUMS, i), before, half), w, half)
        put3(rows, SUMS, i, sums)
        put3(rows, SAMPLE, i, _chosen(here, w, before))
        f, before = take3(rows, NEW + 3, i), take3(rows, SAMPLE + 3, i)
        put3(rows, SAMPLE + 3, i, _chosen(here, f, before))
        elapsed, every = take(rows, ELAPSED, i), take(rows, EVERY, i)
        later = elapsed + every if elapsed >= 0.0 else 0.0
        put(rows, ELAPSED, i, later if here else elapsed)


@register_jitable(forceinline=True)
def _chosen(due, new, old):  # type: ignore[no-untyped-def]
    """Return the new vector where it is due."""
    return (
        new[0] if due else old[0],
        new[1] if due else old[1],
        new[2] if due else old[2],
    )


@register_jitable(forceinline=True)
def _added(sums, values, share):  # type: ignore[no-untyped-def]
    """Return sums with a share of values added."""
    return (
        sums[0] + share * values[0],
        sums[1] + share * values[1],
        sums[2] + share * values[2],
    )


@register_jitable
def _filter(rows):  # type: ignore[no-untyped-def]
    """Let the new samples go through the filters of gyros and accelerometers."""
    for axis in range(3):
        row = GYRO + 4 * axis
        for i in range(LANES):
            coefficients, x = take18(rows, GYRO_FILTER, i), take4(rows, row, i)
            w, before = take(rows, NEW + axis, i), take(rows, RATES + axis, i)
            found, later = filtered_axis(coefficients, x, w), stepped_axis(coefficients, x, w)
            here = take(rows, DUE, i) > 0.0
            put(rows, RATES + axis, i, found if here else before)
            put4(rows, row, i, _four(here, later, x))
    for axis in range(3):
        row = ACCEL + 2 * axis
        for i in range(LANES):
            section, every = take9(rows, ACCEL_FILTER, i), take(rows, EVERY, i)
            f, first = take(rows, NEW + 3 + axis, i), take(rows, ELAPSED, i) < 0.0
            x_1, x_2 = take(rows, row, i), take(rows, row + 1, i)
            x_2 = f if first else x_2
            smooth, (y_1, y_2) = output(section, x_1, x_2, f), after(section, x_1, x_2, f)
            here = take(rows, DUE, i) > 0.0
            put(rows, row, i, y_1 if here else x_1)
            put(rows, row + 1, i, y_2 if here else x_2)
            total = take(rows, SUMS + 3 + axis, i)
            put(rows, SUMS + 3 + axis, i, total + every * smooth if here else total)


@register_jitable(forceinline=True)
def _four(due, new, old):  # type: ignore[no-untyped-def]
    """Return the new numbers where they are due."""
    return (
        new[0] if due else old[0],
        new[1] if due else old[1],
        new[2] if due else old[2],
        new[3] if due else old[3],
    )


@register_jitable(forceinline=True)
def drift(rows, noises, alike, imu_noise, number):  # type: ignore[no-untyped-def]
    """Let the biases drift from a reading at a physics step to the next."""
    kept, driven = imu_noise.kept, imu_noise.driven
    if max(driven) == 0.0:
        return
    _draw(rows, noises, alike, 2 * number + 1, np.empty(COUNT))
    for i in range(LANES):
        before, drawn = take6(rows, DRIFT, i), take6(rows, DRAWN, i)
        drifted = (
            kept[0] * before[0] + driven[0] * drawn[0],
            kept[1] * before[1] + driven[1] * drawn[1],
            kept[2] * before[2] + driven[2] * drawn[2],
            kept[3] * before[3] + driven[3] * drawn[3],
            kept[4] * before[4] + driven[4] * drawn[4],
            kept[5] * before[5] + driven[5] * drawn[5],
        )
        put6(rows, DRIFT, i, drifted)


@register_jitable(forceinline=True)
def _draw(rows, noises, alike, number, drawn):  # type: ignore[no-untyped-def]
    """Write six normal numbers for each candidate."""
    draw_normals(noises[0], number, drawn)
    same = imu.six(drawn)
    for i in range(LANES):
        put6(rows, DRAWN, i, same)
    if not alike:
        for i in range(1, len(noises)):
            draw_normals(noises[i], number, drawn)
            put6(rows, DRAWN, i, imu.six(drawn))

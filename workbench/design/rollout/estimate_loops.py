"""What the laws of a block know by an estimator: loops over its candidates, and their sensors."""

import math
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable, unique
from workbench.design.rollout.gyro_loops import Knowing
from workbench.design.rollout.rows import (
    LANES,
    LAST,
    STATE,
    put,
    put3,
    put4,
    put6,
    put13,
    take,
    take3,
    take4,
    take6,
    take9,
    take13,
    take18,
)
from workbench.design.rollout.senses import CHANNELS, MOST
from workbench.dynamics.air.normals import COUNT, draw_normals
from workbench.dynamics.rigid_body import into_body, rotation
from workbench.estimation import imu
from workbench.estimation.ekf import NOMINAL, estimate, into_world
from workbench.estimation.estimators import Estimator
from workbench.estimation.filters import after, lowpass, output
from workbench.estimation.gyro import (
    at_rest,
    body_rates,
    filtered_axis,
    gyro_filter,
    sample_steps,
    stepped_axis,
)
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER, SAMPLES
from workbench.systems.noise import counted_draws
from workbench.systems.sensors.barometer import altitude_at, pressure_at

BIAS, DRIFT, DRAWN, SCALE, EVERY, GYRO_FILTER, GYRO, RATES = 0, 6, 12, 18, 19, 20, 38, 50
ACCEL_FILTER, ACCEL, SAMPLE, SUMS, ELAPSED, NEW = 53, 62, 68, 74, 80, 81
ESTIMATE = NEW + 6
"""Rows of the block of an IMU: its biases and their drift, normal numbers of a step, factor on the
deviations, steps between samples, coefficients and states of the gyro's filters and what comes out
of them, the same of the accelerometer's, sample before, integral since it was read and the steps
that it took, sample of this step; and the motion that the law knows (13)."""
ROWS = ESTIMATE + 13
MEAN, DEVIATION, BIAS_MEAN, BIAS_DEVIATION, KEPT, DRIVEN, PRECISION = range(7)
"""Rows of `Hearing.noise`."""


class Perceived(NamedTuple):
    """What sensors and estimators of a block remember.

    Attributes:
        rows: of the IMUs, see `ROWS`.
        due: at which steps of a period whose IMU takes a sample (steps, 16).
        memory: of the estimators (16, k).
        waiting: samples of the others, a ring (4, depth, 6, 16).
        stamps: of these (4, depth) [s].
        taken: how many each has taken (4).
        heard: stamp of the last one that the estimators had (4) [s].
        biases: of each channel (4, 6, 16).
        drifts: likewise.
    """

    rows: Any
    due: Any
    memory: Any
    waiting: Any
    stamps: Any
    taken: Any
    heard: Any
    biases: Any
    drifts: Any


@register_jitable
def _begin(block, candidates, hearing, schedule):  # type: ignore[no-untyped-def]
    """Return what sensors and estimators remember at the start."""
    many = len(candidates.gains)
    rows, bias = np.zeros(ROWS * LANES), np.empty(6)
    due = np.zeros((schedule.steps, LANES), dtype=np.bool_)
    memory = np.empty((LANES, candidates.memories.shape[1]))
    for i in range(LANES):
        c = min(i, many - 1)
        memory[i] = candidates.memories[c]
        settings = candidates.gyros[c]
        every = sample_steps(settings[0], schedule.step, schedule.steps)
        for step in range(schedule.steps):
            due[step, i] = step % every == 0
        put(rows, EVERY, i, 1.0 * every)
        put(rows, SCALE, i, 1.0 / math.sqrt(every))
        coefficients = gyro_filter(settings, every * schedule.step)
        for k in range(18):
            put(rows, GYRO_FILTER + k, i, coefficients[k])
        section = lowpass(settings[5], 2.0, every * schedule.step)
        for k in range(9):
            put(rows, ACCEL_FILTER + k, i, section[k])
        w_B = body_rates(take13(block, STATE, i))
        states = at_rest(w_B)
        for k in range(12):
            put(rows, GYRO + k, i, states[k])
        put3(rows, RATES, i, w_B)
        imu.drawn_bias(hearing.imu, candidates.noises[c, 0], bias)
        for k in range(6):
            put(rows, BIAS + k, i, bias[k])
        put(rows, ELAPSED, i, -1.0)
    depth = hearing.depth
    return Perceived(
        rows,
        due,
        memory,
        np.zeros((4, depth, MOST, LANES)),
        np.full((4, depth), math.nan),
        np.zeros(4, dtype=np.int64),
        np.full(4, math.nan),
        np.zeros((4, MOST, LANES)),
        np.zeros((4, MOST, LANES)),
    )


@register_jitable
def _sample_imu(block, perceived, candidates, hearing, number, step):  # type: ignore[no-untyped-def]
    """Let those IMUs take a sample for which it is due at a step of physics."""
    rows, due, constants = perceived.rows, perceived.due[step], hearing.imu
    _draw(rows, candidates.noises, 2 * number, DRAWN)
    p_BS = constants[imu.PLACE], constants[imu.PLACE + 1], constants[imu.PLACE + 2]
    for i in range(LANES):
        exact = imu.measured(take13(block, STATE, i), take6(block, LAST, i), p_BS)
        put6(rows, NEW, i, exact)
    for k in range(6):
        deviation = constants[imu.DEVIATION + k]
        for i in range(LANES):
            noise = deviation * take(rows, SCALE, i) * take(rows, DRAWN + k, i)
            bias = take(rows, BIAS + k, i) + take(rows, DRIFT + k, i)
            put(rows, DRAWN + k, i, bias + noise)
    R_BS = imu.six(constants[imu.TURN :]) + (
        constants[imu.TURN + 6],
        constants[imu.TURN + 7],
        constants[imu.TURN + 8],
    )
    for i in range(LANES):
        put6(rows, NEW, i, imu.with_noise(take6(rows, NEW, i), take6(rows, DRAWN, i), R_BS))
    for axis in range(3):
        row = GYRO + 4 * axis
        for i in range(LANES):
            coefficients, x = take18(rows, GYRO_FILTER, i), take4(rows, row, i)
            w, before = take(rows, NEW + axis, i), take(rows, RATES + axis, i)
            found, later = filtered_axis(coefficients, x, w), stepped_axis(coefficients, x, w)
            put(rows, RATES + axis, i, found if due[i] else before)
            put4(rows, row, i, later if due[i] else x)
    for axis in range(3):
        row = ACCEL + 2 * axis
        for i in range(LANES):
            section, every = take9(rows, ACCEL_FILTER, i), take(rows, EVERY, i)
            f, first = take(rows, NEW + 3 + axis, i), take(rows, ELAPSED, i) < 0.0
            x_1, x_2 = take(rows, row, i), take(rows, row + 1, i)
            x_2 = f if first else x_2
            smooth, later = output(section, x_1, x_2, f), after(section, x_1, x_2, f)
            put(rows, row, i, later[0] if due[i] else x_1)
            put(rows, row + 1, i, later[1] if due[i] else x_2)
            pushed = take(rows, SUMS + 3 + axis, i)
            put(rows, SUMS + 3 + axis, i, pushed + every * smooth if due[i] else pushed)
            w, turned = take(rows, NEW + axis, i), take(rows, SUMS + axis, i)
            trapezoid = 0.5 * every * (take(rows, SAMPLE + axis, i) + w)
            put(rows, SUMS + axis, i, turned + trapezoid if due[i] else turned)
    for k in range(6):
        for i in range(LANES):
            new, old = take(rows, NEW + k, i), take(rows, SAMPLE + k, i)
            put(rows, SAMPLE + k, i, new if due[i] else old)
    for i in range(LANES):
        elapsed = take(rows, ELAPSED, i)
        put(rows, ELAPSED, i, elapsed + take(rows, EVERY, i) if due[i] else elapsed)


@register_jitable
def _drift(perceived, candidates, hearing, number):  # type: ignore[no-untyped-def]
    """Let the biases of the IMUs drift for a step of physics."""
    rows, constants = perceived.rows, hearing.imu
    if constants[imu.DRIVEN : imu.MEAN].any():
        _draw(rows, candidates.noises, 2 * number + 1, DRAWN)
        for k in range(6):
            kept, driven = constants[imu.KEPT + k], constants[imu.DRIVEN + k]
            for i in range(LANES):
                drawn = driven * take(rows, DRAWN + k, i)
                put(rows, DRIFT + k, i, kept * take(rows, DRIFT + k, i) + drawn)


@register_jitable
def _draw(rows, noises, number, row):  # type: ignore[no-untyped-def]
    """Write six normal numbers for each candidate; those of equal seeds are drawn once."""
    many = len(noises)
    drawn = np.empty(COUNT)
    seed = -1.0
    for i in range(LANES):
        own = noises[min(i, many - 1), 0]
        if own != seed:
            draw_normals(own, number, drawn)
            seed = own
        put6(rows, row, i, imu.six(drawn))


@register_jitable
def _hear(block, perceived, candidates, hearing, number, step):  # type: ignore[no-untyped-def]
    """Let the sensors take a sample for which it is due at a step of physics.

    Args:
        block: of the candidates.
        perceived: see there.
        candidates: whose seeds are used.
        hearing: the sensors.
        number: of the step.
        step: its length [s].
    """
    many = len(candidates.noises)
    exact, drawn = np.empty(MOST), np.empty(3 * MOST)
    for kind in range(4):
        every = hearing.every[kind]
        if every == 0 or number % every != 0:
            continue
        slot = perceived.taken[kind] % hearing.depth
        first = perceived.taken[kind] == 0
        perceived.taken[kind] += 1
        perceived.stamps[kind, slot] = number * step
        n, noise = CHANNELS[kind], hearing.noise[kind]
        seed = -1.0
        for i in range(LANES):
            own = candidates.noises[min(i, many - 1), 1 + kind]
            if own != seed:
                counted_draws(own, number // every, drawn[: 3 * n])
                seed = own
            _measure(kind, take13(block, STATE, i), hearing, exact)
            for k in range(n):
                if first:
                    bias = noise[BIAS_MEAN, k] + noise[BIAS_DEVIATION, k] * drawn[2 * n + k]
                    perceived.biases[kind, k, i] = bias
                bias = perceived.biases[kind, k, i] + perceived.drifts[kind, k, i]
                value = exact[k] + (noise[MEAN, k] + bias + noise[DEVIATION, k] * drawn[k])
                if noise[PRECISION, k] > 0.0 and math.isfinite(value):
                    value = noise[PRECISION, k] * round(value / noise[PRECISION, k])
                perceived.waiting[kind, slot, k, i] = value
                left = noise[KEPT, k] * perceived.drifts[kind, k, i]
                perceived.drifts[kind, k, i] = left + noise[DRIVEN, k] * drawn[n + k]


@register_jitable
def _measure(kind, state, hearing, exact):  # type: ignore[no-untyped-def]
    """Write what a perfect sensor measures: one of `settings.HEARD`."""
    R, place = rotation(state[0:4]), hearing.mounting
    if kind == 0:
        arm = into_world(R, place[3:6])
        w_x, w_y, w_z = state[7], state[8], state[9]
        exact[0], exact[1], exact[2] = state[4] + arm[0], state[5] + arm[1], state[6] + arm[2]
        exact[3] = state[10] + w_y * arm[2] - w_z * arm[1]
        exact[4] = state[11] + w_z * arm[0] - w_x * arm[2]
        exact[5] = state[12] + w_x * arm[1] - w_y * arm[0]
    elif kind == 1:
        height = state[6] + into_world(R, place[6:9])[2]
        exact[0] = pressure_at(hearing.reference + height)
    elif kind == 2:
        field = into_body(R, (place[15], place[16], place[17]))
        for k in range(3):
            exact[k] = 0.0
            for j in range(3):
                exact[k] += hearing.R_BM[j, k] * field[j]
    else:
        height = state[6] + into_world(R, place[9:12])[2]
        down = -into_world(R, place[12:15])[2]
        distance = height / down if down > 0.0 else math.inf
        distance = distance if distance <= hearing.farthest else math.inf
        exact[0] = distance if distance >= hearing.nearest else -math.inf


@register_jitable
def _listen(perceived, hearing, i, now, slots, z):  # type: ignore[no-untyped-def]
    """Write what a candidate's sensors newly deliver, see `estimation.samples`."""
    rows, waiting = perceived.rows, perceived.waiting
    z[:] = 0.0
    elapsed = take(rows, ELAPSED, i)
    for k in range(6):
        mean = take(rows, SUMS + k, i) / elapsed
        z[k] = mean if elapsed > 0.0 else take(rows, SAMPLE + k, i)
    if slots[0] >= 0:
        z[GPS], z[GPS + 1] = 1.0, now - perceived.stamps[0, slots[0]]
        for k in range(6):
            z[GPS + 2 + k] = waiting[0, slots[0], k, i]
    if slots[1] >= 0:
        height = altitude_at(waiting[1, slots[1], 0, i]) - hearing.reference
        z[BAROMETER], z[BAROMETER + 1] = 1.0, height
    if slots[2] >= 0:
        z[MAGNETOMETER] = 1.0
        for k in range(3):
            for j in range(3):
                shown = hearing.R_BM[k, j] * waiting[2, slots[2], j, i]
                z[MAGNETOMETER + 1 + k] += shown
    if slots[3] >= 0 and math.isfinite(waiting[3, slots[3], 0, i]):
        distance = waiting[3, slots[3], 0, i]
        distance = min(max(distance, hearing.nearest), hearing.farthest)
        z[RANGE_FINDER], z[RANGE_FINDER + 1] = 1.0, distance


@register_jitable
def _newest(perceived, hearing, now, slots):  # type: ignore[no-untyped-def]
    """Write where the sample stands that each sensor delivers newly; -1 where there is none."""
    for kind in range(4):
        slots[kind] = -1
        taken = perceived.taken[kind]
        for age in range(min(taken, hearing.depth)):
            slot = (taken - 1 - age) % hearing.depth
            stamp = perceived.stamps[kind, slot]
            if stamp + hearing.late[kind] <= now:
                if stamp != perceived.heard[kind]:
                    perceived.heard[kind] = stamp
                    slots[kind] = slot
                break


def make_knowing(estimator: Estimator) -> Knowing:
    """Return how laws know the motion that an estimator tells."""
    update = estimator.update

    @register_jitable
    def know(perceived, candidates, hearing, instant, period):  # type: ignore[no-untyped-def]
        """Update the estimates, and write the motion that the laws know."""
        many = len(candidates.gains)
        rows, slots, z = perceived.rows, np.empty(4, dtype=np.int64), np.empty(SAMPLES)
        now, dt = instant * period, period if instant > 0 else 0.0
        _newest(perceived, hearing, now, slots)
        p_BI = hearing.mounting[0:3]
        for i in range(LANES):
            if i >= many:
                put13(rows, ESTIMATE, i, take13(rows, ESTIMATE, many - 1))
                continue
            _listen(perceived, hearing, i, now, slots, z)
            memory = perceived.memory[i]
            update(memory, z, candidates.filters[i], hearing.mounting, dt)
            found = estimate(memory[:NOMINAL], take3(rows, RATES, i), p_BI)
            w_W = into_world(rotation(found[0:4]), found[7:10])
            put13(rows, ESTIMATE, i, found[0:7] + w_W + found[10:13])
        for i in range(LANES):
            put(rows, ELAPSED, i, 0.0)
            put6(rows, SUMS, i, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))

    @register_jitable
    def measure(block, perceived, candidates, hearing, number, step):  # type: ignore[no-untyped-def]
        """Let sensors measure, and biases drift."""
        _hear(block, perceived, candidates, hearing, number, step)
        _drift(perceived, candidates, hearing, number)

    @register_jitable(forceinline=True)
    def sense(block, i, places, row, perceived):  # type: ignore[no-untyped-def]
        """Put the estimate into a state that stands somewhere from a row on."""
        put13(places, row, i, take13(perceived.rows, ESTIMATE, i))

    name = estimator.name
    return Knowing(
        _begin, _sample_imu, unique(know, name), unique(sense, name), unique(measure, name), False
    )

"""What the laws of a block know by an estimator: loops over its candidates, and their sensors."""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable, unique
from workbench.design.rollout.ekf_loops import begin_ekf, run_ekf
from workbench.design.rollout.gyro_loops import Knowing
from workbench.design.rollout.imu_loops import (
    ELAPSED,
    ESTIMATE,
    RATES,
    SAMPLE,
    SUMS,
    Z,
    begin_imus,
    drift,
    sample_imus,
)
from workbench.design.rollout.rows import (
    LANES,
    STATE,
    put,
    put3,
    put6,
    put13,
    take,
    take3,
    take4,
    take6,
    take13,
)
from workbench.design.rollout.senses import CHANNELS, MOST
from workbench.dynamics.air.normals import counted_draws
from workbench.dynamics.rigid_body import into_body, into_world, rotation
from workbench.estimation.ekf import NOMINAL, estimate
from workbench.estimation.estimators import Estimator
from workbench.estimation.samples import AGES, BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER, SAMPLES
from workbench.estimation.settings import EKF
from workbench.systems.sensors.barometer import altitude_at, pressure_at

MEAN, DEVIATION, BIAS_MEAN, BIAS_DEVIATION, KEPT, DRIVEN, PRECISION = range(7)
"""Rows of `Hearing.noise`."""


class Sensors(NamedTuple):
    """What the other sensors and the estimators of a block remember.

    Attributes:
        hearing: what they are.
        rows: see `imu_loops.ROWS`.
        noises: what their noise starts from (m, 5).
        alike: whether that is the same for all.
        memory: of the estimators, as their loop has it.
        waiting: samples, a ring (4, depth, 6 x 16).
        stamps: of these (4, depth) [s].
        taken: how many each has taken (4).
        heard: stamp of the last one that the estimators had (4) [s].
        biases: of each channel (4, 6 x 16).
        drifts: likewise.
    """

    hearing: Any
    rows: Any
    noises: Any
    alike: Any
    memory: Any
    waiting: Any
    stamps: Any
    taken: Any
    heard: Any
    biases: Any
    drifts: Any


@register_jitable(forceinline=True)
def _is_due(every, number):  # type: ignore[no-untyped-def]
    """Return whether any sensor takes a sample at a step of physics."""
    a, b, c, d = every
    return _divides(a, number) or _divides(b, number) or _divides(c, number) or _divides(d, number)


@register_jitable(forceinline=True)
def _divides(every, number):  # type: ignore[no-untyped-def]
    return every > 0 and number % every == 0


@register_jitable(forceinline=True)
def _measure(block, sensors, number, step):  # type: ignore[no-untyped-def]
    """Let those sensors take a sample for which it is due at a step of physics."""
    for kind in range(4):
        every = sensors.hearing.every[kind]
        if _divides(every, number):
            slot = sensors.taken[kind] % sensors.hearing.depth
            _take_sample(block, sensors, kind, slot, number // every)
            sensors.stamps[kind, slot] = number * step
            sensors.taken[kind] += 1


@register_jitable
def _take_sample(block, sensors, kind, slot, count):  # type: ignore[no-untyped-def]
    """Let all sensors of a kind take a sample, by its count."""
    n, noise, noises = CHANNELS[kind], sensors.hearing.noise[kind], sensors.noises
    places = sensors.waiting[kind, slot]
    _measure_exactly(block, sensors.hearing, kind, places)
    numbers, drawn = np.empty(3 * MOST), np.empty((3 * MOST, LANES))
    for i in range(1 if sensors.alike else len(noises)):
        counted_draws(noises[i, 1 + kind], count, numbers[: 3 * n])
        drawn[: 3 * n, i] = numbers[: 3 * n]
    for k in range(3 * n):
        if sensors.alike:
            drawn[k] = drawn[k, 0]
    for k in range(n):
        lanes = slice(k * LANES, (k + 1) * LANES)
        bias, drifted = sensors.biases[kind, lanes], sensors.drifts[kind, lanes]
        values, now, later, once = places[lanes], drawn[k], drawn[n + k], drawn[2 * n + k]
        mean, deviation, precision = noise[MEAN, k], noise[DEVIATION, k], noise[PRECISION, k]
        kept, driven = noise[KEPT, k], noise[DRIVEN, k]
        if count == 0:
            for i in range(LANES):
                bias[i] = noise[BIAS_MEAN, k] + noise[BIAS_DEVIATION, k] * once[i]
        for i in range(LANES):
            values[i] += mean + (bias[i] + drifted[i]) + deviation * now[i]
        if precision > 0.0:
            for i in range(LANES):
                values[i] = precision * np.rint(values[i] / precision)
        for i in range(LANES):
            drifted[i] = kept * drifted[i] + driven * later[i]


@register_jitable
def _measure_exactly(block, hearing, kind, places):  # type: ignore[no-untyped-def]
    """Write what perfect sensors measure: one of `settings.HEARD`."""
    place = hearing.mounting
    if kind == 0:
        p_BG = place[3:6]
        for i in range(LANES):
            state = take13(block, STATE, i)
            arm = into_world(rotation(state[0:4]), p_BG)
            w_x, w_y, w_z = state[7], state[8], state[9]
            put3(places, 0, i, (state[4] + arm[0], state[5] + arm[1], state[6] + arm[2]))
            v_x = state[10] + w_y * arm[2] - w_z * arm[1]
            v_y = state[11] + w_z * arm[0] - w_x * arm[2]
            put3(places, 3, i, (v_x, v_y, state[12] + w_x * arm[1] - w_y * arm[0]))
    elif kind == 1:
        p_BP = place[6:9]
        for i in range(LANES):
            arm = into_world(rotation(take4(block, STATE, i)), p_BP)
            height = take(block, STATE + 6, i) + arm[2]
            put(places, 0, i, pressure_at(hearing.reference + height))
    elif kind == 2:
        m_W, R_BM = place[15:18], hearing.R_BM
        for i in range(LANES):
            field = into_body(rotation(take4(block, STATE, i)), m_W)
            put3(places, 0, i, into_body(R_BM, field))
    else:
        p_BR, n_BR = place[9:12], place[12:15]
        for i in range(LANES):
            R = rotation(take4(block, STATE, i))
            height = take(block, STATE + 6, i) + into_world(R, p_BR)[2]
            down = -into_world(R, n_BR)[2]
            distance = height / down if down > 0.0 else math.inf
            distance = distance if distance <= hearing.farthest else math.inf
            put(places, 0, i, distance if distance >= hearing.nearest else -math.inf)


@register_jitable(forceinline=True)
def _deliver(sensors, now):  # type: ignore[no-untyped-def]
    """Write what sensors newly deliver, see `estimation.samples`."""
    rows, hearing = sensors.rows, sensors.hearing
    for i in range(LANES):
        elapsed = take(rows, ELAPSED, i)
        sums, sample = take6(rows, SUMS, i), take6(rows, SAMPLE, i)
        share = 1.0 / elapsed
        mean = (
            sums[0] * share if elapsed > 0.0 else sample[0],
            sums[1] * share if elapsed > 0.0 else sample[1],
            sums[2] * share if elapsed > 0.0 else sample[2],
            sums[3] * share if elapsed > 0.0 else sample[3],
            sums[4] * share if elapsed > 0.0 else sample[4],
            sums[5] * share if elapsed > 0.0 else sample[5],
        )
        put6(rows, Z, i, mean)
        put(rows, ELAPSED, i, 0.0)
        put6(rows, SUMS, i, (0.0, 0.0, 0.0, 0.0, 0.0, 0.0))
    for kind in range(4):
        flag = (GPS, BAROMETER, MAGNETOMETER, RANGE_FINDER)[kind]
        slot, taken = -1, sensors.taken[kind]
        for age in range(min(taken, hearing.depth)):
            latest = (taken - 1 - age) % hearing.depth
            stamp = sensors.stamps[kind, latest]
            if stamp + hearing.late[kind] <= now:
                if stamp != sensors.heard[kind]:
                    sensors.heard[kind] = stamp
                    slot = latest
                break
        for i in range(LANES):
            put(rows, Z + flag, i, 1.0 if slot >= 0 else 0.0)
        if slot < 0:
            continue
        places, age = sensors.waiting[kind, slot], now - sensors.stamps[kind, slot]
        if kind > 0:
            for i in range(LANES):
                put(rows, Z + AGES + kind - 1, i, age)
        if kind == 0:
            for i in range(LANES):
                put(rows, Z + GPS + 1, i, age)
                put6(rows, Z + GPS + 2, i, take6(places, 0, i))
        elif kind == 1:
            for i in range(LANES):
                height = altitude_at(take(places, 0, i)) - hearing.reference
                put(rows, Z + BAROMETER + 1, i, height)
        elif kind == 2:
            R_BM = hearing.R_BM
            for i in range(LANES):
                put3(rows, Z + MAGNETOMETER + 1, i, into_world(R_BM, take3(places, 0, i)))
        else:
            for i in range(LANES):
                distance = take(places, 0, i)
                found = math.isfinite(distance)
                distance = min(max(distance, hearing.nearest), hearing.farthest)
                put(rows, Z + RANGE_FINDER, i, 1.0 if found else 0.0)
                put(rows, Z + RANGE_FINDER + 1, i, distance if found else math.nan)


@register_jitable
def _begin_each(candidates):  # type: ignore[no-untyped-def]
    """Return memories of the estimators, and their settings."""
    return candidates.memories.copy(), candidates.filters


def _run_each(estimator: Estimator) -> Callable[..., None]:
    """Return the loop that runs an estimator for one candidate after the other."""
    update = estimator.update

    @register_jitable
    def run(rows, kept, mounting, dt):  # type: ignore[no-untyped-def]
        memories, filters = kept
        many = len(memories)
        z = np.empty(SAMPLES)
        places, p_BI = np.array(mounting), mounting[0:3]
        for i in range(LANES):
            if i >= many:
                put13(rows, ESTIMATE, i, take13(rows, ESTIMATE, many - 1))
                continue
            for k in range(SAMPLES):
                z[k] = take(rows, Z + k, i)
            memory = memories[i]
            update(memory, z, filters[i], places, dt)
            put13(rows, ESTIMATE, i, estimate(memory[:NOMINAL], take3(rows, RATES, i), p_BI))

    return unique(run, estimator.key)


def make_knowing(estimator: Estimator) -> Knowing:
    """Return how laws know the motion that an estimator tells."""
    begin_memory, run = begin_ekf, run_ekf
    if estimator.name != EKF:
        begin_memory, run = _begin_each, _run_each(estimator)

    @register_jitable
    def begin(block, candidates, hearing, schedule):  # type: ignore[no-untyped-def]
        """Return what sensors and estimators remember at the start, see `Knowing`."""
        imus = begin_imus(block, candidates, hearing, schedule)
        depth = hearing.depth
        sensors = Sensors(
            hearing,
            imus.rows,
            candidates.noises,
            imus.alike,
            begin_memory(candidates),
            np.zeros((4, depth, MOST * LANES)),
            np.full((4, depth), math.nan),
            np.zeros(4, dtype=np.int64),
            np.full(4, math.nan),
            np.zeros((4, MOST * LANES)),
            np.zeros((4, MOST * LANES)),
        )
        return True, imus, sensors, hearing.every, imus.rows

    @register_jitable(forceinline=True)
    def know(sensors, instant, period):  # type: ignore[no-untyped-def]
        """Update the estimates, and write the motion that the laws know."""
        rows, hearing = sensors.rows, sensors.hearing
        _deliver(sensors, instant * period)
        dt = period if instant > 0 else 0.0
        run(rows, sensors.memory, hearing.mounting, dt)
        for i in range(LANES):
            found = take13(rows, ESTIMATE, i)
            w_W = into_world(rotation(found[0:4]), found[7:10])
            put3(rows, ESTIMATE + 7, i, w_W)
        number = instant * round(period / hearing.step)
        drift(rows, sensors.noises[:, 0], sensors.alike, hearing.imu_noise, number)

    @register_jitable(forceinline=True)
    def sense(block, i, places, row, rows):  # type: ignore[no-untyped-def]
        """Put the estimate into a state that stands somewhere from a row on."""
        put13(places, row, i, take13(rows, ESTIMATE, i))

    name = estimator.key
    return Knowing(
        begin=unique(begin, name),
        sample=sample_imus,
        know=unique(know, name),
        sense=unique(sense, name),
        is_due=_is_due,
        measure=_measure,
        rests=False,
    )

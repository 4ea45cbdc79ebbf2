"""What the laws of a block know by an estimator: loops over its candidates, with their sensors.

IMUs stand first, around the functions of `estimation.imu`; then estimators, and what they hear. The
Kalman filter has loops of its own, around its own functions; other estimators run for one candidate
after the other.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable, unique
from workbench.control.flight_law import reader, writer
from workbench.design.rollout.gyro_loops import Knowing
from workbench.design.rollout.rows import (
    LANES,
    LAST,
    STATE,
    put,
    put3,
    put4,
    put6,
    put9,
    put13,
    take,
    take3,
    take4,
    take6,
    take7,
    take8,
    take9,
    take13,
    take16,
    take18,
)
from workbench.design.rollout.senses import CHANNELS, MOST
from workbench.dynamics.air.normals import COUNT, counted_draws, draw_normals
from workbench.dynamics.rigid_body import into_body, into_world, rotation
from workbench.estimation import imu
from workbench.estimation.ekf import CHANNELS as NUMBERS
from workbench.estimation.ekf import (
    COVARIANCE,
    DISTANCE,
    ERRORS,
    HEADING,
    HEIGHT,
    INNOVATIONS,
    NOMINAL,
    Covariance,
    Measured,
    blocks_of,
    corrected,
    estimate,
    fused,
    measured_distance,
    measured_heading,
    measured_height,
    measured_motion,
    propagated,
    spread,
    transition,
)
from workbench.estimation.estimators import Estimator
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
from workbench.estimation.samples import AGES, BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER, SAMPLES
from workbench.estimation.settings import EKF
from workbench.systems.sensors.barometer import altitude_at, pressure_at

BIAS, DRIFT, DRAWN, SCALE, EVERY, GYRO_FILTER, GYRO, RATES = 0, 6, 12, 18, 19, 20, 38, 50
ACCEL_FILTER, ACCEL, SAMPLE, SUMS, ELAPSED, NEW = 53, 62, 68, 74, 80, 81
DUE = NEW + 6
CARRIED = DUE + 1
MOTION = CARRIED + 7
Z = MOTION + 19
ESTIMATE = Z + SAMPLES
"""Rows of the block of an IMU: its biases and their drift, normal numbers of a step, factor on the
deviations, steps between samples, coefficients and states of the gyro's filters and what comes out
of them, the same of the accelerometer's, sample before, integral since it was read and the steps
that it took, -1 before the first, sample of this step, whether one is due (0, 1), attitude and
velocity at the sample before, see `imu.carried`, a copy of the body's state and of its acceleration
before, as loops over one array are the quickest; what the estimator gets, see `estimation.samples`;
and the motion that the law knows (13)."""
ROWS = ESTIMATE + 13
X, P, ERROR, SETTINGS = 0, 16, 151, 166
INPUT = SETTINGS + 11
MEASURED = INPUT + 17
SIZE = MEASURED + 17 * NUMBERS
"""Rows of the filter: its nominal state, its covariance block by block, errors found so far, its
settings, what is taken in now, and of each number that is measured H, gap and variance; and how
many they are. What is taken in stands in one place, and beside the rest: only loops over rows of
one array, whose places are known, become vector instructions."""
MEAN, DEVIATION, BIAS_MEAN, BIAS_DEVIATION, KEPT, DRIVEN, PRECISION = range(7)
"""Rows of `Hearing.noise`."""


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
        step: of physics [s].
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
    step: Any
    drawn: Any


@register_jitable
def begin_imus(block, candidates, hearing, schedule):
    """Return the IMUs at the start."""
    rows, due = np.zeros(ROWS * LANES), np.zeros((schedule.steps, LANES))
    works, noise, drawn = False, hearing.imu_noise, np.empty(COUNT)
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
        bias = imu.drawn_bias(noise.mean, noise.spread, candidates.noises[c, 0])
        for k in range(6):
            put(rows, BIAS + k, i, bias[k])
        put(rows, ELAPSED, i, -1.0)
    seeds = candidates.noises[:, 0].copy()
    alike = (candidates.noises == candidates.noises[0]).all()
    deviation, step = noise.deviation, schedule.step
    return Imus(rows, due, works, seeds, alike, hearing.p_BS, hearing.R_BS, deviation, step, drawn)


@register_jitable(forceinline=True)
def sample_imus(block, imus, number, step):
    """Let those IMUs take a sample for which it is due at a step of physics.

    Args:
        block: of the candidates.
        imus: see `Imus`.
        number: of the step.
        step: its place in the control period.
    """
    rows, due, works, noises, alike, p_BS, R_BS, deviation, dt, drawn = imus
    _draw(rows, noises, alike, 2 * number, drawn)
    for i in range(LANES):
        rows[DUE * LANES + i] = due[step, i]
    for i in range(13 * LANES):
        rows[MOTION * LANES + i] = block[STATE * LANES + i]
    for i in range(6 * LANES):
        rows[(MOTION + 13) * LANES + i] = block[LAST * LANES + i]
    for i in range(LANES):
        state = take13(rows, MOTION, i)
        exact = imu.measured(state, take6(rows, MOTION + 13, i), p_BS)
        before, now = take7(rows, CARRIED, i), imu.carried(state, p_BS)
        first, here = take(rows, ELAPSED, i) < 0.0, take(rows, DUE, i) > 0.0
        force = imu.mean_force(before, now, take(rows, EVERY, i) * dt)
        exact = exact[0:3] + _chosen(first, exact[3:6], force)
        put4(rows, CARRIED, i, _four(here, now[0:4], before[0:4]))
        put3(rows, CARRIED + 4, i, _chosen(here, now[4:7], before[4:7]))
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
def _chosen(due, new, old):
    """Return the new vector where it is due."""
    return (
        new[0] if due else old[0],
        new[1] if due else old[1],
        new[2] if due else old[2],
    )


@register_jitable(forceinline=True)
def _added(sums, values, share):
    """Return sums with a share of values added."""
    return (
        sums[0] + share * values[0],
        sums[1] + share * values[1],
        sums[2] + share * values[2],
    )


@register_jitable
def _filter(rows):
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
def _four(due, new, old):
    """Return the new numbers where they are due."""
    return (
        new[0] if due else old[0],
        new[1] if due else old[1],
        new[2] if due else old[2],
        new[3] if due else old[3],
    )


@register_jitable(forceinline=True)
def drift(rows, noises, alike, imu_noise, number):
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
def _draw(rows, noises, alike, number, drawn):
    """Write six normal numbers for each candidate."""
    draw_normals(noises[0], number, drawn)
    same = imu.six(drawn)
    for i in range(LANES):
        put6(rows, DRAWN, i, same)
    if not alike:
        for i in range(1, len(noises)):
            draw_normals(noises[i], number, drawn)
            put6(rows, DRAWN, i, imu.six(drawn))


@register_jitable
def begin_ekf(candidates):
    """Return the rows of the filters at the start."""
    b = np.zeros(SIZE * LANES)
    for i in range(LANES):
        c = min(i, len(candidates.memories) - 1)
        memory = candidates.memories[c]
        for k in range(NOMINAL):
            put(b, X + k, i, memory[k])
        blocks = blocks_of(memory[COVARIANCE:INNOVATIONS].reshape(ERRORS, ERRORS))
        for number in range(len(blocks)):
            for k in range(9):
                put(b, P + 9 * number + k, i, blocks[number][k])
        for k in range(candidates.filters.shape[1]):
            put(b, SETTINGS + k, i, candidates.filters[c, k])
    return b


_BLOCK = ", ".join(f"b[({P} + 9 * {{0}} + {k}) * {LANES} + i]" for k in range(9))
_covariance = reader(Covariance, len(Covariance._fields), "blocks", f"({_BLOCK})", "b, i")
"""Returns a candidate's covariance; `_put_covariance` writes it."""
_put_covariance = writer(len(Covariance._fields), "blocks", _BLOCK, "b, i")


@register_jitable(forceinline=True)
def _settings(b, i):
    """Return a candidate's settings."""
    return take8(b, SETTINGS, i) + take3(b, SETTINGS + 8, i)


@register_jitable(forceinline=True)
def _samples(rows, i):
    """Return what a candidate's filter gets (25)."""
    return take18(rows, Z, i) + take4(rows, Z + 18, i) + take3(rows, Z + 22, i)


@register_jitable(forceinline=True)
def _put_measured(b, channel, i, m):
    """Put what is measured into its place."""
    row = MEASURED + 17 * channel
    put3(b, row, i, m.t)
    put3(b, row + 3, i, m.p)
    put3(b, row + 6, i, m.v)
    put3(b, row + 9, i, m.g)
    put3(b, row + 12, i, m.a)
    put(b, row + 15, i, m.gap)
    put(b, row + 16, i, m.variance)


@register_jitable(forceinline=True)
def _propagate(b, rows, dt):
    """Let a period of the IMU pass."""
    for i in range(6 * LANES):
        b[INPUT * LANES + i] = rows[Z * LANES + i]
    for i in range(LANES):
        x, imu = take16(b, X, i), take6(b, INPUT, i)
        known = spread(_covariance(b, i), transition(x, imu, dt), take4(b, SETTINGS, i), dt)
        _put_covariance(b, i, known)
    for i in range(LANES):
        _put_nominal(b, i, propagated(take16(b, X, i), take6(b, INPUT, i), dt))


@register_jitable(forceinline=True)
def _put_nominal(b, i, x):
    put13(b, X, i, x[0:13])
    put3(b, X + 13, i, x[13:16])


@register_jitable
def _take_in(b, channel):
    """Take a measured number in."""
    first = (MEASURED + 17 * channel) * LANES
    for i in range(17 * LANES):
        b[INPUT * LANES + i] = b[first + i]
    for i in range(LANES):
        m = Measured(
            take3(b, INPUT, i),
            take3(b, INPUT + 3, i),
            take3(b, INPUT + 6, i),
            take3(b, INPUT + 9, i),
            take3(b, INPUT + 12, i),
            take(b, INPUT + 15, i),
            take(b, INPUT + 16, i),
        )
        error = take9(b, ERROR, i) + take6(b, ERROR + 9, i)
        found = fused(_covariance(b, i), error, m, take(b, SETTINGS + 10, i))
        _put_covariance(b, i, found.P)
        put13(b, ERROR, i, found.error[0:13])
        put(b, ERROR + 13, i, found.error[13])
        put(b, ERROR + 14, i, found.error[14])


@register_jitable(forceinline=True)
def _take_in_one(b, rows, mounting, channel, measured):
    """Take in what a sensor measures that gives one number, by the filter's function for it."""
    for i in range(LANES):
        m = measured(take16(b, X, i), _samples(rows, i), mounting, _settings(b, i))
        _put_measured(b, channel, i, m)
    _take_in(b, channel)


@register_jitable(forceinline=True)
def run_ekf(rows, b, mounting, dt):
    """Let all filters do an update, and write their estimates.

    Args:
        rows: see `ROWS`.
        b: see `SIZE`.
        mounting: see `Mounting.packed`.
        dt: since the update before, 0 at the first [s].
    """
    if dt > 0.0:
        _propagate(b, rows, dt)
    gps, height = _any(rows, GPS), _any(rows, BAROMETER)
    heading, distance = _any(rows, MAGNETOMETER), _any(rows, RANGE_FINDER)
    if gps:
        for i in range(LANES):
            m = measured_motion(take16(b, X, i), _samples(rows, i), mounting, _settings(b, i))
            _put_measured(b, 0, i, m[0])
            _put_measured(b, 1, i, m[1])
            _put_measured(b, 2, i, m[2])
            _put_measured(b, 3, i, m[3])
            _put_measured(b, 4, i, m[4])
            _put_measured(b, 5, i, m[5])
        for channel in range(6):
            _take_in(b, channel)
    if height:
        _take_in_one(b, rows, mounting, HEIGHT, measured_height)
    if heading:
        _take_in_one(b, rows, mounting, HEADING, measured_heading)
    if distance:
        _take_in_one(b, rows, mounting, DISTANCE, measured_distance)
    if gps or height or heading or distance:
        for i in range(LANES):
            error = take9(b, ERROR, i) + take6(b, ERROR + 9, i)
            _put_nominal(b, i, corrected(take16(b, X, i), error))
            put9(b, ERROR, i, (0.0,) * 9)
            put3(b, ERROR + 9, i, (0.0,) * 3)
            put3(b, ERROR + 12, i, (0.0,) * 3)
    for i in range(LANES):
        found = estimate(take16(b, X, i), take3(rows, RATES, i), mounting[0:3])
        put13(rows, ESTIMATE, i, found)


@register_jitable(forceinline=True)
def _any(rows, flag):
    """Return whether any candidate has a new sample."""
    found = 0.0
    for i in range(LANES):
        found += take(rows, Z + flag, i)
    return found > 0.0


class Sensors(NamedTuple):
    """What the other sensors and the estimators of a block remember.

    Attributes:
        hearing: what they are.
        rows: see `ROWS`.
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
def _is_due(every, number):
    """Return whether any sensor takes a sample at a step of physics."""
    a, b, c, d = every
    return _divides(a, number) or _divides(b, number) or _divides(c, number) or _divides(d, number)


@register_jitable(forceinline=True)
def _divides(every, number):
    return every > 0 and number % every == 0


@register_jitable(forceinline=True)
def _measure(block, sensors, number, step):
    """Let those sensors take a sample for which it is due at a step of physics."""
    for kind in range(4):
        every = sensors.hearing.every[kind]
        if _divides(every, number):
            slot = sensors.taken[kind] % sensors.hearing.depth
            _take_sample(block, sensors, kind, slot, number // every)
            sensors.stamps[kind, slot] = number * step
            sensors.taken[kind] += 1


@register_jitable
def _take_sample(block, sensors, kind, slot, count):
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
def _measure_exactly(block, hearing, kind, places):
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
def _deliver(sensors, now):
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
def _begin_each(candidates):
    """Return memories of the estimators, and their settings."""
    return candidates.memories.copy(), candidates.filters


def _run_each(estimator: Estimator) -> Callable[..., None]:
    """Return the loop that runs an estimator for one candidate after the other."""
    update = estimator.update

    @register_jitable
    def run(rows, kept, mounting, dt):
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
    def begin(block, candidates, hearing, schedule):
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
    def know(sensors, instant, period):
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
    def sense(block, i, places, row, rows):
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

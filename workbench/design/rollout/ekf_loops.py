"""The Kalman filters of a block: loops over its candidates around the filter's own functions."""

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.imu_loops import ESTIMATE, RATES, Z
from workbench.design.rollout.rows import (
    LANES,
    put,
    put3,
    put9,
    put13,
    take,
    take3,
    take4,
    take6,
    take8,
    take9,
    take16,
    take18,
)
from workbench.estimation.ekf import (
    CHANNELS,
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
from workbench.estimation.samples import BAROMETER, GPS, MAGNETOMETER, RANGE_FINDER

X, P, ERROR, SETTINGS = 0, 16, 151, 166
INPUT = SETTINGS + 11
MEASURED = INPUT + 17
SIZE = MEASURED + 17 * CHANNELS
"""Rows of the filter: its nominal state, its covariance block by block, errors found so far, its
settings, what is taken in now, and of each number that is measured H, gap and variance; and how
many they are. What is taken in stands in one place, and beside the rest: only loops over rows of
one array, whose places are known, become vector instructions."""


@register_jitable
def begin_ekf(candidates):  # type: ignore[no-untyped-def]
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


@register_jitable(forceinline=True)
def _covariance(b, i):  # type: ignore[no-untyped-def]
    """Return a candidate's covariance."""
    return Covariance(
        take9(b, P, i),
        take9(b, P + 9, i),
        take9(b, P + 18, i),
        take9(b, P + 27, i),
        take9(b, P + 36, i),
        take9(b, P + 45, i),
        take9(b, P + 54, i),
        take9(b, P + 63, i),
        take9(b, P + 72, i),
        take9(b, P + 81, i),
        take9(b, P + 90, i),
        take9(b, P + 99, i),
        take9(b, P + 108, i),
        take9(b, P + 117, i),
        take9(b, P + 126, i),
    )


@register_jitable(forceinline=True)
def _put_covariance(b, i, known):  # type: ignore[no-untyped-def]
    """Put a candidate's covariance into its place."""
    put9(b, P, i, known.tt)
    put9(b, P + 9, i, known.tp)
    put9(b, P + 18, i, known.tv)
    put9(b, P + 27, i, known.tg)
    put9(b, P + 36, i, known.ta)
    put9(b, P + 45, i, known.pp)
    put9(b, P + 54, i, known.pv)
    put9(b, P + 63, i, known.pg)
    put9(b, P + 72, i, known.pa)
    put9(b, P + 81, i, known.vv)
    put9(b, P + 90, i, known.vg)
    put9(b, P + 99, i, known.va)
    put9(b, P + 108, i, known.gg)
    put9(b, P + 117, i, known.ga)
    put9(b, P + 126, i, known.aa)


@register_jitable(forceinline=True)
def _settings(b, i):  # type: ignore[no-untyped-def]
    """Return a candidate's settings."""
    return take8(b, SETTINGS, i) + take3(b, SETTINGS + 8, i)


@register_jitable(forceinline=True)
def _samples(rows, i):  # type: ignore[no-untyped-def]
    """Return what a candidate's filter gets (25)."""
    return take18(rows, Z, i) + take4(rows, Z + 18, i) + take3(rows, Z + 22, i)


@register_jitable(forceinline=True)
def _put_measured(b, channel, i, m):  # type: ignore[no-untyped-def]
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
def _propagate(b, rows, dt):  # type: ignore[no-untyped-def]
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
def _put_nominal(b, i, x):  # type: ignore[no-untyped-def]
    put13(b, X, i, x[0:13])
    put3(b, X + 13, i, x[13:16])


@register_jitable
def _take_in(b, channel):  # type: ignore[no-untyped-def]
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
def _take_in_one(b, rows, mounting, channel, measured):  # type: ignore[no-untyped-def]
    """Take in what a sensor measures that gives one number, by the filter's function for it."""
    for i in range(LANES):
        m = measured(take16(b, X, i), _samples(rows, i), mounting, _settings(b, i))
        _put_measured(b, channel, i, m)
    _take_in(b, channel)


@register_jitable(forceinline=True)
def run_ekf(rows, b, mounting, dt):  # type: ignore[no-untyped-def]
    """Let all filters do an update, and write their estimates.

    Args:
        rows: see `imu_loops.ROWS`.
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
def _any(rows, flag):  # type: ignore[no-untyped-def]
    """Return whether any candidate has a new sample."""
    found = 0.0
    for i in range(LANES):
        found += take(rows, Z + flag, i)
    return found > 0.0

"""An estimator run over recorded samples of any origin."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.common.series import TimedArrays, interpolated_on_grid
from workbench.estimation import ekf_state
from workbench.estimation.estimators import (
    COVARIANCE_TRIANGLE,
    Estimator,
    checked_update,
    known_motion,
)
from workbench.estimation.samples import (
    AGES,
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
    Mounting,
)

MAX_UPDATE_PERIOD_S = 0.02
"""Longest period of an update [s]; a longer time between two IMU samples is split."""
IMU_GAP_PERIODS = 3.0
"""A time between IMU samples of more than this many usual periods is reported."""
_PROGRESS_UPDATES = 1024
"""Updates between two reports of progress."""


class StampedSamples(NamedTuple):
    """Samples of a sensor over time, in order.

    Attributes:
        stamp: when each was taken (N) [s], growing.
        arrived: when each was available to the flight computer (N) [s].
        values: (N, k).
    """

    stamp: np.ndarray
    arrived: np.ndarray
    values: np.ndarray


@dataclass(frozen=True)
class SensorSamples:
    """Samples of sensors over time; None for a sensor without samples.

    Attributes:
        imu: angular velocity [rad/s] and specific force [m/s²] in B (6).
        gps: place and velocity of the antenna in W [m, m/s] (6).
        barometer: height [m] (1).
        magnetometer: field in B [T] (3).
        range_finder: distance [m] (1).
    """

    imu: StampedSamples
    gps: StampedSamples | None = None
    barometer: StampedSamples | None = None
    magnetometer: StampedSamples | None = None
    range_finder: StampedSamples | None = None


@dataclass(frozen=True)
class EstimateHistory(TimedArrays):
    """The results of an estimator after each of its updates.

    Attributes:
        time: stamps of the IMU (N) [s].
        estimate: (N, 13) q_WB, p_WB [m], w_WB_W [rad/s] and v_WB_W [m/s].
        biases: (N, 6) of gyro [rad/s] and accelerometer [m/s²] in B.
        deviations: (N, 15), see `Estimator`; so the next two.
        covariance: (N, 45).
        innovations: (N, 20).
    """

    time: np.ndarray
    estimate: np.ndarray
    biases: np.ndarray
    deviations: np.ndarray
    covariance: np.ndarray
    innovations: np.ndarray


class ImuGap(NamedTuple):
    """A time without samples of the IMU: its begin and its length [s]."""

    begin: float
    length: float


def imu_gaps(imu: StampedSamples) -> tuple[ImuGap, ...]:
    """Return the times without samples, see `IMU_GAP_PERIODS`."""
    periods = np.diff(imu.stamp)
    if not len(periods):
        return ()
    long = np.flatnonzero(periods > IMU_GAP_PERIODS * np.median(periods))
    return tuple(ImuGap(float(imu.stamp[each]), float(periods[each])) for each in long)


def run_estimator(
    estimator: Estimator,
    samples: SensorSamples,
    settings: Sequence[float],
    mounting: Mounting,
    begin: np.ndarray,
    progress: Callable[[float], None] | None = None,
) -> EstimateHistory:
    """Run an estimator over samples: an update with each of the IMU.

    For the IMU, a period uses the mean of the samples at both ends. A period longer than
    `MAX_UPDATE_PERIOD_S` is split, with linear interpolation. A sample of another sensor joins the
    first update that is not before its stamp, and whose IMU sample did not arrive before it; of
    several, the newest counts.

    Args:
        estimator: that runs.
        samples: of all sensors; of the IMU one or more.
        settings: the estimator's live numbers, in their order.
        mounting: of the sensors.
        begin: memory at the time of the first sample of the IMU, see `Estimator.begin`.
        progress: called with the share done, 0 .. 1.
    """
    imu = _split(samples.imu)
    count = len(imu.stamp)
    update, places = checked_update(estimator), mounting.packed()
    numbers = np.array(settings, dtype=float)
    inputs = _inputs(samples, imu)
    memory = np.array(begin, dtype=float)
    found = EstimateHistory(
        time=imu.stamp,
        estimate=np.empty((count, 13)),
        biases=np.empty((count, 6)),
        deviations=np.empty((count, ekf_state.ERRORS)),
        covariance=np.empty((count, len(COVARIANCE_TRIANGLE[0]))),
        innovations=np.empty((count, 2 * ekf_state.MEASUREMENT_CHANNELS)),
    )
    periods = np.diff(imu.stamp, prepend=imu.stamp[:1])
    for k, dt in enumerate(periods.tolist()):
        update(memory, inputs[k], numbers, places, dt)
        found.estimate[k] = known_motion(memory, imu.values[k], mounting.p_BI)
        found.biases[k] = memory[10 : ekf_state.NOMINAL]
        found.deviations[k] = estimator.deviations(memory)
        found.covariance[k] = estimator.covariance(memory)
        found.innovations[k] = estimator.innovations(memory)
        if progress and k % _PROGRESS_UPDATES == 0:
            progress(k / count)
    return found


def _split(imu: StampedSamples) -> StampedSamples:
    """Return samples of the IMU with none farther apart than `MAX_UPDATE_PERIOD_S`."""
    periods = np.diff(imu.stamp)
    if not np.any(periods > MAX_UPDATE_PERIOD_S):
        return imu
    pieces = [
        np.linspace(begin, end, int(np.ceil(period / MAX_UPDATE_PERIOD_S)), endpoint=False)
        for begin, end, period in zip(imu.stamp[:-1], imu.stamp[1:], periods, strict=True)
    ]
    stamp = np.concatenate([*pieces, imu.stamp[-1:]])
    arrived, values = (
        interpolated_on_grid(imu.stamp, each, stamp) for each in (imu.arrived, imu.values)
    )
    return StampedSamples(stamp, arrived, values)


def _inputs(samples: SensorSamples, imu: StampedSamples) -> np.ndarray:
    """Return the samples of each update (N, 25), see `estimation.samples`."""
    z = np.zeros((len(imu.stamp), SAMPLE_ARRAY_SIZE))
    z[0, :6] = imu.values[0]
    z[1:, :6] = 0.5 * (imu.values[:-1] + imu.values[1:])
    if samples.gps:
        rows, new = _joined(samples.gps, imu)
        z[rows, GPS] = 1.0
        z[rows, GPS + 1] = imu.stamp[rows] - samples.gps.stamp[new]
        z[rows, GPS + 2 : GPS + 8] = samples.gps.values[new]
    others = (
        (BAROMETER, samples.barometer),
        (MAGNETOMETER, samples.magnetometer),
        (RANGE_FINDER, samples.range_finder),
    )
    for place, (at, sensor) in enumerate(others):
        if sensor:
            rows, new = _joined(sensor, imu)
            z[rows, at] = 1.0
            z[rows, AGES + place] = imu.stamp[rows] - sensor.stamp[new]
            z[rows, at + 1 : at + 1 + sensor.values.shape[1]] = sensor.values[new]
    return z


def _joined(sensor: StampedSamples, imu: StampedSamples) -> tuple[np.ndarray, np.ndarray]:
    """Return indices of updates, and of the sensor's sample that each uses."""
    rows = np.maximum(
        np.searchsorted(imu.stamp, sensor.stamp), np.searchsorted(imu.arrived, sensor.arrived)
    )
    new = np.arange(len(rows))
    # samples from before the first update are not used
    here = (rows < len(imu.stamp)) & (sensor.stamp >= imu.stamp[0])
    rows, new = rows[here], new[here]
    last = np.append(np.diff(rows) > 0, True)[: len(rows)]
    return rows[last], new[last]

"""An estimator over samples of motions that are known in closed form."""

import math

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.estimation import ekf, ekf_state
from workbench.estimation.estimators import find_estimator
from workbench.estimation.run import SensorSamples, StampedSamples, imu_gaps, run_estimator
from workbench.estimation.samples import Mounting

PERIOD = 1 / 200
STILL = np.array([1.0, *[0.0] * 12])
UP = np.array([0.0, 0.0, 9.81])


def imu(time, rates=(0.0, 0.0, 0.0), forces=UP):
    values = np.hstack([np.broadcast_to(rates, (len(time), 3)), np.tile(forces, (len(time), 1))])
    return StampedSamples(time, time, values)


def run(samples, state=STILL, name="ekf", mounting=None):
    estimator, mounting = find_estimator(name), mounting or Mounting()
    begin = estimator.begin(state, mounting, np.zeros(ekf_state.ERRORS), ekf.InitialDeviations())
    return run_estimator(estimator, samples, estimator.settings(), mounting, begin)


@pytest.mark.parametrize("name", ["ekf", "complementary"])
def test_without_other_sensors_a_bias_of_the_accelerometer_drifts_as_its_integral(name):
    b, time = 0.02, np.arange(0.0, 20.0, PERIOD)
    found = run(SensorSamples(imu(time, forces=UP + [0.0, 0.0, b])), name=name)
    assert found.estimate[:, 12] == pytest.approx(b * time, abs=1e-9)
    if name == "ekf":  # the other's place has an error of first order in the period
        assert found.estimate[:, 6] == pytest.approx(0.5 * b * time**2, abs=1e-9)


def test_a_bias_of_the_gyro_tilts_the_estimate_and_gravity_does_the_rest():
    """Roll b t, and with it v_y = -g (1 - cos b t) / b."""
    b, time = 0.01, np.arange(0.0, 20.0, PERIOD)
    found = run(SensorSamples(imu(time, rates=(b, 0.0, 0.0))))
    roll = Rotation.from_quat(found.estimate[:, [1, 2, 3, 0]]).as_rotvec()
    assert roll == pytest.approx(np.outer(b * time, [1.0, 0.0, 0.0]), abs=1e-9)
    assert found.estimate[:, 11] == pytest.approx(-9.81 * (1.0 - np.cos(b * time)) / b, abs=1e-6)
    assert found.estimate[:, 7] == pytest.approx(b)


def test_samples_of_a_turn_that_speeds_up_count_with_both_ends_of_a_period():
    """About z, w = a t: the heading is a t² / 2; with one end alone it would be a t dt / 2 off."""
    a, time = 1.0, np.arange(0.0, 2.0, PERIOD)
    rates = np.outer(a * time, [0.0, 0.0, 1.0])
    found = run(SensorSamples(imu(time, rates=rates)))
    heading = Rotation.from_quat(found.estimate[:, [1, 2, 3, 0]]).as_rotvec()[:, 2]
    assert heading == pytest.approx(0.5 * a * time**2, abs=1e-9)


def test_a_gap_of_the_imu_is_told_and_bridged():
    """6 rad in one step would be beyond the filter's series; in small ones they are a turn."""
    time = np.arange(0.0, 3.0, PERIOD)
    held = (time < 1.0) | (time > 2.0)
    samples = imu(time[held], rates=(0.0, 0.0, 6.0))
    found = run(SensorSamples(samples))
    assert np.diff(found.time).max() < 0.0201
    ahead = Rotation.from_quat(found.estimate[:, [1, 2, 3, 0]]).apply([1.0, 0.0, 0.0])
    angle = 6.0 * found.time
    assert ahead == pytest.approx(
        np.stack([np.cos(angle), np.sin(angle), 0.0 * angle], axis=1), abs=1e-6
    )
    (gap,) = imu_gaps(samples)
    assert gap == pytest.approx((1.0 - PERIOD, 1.0 + 2.0 * PERIOD), abs=1e-9)
    assert imu_gaps(imu(time)) == imu_gaps(imu(time[:1])) == ()


def test_no_sample_counts_before_it_was_taken():
    """The IMU's samples come 20 ms late, the fixes at once: they wait for the update after them."""
    speed, time = 5.0, np.arange(0.0, 2.0, PERIOD)
    taken = np.arange(0.1021, 1.9, 0.1)
    fixes = np.zeros((len(taken), 6))
    fixes[:, 0], fixes[:, 3] = speed * taken, speed
    values = np.hstack([np.zeros((len(time), 3)), np.tile(UP, (len(time), 1))])
    late = StampedSamples(time, time + 0.02, values)
    state = np.array([1.0, *[0.0] * 9, speed, 0.0, 0.0])
    found = run(SensorSamples(late, gps=StampedSamples(taken, taken, fixes)), state)
    used = found.time[np.isfinite(found.innovations).any(axis=1)]
    assert used == pytest.approx(np.ceil(taken / PERIOD) * PERIOD)


def test_a_sample_counts_when_it_has_come_with_the_age_that_it_has():
    """At 5 m/s a fix that is 0.2 s old is 1 m behind; the drone's place is known exactly."""
    speed, late, time = 5.0, 0.2, np.arange(0.0, 4.0, PERIOD)
    taken = np.arange(0.0521, 3.7, 0.1)
    fixes = np.zeros((len(taken), 6))
    fixes[:, 0], fixes[:, 3] = speed * taken, speed
    moving = STILL.copy()
    moving[10] = speed
    found = run(SensorSamples(imu(time), gps=StampedSamples(taken, taken + late, fixes)), moving)
    heard = np.flatnonzero(np.isfinite(found.innovations[:, 0]))
    assert len(heard) == len(taken)
    waited = found.time[heard] - (taken + late)
    assert np.all((waited > -1e-9) & (waited < PERIOD + 1e-9))
    assert np.abs(found.innovations[heard][:, :12:2]).max() < 1e-9
    assert found.estimate[:, 4] == pytest.approx(speed * time, abs=1e-9)


def test_a_late_height_is_that_of_when_it_was_taken():
    """Climbing at 2 m/s, a height that is 0.1 s old is 0.2 m too low, by air and to the ground."""
    speed, late, time = 2.0, 0.1, np.arange(0.0, 2.0, PERIOD)
    taken = np.arange(0.0521, 1.8, 0.07)
    heights = StampedSamples(taken, taken + late, 3.0 + speed * taken[:, None])
    moving = STILL.copy()
    moving[6], moving[12] = 3.0, speed
    found = run(SensorSamples(imu(time), barometer=heights, range_finder=heights), moving)
    for channel in (ekf_state.HEIGHT_CHANNEL, ekf_state.DISTANCE_CHANNEL):
        told = found.innovations[:, 2 * channel]
        assert np.isfinite(told).sum() == len(taken)
        assert np.nanmax(np.abs(told)) < 1e-9


def test_of_several_samples_between_two_updates_the_newest_counts():
    time, taken = np.arange(128) / 64, np.arange(509) / 256  # exact in binary, so that they meet
    newest = np.arange(509)[:, None] % 4 == 0
    fields = np.where(newest, [0.0, 2e-5, -4e-5], [2e-5, 0.0, -4e-5])
    found = run(SensorSamples(imu(time), magnetometer=StampedSamples(taken, taken, fields)))
    told = found.innovations[:, 14]
    assert np.isfinite(told).all()
    assert np.abs(told).max() < 1e-9
    assert math.isclose(found.estimate[-1, 0], 1.0)


def test_a_sample_of_before_the_first_update_is_not_of_the_run():
    time = np.arange(1.0, 2.0, PERIOD)
    taken = np.array([0.5, 1.5])
    found = run(SensorSamples(imu(time), barometer=StampedSamples(taken, taken, np.zeros((2, 1)))))
    assert np.isfinite(found.innovations[:, 12]).sum() == 1

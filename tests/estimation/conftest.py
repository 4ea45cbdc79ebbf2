"""Flights whose truth the estimators' integration carries on exactly, and what sensors say."""

from typing import NamedTuple

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from workbench.estimation import ekf
from workbench.estimation.estimators import checked_update, find_estimator
from workbench.estimation.samples import (
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
)

G = np.array([0.0, 0.0, 9.81])
PERIOD = 1 / 128


class Flight(NamedTuple):
    """The motion of an IMU; row k of `w` and `f` are means of the period before row k of others.

    Attitude, place and velocity in W; angular velocity and specific force in B. Row 0 of `w` and
    `f` repeats row 1.
    """

    R: Rotation
    p: np.ndarray
    v: np.ndarray
    w: np.ndarray
    f: np.ndarray

    def state(self, k):
        """Return q_WB, p, w_W, v at a row, as of a body whose IMU is at its origin (13)."""
        q = self.R[k].as_quat(scalar_first=True)
        return np.concatenate([q, self.p[k], self.R[k].apply(self.w[k]), self.v[k]])


def flight(place, yaw, duration):
    """Return the flight along a path: `place` gives p (N, 3) for times (N), `yaw` angles (N).

    The thrust axis is along the specific force, as a multirotor's without drag has to be.
    """
    t = np.arange(round(duration / PERIOD) + 1) * PERIOD
    small = 1e-4
    v = (place(t + small) - place(t - small)) / (2 * small)
    a = (place(t + small) - 2 * place(t) + place(t - small)) / small**2
    up = (a + G) / np.linalg.norm(a + G, axis=1, keepdims=True)
    ahead = np.stack([np.cos(yaw(t)), np.sin(yaw(t)), 0 * t], axis=1)
    left = np.cross(up, ahead)
    left /= np.linalg.norm(left, axis=1, keepdims=True)
    R = Rotation.from_matrix(np.stack([np.cross(left, up), left, up], axis=2))
    # angular velocities that turn one attitude into the next, and forces likewise
    w = (R[:-1].inv() * R[1:]).as_rotvec() / PERIOD
    middle = R[:-1] * Rotation.from_rotvec(0.5 * PERIOD * w)
    f = middle.inv().apply(np.diff(v, axis=0) / PERIOD + G)
    steps = 0.5 * PERIOD * (v[:-1] + v[1:])
    p = place(t[:1]) + np.concatenate([np.zeros((1, 3)), np.cumsum(steps, axis=0)])
    return Flight(R, p, v, w[np.r_[0, : len(w)]], f[np.r_[0, : len(f)]])


def hover(duration):
    return flight(
        lambda t: np.outer(np.ones_like(t), (1.0, 2.0, 3.0)), lambda t: 0.3 + 0 * t, duration
    )


def figure_of_eight(duration):
    """Return one of 5 m/s and 35 degrees of tilt that climbs and turns."""

    def place(t):
        return np.stack([3 * np.sin(1.2 * t), 1.5 * np.sin(2.4 * t), 6 + np.sin(0.9 * t)], axis=1)

    return flight(place, lambda t: 0.8 * np.sin(0.7 * t), duration)


def full_speed(duration):
    """Return a circle at 8 m/s, 45 degrees of tilt, looking where it flies to."""

    def place(t):
        return np.stack([6.5 * np.cos(8 / 6.5 * t), 6.5 * np.sin(8 / 6.5 * t), 4 + 0 * t], axis=1)

    return flight(place, lambda t: 8 / 6.5 * t + np.pi / 2, duration)


FLIGHTS = {"hover": hover, "figure of eight": figure_of_eight, "full speed": full_speed}
EVERY = {"gps": 12, "barometer": 4, "magnetometer": 3, "range_finder": 5}
"""Updates between two samples."""


def samples(flown, mounting, settings, rng, biases, every=EVERY, age=0):
    """Return what sensors give at each update (N, 22), with noise as an estimator expects it.

    Args:
        biases: of gyro and accelerometer (N, 6).
        every: updates between two samples, by kind.
        age: of the GPS's samples, in updates.
    """
    n = len(flown.p)
    found = np.zeros((n, SAMPLE_ARRAY_SIZE))
    white = np.repeat([settings.ekf_gyro_noise, settings.ekf_accel_noise], 3) / PERIOD**0.5
    found[:, :6] = np.hstack([flown.w, flown.f]) + biases + white * rng.normal(size=(n, 6))
    R, p_BI = flown.R, np.array(mounting.p_BI)

    def place(p_BX):
        return flown.p + R.apply(np.array(p_BX) - p_BI)

    arm = np.array(mounting.p_BG) - p_BI
    antenna = np.hstack([place(mounting.p_BG), flown.v + R.apply(np.cross(flown.w, arm))])
    spread = [settings.ekf_gps_position] * 2 + [settings.ekf_gps_height]
    spread += [settings.ekf_gps_velocity] * 3
    heard = np.arange(max(age, 1), n)[:: every["gps"]]
    found[heard, GPS], found[heard, GPS + 1] = 1, age * PERIOD
    found[heard, GPS + 2 : GPS + 8] = antenna[heard - age] + spread * rng.normal(
        size=(len(heard), 6)
    )
    heard = np.arange(1, n)[:: every["barometer"]]
    found[heard, BAROMETER] = 1
    height = place(mounting.p_BP)[heard, 2]
    found[heard, BAROMETER + 1] = height + settings.ekf_barometer * rng.normal(size=len(heard))
    heard = np.arange(1, n)[:: every["magnetometer"]]
    field = R[heard].inv().apply(mounting.m_W)
    field += settings.ekf_magnetometer * rng.normal(size=field.shape)
    found[heard, MAGNETOMETER] = 1
    found[heard, MAGNETOMETER + 1 : MAGNETOMETER + 4] = field
    heard = np.arange(1, n)[:: every["range_finder"]]
    down = -R[heard].apply(mounting.n_BR)[:, 2]
    found[heard, RANGE_FINDER] = 1
    found[heard, RANGE_FINDER + 1] = place(mounting.p_BR)[
        heard, 2
    ] / down + settings.ekf_range_finder * rng.normal(size=len(heard))
    return found


def begin(flown, settings, rng):
    """Return the memory of an EKF that is off by what it takes its errors to be, and biases (N, 6).

    The biases begin as far off as the others, and walk.
    """
    deviations = ekf.InitialDeviations()
    memory = ekf.initial_ekf(flown.state(0), (0.0, 0.0, 0.0), deviations)
    errors = np.repeat(deviations, 3) * rng.normal(size=15)
    memory[:4] = (flown.R[0] * Rotation.from_rotvec(errors[:3]).inv()).as_quat(scalar_first=True)
    memory[4:10] -= errors[3:9]
    walk = np.repeat([settings.ekf_gyro_bias_walk, settings.ekf_accel_bias_walk], 3) * PERIOD**0.5
    return memory, errors[9:] + np.cumsum(walk * rng.normal(size=(len(flown.p), 6)), axis=0)


class Kit(NamedTuple):
    """What tests of estimators share."""

    period: float
    flights: dict
    flight: object
    samples: object
    begin: object
    ekf: object
    complementary: object


@pytest.fixture(scope="session")
def kit():
    """Return flights, samples and updates."""
    return Kit(
        PERIOD,
        FLIGHTS,
        flight,
        samples,
        begin,
        checked_update(find_estimator("ekf")),
        checked_update(find_estimator("complementary")),
    )

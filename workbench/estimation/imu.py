"""The IMU of the flight computer: truth, bias, noise and faults of each sample.

It has its own random numbers, so equal seeds give equal samples in all diagrams and compiled code.
"""

import math
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Numbers, Vector3
from workbench.dynamics.air.normals import drawn_normals, normal_rows
from workbench.dynamics.rigid_body import into_body, into_world, rotation
from workbench.plant.faults import FAULT_NOISE_FACTOR, Fault
from workbench.plant.gravity import GRAVITY
from workbench.plant.sensors import Imu

ImuVector = tuple[float, float, float, float, float, float]
"""Angular velocity [rad/s], then specific force [m/s²]."""

IMU_NOISE_SOURCE = "imu of the estimator"
"""Name of the source of its noise."""
BIAS_DRAW_NUMBER = 1 << 40
"""Number of the draw of biases, larger than those of samples."""


class ImuNoise(NamedTuple):
    """Noise of gyro and accelerometer along the axes of the sensor.

    Attributes:
        deviation: of a sample a physics step (6).
        kept: share of the drift that remains from one reading to the next (6).
        driven: deviation added to the drift between readings (6).
        mean: of the bias (6).
        spread: deviation of the bias, which is drawn once (6).
    """

    deviation: tuple[float, ...]
    kept: tuple[float, ...]
    driven: tuple[float, ...]
    mean: tuple[float, ...]
    spread: tuple[float, ...]


def imu_noise(sensor: Imu, step: float, period: float) -> ImuNoise:
    """Return the noise of a described IMU, with the densities at its own rate.

    Args:
        sensor: the description's record.
        step: of physics [s].
        period: between readings, at which the biases drift [s].
    """
    rate = sensor.rate or sensor.usual_rate
    noises = (*sensor.angular_velocity, *sensor.linear_acceleration)
    drifts = [noise.drift(period) for noise in noises]
    return ImuNoise(
        deviation=tuple(noise.at_rate(rate, 1.0 / step).stddev for noise in noises),
        kept=tuple(kept for kept, _ in drifts),
        driven=tuple(driven for _, driven in drifts),
        mean=tuple(noise.mean + noise.bias_mean for noise in noises),
        spread=tuple(noise.bias_stddev for noise in noises),
    )


@register_jitable
def drawn_imu_bias(mean: Numbers, spread: Numbers, seed: float) -> ImuVector:
    """Return the initial biases of a flight, in the axes of the sensor (6).

    Args:
        mean: of the biases (6).
        spread: their deviations (6).
        seed: of the flight's noise.
    """
    drawn = drawn_normals(seed, BIAS_DRAW_NUMBER)
    return (
        mean[0] + spread[0] * drawn[0],
        mean[1] + spread[1] * drawn[1],
        mean[2] + spread[2] * drawn[2],
        mean[3] + spread[3] * drawn[3],
        mean[4] + spread[4] * drawn[4],
        mean[5] + spread[5] * drawn[5],
    )


@register_jitable(forceinline=True)
def ideal_imu_sample(state: Numbers, acceleration: Numbers, p_BS: Numbers) -> ImuVector:
    """Return the measurement of an ideal IMU, in the axes of B.

    Args:
        state: of the body (13).
        acceleration: wdot_WB_W [rad/s²] and vdot_WB_W [m/s²] (6).
        p_BS: position of the IMU (3) [m].
    """
    R = rotation(state[0:4])
    w_x, w_y, w_z = into_body(R, state[7:10])
    e_x, e_y, e_z = into_body(R, acceleration[0:3])
    a_x, a_y, a_z = acceleration[3:6]
    f_x, f_y, f_z = into_body(R, (a_x, a_y, a_z + GRAVITY))
    p_x, p_y, p_z = p_BS
    s_x = w_y * p_z - w_z * p_y
    s_y = w_z * p_x - w_x * p_z
    s_z = w_x * p_y - w_y * p_x
    f_x = f_x + e_y * p_z - e_z * p_y + w_y * s_z - w_z * s_y
    f_y = f_y + e_z * p_x - e_x * p_z + w_z * s_x - w_x * s_z
    f_z = f_z + e_x * p_y - e_y * p_x + w_x * s_y - w_y * s_x
    return w_x, w_y, w_z, f_x, f_y, f_z


@register_jitable(forceinline=True)
def imu_velocity_state(state: Numbers, p_BS: Numbers) -> tuple[float, ...]:
    """Return q_WB and the velocity of the IMU in W [m/s] (7) of a state of the body (13)."""
    l_x, l_y, l_z = into_world(rotation(state[0:4]), p_BS)
    w_x, w_y, w_z = state[7:10]
    return (
        state[0],
        state[1],
        state[2],
        state[3],
        state[10] + w_y * l_z - w_z * l_y,
        state[11] + w_z * l_x - w_x * l_z,
        state[12] + w_x * l_y - w_y * l_x,
    )


@register_jitable(forceinline=True)
def mean_force(before: Numbers, now: Numbers, period: float) -> Vector3:
    """Return the mean specific force between two samples, in B half-way between their attitudes.

    It is that of the change of velocity. The force at an instant would miss an impact, or take its
    peak for the mean: a landing at 0.4 m/s is over within a millisecond of 1500 m/s².

    Args:
        before: see `imu_velocity_state`.
        now: likewise.
        period: between them [s].
    """
    half = (before[0] + now[0], before[1] + now[1], before[2] + now[2], before[3] + now[3])
    rate = 1.0 / period
    return into_body(
        rotation(half),
        (
            rate * (now[4] - before[4]),
            rate * (now[5] - before[5]),
            rate * (now[6] - before[6]) + GRAVITY,
        ),
    )


@register_jitable
def mean_rate(before: Numbers, now: Numbers, period: float) -> Vector3:
    """Return the mean angular velocity between two attitudes, in B [rad/s].

    Args:
        before: q_WB (w, x, y, z), of any length but zero.
        now: likewise; less than half a turn later.
        period: between them [s].
    """
    a_w, a_x, a_y, a_z = before
    b_w, b_x, b_y, b_z = now
    # the quaternion before⁻¹ now
    w = a_w * b_w + a_x * b_x + a_y * b_y + a_z * b_z
    x = a_w * b_x - a_x * b_w - a_y * b_z + a_z * b_y
    y = a_w * b_y - a_y * b_w - a_z * b_x + a_x * b_z
    z = a_w * b_z - a_z * b_w - a_x * b_y + a_y * b_x
    size = math.sqrt(x * x + y * y + z * z)
    share = 2.0 * math.atan2(size, w) / (size * period) if size > 0.0 else 0.0
    return share * x, share * y, share * z


def imu_noise_rows(
    noise: ImuNoise,
    numbers: np.ndarray,
    every: int,
    fault: float,
    bias: Numbers,
    seed: float,
    R_BS: Sequence[Sequence[float]] | np.ndarray,
) -> np.ndarray:
    """Return bias and noise of some samples, in B (K, 6).

    Args:
        noise: of the sensor.
        numbers: of the physics steps of the samples (K).
        every: number of steps between samples.
        fault: see `plant.faults.Fault`.
        bias: biases and drift together (6).
        seed: of the flight's noise.
        R_BS: axes of the sensor in B (3, 3).
    """
    scale = (FAULT_NOISE_FACTOR if fault == Fault.NOISY else 1.0) / math.sqrt(every)
    deviation = scale * np.array(noise.deviation)
    rows: np.ndarray = np.asarray(bias) + deviation * normal_rows(seed, 2 * numbers)
    in_body: np.ndarray = rows.reshape(-1, 2, 3) @ np.array(R_BS).T
    return in_body.reshape(-1, 6)


def next_drift(noise: ImuNoise, drift: Numbers, number: int, seed: float) -> np.ndarray:
    """Return the drift of the biases (6) at the reading after one with a number."""
    kept: np.ndarray = np.array(noise.kept) * drift
    if not any(noise.driven):
        return kept  # without a draw, which takes a fiftieth of a flight's time
    (drawn,) = normal_rows(seed, np.array([2 * number + 1]))
    return kept + np.array(noise.driven) * drawn

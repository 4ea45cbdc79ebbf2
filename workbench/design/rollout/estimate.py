"""The state from an estimator, and its IMU, GPS, barometer, magnetometer and range finder.

They are those of the diagram: `systems.flight_imu`, `systems.sensors` and `systems.navigation`.
"""

import math
from collections.abc import Callable
from typing import Any

import numpy as np

from workbench.common.jitable import give_unique_name, register_jitable
from workbench.common.vectors import Numbers
from workbench.design.rollout.fields import get_field, set_field
from workbench.design.rollout.lane_times import PeriodClock, is_multiple, next_multiple
from workbench.design.rollout.period import StateSource
from workbench.design.rollout.record import FILTER_COEFFICIENTS, IMU_MOTION_SIZE
from workbench.design.rollout.sensor_set import (
    MAX_NOISE_CHANNELS,
    NOISE_CHANNELS,
    EstimatorInputs,
    SensorSet,
)
from workbench.dynamics.air.normals import NORMALS_PER_SAMPLE, counted_draws, draw_normals
from workbench.dynamics.motion_between import (
    body_rate,
    mean_specific_force,
    motion_between,
    point_motion,
)
from workbench.dynamics.rigid_body import into_body, into_world, rotation
from workbench.estimation.ekf import motion_estimate as estimated_motion
from workbench.estimation.ekf_state import NOMINAL
from workbench.estimation.estimators import Estimator
from workbench.estimation.filters import section_output, section_states
from workbench.estimation.gyro import (
    filtered_rates,
    state_body_rates,
    steady_gyro_states,
    stepped_filters,
)
from workbench.estimation.imu import ideal_imu_sample, mean_rate
from workbench.estimation.samples import (
    AGES,
    BAROMETER,
    GPS,
    MAGNETOMETER,
    RANGE_FINDER,
    SAMPLE_ARRAY_SIZE,
)
from workbench.estimation.settings import AIDING_SENSORS
from workbench.plant.gravity import GRAVITY
from workbench.systems.sensors.barometer import altitude_at, pressure_at

AIDING_SENSOR_COUNT = len(NOISE_CHANNELS)
GPS_KIND = AIDING_SENSORS.index("gps")
BAROMETER_KIND = AIDING_SENSORS.index("barometer")
MAGNETOMETER_KIND = AIDING_SENSORS.index("magnetometer")
"""Kinds of sensors, in the order of `AIDING_SENSORS`."""


def estimate_fields(senses: SensorSet) -> dict[str, Any]:
    """Return the fields that a flight's record has for sensors and estimator.

    estimate        (13) motion that the estimator tells
    estimator       memory of the estimator; settings are its live numbers
    seeds           (5) of the noise of IMU and other sensors
    bias, drift     (6) of the IMU
    accel_filter    (9) low-pass of the accelerometer; accel_states its states (6)
    readings        (kinds, depth, 1 + numbers) samples that wait, newest first: stamp [s] and
                    values
    biases, drifts  (kinds, numbers) of the noise
    delivered       (kinds) stamps of the samples that the estimator had last [s]
    """
    return {
        "estimate": (13,),
        "estimator": (senses.memory_size,),
        "settings": (len(senses.settings),),
        "seeds": (1 + AIDING_SENSOR_COUNT,),
        "bias": (6,),
        "drift": (6,),
        "accel_filter": (FILTER_COEFFICIENTS,),
        "accel_filters": (),
        "accel_states": (6,),
        "readings": (AIDING_SENSOR_COUNT, senses.inputs.depth, 1 + MAX_NOISE_CHANNELS),
        "biases": (AIDING_SENSOR_COUNT, MAX_NOISE_CHANNELS),
        "drifts": (AIDING_SENSOR_COUNT, MAX_NOISE_CHANNELS),
        "delivered": (AIDING_SENSOR_COUNT,),
    }


@register_jitable
def _read_imu(
    flight: np.record, clock: PeriodClock, sensors: EstimatorInputs, z: np.ndarray
) -> None:
    """Simulate the IMU since the last control update, as `systems.flight_imu` does.

    Mean angular velocity [rad/s] and mean specific force [m/s²], in B with noise, go to the first
    six places of z. The record gets the filtered `rates`, the states of the filters, the `motion`
    of now and the next `drift`. At the first update there is one sample.
    """
    state, p_BS, step = get_field(flight, "state"), sensors.p_BS, clock.step
    steps, number = round(clock.period / step), int(flight.count)
    steps_per_sample = int(flight.gyro_every)
    now, before, end, middle = np.empty((4, IMU_MOTION_SIZE))
    motion = point_motion(state, p_BS)
    for k in range(IMU_MOTION_SIZE):
        now[k] = motion[k]
        before[k] = flight.motion[k]
    has_previous, samples, parts = flight.sampled > 0.0, 1, 1
    w_B = state_body_rates(state)
    force = ideal_imu_sample(state, get_field(flight, "acceleration"), p_BS)[3:6]
    mean_rates = w_B
    if has_previous:
        samples = steps // steps_per_sample
        filtered = flight.gyro_filters > 0.0 or flight.accel_filters > 0.0
        parts = samples if filtered else 2 - samples % 2  # without filters two do
        mean_rates = mean_rate(before[0:4], now[0:4], clock.period)
    share, samples_per_part = 1.0 / parts, samples // parts
    coefficients, states = get_field(flight, "gyro_filter"), get_field(flight, "gyro_states")
    rates, noise, drawn = w_B, np.zeros(6), np.empty(NORMALS_PER_SAMPLE)
    mean_force, gyro_noise = np.zeros(3), np.zeros(3)
    for part in range(parts):
        if has_previous:
            motion_between(flight.motion, now, clock.period, share * (part + 1.0), end)
            motion_between(flight.motion, now, clock.period, share * (part + 0.5), middle)
            w_B = body_rate(end)
            force = mean_specific_force(before, middle, end, share * clock.period, GRAVITY)
            for k in range(IMU_MOTION_SIZE):
                before[k] = end[k]
        # of a part the gyro has the noise of the last sample, the force the mean of all
        noise[3:6] = 0.0
        for k in range(samples_per_part):
            passed = (part * samples_per_part + k + 1) * steps_per_sample
            offset = passed - steps if has_previous else 0
            _draw_noise(flight, sensors, number * steps + offset, steps_per_sample, drawn)
            for axis in range(3):
                noise[axis] = drawn[axis]
                noise[3 + axis] += drawn[3 + axis] / samples_per_part
                gyro_noise[axis] += drawn[axis] / samples
        w_B = (w_B[0] + noise[0], w_B[1] + noise[1], w_B[2] + noise[2])
        force = (force[0] + noise[3], force[1] + noise[4], force[2] + noise[5])
        if not has_previous:
            states = steady_gyro_states(w_B)
            set_field(flight, "accel_states", (0.0, force[0], 0.0, force[1], 0.0, force[2]))
        rates = filtered_rates(coefficients, states, w_B)
        states = stepped_filters(coefficients, states, w_B)
        section, smooth = flight.accel_filter, flight.accel_states
        for axis in range(3):
            x_1, x_2 = smooth[2 * axis], smooth[2 * axis + 1]
            mean_force[axis] += share * section_output(section, x_1, x_2, force[axis])
            smooth[2 * axis], smooth[2 * axis + 1] = section_states(section, x_1, x_2, force[axis])
    set_field(flight, "rates", rates)
    set_field(flight, "gyro_states", states)
    set_field(flight, "motion", motion)
    flight.sampled = 1.0
    for axis in range(3):
        z[axis] = mean_rates[axis] + gyro_noise[axis]
        z[3 + axis] = mean_force[axis]
    draw_normals(flight.seeds[0], 2 * number * steps + 1, drawn)
    kept, driven = sensors.imu_noise.kept, sensors.imu_noise.driven
    for k in range(6):
        flight.drift[k] = kept[k] * flight.drift[k] + driven[k] * drawn[k]


@register_jitable
def _draw_noise(
    flight: np.record, sensors: EstimatorInputs, number: int, every: int, drawn: np.ndarray
) -> None:
    """Write bias and noise of the IMU's sample at a step of physics, in B (6).

    Noise has the even numbers of draws, drift the odd ones.
    """
    draw_normals(flight.seeds[0], 2 * number, drawn)
    deviation, scale = sensors.imu_noise.deviation, 1.0 / math.sqrt(every)
    for k in range(6):
        drawn[k] = flight.bias[k] + flight.drift[k] + scale * deviation[k] * drawn[k]
    for first in (0, 3):
        noise = (drawn[first], drawn[first + 1], drawn[first + 2])
        drawn[first], drawn[first + 1], drawn[first + 2] = into_world(sensors.R_BS, noise)


@register_jitable
def _deliver_samples(
    flight: np.record, sensors: EstimatorInputs, now: float, z: np.ndarray
) -> None:
    """Write what other sensors newly deliver, see `estimation.samples`."""
    for kind in range(AIDING_SENSOR_COUNT):
        readings, taken = flight.readings[kind], -1
        for age in range(len(readings)):
            if readings[age, 0] + sensors.latencies[kind] <= now:  # the stamp of none is NaN
                taken = age
                break
        if taken < 0 or readings[taken, 0] == flight.delivered[kind]:
            continue
        stamp, values = readings[taken, 0], readings[taken, 1:]
        flight.delivered[kind] = stamp
        if kind == GPS_KIND:
            z[GPS], z[GPS + 1] = 1.0, now - stamp
            z[GPS + 2 : GPS + 8] = values[:6]
        elif kind == BAROMETER_KIND:
            z[BAROMETER], z[BAROMETER + 1] = 1.0, altitude_at(values[0]) - sensors.reference
            z[AGES] = now - stamp
        elif kind == MAGNETOMETER_KIND:
            field = into_world(sensors.R_BM, (values[0], values[1], values[2]))
            z[MAGNETOMETER], z[AGES + 1] = 1.0, now - stamp
            for k in range(3):
                z[MAGNETOMETER + 1 + k] = field[k]
        elif math.isfinite(values[0]):
            z[RANGE_FINDER], z[AGES + 2] = 1.0, now - stamp
            z[RANGE_FINDER + 1] = min(max(values[0], sensors.nearest), sensors.farthest)


@register_jitable
def _due(sensors: EstimatorInputs, now: float) -> float:
    """Return when a sensor next takes a sample [s]."""
    found = math.inf
    for kind in range(AIDING_SENSOR_COUNT):
        if sensors.periods[kind] > 0.0:
            found = min(found, next_multiple(now, sensors.periods[kind]))
    return found


@register_jitable
def _sample(flight: np.record, sensors: EstimatorInputs, now: float) -> None:
    """Take the samples that are due."""
    for kind in range(AIDING_SENSOR_COUNT):
        period = sensors.periods[kind]
        if period > 0.0 and is_multiple(now, period):
            _take_sample(flight, sensors, kind, now, round(now / period))


@register_jitable
def _take_sample(
    flight: np.record, sensors: EstimatorInputs, kind: int, now: float, count: int
) -> None:
    """Take a sample of a sensor, by its count."""
    n, noise, readings = NOISE_CHANNELS[kind], sensors.noise[kind], flight.readings[kind]
    for age in range(len(readings) - 1, 0, -1):
        readings[age] = readings[age - 1]
    values, drawn = readings[0, 1:], np.empty(3 * n)
    readings[0, 0] = now
    _measure(get_field(flight, "state"), sensors, kind, values)
    counted_draws(flight.seeds[1 + kind], count, drawn)
    bias, drift = flight.biases[kind], flight.drifts[kind]
    for k in range(n):
        mean, deviation, bias_mean, bias_deviation, kept, driven, precision = noise[k]
        if count == 0:
            bias[k] = bias_mean + bias_deviation * drawn[2 * n + k]
        values[k] += mean + (bias[k] + drift[k]) + deviation * drawn[k]
        if precision > 0.0:
            values[k] = precision * np.rint(values[k] / precision)
        drift[k] = kept * drift[k] + driven * drawn[n + k]


@register_jitable
def _measure(state: Numbers, sensors: EstimatorInputs, kind: int, values: np.ndarray) -> None:
    """Write what a perfect sensor measures."""
    R_WB, place = rotation(state[0:4]), sensors.mounting
    if kind == GPS_KIND:
        fix = point_motion(state, place[3:6])
        for k in range(3):
            values[k], values[3 + k] = fix[4 + k], fix[11 + k]
    elif kind == BAROMETER_KIND:
        values[0] = pressure_at(sensors.reference + state[6] + into_world(R_WB, place[6:9])[2])
    elif kind == MAGNETOMETER_KIND:
        field = into_body(sensors.R_BM, into_body(R_WB, place[15:18]))
        for k in range(3):
            values[k] = field[k]
    else:
        height = state[6] + into_world(R_WB, place[9:12])[2]
        down = -into_world(R_WB, place[12:15])[2]
        distance = height / down if down > 0.0 else math.inf
        distance = distance if distance <= sensors.farthest else math.inf
        values[0] = distance if distance >= sensors.nearest else -math.inf


@register_jitable
def _held_estimate(
    flight: np.record, clock: PeriodClock, sensors: EstimatorInputs | None, passed: float
) -> tuple[float, ...]:
    """Return the estimate, which holds between updates (13)."""
    return get_field(flight, "estimate")


@register_jitable
def _mode_estimate(flight: np.record) -> tuple[float, ...]:
    """Return the estimate, by which the flight mode goes, too (13)."""
    return get_field(flight, "estimate")


def estimator_source(estimator: Estimator) -> StateSource:
    """Return the functions by which a law gets its state from an estimator."""
    update: Callable[..., None] = estimator.update

    @register_jitable
    def sense(flight: np.record, clock: PeriodClock, sensors: EstimatorInputs) -> None:
        """Update the estimate, and write it for the law."""
        z, places = np.zeros(SAMPLE_ARRAY_SIZE), np.array(sensors.mounting)
        _read_imu(flight, clock, sensors, z)
        _deliver_samples(flight, sensors, flight.count * clock.period, z)
        dt = clock.period if flight.count > 0.0 else 0.0
        memory, settings = flight.estimator.copy(), flight.settings.copy()
        update(memory, z, settings, places, dt)
        flight.estimator[:] = memory
        found = estimated_motion(memory[:NOMINAL], flight.rates, sensors.mounting[0:3])
        w_W = into_world(rotation(found[0:4]), found[7:10])  # it is in B
        known = found[0:7] + w_W + found[10:13]
        set_field(flight, "estimate", known)  # the law may get an older one, see `DelayRings`
        set_field(flight, "known", known)

    return StateSource(
        give_unique_name(sense, estimator.key),
        _held_estimate,
        _mode_estimate,
        _due,
        _sample,
        estimator.key,
    )

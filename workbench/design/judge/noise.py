"""Effect of each sensor's noise on attitude and rotor commands, from the linear model."""

import math
from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.design.linear.model import MEASURED_SIGNALS, LinearModel
from workbench.design.linear.operating_point import HOLDING_POINT, OperatingPoint
from workbench.design.linear.study import LinearStudy
from workbench.diagram.mounting import find_imu
from workbench.estimation.imu import imu_noise
from workbench.plant.magnetic_field import earth_magnetic_field
from workbench.plant.sensors import Barometer, Gps, Magnetometer, Noise, RangeFinder, Sensor
from workbench.systems.sensors.barometer import pressure_at

NOISE_DOUBLINGS = 14
"""RMS values are those after 2^14 control periods: 128 s at 128 Hz. An unobserved heading drifts,
and has no steady value."""
ATTITUDE_OUTPUTS = ("roll", "pitch", "yaw")


@dataclass(frozen=True)
class NoiseEffect:
    """The effect of the noise of one sensor, or of all.

    Attributes:
        sensor: its kind, `gyro` and `accelerometer` of the IMU, or `all`.
        attitude: RMS of roll, pitch and yaw (3) [rad].
        command: RMS of the commands of rotors (n) over their speeds in hover.
    """

    sensor: str
    attitude: tuple[float, float, float]
    command: tuple[float, ...]

    @property
    def worst_command(self) -> float:
        """RMS of the command of the rotor with the largest one."""
        return max(self.command)


def noise_effects(
    study: LinearStudy,
    point: OperatingPoint = HOLDING_POINT,
    gains: Mapping[str, float] | None = None,
) -> tuple[NoiseEffect, ...]:
    """Return the effect of the described noise of each sensor, and of all together.

    A flight on the true motion has no noise. The effect then is that of gyro noise added to the
    true angular velocity.

    Args:
        study: of the vehicle and its estimator.
        point: the operating point.
        gains: parameter values by name that differ from the scenario's.

    Raises:
        WorkbenchError: if the vehicle has no IMU, or cannot fly at the point.
    """
    model = study.noisy(point, gains)
    deviations = input_deviations(study, model)
    hover = model.trim.speeds
    rows = noise_output_rows(model)
    variances = []
    groups = _groups(model)
    for names in groups.values():
        deviation = np.array([deviations[name] for name in names])
        variances.append(_variance(model, model.B(names) * deviation, rows))
    found = []
    for sensor, variance in [*zip(groups, variances, strict=True), ("all", sum(variances))]:
        rms = np.sqrt(np.asarray(variance))
        roll, pitch, yaw = rms[:3].tolist()
        found.append(NoiseEffect(sensor, (roll, pitch, yaw), tuple((rms[3:] / hover).tolist())))
    told = [each for each in found if each.sensor == "all" or max(each.attitude) > 0.0]
    return tuple(told)


def noise_response(model: LinearModel, sensor: str, frequency: np.ndarray) -> np.ndarray:
    """Return the response (F, outputs, inputs) of attitude and commands to a sensor's noise.

    Outputs are roll, pitch, yaw [rad] and the commands of rotors [rad/s]. Inputs are the axes of a
    gyro or accelerometer, constant within a period, or the quantities that the sensor measures.

    Args:
        model: from `LinearStudy.noisy`.
        sensor: a name from `noise_effects`.
        frequency: (F) [rad/s].

    Raises:
        WorkbenchError: if there is no such sensor.
    """
    groups = _groups(model)
    if sensor not in groups:
        raise WorkbenchError(f"no noise of '{sensor}' is known: take {', '.join(groups)}")
    B = model.B(groups[sensor])
    if sensor in ("gyro", "accelerometer"):
        B = B.reshape(len(B), -1, 3).sum(axis=1)
    rows = noise_output_rows(model)
    z = np.exp(1j * frequency * model.period)
    whole = np.eye(len(model.A))
    return np.array(
        [rows @ np.linalg.solve(each * whole - model.A, B.astype(complex)) for each in z]
    )


def input_deviations(study: LinearStudy, model: LinearModel) -> dict[str, float]:
    """Return the standard deviation of each input of a `LinearStudy.noisy` model, by name.

    A sensor slower than the updates of the model is treated as if it measured at every update, with
    its noise increased by the square root of the ratio of rates.
    """
    rates = study.scenario.rates
    inertial = find_imu(study.vehicle, study.scenario.sensors.noise)
    imu = imu_noise(inertial, rates.physics_step, rates.control_period)
    names = [signal.name for signal in model.inputs]
    samples = sum(name.startswith("gyro_noise_x_") for name in names)
    every = rates.control_steps / samples
    found = dict.fromkeys(names, 0.0)
    for sample in range(samples):
        for place, (kind, axis) in enumerate((k, a) for k in ("gyro", "accel") for a in "xyz"):
            found[f"{kind}_noise_{axis}_{sample + 1}"] = imu.deviation[place] / math.sqrt(every)
    if not study.scenario.is_estimated:
        return found
    for choice in reversed(study.setup.sensors):
        deviations = _measured_deviations(choice.sensor, study)
        spread = math.sqrt(max(1.0, choice.period / rates.control_period))
        found |= {f"{name}_noise": spread * value for name, value in deviations.items()}
    return found


def noise_output_rows(model: LinearModel) -> np.ndarray:
    """Return the rows (3 + n) from states to attitude and commands of rotors."""
    commands = [f"command_{rotor + 1}" for rotor in range(model.trim.speeds.size)]
    places = [model.state_names.index(name) for name in commands]
    return np.vstack([model.C(ATTITUDE_OUTPUTS), np.eye(len(model.A))[places]])


def _variance(model: LinearModel, B: np.ndarray, rows: np.ndarray) -> np.ndarray:
    """Return the variance of each output after 2^14 periods of noise, by doubling."""
    A, P = model.A, B @ B.T
    for _ in range(NOISE_DOUBLINGS):
        P = P + A @ P @ A.T
        A = A @ A
    found: np.ndarray = np.maximum(np.einsum("ij,jk,ik->i", rows, P, rows), 0.0)
    return found


def _groups(model: LinearModel) -> dict[str, list[str]]:
    """Return the inputs of each sensor's noise by its kind."""
    names = [signal.name for signal in model.inputs]
    found = {
        "gyro": [name for name in names if name.startswith("gyro_noise_")],
        "accelerometer": [name for name in names if name.startswith("accel_noise_")],
    }
    for kind in ("gps", "barometer", "magnetometer", "range_finder"):
        found[kind] = [f"{name}_noise" for name, _ in MEASURED_SIGNALS if name.startswith(kind)]
    return found


def _measured_deviations(sensor: Sensor, study: LinearStudy) -> dict[str, float]:
    """Return the standard deviations of the quantities of a sensor, by the names of
    `MEASURED_SIGNALS`.
    """
    if isinstance(sensor, Gps):
        level, up = sensor.horizontal_position.stddev, sensor.vertical_position.stddev
        slow, climb = sensor.horizontal_velocity.stddev, sensor.vertical_velocity.stddev
        names = [name for name, _ in MEASURED_SIGNALS[:6]]
        return dict(zip(names, (level, level, up, slow, slow, climb), strict=True))
    if isinstance(sensor, Barometer):
        height = study.setup.home.altitude if sensor.reference_altitude is None else 0.0
        slope = pressure_at(height + 0.5) - pressure_at(height - 0.5)
        return {"barometer_height": abs(sensor.noise.stddev / slope)}
    if isinstance(sensor, Magnetometer):
        east, north, _ = earth_magnetic_field(study.setup.home).tolist()
        noise: Noise = sensor.magnetic_field[0]
        return {"magnetometer_heading": noise.stddev / math.hypot(east, north)}
    if isinstance(sensor, RangeFinder):
        return {"range_finder_distance": sensor.noise.stddev}
    return {}

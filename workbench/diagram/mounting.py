"""Positions and references of the sensors that an estimator uses."""

import math
from collections.abc import Sequence

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.estimation.ekf import InitialDeviations
from workbench.estimation.samples import Mounting
from workbench.plant.home import Home
from workbench.plant.sensors import Imu, Noise, Sensor
from workbench.plant.vehicle import Vehicle
from workbench.scenario.sensor_choice import SensorChoice, without_noise


def find_imu(vehicle: Vehicle, noise: bool) -> Imu:
    """Return the first IMU of a vehicle that is on its base link, not on one that a joint moves.

    Args:
        vehicle: whose.
        noise: whether it has its noise.

    Raises:
        WorkbenchError: if it has none.
    """
    for sensor in vehicle.body_imus:
        found = sensor if noise else without_noise(sensor)
        assert isinstance(found, Imu)
        return found
    has_one = any(isinstance(each, Imu) for each in vehicle.sensors)
    where = " on a link that no joint moves" if has_one else ""
    raise WorkbenchError(
        f"{vehicle.name} has no IMU{where}, and no estimator does without: add one to "
        f"{vehicle.source} (docs/descriptions.md), or fly on `--estimator truth`"
    )


def deviations_at_start(imu: Imu) -> InitialDeviations:
    """Return the initial uncertainty of an estimate, with IMU biases from the description.

    The filter must not assume biases of an exact IMU, because that makes tilt and heading
    uncertain: in hover an accelerometer bias looks like a tilt, and a tilt rotates the measured
    magnetic field.
    """
    least = InitialDeviations()
    return least._replace(
        gyro_bias=math.hypot(least.gyro_bias, _bias(imu.angular_velocity)),
        accel_bias=math.hypot(least.accel_bias, _bias(imu.linear_acceleration)),
    )


def _bias(noises: Sequence[Noise]) -> float:
    """Return the largest bias of some axes, root mean square."""
    return max(math.hypot(noise.bias_mean, noise.bias_stddev) for noise in noises)


def mounting_of(imu: Imu, choices: Sequence[SensorChoice], home: Home) -> Mounting:
    """Return where the IMU and the first sensor of each kind are mounted."""
    from workbench.plant.magnetic_field import earth_magnetic_field  # with it comes pymap3d

    gps, barometer, finder = (_first(choices, k) for k in ("gps", "barometer", "range_finder"))
    nowhere = Mounting()
    return Mounting(
        p_BI=imu.p_BS,
        p_BG=gps.p_BS if gps else nowhere.p_BG,
        p_BP=barometer.p_BS if barometer else nowhere.p_BP,
        p_BR=finder.p_BS if finder else nowhere.p_BR,
        n_BR=np.array(finder.R_BS)[:, 0] if finder else nowhere.n_BR,
        m_W=earth_magnetic_field(home),
    )


def magnetometer_turn(choices: Sequence[SensorChoice]) -> np.ndarray:
    """Return the orientation R_BM (3, 3) of the first magnetometer."""
    magnetometer = _first(choices, "magnetometer")
    return np.array(magnetometer.R_BS) if magnetometer else np.eye(3)


def gps_repeats(choices: Sequence[SensorChoice]) -> bool:
    """Return whether the first GPS may give equal samples in the air without a fault.

    A drone in the air always moves a little. Only a GPS that rounds all its numbers to steps larger
    than its noise can repeat a sample.
    """
    gps = _first(choices, "gps")
    if gps is None:
        return False
    return all(noise.precision > noise.stddev for noise in gps.noises)


def _first(choices: Sequence[SensorChoice], kind: str) -> Sensor | None:
    return next((each.sensor for each in choices if each.sensor.kind == kind), None)

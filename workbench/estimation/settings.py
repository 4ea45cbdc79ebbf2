"""Names and live parameters of estimators for scenarios.

Commands import this before anything heavy is loaded.
"""

from typing import NamedTuple

from workbench.common.parameter import Parameter

TRUTH = "truth"
"""The controller gets the true motion."""
COMPLEMENTARY, EKF = "complementary", "ekf"
ESTIMATORS = (TRUTH, COMPLEMENTARY, EKF)
"""Estimators that a scenario can name, besides a user's own file."""
USER_ESTIMATOR = "estimator"
"""System of the parameters of a user's own estimator, see `Parameter`."""
AIDING_SENSORS = ("gps", "barometer", "magnetometer", "range_finder")
"""Kinds of sensors that an estimator uses, besides the IMU."""


class EkfSettings(NamedTuple):
    """Live parameters of the filter; `ESTIMATOR_PARAMETERS` has meaning, unit and range."""

    ekf_gyro_noise: float = 1.5e-4
    ekf_accel_noise: float = 2.5e-3
    ekf_gyro_bias_walk: float = 1e-5
    ekf_accel_bias_walk: float = 2e-4
    ekf_gps_position: float = 0.5
    ekf_gps_height: float = 1.0
    ekf_gps_velocity: float = 0.1
    ekf_barometer: float = 0.2
    ekf_magnetometer: float = 5e-7
    ekf_range_finder: float = 0.02
    ekf_gate: float = 5.0


class ComplementarySettings(NamedTuple):
    """Live parameters of the filter; `ESTIMATOR_PARAMETERS` has meaning, unit and range."""

    complementary_kp: float = 0.5
    complementary_ki: float = 0.02
    complementary_position_time: float = 4.0
    complementary_velocity_time: float = 1.0
    complementary_height_time: float = 2.0


_EKF_ROWS = (
    ("ekf_gyro_noise", "rad/s/Hz^0.5", 1.0, "noise density of the gyro, as the EKF assumes it"),
    ("ekf_accel_noise", "m/s^2/Hz^0.5", 10.0, "the same of the accelerometer"),
    (
        "ekf_gyro_bias_walk",
        "rad/s^2/Hz^0.5",
        1.0,
        "random walk of its bias, as the EKF assumes it",
    ),
    ("ekf_accel_bias_walk", "m/s^3/Hz^0.5", 10.0, "the same of the accelerometer's"),
    ("ekf_gps_position", "m", 100.0, "deviation of GPS east and north, as the EKF assumes it"),
    ("ekf_gps_height", "m", 100.0, "the same upwards"),
    ("ekf_gps_velocity", "m/s", 100.0, "the same of its velocity"),
    ("ekf_barometer", "m", 100.0, "deviation of the barometer's height, as the EKF assumes it"),
    ("ekf_magnetometer", "T", 1e-4, "deviation of the magnetometer, as the EKF assumes it"),
    ("ekf_range_finder", "m", 100.0, "deviation of the range finder, as the EKF assumes it"),
    ("ekf_gate", "1", 1000.0, "deviations beyond which the EKF leaves a measurement out"),
)
_COMPLEMENTARY_ROWS = (
    ("complementary_kp", "1/s", 100.0, "pull of accelerometer and magnetometer on the attitude"),
    ("complementary_ki", "1/s^2", 100.0, "their pull on the gyro's bias"),
    ("complementary_position_time", "s", 100.0, "time constant of the position by GPS"),
    ("complementary_velocity_time", "s", 100.0, "time constant of the velocity by GPS"),
    ("complementary_height_time", "s", 100.0, "time constant of the height by barometer"),
)


def _ekf(row: tuple[str, str, float, str]) -> Parameter:
    name, unit, most, help = row
    default = getattr(EkfSettings(), name)
    # an exact measurement would lead to a division by zero
    least = 0.0 if name.endswith(("_noise", "_walk")) else 1e-3 * default
    return Parameter(name, unit, help, least, most, default, EKF)


def _complementary(row: tuple[str, str, float, str]) -> Parameter:
    name, unit, most, help = row
    least = 0.01 if unit == "s" else 0.0
    default = getattr(ComplementarySettings(), name)
    return Parameter(name, unit, help, least, most, default, COMPLEMENTARY)


ESTIMATOR_PARAMETERS = (*map(_ekf, _EKF_ROWS), *map(_complementary, _COMPLEMENTARY_ROWS))
"""Rows of the parameter table, in the order of the settings."""

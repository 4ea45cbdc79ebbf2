"""Names and live parameters of estimators for scenarios.

Commands import this before anything heavy is loaded.
"""

from typing import NamedTuple

TRUTH = "truth"
"""The controller gets the true motion."""
COMPLEMENTARY, EKF = "complementary", "ekf"
ESTIMATORS = (TRUTH, COMPLEMENTARY, EKF)
"""Estimators that a scenario can name, besides a user's own file."""
OWN = "estimator"
"""System of the parameters of a user's own estimator, see `Parameter`."""
HEARD = ("gps", "barometer", "magnetometer", "range_finder")
"""Kinds of sensors that an estimator uses, besides the IMU."""


class EkfSettings(NamedTuple):
    """Live parameters of the filter; `workbench params` lists meaning, unit and range of each."""

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
    """Live parameters of the filter; `workbench params` lists meaning, unit and range of each."""

    complementary_kp: float = 0.5
    complementary_ki: float = 0.02
    complementary_position_time: float = 4.0
    complementary_velocity_time: float = 1.0
    complementary_height_time: float = 2.0

"""Parts of the Kalman filter by hand: the gate, the start, and what each measurement assumes."""

import math

import numpy as np
import pytest
from pydrake.math import RollPitchYaw, RotationMatrix

from workbench.estimation.ekf import _fuse_measurement, nominal
from workbench.estimation.ekf_state import ERRORS, MEASUREMENT_NAMES, MEASUREMENT_SETTINGS


def test_the_gate_is_of_the_innovation_with_the_uncertainty_of_the_estimate(case):
    """P = 4 and r = 1 make s = 5: what is 3 sqrt(5) away counts just so."""
    H = np.eye(ERRORS)[3]
    for share, counts in ((0.99, True), (1.01, False)):
        P, dx = 4.0 * np.eye(ERRORS), np.zeros(ERRORS)
        gap = -share * 3.0 * math.sqrt(5.0)
        with case(share):
            assert _fuse_measurement(P, dx, H, gap, 1.0, 3.0) == (gap, 5.0)
            assert dx[3] == (pytest.approx(0.8 * gap) if counts else 0.0)
            assert P[3, 3] == pytest.approx(0.8 if counts else 4.0)


def test_the_start_is_the_motion_of_the_imu():
    R = RotationMatrix(RollPitchYaw(0.3, -0.5, 2.0))
    p, w, v, p_BI = ([1.0, 2.0, 3.0], [0.4, -1.0, 2.0], [5.0, -6.0, 7.0], [0.1, -0.2, 0.3])
    x = nominal([*(2.0 * R.ToQuaternion().wxyz()), *p, *w, *v], p_BI)
    arm = R.matrix() @ p_BI
    assert x[0:4] == pytest.approx(R.ToQuaternion().wxyz())
    assert x[4:7] == pytest.approx(p + arm)
    assert x[7:10] == pytest.approx(v + np.cross(w, arm))
    assert not x[10:].any()


def test_each_measurement_has_the_deviation_of_its_own_kind():
    found = dict(zip(MEASUREMENT_NAMES, MEASUREMENT_SETTINGS, strict=True))
    level = {f"gps_{axis}": "ekf_gps_position" for axis in "xy"}
    velocity = {f"gps_v_{axis}": "ekf_gps_velocity" for axis in "xyz"}
    others = {name: f"ekf_{name}" for name in ("barometer", "magnetometer", "range_finder")}
    assert found == level | {"gps_z": "ekf_gps_height"} | velocity | others

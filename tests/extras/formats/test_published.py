"""Published descriptions, unchanged: what a person reads in the files, stated by hand."""

import math

import numpy as np
import pytest

from tests.plant.test_published import about, has_remark, load, no_ros, pytestmark
from workbench.plant.sensors import Barometer, Gps, Imu, Magnetometer, Noise

__all__ = ["no_ros", "pytestmark"]


def test_crazyflie():
    """27 g, all in the body; constants are per RPM², and rotors sit where their inertia does."""
    description, vehicle = load("gym_pybullet_drones/cf2x.urdf")
    rpm = 2.0 * math.pi / 60.0
    assert vehicle.mass == 0.027
    assert vehicle.p_BoBcm_B == pytest.approx((0.0, 0.0, 0.0))
    assert vehicle.inertia == pytest.approx(np.diag([1.4e-5, 1.4e-5, 2.17e-5]))
    places = [(0.028, -0.028, 0), (-0.028, -0.028, 0), (-0.028, 0.028, 0), (0.028, 0.028, 0)]
    for rotor, place, direction in zip(vehicle.rotors, places, (1, -1, 1, -1), strict=True):
        assert rotor.p_BR == pytest.approx(place)
        assert rotor.direction == direction
        assert rotor.motor_constant == pytest.approx(3.16e-10 / rpm**2)
        assert rotor.moment_constant == pytest.approx(7.94e-12 / 3.16e-10)
        largest = math.sqrt(2.25 * 9.8 * 0.027 / (4 * 3.16e-10))
        assert rotor.max_rot_velocity == pytest.approx(largest * rpm)
        assert (rotor.ground_effect_coefficient, rotor.propeller_radius) == (11.36859, 2.31348e-2)
        assert rotor.inflow_coefficient == 10.311e-7
    assert has_remark(description, "time constants")
    for name in ["arm", "max_speed_kmh", "drag_coeff_xy", "dw_coeff_1", "dw_coeff_2", "dw_coeff_3"]:
        assert has_remark(description, f"{name}=", "not used")


@pytest.mark.parametrize("path", ["x500", "x500/model.sdf"])
def test_x500(path):
    """A body of 2 kg; rotors of 16.08 g, 0.174 m to each side and 6 cm up; 0 front right."""
    description, vehicle = load(f"px4_gazebo_models/{path}")
    m = 0.016076923076923075
    centre = np.array([0.0, 0.0, 4 * m * 0.06 / (2 + 4 * m)])
    own = np.array([3.8464910483993325e-07, 2.6115851691700804e-05, 2.649858234714004e-05])
    inertia = np.diag([0.02166666666666667, 0.02166666666666667, 0.04000000000000001])
    inertia = inertia + about(centre, 2.0) + 4 * np.diag(own)
    places = [(0.174, -0.174, 0.06), (-0.174, 0.174, 0.06), (0.174, 0.174, 0.06)]
    places.append((-0.174, -0.174, 0.06))
    for place in places:
        inertia += about(np.array(place) - centre, m)
    assert vehicle.name == "x500"
    assert vehicle.mass == pytest.approx(2 + 4 * m, rel=1e-12)
    assert vehicle.p_BoBcm_B == pytest.approx(centre, abs=1e-12)
    assert vehicle.inertia == pytest.approx(inertia, rel=1e-9, abs=1e-15)
    for rotor, place, direction in zip(vehicle.rotors, places, (1, 1, -1, -1), strict=True):
        assert rotor.p_BR == pytest.approx(place)
        assert rotor.axis_B == pytest.approx((0.0, 0.0, 1.0))
        assert rotor.direction == direction
        assert rotor.motor_constant == 8.54858e-06
        assert rotor.moment_constant == 0.016
        assert (rotor.time_constant_up, rotor.time_constant_down) == (0.0125, 0.025)
        assert rotor.max_rot_velocity == 1000.0
        assert rotor.inertia == pytest.approx(own[2])
    assert has_remark(description, "gz_frame_id", "x500_base")
    assert has_remark(description, "NXP-HGD-CF.dae", "not found")
    assert has_remark(description, "magnetometer_sensor", "gauss")


def test_x500_sensors():
    _, vehicle = load("px4_gazebo_models/x500")
    barometer, magnetometer, imu, gps = vehicle.sensors
    assert isinstance(barometer, Barometer)
    assert (barometer.name, barometer.rate) == ("air_pressure_sensor", 50.0)
    assert barometer.noise == Noise(stddev=3.0)
    assert isinstance(magnetometer, Magnetometer)
    assert (magnetometer.name, magnetometer.rate) == ("magnetometer_sensor", 100.0)
    assert magnetometer.magnetic_field == (Noise(stddev=pytest.approx(1e-8)),) * 3
    assert isinstance(imu, Imu)
    assert (imu.name, imu.type, imu.frame, imu.rate) == ("imu_sensor", "imu", "base_link", 250.0)
    assert [noise.stddev for noise in imu.angular_velocity] == [0.0008726646] * 3
    assert [noise.stddev for noise in imu.linear_acceleration] == [0.00637, 0.00637, 0.00686]
    assert isinstance(gps, Gps)
    assert (gps.name, gps.type, gps.frame, gps.rate) == ("navsat_sensor", "navsat", "base_link", 30)

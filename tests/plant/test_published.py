"""Published descriptions, unchanged: what a person reads in the files, stated by hand.

They lie beside the repository, in ../shared/models, and are not part of it.
"""

import math
from pathlib import Path

import numpy as np
import pytest

from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.sensors import Barometer, Gps, Imu, Magnetometer, Noise

MODELS = Path(__file__).resolve().parents[2].parent / "shared" / "models"
pytestmark = pytest.mark.skipif(
    not MODELS.is_dir(), reason=f"put published descriptions into {MODELS} to try them"
)
BASE_ARGS = {
    "enable_mavlink_interface": "false",
    "enable_ground_truth": "true",
    "enable_logging": "true",
    "log_file": "log",
    "wait_to_record_bag": "true",
}


@pytest.fixture(autouse=True)
def no_ros(monkeypatch):
    """Nothing may be found through the environment."""
    for name in ("ROS_PACKAGE_PATH", "AMENT_PREFIX_PATH", "GZ_SIM_RESOURCE_PATH"):
        monkeypatch.delenv(name, raising=False)


def load(path: str, args=None):
    description = read_description(MODELS / path, args)
    return description, make_vehicle(description)


def hummingbird(file: str = "hummingbird.xacro", **args: str):
    return load(f"rotors_description/urdf/{file}", {"namespace": "bird", **args})


def about(offset, mass) -> np.ndarray:
    """Return the inertia of a point mass about the origin."""
    r = np.array(offset)
    return mass * (r @ r * np.eye(3) - np.outer(r, r))


def said(description, *words: str) -> bool:
    return any(all(word in str(remark) for word in words) for remark in description.remarks)


def test_hummingbird_body():
    """0.68 kg and four rotors of 9 g at (±0.17, ±0.17) on the axes, 1 cm up.

    A rotor's inertia is that of a box 0.1 x 0.015 x 0.003 of ten times its mass.
    """
    _, vehicle = hummingbird()
    centre = np.array([0.0, 0.0, 4 * 0.009 * 0.01 / 0.716])
    box = 0.0833333 * 0.09 * np.array([0.015**2 + 0.003**2, 0.1**2 + 0.003**2, 0.1**2 + 0.015**2])
    inertia = np.diag([0.007, 0.007, 0.012]) + about(centre, 0.68) + 4 * np.diag(box)
    for place in ([0.17, 0, 0.01], [0, 0.17, 0.01], [-0.17, 0, 0.01], [0, -0.17, 0.01]):
        inertia += about(np.array(place) - centre, 0.009)
    assert vehicle.base_link == "bird/base_link"
    assert vehicle.mass == pytest.approx(0.716, rel=1e-9)
    assert vehicle.p_BoBcm_B == pytest.approx(centre, abs=1e-12)
    assert vehicle.inertia == pytest.approx(inertia, rel=1e-9, abs=1e-15)


@pytest.mark.parametrize("file", ["hummingbird.xacro", "hummingbird_base.xacro"])
def test_hummingbird_rotors(file):
    """Front, left, back, right; front and back turn clockwise."""
    _, vehicle = hummingbird(file, **(BASE_ARGS if "base" in file else {}))
    places = [(0.17, 0, 0.01), (0, 0.17, 0.01), (-0.17, 0, 0.01), (0, -0.17, 0.01)]
    for number, (rotor, place) in enumerate(zip(vehicle.rotors, places, strict=True)):
        assert rotor.joint == f"bird/rotor_{number}_joint"
        assert rotor.p_BR == pytest.approx(place, abs=1e-12)
        assert rotor.axis_B == pytest.approx((0.0, 0.0, 1.0), abs=1e-12)
        assert rotor.direction == (1 if number % 2 else -1)
        assert rotor.motor_constant == 8.54858e-06
        assert rotor.moment_constant == 0.016
        assert (rotor.time_constant_up, rotor.time_constant_down) == (0.0125, 0.025)
        assert rotor.max_rot_velocity == 838.0
        # a tenth of the box: the macro multiplies the mass by rotor_velocity_slowdown_sim
        assert rotor.inertia == pytest.approx(0.0833333 * 0.009 * (0.1**2 + 0.015**2))


def test_hummingbird_says_what_is_missing():
    description, _ = hummingbird()
    assert said(description, "base_link_inertia", "hummingbird.dae", "not found")
    assert said(description, "plugin 'multirotor_base_plugin'")


def test_hummingbird_with_sensors_weighs_more_and_holds_their_joints():
    """An IMU of 15 g, and two ground-truth sensors of 10 mg."""
    description, vehicle = hummingbird("hummingbird_base.xacro", **BASE_ARGS)
    assert vehicle.mass == pytest.approx(0.716 + 0.015 + 2e-5, rel=1e-9)
    assert said(description, "joint 'bird/imu_joint'", "held at zero")


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
    assert said(description, "time constants")
    for name in ["arm", "max_speed_kmh", "drag_coeff_xy", "dw_coeff_1", "dw_coeff_2", "dw_coeff_3"]:
        assert said(description, f"{name}=", "not used")


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
    assert said(description, "gz_frame_id", "x500_base")
    assert said(description, "NXP-HGD-CF.dae", "not found")
    assert said(description, "magnetometer_sensor", "gauss")


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

"""What the shipped drone carries; the figures are those of models/README.md."""

import numpy as np
import pytest

from workbench.common.resources import find_model
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.sensors import Barometer, Magnetometer, Noise, RangeFinder


def drone(**args):
    return make_vehicle(read_description(find_model("dh_drone"), args))


@pytest.fixture(scope="module")
def full():
    return drone()


def test_it_carries_one_sensor_of_each_kind(full):
    kinds = sorted(sensor.kind for sensor in full.sensors)
    assert kinds == [
        *("barometer", "depth_camera", "gps", "imu", "lidar", "magnetometer", "range_finder")
    ]


def test_the_barometer_is_in_the_shell(full):
    (barometer,) = (sensor for sensor in full.sensors if isinstance(sensor, Barometer))
    assert (barometer.name, barometer.frame, barometer.rate) == ("barometer", "barometer_link", 50)
    assert np.abs(barometer.p_BS).max() < 0.07
    assert barometer.noise == Noise(stddev=2.0)
    assert barometer.reference_altitude is None


def test_the_magnetometer_is_in_the_shell_and_weighs_nothing(full):
    (found,) = (sensor for sensor in full.sensors if isinstance(sensor, Magnetometer))
    assert (found.name, found.frame, found.link) == ("magnetometer", "magnetometer", "base_link")
    assert (found.rate, found.magnetic_field) == (50.0, (Noise(stddev=0.5e-6),) * 3)
    assert np.abs(found.p_BS).max() < 0.07
    without = drone(magnetometer="false")
    assert without.sensors == full.sensors[:-1]
    assert (without.mass, without.p_BoBcm_B) == (full.mass, full.p_BoBcm_B)
    assert np.array_equal(without.inertia, full.inertia)


def test_the_range_finder_looks_down_and_sees_the_ground_it_stands_on(full):
    (finder,) = (sensor for sensor in full.sensors if isinstance(sensor, RangeFinder))
    assert (finder.name, finder.frame) == ("range_finder", "range_finder_link")
    assert np.array(finder.R_BS)[:, 0] == pytest.approx([0.0, 0.0, -1.0], abs=1e-12)
    assert np.array(finder.R_BS)[:, 1] == pytest.approx([0.0, 1.0, 0.0], abs=1e-12)
    assert finder.min_range < full.ground_clearance + finder.p_BS[2] < finder.max_range
    assert (finder.rate, finder.noise) == (50.0, Noise(stddev=0.01))


@pytest.mark.parametrize(
    "without", [{"barometer"}, {"range_finder"}, {"barometer", "range_finder"}]
)
def test_the_body_is_the_same_without_barometer_and_range_finder(full, without):
    light = drone(**dict.fromkeys(without, "false"))
    assert {sensor.name for sensor in full.sensors} - {s.name for s in light.sensors} == without
    assert full.mass == pytest.approx(1.90, abs=1e-12)
    assert light.mass == pytest.approx(full.mass, abs=1e-12)
    assert light.p_BoBcm_B == pytest.approx(full.p_BoBcm_B, abs=1e-12)
    assert light.inertia == pytest.approx(full.inertia, abs=1e-12)
    assert light.ground_clearance == pytest.approx(full.ground_clearance, abs=1e-12)


@pytest.mark.parametrize("name", ["lidar", "gps", "camera", "imu"])
def test_the_other_sensors_take_their_mass_with_them(full, name):
    assert drone(**{name: "false"}).mass < full.mass - 0.01

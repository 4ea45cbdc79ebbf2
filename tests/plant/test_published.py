"""Published descriptions, unchanged: what a person reads in the files, stated by hand.

They lie beside the repository, in ../shared/models, and are not part of it.
"""

from pathlib import Path

import numpy as np
import pytest

from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle

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


def has_remark(description, *words: str) -> bool:
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
    assert has_remark(description, "base_link_inertia", "hummingbird.dae", "not found")
    assert has_remark(description, "plugin 'multirotor_base_plugin'")


def test_hummingbird_with_sensors_weighs_more_and_holds_their_joints():
    """An IMU of 15 g, and two ground-truth sensors of 10 mg."""
    description, vehicle = hummingbird("hummingbird_base.xacro", **BASE_ARGS)
    assert vehicle.mass == pytest.approx(0.716 + 0.015 + 2e-5, rel=1e-9)
    assert has_remark(description, "joint 'bird/imu_joint'", "held at zero")

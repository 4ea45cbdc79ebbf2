"""Oracle: mass, centre and inertia summed by hand from the links of the expanded URDF."""

import xml.etree.ElementTree as ET

import numpy as np
import pytest
import xacro
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model
from workbench.plant.loading import load_vehicle

PROPELLERS = [f"propeller{i}_link" for i in range(1, 5)]
SENSORS = ["lidar_link", "GPS_link", "camera_link", "IMU_link"]
OURS = ["range_finder_link", "barometer_link"]


def numbers(element, attribute) -> np.ndarray:
    text = None if element is None else element.get(attribute)
    return np.array([float(word) for word in (text or "0 0 0").split()])


def place(element):
    """Return rotation matrix and position of an <origin>."""
    origin = element.find("origin")
    return RollPitchYaw(numbers(origin, "rpy")).ToRotationMatrix().matrix(), numbers(origin, "xyz")


def link_places(robot) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """Return each link's rotation and position in the base link."""
    places = {"base_link": (np.eye(3), np.zeros(3))}
    joints = list(robot.iter("joint"))
    while joints:
        joint = joints.pop(0)
        parent, child = joint.find("parent").get("link"), joint.find("child").get("link")
        if parent in places:
            R, p = place(joint)
            R_parent, p_parent = places[parent]
            places[child] = (R_parent @ R, p_parent + R_parent @ p)
        else:
            joints.append(joint)
    return places


def summed_by_hand(urdf: str) -> tuple[float, np.ndarray, np.ndarray]:
    """Return mass, centre of mass, and inertia about it, by the parallel-axis theorem."""
    robot = ET.fromstring(urdf)
    parts = []
    places = link_places(robot)
    for link in robot.findall("link"):
        inertial = link.find("inertial")
        R, p = places[link.get("name")]
        R_own, p_own = place(inertial)
        tensor = inertial.find("inertia")
        xx, xy, xz, yy, yz, zz = (
            float(tensor.get(name)) for name in ("ixx", "ixy", "ixz", "iyy", "iyz", "izz")
        )
        own = np.array([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
        turned = (R @ R_own) @ own @ (R @ R_own).T
        parts.append((float(inertial.find("mass").get("value")), p + R @ p_own, turned))
    mass = sum(m for m, _, _ in parts)
    centre = sum(m * p for m, p, _ in parts) / mass
    inertia = np.zeros((3, 3))
    for m, p, own in parts:
        arm = p - centre
        inertia += own + m * (arm @ arm * np.eye(3) - np.outer(arm, arm))
    return mass, centre, inertia


def test_mass_is_that_of_the_paper(dh_vehicle):
    assert dh_vehicle.mass == pytest.approx(1.90, abs=0.02)


@pytest.mark.parametrize("args", [{}, {"mass": "2.6", "arm_length": "0.3", "camera": "false"}])
def test_mass_centre_and_inertia_are_the_sum_of_the_links(args):
    path = find_model("dh_drone")
    vehicle = load_vehicle(path, args)
    urdf = xacro.process_file(str(path), mappings=args).toxml()
    mass, centre, inertia = summed_by_hand(urdf)
    assert vehicle.mass == pytest.approx(mass, rel=1e-12)
    assert vehicle.p_BoBcm_B == pytest.approx(centre, abs=1e-12)
    assert vehicle.inertia == pytest.approx(inertia, abs=1e-12)


def test_inertia_is_one_that_a_body_can_have(dh_vehicle):
    a, b, c = np.linalg.eigvalsh(dh_vehicle.inertia)
    assert a > 0.0
    assert a + b >= c


def test_inertia_is_of_the_size_of_the_drone(dh_vehicle):
    """All mass within 0.38 m of the centre, and more than the four motors at 0.25 m."""
    yaw = dh_vehicle.inertia[2, 2]
    assert 4 * 0.095 * 0.25**2 < yaw < dh_vehicle.mass * 0.38**2


def test_the_centre_of_mass_lies_over_the_middle(dh_vehicle):
    assert dh_vehicle.p_BoBcm_B[:2] == pytest.approx((0.0, 0.0), abs=1e-3)


def test_links_have_the_names_of_the_paper(dh_vehicle):
    names = [frame.name for frame in dh_vehicle.frames]
    assert names[0] == dh_vehicle.base_link == "base_link"
    assert set(names) == {"base_link", *PROPELLERS, *SENSORS, *OURS}


def test_rotors_stand_on_a_cross_and_turn_in_turn(dh_vehicle):
    """Numbered counter-clockwise from front left, 0.25 m from the centre, odd ones clockwise."""
    side = 0.25 / np.sqrt(2.0)
    places = [(side, side), (-side, side), (-side, -side), (side, -side)]
    for number, (rotor, place_xy) in enumerate(zip(dh_vehicle.rotors, places, strict=True), 1):
        assert rotor.joint == f"propeller{number}_joint"
        assert rotor.link == f"propeller{number}_link"
        assert rotor.p_BR[:2] == pytest.approx(place_xy)
        assert rotor.axis_B == pytest.approx((0.0, 0.0, 1.0))
        assert rotor.direction == (-1 if number % 2 else 1)
        assert dh_vehicle.frame(rotor.link).p_BF == rotor.p_BR


def test_ground_clearance_is_the_height_over_the_feet(dh_vehicle):
    """Half an arm's height 0.007, a leg of 0.115 and a foot of radius 0.014."""
    assert dh_vehicle.ground_clearance == pytest.approx(0.136, abs=1e-9)


def test_arguments_reach_the_record():
    args = {"mass": "2.5", "arm_length": "0.4", "lidar": "false"}
    vehicle = load_vehicle(find_model("dh_drone"), args)
    assert vehicle.mass == pytest.approx(2.5 - 0.16)  # the lidar and its post are left off
    assert np.hypot(*vehicle.rotors[0].p_BR[:2]) == pytest.approx(0.4)
    assert "lidar_link" not in [frame.name for frame in vehicle.frames]


def test_a_tilted_rotor_pushes_along_its_own_z(broken_quad):
    """A pitch with sine 0.1 takes z to (0.1, 0, cos)."""
    origin = '<origin xyz="0.0 0.2 0.05"'
    path = broken_quad(origin, f'{origin} rpy="0 {np.arcsin(0.1)} 0"')
    rotor = load_vehicle(path).rotors[1]
    assert rotor.axis_B == pytest.approx((0.1, 0.0, np.sqrt(0.99)))
    assert rotor.p_BR == pytest.approx((0.0, 0.2, 0.05))


def test_too_few_rotors_are_refused(broken_quad):
    path = broken_quad("motor_model.so", "other.so")
    with pytest.raises(WorkbenchError, match=f"{path}: 3 rotors"):
        load_vehicle(path)


def test_rotors_that_cannot_control_are_refused_with_the_file(quad, write):
    path = write(quad.replace(">ccw<", ">cw<"))
    with pytest.raises(WorkbenchError, match=f"{path}: .*rank 3 of 4"):
        load_vehicle(path)


def test_a_drone_without_mass_is_refused(quad, write):
    begin, end = quad.index("<inertial>"), quad.index("</inertial>") + len("</inertial>")
    path = write(quad[:begin] + quad[end:])
    with pytest.raises(WorkbenchError, match=f"{path}.*mass"):
        load_vehicle(path)


@pytest.mark.parametrize(
    "inertia",
    [
        'ixx="-0.01" iyy="0.012" izz="0.02"',  # negative
        'ixx="0" iyy="0" izz="0"',  # a point
    ],
)
def test_an_inertia_that_no_body_can_have_is_refused(broken_quad, inertia):
    path = broken_quad('ixx="0.01" iyy="0.012" izz="0.02"', inertia)
    with pytest.raises(WorkbenchError, match=f"{path}.*inertia"):
        load_vehicle(path)

"""Frames of the link as messages of ROS 2."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2._dynamic import generate_dynamic
from scipy.spatial.transform import Rotation

from workbench.gateways.ros_messages.cdr import encode
from workbench.gateways.ros_messages.conversion import conversion
from workbench.gateways.ros_messages.library import schema_text
from workbench.gateways.ros_messages.making import odometry
from workbench.link import drone_topics as numbers
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.link.topics import Direction, Field, Topic

T_NS = 3_000_000_007
HALF = math.sqrt(0.5)
SCAN = {"frame": "lidar_link", "azimuths": [0.0, math.pi / 2, 2], "elevations": [0.0, 0.0, 1]}
OUTFIT = Outfit(
    rotors=4,
    fast=204.8,
    slow=34.0,
    imu=204.8,
    gps=10.0,
    lidar=10.0,
    rays=2,
    scan=SCAN,
    frames=(("world", "base_link"), ("base_link", "imu_link")),
    magnetometer=51.2,
    estimate=True,
)
TOPICS = {topic.id: topic for topic in drone_topics(OUTFIT)}


def messages(topic: Topic, payload: bytes) -> list:
    return conversion(topic).messages(T_NS, payload)


def made(number: int, *values) -> dict:
    """Return the values of a topic's messages by the topic of ROS 2, as others decode them."""
    topic = TOPICS[number]
    found = {}
    for channel, message in messages(topic, topic.pack(values)):
        decode = generate_dynamic(channel.type, schema_text(channel.type))[channel.type]
        found[channel.topic] = decode(encode(channel.type, message))
    return found


def test_every_topic_is_converted_and_its_channels_are_known_before(case):
    for topic in TOPICS.values():
        with case(topic):
            values = [
                "x" if f.type == "char" else 1 if f.count == 1 else [1] * f.count
                for f in topic.fields
            ]
            found = conversion(topic)
            got = found.messages(T_NS, topic.pack(values))
            assert [channel for channel, _ in got] == [*found.channels]
            assert got


def test_our_own_messages_have_the_links_fields():
    got = made(numbers.VELOCITY, 1.0, 2.0, 3.0, 0.25, 0.5, 0.75)["/dh_drone/velocity_data"]
    assert (got.v_x, got.v_y, got.v_z, got.w_x, got.w_y, got.w_z) == (1, 2, 3, 0.25, 0.5, 0.75)
    assert (got.header.stamp.sec, got.header.stamp.nanosec) == (3, 7)
    assert got.header.frame_id == "world"


def test_texts_and_arrays_arrive():
    state = made(numbers.DRONE_STATE, 3, "hovering", 0.5, math.inf)["/dh_drone/drone_state"]
    assert (state.mode, state.condition, state.charge, state.clearance) == (
        3,
        "hovering",
        0.5,
        math.inf,
    )
    rotors = made(numbers.ROTORS, [1, 2, 3, 4], [5, 6, 7, 8])["/dh_drone/rotors"]
    assert (rotors.speed, rotors.thrust) == ([1, 2, 3, 4], [5, 6, 7, 8])


@pytest.mark.parametrize(
    ("angles", "expected"),  # roll, pitch, yaw; x, y, z, w
    [
        ((0, 0, 0), (0, 0, 0, 1)),
        ((math.pi / 2, 0, 0), (HALF, 0, 0, HALF)),
        ((0, math.pi / 2, 0), (0, HALF, 0, HALF)),
        ((0, 0, math.pi / 2), (0, 0, HALF, HALF)),
        ((math.pi / 2, 0, math.pi / 2), (0.5, 0.5, 0.5, 0.5)),
    ],
)
def test_a_pose_is_turned_by_roll_pitch_yaw(angles, expected):
    got = made(numbers.POSITION, 1, 2, 3, *angles, 0, 0, 0)["/dh_drone/pose"].pose
    assert (got.position.x, got.position.y, got.position.z) == (1, 2, 3)
    turn = got.orientation
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx(expected, abs=1e-7)


def test_odometry_has_its_velocities_in_the_bodys_axes():
    position = dict(zip(("x", "y", "z", "roll", "pitch"), (1, 2, 3, 0, 0), strict=True))
    velocity = {"v_x": 1.0, "v_y": 0.0, "v_z": 0.5, "w_x": 0.0, "w_y": 2.0, "w_z": 0.25}
    values = odometry(T_NS, position | {"yaw": math.pi / 2}, velocity)
    twist = values["twist"]["twist"]
    assert [*twist["linear"].values()] == pytest.approx([0, -1, 0.5], abs=1e-12)
    assert [*twist["angular"].values()] == pytest.approx([2, 0, 0.25], abs=1e-12)
    assert (values["header"]["frame_id"], values["child_frame_id"]) == ("world", "base_link")
    assert encode("nav_msgs/msg/Odometry", values)


def test_an_estimate_has_its_variances_in_the_axes_that_ros_wants():
    """Turned by 90 deg about z: the body's x is the world's y."""
    motion = (1, 2, 3, 0, 0, math.pi / 2, 1, 0, 0.5, 0, 2, 0.25)
    sigmas = (0.5, 0.25, 1, 0.125, 0.0625, 0.5, 2, 4, 1)
    got = made(numbers.ESTIMATE, *motion, *sigmas)
    odometry = got["/dh_drone/estimated_odometry"]
    covariance = np.reshape(odometry.pose.covariance, (6, 6))
    along = [0.25, 0.0625, 1.0, 0.0625**2, 0.125**2, 0.25]
    assert covariance == pytest.approx(np.diag(along), abs=1e-7)
    covariance = np.reshape(odometry.twist.covariance, (6, 6))
    assert covariance == pytest.approx(np.diag([16.0, 4.0, 1.0, 0.0, 0.0, 0.0]), abs=1e-5)
    linear = odometry.twist.twist.linear
    assert (linear.x, linear.y, linear.z) == pytest.approx((0, -1, 0.5), abs=1e-6)
    assert odometry.child_frame_id == "base_link"
    assert got["/dh_drone/estimate"].sigma_v_y == 4.0
    unknown = made(numbers.ESTIMATE, *motion, *[math.nan] * 9)["/dh_drone/estimated_odometry"]
    assert set(unknown.pose.covariance) == {0.0} == set(unknown.twist.covariance)


def test_the_variances_of_an_estimate_turn_with_the_body():
    """Sigmas of angles are about the body's axes, those of velocity along the world's."""
    angles, angular, linear = (0.3, -0.5, 1.1), (0.125, 0.0625, 0.5), (2.0, 4.0, 1.0)
    motion = (1, 2, 3, *angles, 1, 0, 0.5, 0, 2, 0.25)
    got = made(numbers.ESTIMATE, *motion, 0.5, 0.25, 1, *angular, *linear)
    odometry = got["/dh_drone/estimated_odometry"]
    R = Rotation.from_euler("ZYX", angles[::-1]).as_matrix()  # of the body in the world
    about = np.diag(R @ np.diag(np.square(angular)) @ R.T)
    along = np.diag(R.T @ np.diag(np.square(linear)) @ R)
    covariance = np.reshape(odometry.pose.covariance, (6, 6))
    assert covariance == pytest.approx(np.diag([0.25, 0.0625, 1.0, *about]), abs=1e-6)
    covariance = np.reshape(odometry.twist.covariance, (6, 6))
    assert covariance == pytest.approx(np.diag([*along, 0.0, 0.0, 0.0]), abs=1e-5)


def test_a_fix_is_in_degrees_and_its_covariance_is_unknown():
    got = made(numbers.GPS, 2_500_000_000, math.pi / 4, -math.pi / 2, 488.0, [1, 2, 3])
    fix = got["/dh_drone/gps"]
    assert (fix.latitude, fix.longitude, fix.altitude) == pytest.approx((45, -90, 488))
    assert (fix.header.stamp.sec, fix.header.stamp.nanosec) == (2, 500_000_000)
    assert (fix.status.status, fix.status.service) == (0, 1)
    assert (fix.position_covariance_type, set(fix.position_covariance)) == (0, {0.0})
    linear = got["/dh_drone/gps_velocity"].twist.linear
    assert (linear.x, linear.y, linear.z) == (1, 2, 3)


def test_an_imu_has_its_own_time_and_a_quaternion_in_the_order_of_ros():
    got = made(numbers.IMU, 1_000_000_001, [0, 0, 9.5], [1, 2, 3], [0.5, 0.25, 0, 1])
    imu = got["/dh_drone/imu"]
    assert (imu.header.stamp.sec, imu.header.stamp.nanosec) == (1, 1)
    turn = imu.orientation
    assert (turn.w, turn.x, turn.y, turn.z) == (0.5, 0.25, 0, 1)
    assert (imu.linear_acceleration.z, imu.angular_velocity.x) == (9.5, 1)
    assert set(imu.orientation_covariance) == {0.0}


def test_a_magnetic_field_is_in_tesla_and_its_covariance_is_unknown():
    got = made(numbers.MAGNETOMETER, 1_000_000_001, [1e-6, 2e-5, -4e-5])["/dh_drone/magnetometer"]
    assert (got.header.stamp.sec, got.header.stamp.nanosec) == (1, 1)
    field = got.magnetic_field
    assert (field.x, field.y, field.z) == pytest.approx((1e-6, 2e-5, -4e-5), rel=1e-7)
    assert [*got.magnetic_field_covariance] == [0.0] * 9


def test_a_sensors_frame_is_that_of_its_topic():
    topic = TOPICS[numbers.IMU]
    named = Topic(topic.id, topic.name, topic.direction, 1, topic.fields, about={"frame": "imu_x"})
    payload = topic.pack([1, [0] * 3, [0] * 3, [0] * 4])
    assert messages(named, payload)[0][1]["header"]["frame_id"] == "imu_x"
    assert messages(topic, payload)[0][1]["header"]["frame_id"] == "base_link"


def test_a_cloud_has_the_points_of_rays_that_met_something():
    got = made(numbers.LIDAR_CLOUD, 5, [math.inf, 2.0])["/dh_drone/lidar_cloud"]
    points = np.frombuffer(got.data, "<f4").reshape(-1, 3)
    assert points == pytest.approx(np.array([[0.0, 2.0, 0.0]]), abs=1e-6)
    assert (got.width, got.height, got.point_step, got.row_step) == (1, 1, 12, 12)
    assert [(field.name, field.offset, field.datatype) for field in got.fields] == [
        ("x", 0, 7),
        ("y", 4, 7),
        ("z", 8, 7),
    ]
    assert got.header.frame_id == "lidar_link"


def test_a_large_cloud_is_the_same():
    count = 1000
    scan = {"azimuths": [0.0, 0.001, count], "elevations": [0.0, 0.0, 1]}
    fields = (Field("stamp", "int64", "ns"), Field("ranges", "float32", "m", "S", count))
    topic = Topic(numbers.LIDAR_CLOUD, "/c", Direction.OUT, 10, fields, about=scan)
    found = messages(topic, topic.pack([1_000_000_002, [1.0] * count]))[0][1]
    points = np.frombuffer(found["data"], "<f4").reshape(-1, 3)
    angles = 0.001 * np.arange(count)
    assert points[:, 0] == pytest.approx(np.cos(angles), abs=1e-6)
    assert points[:, 1] == pytest.approx(np.sin(angles), abs=1e-6)
    assert found["header"]["stamp"] == {"sec": 1, "nanosec": 2}


def test_frames_become_transforms_from_parent_to_child():
    got = made(numbers.FRAMES, [1, 2, 3, HALF, 0, 0, HALF, 4, 5, 6, 1, 0, 0, 0])["/tf"]
    first, second = got.transforms
    assert (first.header.frame_id, first.child_frame_id) == ("world", "base_link")
    assert (second.header.frame_id, second.child_frame_id) == ("base_link", "imu_link")
    assert (first.transform.translation.x, second.transform.translation.z) == (1, 6)
    turn = first.transform.rotation
    assert (turn.x, turn.y, turn.z, turn.w) == pytest.approx((0, 0, HALF, HALF))


def test_a_payload_of_another_size_is_refused():
    with pytest.raises(ValueError, match="does not fit"):
        messages(TOPICS[numbers.VELOCITY], b"12345")


def test_a_topic_of_tomorrow_becomes_nothing():
    topic = Topic(999, "/dh_drone/new", Direction.OUT, 1.0, (Field("a", "int32", "1"),))
    assert messages(topic, topic.pack([1])) == []


def test_neither_drake_nor_ros_is_loaded():
    modules = "workbench.gateways.ros_messages.conversion, workbench.gateways.ros_messages.cdr"
    code = f"import sys, {modules}; print(*sys.modules)"
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    assert not loaded & {"pydrake", "PyQt6", "cyclonedds", "rclpy", "mcap"}

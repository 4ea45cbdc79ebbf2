"""Frames of the link as messages of ROS 2."""

import dataclasses
import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from mcap_ros2._dynamic import generate_dynamic
from scipy.spatial.transform import Rotation

from workbench.link import drone_topics as numbers
from workbench.link.drone_topics import drone_topics
from workbench.link.picture import PictureLayout, Pinhole
from workbench.link.ros_messages.cdr import encode
from workbench.link.ros_messages.conversion import conversion
from workbench.link.ros_messages.library import schema_text
from workbench.link.ros_messages.making import odometry
from workbench.link.ros_messages.transforms import (
    fixed_transforms_maker,
    moving_transforms_maker,
)
from workbench.link.signal import TopicOptions
from workbench.link.topics import Field, Topic, TopicDirection

T_NS = 3_000_000_007
HALF = math.sqrt(0.5)
SCAN = {"frame": "lidar_link", "azimuths": [0.0, math.pi / 2, 2], "elevations": [0.0, 0.0, 1]}
OUTFIT = TopicOptions(
    rotors=4,
    fast=204.8,
    slow=34.0,
    rates={"imu": 204.8, "gps": 10.0, "lidar": 10.0, "magnetometer": 51.2, "estimate": 204.8},
    rays=2,
    scan=SCAN,
    frames=(("world", "body"), ("body", "imu_link"), ("body", "arm")),
    moving=("body", "arm"),
    joints=("shoulder", "elbow"),
    contacts=("body", "foot"),
    cables=("sling",),
    deviations={
        "imu": (0.1, 0.2, 0.3, 0.01, 0.02, 0.03),
        "gps": (1.5, 1.5, 3.0, 0.1, 0.1, 0.2),
        "magnetometer": (1e-7, 2e-7, 0.0),
    },
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
    got = made(numbers.VELOCITY_SIGNAL.id, 1.0, 2.0, 3.0, 0.25, 0.5, 0.75)[
        "/dh_drone/velocity_data"
    ]
    assert (got.v_x, got.v_y, got.v_z, got.w_x, got.w_y, got.w_z) == (1, 2, 3, 0.25, 0.5, 0.75)
    assert (got.header.stamp.sec, got.header.stamp.nanosec) == (3, 7)
    assert got.header.frame_id == "world"


def test_texts_and_arrays_arrive():
    state = made(numbers.DRONE_STATE_SIGNAL.id, 3, "hovering", 0.5, math.inf)[
        "/dh_drone/drone_state"
    ]
    assert (state.mode, state.condition, state.charge, state.clearance) == (
        3,
        "hovering",
        0.5,
        math.inf,
    )
    rotors = made(numbers.ROTORS_SIGNAL.id, [1, 2, 3, 4], [5, 6, 7, 8])["/dh_drone/rotors"]
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
    got = made(numbers.POSITION_SIGNAL.id, 1, 2, 3, *angles, 0, 0, 0)["/dh_drone/pose"].pose
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
    assert (values["header"]["frame_id"], values["child_frame_id"]) == ("odom", "base_link")
    assert values["pose"]["covariance"] == tuple(1e-9 * np.eye(6).ravel())  # the truth
    assert encode("nav_msgs/msg/Odometry", values)


def test_an_estimate_has_its_variances_in_the_axes_that_ros_wants():
    """Turned by 90 deg about z: the body's x is the world's y."""
    motion = (1, 2, 3, 0, 0, math.pi / 2, 1, 0, 0.5, 0, 2, 0.25)
    sigmas = (0.5, 0.25, 1, 0.125, 0.0625, 0.5, 2, 4, 1)
    got = made(numbers.ESTIMATE_SIGNAL.id, *motion, *sigmas)
    odometry = got["/dh_drone/estimated_odometry"]
    covariance = np.reshape(odometry.pose.covariance, (6, 6))
    along = [0.25, 0.0625, 1.0, 0.0625**2, 0.125**2, 0.25]
    assert covariance == pytest.approx(np.diag(along), abs=1e-7)
    covariance = np.reshape(odometry.twist.covariance, (6, 6))
    assert covariance == pytest.approx(np.diag([16.0, 4.0, 1.0, 0.0, 0.0, 0.0]), abs=1e-5)
    linear = odometry.twist.twist.linear
    assert (linear.x, linear.y, linear.z) == pytest.approx((0, -1, 0.5), abs=1e-6)
    assert odometry.child_frame_id == "body"
    assert got["/dh_drone/estimate"].sigma_v_y == 4.0
    unknown = made(numbers.ESTIMATE_SIGNAL.id, *motion, *[math.nan] * 9)[
        "/dh_drone/estimated_odometry"
    ]
    assert set(unknown.pose.covariance) == {0.0} == set(unknown.twist.covariance)


def test_the_variances_of_an_estimate_turn_with_the_body():
    """Sigmas of angles are about the body's axes, those of velocity along the world's."""
    angles, angular, linear = (0.3, -0.5, 1.1), (0.125, 0.0625, 0.5), (2.0, 4.0, 1.0)
    motion = (1, 2, 3, *angles, 1, 0, 0.5, 0, 2, 0.25)
    got = made(numbers.ESTIMATE_SIGNAL.id, *motion, 0.5, 0.25, 1, *angular, *linear)
    odometry = got["/dh_drone/estimated_odometry"]
    R = Rotation.from_euler("ZYX", angles[::-1]).as_matrix()  # of the body in the world
    about = np.diag(R @ np.diag(np.square(angular)) @ R.T)
    along = np.diag(R.T @ np.diag(np.square(linear)) @ R)
    covariance = np.reshape(odometry.pose.covariance, (6, 6))
    assert covariance == pytest.approx(np.diag([0.25, 0.0625, 1.0, *about]), abs=1e-6)
    covariance = np.reshape(odometry.twist.covariance, (6, 6))
    assert covariance == pytest.approx(np.diag([*along, 0.0, 0.0, 0.0]), abs=1e-5)


def test_a_fix_is_in_degrees_with_the_variances_of_its_noise():
    got = made(numbers.GPS_SIGNAL.id, 2_500_000_000, math.pi / 4, -math.pi / 2, 488.0, [1, 2, 3])
    fix = got["/dh_drone/gps"]
    assert (fix.latitude, fix.longitude, fix.altitude) == pytest.approx((45, -90, 488))
    assert (fix.header.stamp.sec, fix.header.stamp.nanosec) == (2, 500_000_000)
    assert (fix.status.status, fix.status.service) == (0, 1)
    assert fix.position_covariance_type == 2  # diagonal known
    assert [*fix.position_covariance] == [2.25, 0, 0, 0, 2.25, 0, 0, 0, 9.0]
    velocity = got["/dh_drone/gps_velocity"]
    linear = velocity.twist.linear
    assert (linear.x, linear.y, linear.z) == (1, 2, 3)
    # the time of the sample, which is older than the frame that delivers it
    assert (velocity.header.stamp.sec, velocity.header.stamp.nanosec) == (2, 500_000_000)


def test_an_imu_has_its_own_time_and_a_quaternion_in_the_order_of_ros():
    got = made(numbers.IMU_SIGNAL.id, 1_000_000_001, [0, 0, 9.5], [1, 2, 3], [0.5, 0.25, 0, 1])
    imu = got["/dh_drone/imu"]
    assert (imu.header.stamp.sec, imu.header.stamp.nanosec) == (1, 1)
    turn = imu.orientation
    assert (turn.w, turn.x, turn.y, turn.z) == (0.5, 0.25, 0, 1)
    assert (imu.linear_acceleration.z, imu.angular_velocity.x) == (9.5, 1)
    assert np.diag(np.reshape(imu.orientation_covariance, (3, 3))) == pytest.approx(1e-9)
    assert np.diag(np.reshape(imu.linear_acceleration_covariance, (3, 3))) == pytest.approx(
        [0.01, 0.04, 0.09]
    )
    assert np.diag(np.reshape(imu.angular_velocity_covariance, (3, 3))) == pytest.approx(
        [1e-4, 4e-4, 9e-4]
    )


def test_a_magnetic_field_is_in_tesla_with_the_variances_of_its_noise():
    got = made(numbers.MAGNETOMETER_SIGNAL.id, 1_000_000_001, [1e-6, 2e-5, -4e-5])[
        "/dh_drone/magnetometer"
    ]
    assert (got.header.stamp.sec, got.header.stamp.nanosec) == (1, 1)
    field = got.magnetic_field
    assert (field.x, field.y, field.z) == pytest.approx((1e-6, 2e-5, -4e-5), rel=1e-7)
    assert np.diag(np.reshape(got.magnetic_field_covariance, (3, 3))) == pytest.approx(
        [1e-14, 4e-14, 1e-18]  # one without noise is not unknown
    )


def test_of_an_older_server_covariances_are_unknown():
    for number, name in ((9, "orientation"), (10, "position"), (18, "magnetic_field")):
        topic = dataclasses.replace(TOPICS[number], about={})
        payload = topic.pack([1 if f.count == 1 else [1] * f.count for f in topic.fields])
        (_, message), *_ = messages(topic, payload)
        if name != "orientation":
            assert set(message[f"{name}_covariance"]) == {0.0}
        assert set(message.get("angular_velocity_covariance", (0.0,))) == {0.0}


def test_a_battery_is_in_ampere_hours_and_discharges():
    got = made(numbers.BATTERY_SIGNAL.id, 14.5, 20.0, 0.25, 18_000.0)["/dh_drone/battery_state"]
    assert (got.voltage, got.current, got.percentage) == (14.5, -20.0, 0.25)
    assert (got.capacity, got.charge) == (5.0, 1.25)
    assert got.power_supply_status == 2 and got.present  # discharging
    unknown = made(numbers.BATTERY_SIGNAL.id, math.nan, math.nan, 0.25, math.nan)
    assert math.isnan(unknown["/dh_drone/battery_state"].voltage)


def test_joints_have_their_names():
    got = made(numbers.JOINT_STATES_SIGNAL.id, [0.5, -0.25], [1.0, 2.0])["/dh_drone/joint_states"]
    assert (got.name, got.position, got.velocity) == (
        ["shoulder", "elbow"],
        [0.5, -0.25],
        [1.0, 2.0],
    )
    one = dataclasses.replace(OUTFIT, joints=("arm",))
    [topic] = [each for each in drone_topics(one) if each.id == numbers.JOINT_STATES_SIGNAL.id]
    assert messages(topic, topic.pack([0.5, 1.0]))[0][1]["position"] == (0.5,)


def test_setpoints_of_joints_have_their_names_and_no_velocities():
    driven = dataclasses.replace(OUTFIT, setpoints=("position", "effort"))
    [topic] = [t for t in drone_topics(driven) if t.id == numbers.JOINT_SETPOINTS_SIGNAL.id]
    [(_, message)] = [m for m in messages(topic, topic.pack([[0.5, math.nan], [math.nan, 2.0]]))]
    assert message["name"] == ["shoulder", "elbow"]
    assert (message["velocity"], message["position"][0], message["effort"][1]) == ((), 0.5, 2.0)


def test_forces_of_contact_and_tensions_have_the_names_of_links_and_cables():
    got = made(numbers.CONTACT_FORCES_SIGNAL.id, [0.0, 0.0, 2.5, -0.5, 0.0, 4.0])
    forces = got["/dh_drone/contact_forces"]
    assert (forces.links, forces.force) == (["body", "foot"], [0.0, 0.0, 2.5, -0.5, 0.0, 4.0])
    tensions = made(numbers.TENSIONS_SIGNAL.id, 1.5)["/dh_drone/tensions"]
    assert (tensions.cables, tensions.tension) == (["sling"], [1.5])


def test_a_sensors_frame_is_that_of_its_topic():
    topic = TOPICS[numbers.IMU_SIGNAL.id]
    named = Topic(topic.id, topic.name, topic.direction, 1, topic.fields, about={"frame": "imu_x"})
    payload = topic.pack([1, [0] * 3, [0] * 3, [0] * 4])
    assert messages(named, payload)[0][1]["header"]["frame_id"] == "imu_x"
    assert messages(topic, payload)[0][1]["header"]["frame_id"] == "base_link"


def test_a_cloud_has_the_points_of_rays_that_met_something():
    got = made(numbers.LIDAR_CLOUD_SIGNAL.id, 5, [math.inf, 2.0])["/dh_drone/lidar_cloud"]
    points = np.frombuffer(got.data, "<f4").reshape(-1, 3)
    assert points == pytest.approx(np.array([[0.0, 2.0, 0.0]]), abs=1e-6)
    assert (got.width, got.height, got.point_step, got.row_step) == (1, 1, 12, 12)
    assert [(field.name, field.offset, field.datatype) for field in got.fields] == [
        ("x", 0, 7),
        ("y", 4, 7),
        ("z", 8, 7),
    ]
    assert got.header.frame_id == "lidar_link"


def test_the_rays_of_a_cloud_go_round_at_each_elevation_before_the_next():
    scan = {"azimuths": [0.0, math.pi / 2, 3], "elevations": [0.0, math.pi / 6, 2]}
    fields = (Field("stamp", "int64", "ns"), Field("ranges", "float32", "m", "S", 6))
    topic = dataclasses.replace(TOPICS[numbers.LIDAR_CLOUD_SIGNAL.id], fields=fields, about=scan)
    found = messages(topic, topic.pack([0, [1.0, 2.0, 3.0, 2.0, 4.0, math.inf]]))[0][1]
    points = np.frombuffer(found["data"], "<f4").reshape(-1, 3)
    level, up = math.sqrt(3.0), 0.5  # cosine of 30 degrees doubled, and its sine
    expected = [[1, 0, 0], [0, 2, 0], [-3, 0, 0], [level, 0, 2 * up], [0, 2 * level, 4 * up]]
    assert points == pytest.approx(np.array(expected), abs=1e-6)


def test_a_large_cloud_is_the_same():
    count = 1000
    scan = {"azimuths": [0.0, 0.001, count], "elevations": [0.0, 0.0, 1]}
    fields = (Field("stamp", "int64", "ns"), Field("ranges", "float32", "m", "S", count))
    topic = dataclasses.replace(TOPICS[numbers.LIDAR_CLOUD_SIGNAL.id], fields=fields, about=scan)
    found = messages(topic, topic.pack([1_000_000_002, [1.0] * count]))[0][1]
    points = np.frombuffer(found["data"], "<f4").reshape(-1, 3)
    angles = 0.001 * np.arange(count)
    assert points[:, 0] == pytest.approx(np.cos(angles), abs=1e-6)
    assert points[:, 1] == pytest.approx(np.sin(angles), abs=1e-6)
    assert found["header"]["stamp"] == {"sec": 1, "nanosec": 2}


POSES = [1, 2, 3, HALF, 0, 0, HALF, 4, 5, 6, 1, 0, 0, 0, 7, 8, 9, 1, 0, 0, 0]


def frames_topic(**changes):
    options = dataclasses.replace(OUTFIT, **changes)
    [topic] = [each for each in drone_topics(options) if each.id == numbers.FRAMES_SIGNAL.id]
    return topic


def pairs_in(transforms):
    return [(each["header"]["frame_id"], each["child_frame_id"]) for each in transforms]


def test_frames_that_move_become_transforms_from_parent_to_child():
    values = moving_transforms_maker(frames_topic())(T_NS, {"poses": POSES})
    first, second = values["transforms"]
    assert pairs_in((first, second)) == [("odom", "body"), ("body", "arm")]
    assert first["transform"]["translation"] == {"x": 1, "y": 2, "z": 3}
    assert second["transform"]["translation"]["z"] == 9
    assert first["transform"]["rotation"] == {"w": HALF, "x": 0, "y": 0, "z": HALF}


def test_fixed_frames_are_those_of_rep_105_and_of_the_drone():
    """REP-105: each frame has one parent, and map is that of odom, odom that of the drone."""
    found = fixed_transforms_maker(frames_topic())(T_NS, {"poses": POSES})["transforms"]
    assert pairs_in(found) == [
        ("world", "map"),
        ("map", "odom"),
        ("body", "base_link"),
        ("body", "imu_link"),
    ]
    same = found[0]["transform"]
    assert (same["translation"]["x"], same["rotation"]["w"]) == (0, 1)
    assert found[3]["transform"]["translation"]["z"] == 6


def test_a_log_has_all_frames_in_one_message():
    found = made(numbers.FRAMES_SIGNAL.id, POSES)["/tf"].transforms
    children = [each.child_frame_id for each in found]
    assert children == ["body", "arm", "map", "odom", "base_link", "imu_link"]


def test_a_drone_with_a_base_link_needs_no_other_and_an_older_server_moves_all():
    topic = frames_topic(frames=(("world", "base_link"), ("base_link", "s")))
    older = dataclasses.replace(topic, about={"frames": topic.about["frames"]})
    values = {"poses": POSES[:14]}
    moving, fixed = moving_transforms_maker(older), fixed_transforms_maker(older)
    assert pairs_in(moving(T_NS, values)["transforms"]) == [
        ("odom", "base_link"),
        ("base_link", "s"),
    ]
    assert pairs_in(fixed(T_NS, values)["transforms"]) == [("world", "map"), ("map", "odom")]


def test_a_payload_of_another_size_is_refused():
    with pytest.raises(ValueError, match="does not fit"):
        messages(TOPICS[numbers.VELOCITY_SIGNAL.id], b"12345")


def test_a_topic_of_tomorrow_becomes_nothing():
    topic = Topic(999, "/dh_drone/new", TopicDirection.OUT, 1.0, (Field("a", "int32", "1"),))
    assert messages(topic, topic.pack([1])) == []


def test_neither_drake_nor_ros_is_loaded():
    modules = "workbench.link.ros_messages.conversion, workbench.link.ros_messages.cdr"
    code = f"import sys, {modules}; print(*sys.modules)"
    root = Path(__file__).resolve().parents[3]
    done = subprocess.run([sys.executable, "-c", code], cwd=root, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    loaded = {name.split(".")[0] for name in done.stdout.split()}
    assert not loaded & {"pydrake", "PyQt6", "cyclonedds", "rclpy", "mcap"}


def test_a_camera_info_projects_as_a_pinhole_and_its_image_has_the_rows():
    """u = fx x / z + cx and v = fy y / z + cy; depths are rows of 16-bit millimetres."""
    camera = Pinhole(3, 2, 300.0, 500.0, 1.25, 0.75)
    options = dataclasses.replace(
        OUTFIT,
        rates={**OUTFIT.rates, "depth_camera": 5.0},
        picture=PictureLayout(camera, "optical", False),
    )
    (topic,) = [each for each in drone_topics(options) if each.id == numbers.DEPTH_IMAGE_SIGNAL.id]
    depths = np.array([[1000, 2000, 3000], [4000, 5000, 65_535]], "<u2")
    payload = topic.pack((T_NS, np.frombuffer(depths.tobytes(), "<u4").tolist()))
    found = {}
    for channel, message in messages(topic, payload):
        decode = generate_dynamic(channel.type, schema_text(channel.type))[channel.type]
        found[channel.topic.rpartition("/")[2]] = decode(encode(channel.type, message))
    info, image = found["camera_info"], found["image_raw"]
    x, y, z = 0.3, -0.2, 2.0
    pixel = [300.0 * x / z + 1.25, 500.0 * y / z + 0.75, 1.0]
    assert np.reshape(info.k, (3, 3)) @ [x, y, z] / z == pytest.approx(pixel)
    assert np.reshape(info.p, (3, 4)) @ [x, y, z, 1.0] / z == pytest.approx(pixel)
    assert np.reshape(info.r, (3, 3)).tolist() == np.eye(3).tolist() and not any(info.d)
    for each in (info, image):
        assert (each.width, each.height) == (3, 2) and each.header.frame_id == "optical"
    rows = np.frombuffer(bytes(image.data), "<u2").reshape(image.height, image.step // 2)
    assert image.encoding == "16UC1" and rows.tolist() == depths.tolist()

"""Bags of ROS 2 that rosbags wrote, with the definitions and bytes of ROS 2."""

import math
import sqlite3
from contextlib import closing

import numpy as np
import pytest
from rosbags.rosbag2 import StoragePlugin, Writer
from rosbags.typesys import Stores, get_typestore

from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.logs.flight_reader import read_flight

pytestmark = pytest.mark.usefixtures("unheld")

STORE = get_typestore(Stores.ROS2_JAZZY)
BEGIN_NS = 1_790_000_000_000_000_000
"""Time of a real flight [ns since 1970]."""


def message(kind, **values):
    return STORE.types[kind](**values)


def header(t_ns, frame):
    stamp = message("builtin_interfaces/msg/Time", sec=t_ns // 10**9, nanosec=t_ns % 10**9)
    return message("std_msgs/msg/Header", stamp=stamp, frame_id=frame)


def vector(kind, parts):
    return message(f"geometry_msgs/msg/{kind}", **dict(zip("xyz", parts, strict=True)))


def odometry(t_ns, place, yaw, forward):
    turn = message(
        "geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=math.sin(yaw / 2), w=math.cos(yaw / 2)
    )
    pose = message("geometry_msgs/msg/Pose", position=vector("Point", place), orientation=turn)
    twist = message(
        "geometry_msgs/msg/Twist",
        linear=vector("Vector3", (forward, 0.0, 0.0)),
        angular=vector("Vector3", (0.0, 0.0, 0.5)),
    )
    zeros = np.zeros(36)
    return message(
        "nav_msgs/msg/Odometry",
        header=header(t_ns, "odom"),
        child_frame_id="base_link",
        pose=message("geometry_msgs/msg/PoseWithCovariance", pose=pose, covariance=zeros),
        twist=message("geometry_msgs/msg/TwistWithCovariance", twist=twist, covariance=zeros),
    )


def imu(t_ns, turn):
    return message(
        "sensor_msgs/msg/Imu",
        header=header(t_ns, "imu_link"),
        orientation=message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=0.0, w=1.0),
        orientation_covariance=np.zeros(9),
        angular_velocity=vector("Vector3", (0.0, 0.0, turn)),
        angular_velocity_covariance=np.zeros(9),
        linear_acceleration=vector("Vector3", (0.0, 0.0, 9.75)),
        linear_acceleration_covariance=np.zeros(9),
    )


def pose(t_ns, place):
    turn = message("geometry_msgs/msg/Quaternion", x=0.0, y=0.0, z=1.0, w=0.0)
    return message(
        "geometry_msgs/msg/PoseStamped",
        header=header(t_ns, "map"),
        pose=message("geometry_msgs/msg/Pose", position=vector("Point", place), orientation=turn),
    )


def write_bag(folder, messages, plugin=StoragePlugin.MCAP):
    """Write messages, of topic, type, time in the bag [ns] and content; return the file."""
    with Writer(folder, version=9, storage_plugin=plugin) as writer:
        connections = {}
        for topic, kind, t_ns, made in messages:
            if topic not in connections:
                connections[topic] = writer.add_connection(topic, kind, typestore=STORE)
            writer.write(connections[topic], t_ns, STORE.serialize_cdr(made, kind))
    return next(each for each in folder.iterdir() if each.suffix != ".yaml")


def usual_messages():
    """Yield the messages of a second."""
    for step in range(200):
        t = BEGIN_NS + step * 5_000_000
        if step % 4 == 0:
            made = odometry(t, (1.0, 2.0, 0.01 * step), math.pi / 2, 1.5)
            yield "/robot/odom", "nav_msgs/msg/Odometry", t + 1000, made
        yield "/robot/imu", "sensor_msgs/msg/Imu", t + 2000, imu(t, 0.5)
        kind = "std_msgs/msg/Float64"
        yield "/robot/load", kind, t, message(kind, data=float(step))


@pytest.fixture(scope="module")
def bag(tmp_path_factory):
    return write_bag(tmp_path_factory.mktemp("bag") / "flight", usual_messages())


def test_a_bag_is_a_flight_with_our_names_and_its_own(bag):
    flight = read_flight(bag)
    signals = flight.signals
    assert (flight.format, flight.end) == ("ROS 2 bag", pytest.approx(0.995))
    height = signals["position_data.z"]
    assert height.unit == "m" and height.values[-1] == pytest.approx(1.96)
    assert np.diff(height.time) == pytest.approx(0.02)
    assert signals["position_data.yaw"].values == pytest.approx(math.pi / 2)
    # Forward is north then: REP-103, twist in the body's axes.
    assert signals["velocity_data.v_y"].values == pytest.approx(1.5)
    assert signals["velocity_data.v_x"].values == pytest.approx(0.0, abs=1e-12)
    assert signals["imu.angular_velocity.z"].values == pytest.approx(0.5)
    assert signals["imu.linear_acceleration.z"].values == pytest.approx(9.75)
    assert signals["robot_load.data"].values[-1] == 199.0
    assert flight.clock_start == pytest.approx(1e-9 * BEGIN_NS)


def test_a_bag_is_listed_like_any_log(bag, capsys):
    assert main(["log", str(bag)]) == 0
    assert "ROS 2 bag" in capsys.readouterr().out


def test_a_damaged_bag_is_a_sentence(bag, tmp_path):
    path = tmp_path / "cut.mcap"
    path.write_bytes(bag.read_bytes()[:3000])
    with pytest.raises(WorkbenchError, match="cannot be read as a bag of ROS 2"):
        read_flight(path)


def test_a_bag_in_sqlite_is_the_same_flight(bag, tmp_path, case):
    """ROS 2 Humble writes no definitions of types; those of usual messages are known."""
    path = write_bag(tmp_path / "flight", usual_messages(), StoragePlugin.SQLITE3)
    expected = read_flight(bag)
    for drops in (False, True):
        with case(drops):
            if drops:
                with closing(sqlite3.connect(path)) as base:
                    base.execute("DROP TABLE message_definitions")
                    base.commit()
            flight = read_flight(path)
            missing = {"robot_load.data"} if drops else set()
            why = "/robot/load was left out: the bag does not define std_msgs/msg/Float64"
            assert flight.remarks == ((why,) if drops else ())
            assert set(flight.signals) == set(expected.signals) - missing
            for name, signal in flight.signals.items():
                np.testing.assert_array_equal(signal.values, expected[name].values)
                np.testing.assert_array_equal(signal.time, expected[name].time)
    path.write_bytes(path.read_bytes()[:5000])
    with pytest.raises(WorkbenchError, match="cannot be read as a bag of ROS 2"):
        read_flight(path)


def test_messages_without_a_header_follow_the_clock_of_the_headers(tmp_path):
    """In a simulation at half speed, the bag has the time of the day."""
    kind = "std_msgs/msg/Float64"

    def simulated():
        for step in range(200):
            t_ns, shown = BEGIN_NS + step * 10_000_000, 3 * 10**9 + step * 5_000_000
            yield "/imu", "sensor_msgs/msg/Imu", t_ns, imu(shown, 0.5)
            if step % 10 == 5:
                yield "/load", kind, t_ns, message(kind, data=1e-9 * shown)

    flight = read_flight(write_bag(tmp_path / "flight", simulated()))
    load = flight["load.data"]
    assert len(load.time) == 20
    np.testing.assert_allclose(load.time, load.values - 3.0, atol=1e-6)
    assert flight.end == pytest.approx(0.995) and flight.clock_start == pytest.approx(3.0)
    assert any("/load: the time is that of arrival" in each for each in flight.remarks)


def test_a_topic_on_a_clock_of_its_own_has_the_time_of_arrival(tmp_path):
    """A sensor whose headers count from its start, beside others with the time of the day."""

    def made():
        for step in range(100):
            t_ns = BEGIN_NS + step * 5_000_000
            yield "/robot/imu", "sensor_msgs/msg/Imu", t_ns, imu(t_ns, 0.5)
            if step % 2 == 0:
                yield (
                    "/pose",
                    "geometry_msgs/msg/PoseStamped",
                    t_ns,
                    pose(1 + step * 5_000_000, (0.01 * step, 0.0, 0.0)),
                )

    flight = read_flight(write_bag(tmp_path / "flight", made()))
    place = flight["position_data.x"]
    np.testing.assert_allclose(place.time, 0.5 * place.values, atol=1e-6)
    assert len(place.time) == 50 and len(flight["imu.angular_velocity.z"].time) == 100
    assert any("/pose: the time is that of arrival" in each for each in flight.remarks)


def test_what_an_imu_does_not_measure_is_left_out(tmp_path, case):
    """REP-145: the first covariance is -1 then; others leave the quaternion at zero."""

    def made(unknown, quaternion):
        for step in range(50):
            t = BEGIN_NS + step * 5_000_000
            one = imu(t, 0.5)
            one.orientation.w = quaternion
            one.__dict__[f"{unknown}_covariance"][0] = -1.0
            yield "/imu", "sensor_msgs/msg/Imu", t, one

    for unknown, quaternion, attitude, force in (
        ("orientation", 1.0, False, True),
        ("angular_velocity", 0.0, False, True),
        ("linear_acceleration", 1.0, True, False),
    ):
        with case(unknown):
            flight = read_flight(write_bag(tmp_path / unknown, made(unknown, quaternion)))
            assert ("position_data.roll" in flight) == ("attitude.q_w" in flight) == attitude
            assert ("imu.linear_acceleration.z" in flight) == force
            assert ("imu.angular_velocity.z" in flight) == (unknown != "angular_velocity")


def test_a_goal_is_a_setpoint_and_no_motion(tmp_path):
    def made():
        for step in range(50):
            t = BEGIN_NS + step * 5_000_000
            yield (
                "/mavros/setpoint_position/local",
                "geometry_msgs/msg/PoseStamped",
                t,
                pose(t, (7.0, 8.0, 9.0)),
            )
            yield "/vrpn/pose", "geometry_msgs/msg/PoseStamped", t, pose(t, (1.0, 2.0, 3.0))

    flight = read_flight(write_bag(tmp_path / "flight", made()))
    for topic, place in (("position_data", (1.0, 2.0, 3.0)), ("setpoint", (7.0, 8.0, 9.0))):
        assert [flight[f"{topic}.{axis}"].values[0] for axis in "xyz"] == list(place)
    assert abs(flight["setpoint.yaw"].values[0]) == pytest.approx(math.pi)

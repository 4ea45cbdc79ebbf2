"""What is written to ROS 2, read back by a second participant."""

import math
import os
import time

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from cyclonedds.domain import DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader

from workbench.extras.gateways.ros2_dds import DdsDomain, dds_topic, message_type
from workbench.extras.gateways.ros2_publishing import (
    CLOCK_CHANNEL,
    FIXED_TRANSFORMS_CHANNEL,
    ODOMETRY_CHANNEL,
    PARAMETER_EVENTS_CHANNEL,
    RosPublisher,
)
from workbench.link.drone_topics import drone_topics
from workbench.link.ros_messages.conversion import conversion
from workbench.link.sample import Sample
from workbench.link.signal import RosChannel, TopicOptions

DOMAIN = 101 + (os.getpid() + 50) % 100
OUTFIT = TopicOptions(
    4, 200.0, 10.0, rates={"gps": 10.0}, frames=(("world", "body"), ("body", "GPS_link"))
)
TOPICS = {topic.name.rsplit("/", 1)[1]: topic for topic in drone_topics(OUTFIT)}
NORTH = (1.0, -2.0, 3.5, 0.0, 0.0, math.pi / 2, 0.25, 0.5, 0.75)
VELOCITY = (0.0, 2.0, 0.5, 0.0, 0.0, 0.25)
T_NS = 7_250_000_000
LIMIT = 300.0
"""Generous: a busy machine is no failure [s]."""


def sample(name, *values, t_ns=T_NS):
    return Sample(TOPICS[name], t_ns, TOPICS[name].pack(values))


class Place:
    """A domain with a gateway's publishing, and another participant that reads."""

    def __init__(self, domain):
        self.publishing = RosPublisher(domain.participant, "dh_drone")
        self.other = DomainParticipant(DOMAIN)

    def reader(self, channel, *policies):
        topic = dds_topic(self.other, channel.topic, message_type(channel.type))
        qos = Qos(*(policies or (Policy.Reliability.Reliable(0), Policy.History.KeepLast(10))))
        return DataReader(self.other, topic, qos=qos)


@pytest.fixture
def place():
    with DdsDomain(DOMAIN) as domain:
        place = Place(domain)
        yield place
        place.publishing = place.other = None


def taken(reader):
    """Return what a reader gets, as soon as there is something."""
    end = time.monotonic() + LIMIT
    while not (found := reader.take(20)):
        assert time.monotonic() < end, "nothing came"
        time.sleep(0.002)
    return found


def matched(reader):
    end = time.monotonic() + LIMIT
    while not reader.get_matched_publications():
        assert time.monotonic() < end, "nobody writes"
        time.sleep(0.002)
    return reader


def test_all_topics_are_there_before_the_first_message(place):
    place.publishing.announce(TOPICS.values())
    expected = {each[:2] for topic in TOPICS.values() for each in conversion(topic).channels}
    others = {CLOCK_CHANNEL, ODOMETRY_CHANNEL, FIXED_TRANSFORMS_CHANNEL, PARAMETER_EVENTS_CHANNEL}
    others = {each[:2] for each in others}
    assert {each[:2] for each in place.publishing.channels} == expected | others
    names = {topic for topic, _ in expected}
    assert {"/dh_drone/velocity_data", "/dh_drone/pose", "/dh_drone/gps", "/tf"} <= names


def test_another_vehicle_has_its_own_topics_and_the_common_ones():
    with DdsDomain(DOMAIN) as domain:
        publishing = RosPublisher(domain.participant, "iris")
        publishing.announce(TOPICS.values())
        names = {writer.topic.name for writer in publishing.writers}
        publishing = None
    assert {"rt/iris/gps", "rt/iris/odometry", "rt/tf", "rt/clock"} <= names
    assert not any("dh_drone" in name for name in names)


def test_fixed_frames_are_there_for_who_comes_later(place):
    place.publishing.announce(TOPICS.values())
    poses = [0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0] * 2
    for _ in range(3):
        place.publishing.write(sample("frames", poses))
    qos = (Policy.Reliability.Reliable(0), Policy.Durability.TransientLocal)
    (message,) = taken(place.reader(FIXED_TRANSFORMS_CHANNEL, *qos))  # once, not three times
    assert [each.child_frame_id for each in message.transforms][:2] == ["map", "odom"]


@pytest.mark.parametrize(
    "policy", [Policy.Reliability.Reliable(0), Policy.Reliability.BestEffort], ids=str
)
def test_reliable_and_best_effort_readers_both_get_a_message(place, policy):
    place.publishing.announce(TOPICS.values())
    channel = RosChannel("/dh_drone/velocity_data", "dh_drone_msgs/msg/VelocityData")
    reader = matched(place.reader(channel, policy))
    place.publishing.write(sample("velocity_data", *VELOCITY))
    (message,) = taken(reader)
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (7, 250_000_000)
    assert message.header.frame_id == "world"
    assert (message.v_x, message.v_y, message.v_z, message.w_z) == (0.0, 2.0, 0.5, 0.25)


def test_a_writer_offers_what_ros_asks_for_by_default(place):
    place.publishing.announce(TOPICS.values())
    reader = matched(place.reader(CLOCK_CHANNEL))
    (handle,) = reader.get_matched_publications()
    qos = reader.get_matched_publication_data(handle).qos
    assert Policy.Durability.Volatile in qos
    assert qos[Policy.Reliability] == Policy.Reliability.Reliable(0)
    representation = qos[Policy.DataRepresentation]
    assert representation.use_cdrv0_representation
    assert not representation.use_xcdrv2_representation


def test_position_and_velocity_of_one_time_are_an_odometry(place):
    place.publishing.announce(TOPICS.values())
    reader = matched(place.reader(ODOMETRY_CHANNEL))
    place.publishing.write(sample("position_data", *NORTH, t_ns=T_NS - 5_000_000))
    place.publishing.write(sample("velocity_data", *VELOCITY))
    place.publishing.write(sample("position_data", *NORTH))
    (message,) = taken(reader)  # the first position had no velocity of its time
    assert (message.header.frame_id, message.child_frame_id) == ("odom", "body")
    place_told, turn = message.pose.pose.position, message.pose.pose.orientation
    assert (place_told.x, place_told.y, place_told.z) == (1.0, -2.0, 3.5)
    assert (turn.z, turn.w) == pytest.approx((0.5**0.5, 0.5**0.5))
    speed = message.twist.twist
    assert (speed.linear.x, speed.linear.y) == pytest.approx((2.0, 0.0), abs=1e-6)
    assert (speed.linear.z, speed.angular.z) == pytest.approx((0.5, 0.25))


def test_the_clock_is_simulated_time(place):
    place.publishing.announce(TOPICS.values())
    reader = matched(place.reader(CLOCK_CHANNEL))
    place.publishing.write(sample("time_data", 7, 250_000_000, 1))
    (message,) = taken(reader)
    assert (message.clock.sec, message.clock.nanosec) == (7, 250_000_000)


def test_a_set_parameter_is_an_event_of_the_node(place):
    """As rclcpp's ParameterEventHandler reads it: by node, name and type 3, a double."""
    place.publishing.announce(TOPICS.values())
    reader = matched(place.reader(PARAMETER_EVENTS_CHANNEL))
    place.publishing.write(sample("parameters", "kp_pitch", 200.5))
    (message,) = taken(reader)
    assert (message.stamp.sec, message.stamp.nanosec) == (7, 250_000_000)
    assert (message.node, message.new_parameters) == ("/dh_drone/flight", [])
    [changed] = message.changed_parameters
    assert (changed.name, changed.value.type, changed.value.double_value) == ("kp_pitch", 3, 200.5)


def test_a_topic_that_is_described_anew_is_read_anew(place):
    place.publishing.announce(TOPICS.values())
    kind = RosChannel("/dh_drone/rotors", "dh_drone_msgs/msg/RotorData")
    reader = matched(place.reader(kind))
    place.publishing.write(sample("rotors", (1.0,) * 4, (2.0,) * 4))
    six = next(
        each for each in drone_topics(TopicOptions(6, 200.0, 10.0)) if each.name == kind.topic
    )
    place.publishing.write(Sample(six, T_NS, six.pack(((1.0,) * 6, (2.0,) * 6))))
    counts = []
    while len(counts) < 2:
        counts += [len(message.speed) for message in taken(reader)]
    assert counts == [4, 6]

"""What is written to ROS 2, read back by a second participant."""

import math
import os
import time

import pytest

pytest.importorskip("cyclonedds", reason="install the extra `ros2` to try it")

from cyclonedds.domain import DomainParticipant
from cyclonedds.qos import Policy, Qos
from cyclonedds.sub import DataReader

from workbench.gateways.ros2_dds import DdsDomain, message_type
from workbench.gateways.ros2_publishing import CLOCK_CHANNEL, ODOMETRY, Publishing, dds_topic
from workbench.gateways.ros_messages.conversion import Channel, conversion
from workbench.link.drone_topics import Outfit, drone_topics
from workbench.link.sample import Sample

DOMAIN = 101 + (os.getpid() + 50) % 100
OUTFIT = Outfit(4, 200.0, 10.0, gps=10.0, frames=(("world", "body"), ("body", "GPS_link")))
TOPICS = {topic.name.rsplit("/", 1)[1]: topic for topic in drone_topics(OUTFIT)}
NORTH = (1.0, -2.0, 3.5, 0.0, 0.0, math.pi / 2, 0.25, 0.5, 0.75)
VELOCITY = (0.0, 2.0, 0.5, 0.0, 0.0, 0.25)
T_NS = 7_250_000_000


def sample(name, *values, t_ns=T_NS):
    return Sample(TOPICS[name], t_ns, TOPICS[name].pack(values))


class Place:
    """A domain with a gateway's publishing, and another participant that reads."""

    def __init__(self, domain):
        self.publishing = Publishing(domain.participant)
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
    end = time.monotonic() + 20.0
    while not (found := reader.take(20)):
        assert time.monotonic() < end, "nothing came"
        time.sleep(0.002)
    return found


def matched(reader):
    end = time.monotonic() + 20.0
    while not reader.get_matched_publications():
        assert time.monotonic() < end, "nobody writes"
        time.sleep(0.002)
    return reader


def test_all_topics_are_there_before_the_first_message(place):
    place.publishing.announce(TOPICS.values())
    expected = {channel for topic in TOPICS.values() for channel in conversion(topic).channels}
    assert set(place.publishing.channels) == expected | {CLOCK_CHANNEL, ODOMETRY}
    names = {channel.topic for channel in expected}
    assert {"/dh_drone/velocity_data", "/dh_drone/pose", "/dh_drone/gps", "/tf"} <= names


@pytest.mark.parametrize(
    "policy", [Policy.Reliability.Reliable(0), Policy.Reliability.BestEffort], ids=str
)
def test_reliable_and_best_effort_readers_both_get_a_message(place, policy):
    place.publishing.announce(TOPICS.values())
    channel = Channel("/dh_drone/velocity_data", "dh_drone_msgs/msg/VelocityData")
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
    reader = matched(place.reader(ODOMETRY))
    place.publishing.write(sample("position_data", *NORTH, t_ns=T_NS - 5_000_000))
    place.publishing.write(sample("velocity_data", *VELOCITY))
    place.publishing.write(sample("position_data", *NORTH))
    (message,) = taken(reader)  # the first position had no velocity of its time
    assert (message.header.frame_id, message.child_frame_id) == ("world", "body")
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


def test_a_topic_that_is_described_anew_is_read_anew(place):
    place.publishing.announce(TOPICS.values())
    kind = Channel("/dh_drone/rotors", "dh_drone_msgs/msg/RotorData")
    reader = matched(place.reader(kind))
    place.publishing.write(sample("rotors", (1.0,) * 4, (2.0,) * 4))
    six = next(each for each in drone_topics(Outfit(6, 200.0, 10.0)) if each.name == kind.topic)
    place.publishing.write(Sample(six, T_NS, six.pack(((1.0,) * 6, (2.0,) * 6))))
    counts = []
    while len(counts) < 2:
        counts += [len(message.speed) for message in taken(reader)]
    assert counts == [4, 6]

"""Foxglove's own server, asked by a plain WebSocket client."""

import asyncio
import importlib
import json
import math
import struct

import aiohttp
import pytest

from workbench.common.errors import WorkbenchError
from workbench.extras.gateways.foxglove import Foxglove, check_reach
from workbench.link.address import Address
from workbench.link.drone_topics import drone_topics
from workbench.link.sample import Sample
from workbench.link.signal import TopicOptions

pytest.importorskip("foxglove", reason="install the extra `foxglove` to try it")

TOPICS = {
    topic.name: topic
    for topic in drone_topics(
        TopicOptions(4, 200.0, 10.0, rates={"imu": 200.0}, frames=[("W", "B")])
    )
}
PROTOCOLS = ("foxglove.sdk.v1", "foxglove.websocket.v1")


@pytest.fixture
def outlet():
    outlet = Foxglove("dh_drone", Address("127.0.0.1", 0), anybody=False)
    outlet.announce(tuple(TOPICS.values()))
    yield outlet
    outlet.close()


def sample(name, *values, t_ns=1_250_000_000):
    topic = TOPICS[f"/dh_drone/{name}"]
    return Sample(topic, t_ns, topic.pack(values))


async def watch(outlet, name, deliver):
    """Return what is offered, and the message on a topic: channels, schema, time, bytes."""
    async with (
        asyncio.timeout(300.0),
        aiohttp.ClientSession() as session,
        session.ws_connect(f"http://{outlet.address}", protocols=PROTOCOLS) as socket,
    ):
        offered = {}
        while name not in offered:
            said = json.loads((await socket.receive()).data)
            if said["op"] == "advertise":
                offered |= {channel["topic"]: channel for channel in said["channels"]}
        channel = offered[name]
        await socket.send_json(
            {"op": "subscribe", "subscriptions": [{"id": 7, "channelId": channel["id"]}]}
        )
        while True:
            deliver()  # until the subscription has come through
            try:
                got = await asyncio.wait_for(socket.receive(), 0.2)
            except TimeoutError:
                continue
            if got.type is aiohttp.WSMsgType.BINARY and got.data[0] == 1:
                number, t_ns = struct.unpack_from("<IQ", got.data, 1)
                assert number == 7
                return offered, channel, t_ns, got.data[13:]


def decode(channel, data):
    """Decode with the schema that was offered, by a reader that shares no code with ours."""
    decoder = importlib.import_module("mcap_ros2.decoder").DecoderFactory()
    schema = importlib.import_module("mcap.records").Schema(
        id=1, name=channel["schemaName"], encoding="ros2msg", data=channel["schema"].encode()
    )
    return decoder.decoder_for("cdr", schema)(data)


def test_topics_are_offered_and_a_pose_arrives_as_ros_has_it(outlet):
    pose = sample("position_data", 1.0, 2.0, 3.0, 0.0, 0.0, math.pi / 2, 0.0, 0.0, 0.0)
    offered, channel, t_ns, data = asyncio.run(
        watch(outlet, "/dh_drone/pose", lambda: outlet.deliver(pose))
    )
    assert {"/dh_drone/position_data", "/dh_drone/imu", "/tf", "/dh_drone/events"} <= set(offered)
    assert (channel["encoding"], channel["schemaEncoding"]) == ("cdr", "ros2msg")
    assert channel["schemaName"] == "geometry_msgs/msg/PoseStamped"
    assert t_ns == 1_250_000_000
    message = decode(channel, data)
    place, turn = message.pose.position, message.pose.orientation
    assert (place.x, place.y, place.z) == (1.0, 2.0, 3.0)
    assert (turn.z, turn.w) == pytest.approx((math.sqrt(0.5), math.sqrt(0.5)))
    assert (message.header.stamp.sec, message.header.stamp.nanosec) == (1, 250_000_000)


def test_our_own_types_arrive_too(outlet):
    rotors = sample("rotors", (1.0, 2.0, 3.0, 4.0), (0.5,) * 4)
    _, channel, _, data = asyncio.run(
        watch(outlet, "/dh_drone/rotors", lambda: outlet.deliver(rotors))
    )
    assert list(decode(channel, data).speed) == [1.0, 2.0, 3.0, 4.0]


def test_a_server_that_came_back_with_other_rotors_is_offered_anew(outlet):
    (six,) = (
        topic
        for topic in drone_topics(TopicOptions(6, 200.0, 10.0))
        if topic.name.endswith("rotors")
    )
    outlet.deliver(sample("rotors", (1.0,) * 4, (0.5,) * 4))
    rotors = Sample(six, 5, six.pack([(1.0,) * 6, (0.5,) * 6]))
    outlet.deliver(rotors)
    _, channel, _, data = asyncio.run(
        watch(outlet, "/dh_drone/rotors", lambda: outlet.deliver(rotors))
    )
    assert len(decode(channel, data).thrust) == 6


def test_nobody_may_publish(outlet):
    async def ask():
        async with (
            aiohttp.ClientSession() as session,
            session.ws_connect(f"http://{outlet.address}", protocols=PROTOCOLS) as socket,
        ):
            return json.loads((await asyncio.wait_for(socket.receive(), 300.0)).data)

    said = asyncio.run(ask())
    assert said["op"] == "serverInfo"
    assert said["capabilities"] == ["time"]


def test_a_port_in_use_is_a_sentence(outlet):
    with pytest.raises(WorkbenchError, match="cannot listen at 127.0.0.1:.*--listen"):
        Foxglove("dh_drone", outlet.address, anybody=False)


@pytest.mark.parametrize("host", ["0.0.0.0", "::", "192.168.1.5", "drone.local"])
def test_others_may_watch_only_if_that_is_said(host):
    with pytest.raises(WorkbenchError, match=f"others may reach {host}: .*--anybody"):
        Foxglove("dh_drone", Address(host, 0), anybody=False)


def test_whoever_says_so_may_let_others_watch():
    outlet = Foxglove("dh_drone", Address("0.0.0.0", 0), anybody=True)
    assert outlet.address.port > 0
    outlet.close()


@pytest.mark.parametrize(
    "host", ["127.0.0.1", "127.1.2.3", "::1", "localhost", "LocalHost", "::ffff:127.0.0.1"]
)
def test_this_computers_own_programs_may_watch(host):
    check_reach(Address(host, 0), anybody=False)


def test_a_missing_package_is_a_sentence(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "foxglove", None)
    with pytest.raises(WorkbenchError, match="`pip install foxglove-sdk`"):
        Foxglove("dh_drone", Address("127.0.0.1", 0), anybody=False)

"""Our logs as bags of ROS 2: read by rosbags, which knows nothing of ours, and under each name."""

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from tests.logs.conftest import fly
from workbench.logs.flight_log import FlightLog
from workbench.logs.flight_reader import read_flight
from workbench.logs.record import read_log
from workbench.scenario.scenario import Scenario, ScenarioStart
from workbench.scenario.sensors_config import SensorsConfig

pytestmark = pytest.mark.usefixtures("unheld")


def write(flown, path, vehicle):
    """Write the flight as that of a vehicle."""
    log = FlightLog(path, flown.topics, flown.scenario, flown.settings, flown.values, vehicle)
    for sampled in flown.samples:
        log.write(sampled)
    log.close()
    return path


def test_rosbags_reads_each_message_under_the_name_of_the_vehicle(flown, tmp_path):
    path = write(flown, tmp_path / "flight.mcap", "Iris 2")
    with AnyReader([path]) as bag:
        counts = {each.topic: each.msgcount for each in bag.connections}
        assert {"/Iris_2/pose", "/Iris_2/velocity_data", "/tf"} <= set(counts)
        assert not any("dh_drone" in topic for topic in counts)
        last = {}
        for connection, _, data in bag.messages():
            last[connection.topic] = bag.deserialize(data, connection.msgtype)
        assert set(last) == {topic for topic, count in counts.items() if count}
    place = flown.samples[-1].state[4:7]
    pose = last["/Iris_2/pose"].pose.position
    assert max(abs(a - b) for a, b in zip((pose.x, pose.y, pose.z), place, strict=True)) < 1e-6
    assert last["/tf"].transforms[0].header.frame_id == "odom"


def test_a_log_has_the_same_signals_whatever_the_vehicles_name(flown, tmp_path):
    paths = [write(flown, tmp_path / f"{i}.mcap", name) for i, name in enumerate(("dh_drone", "x"))]
    one, other = map(read_log, paths)
    assert list(one.topics) == list(other.topics) and "position_data" in one.topics
    signals = [set(read_flight(path).signals) for path in paths]
    assert signals[0] == signals[1]
    assert "battery.charge" in signals[0] and "battery.voltage" not in signals[0]  # all NaN


def test_pictures_and_their_calibration_are_read_by_rosbags_and_mcap_ros2_support(tmp_path):
    """The focal length of 60 degrees in 160 columns, and the colours of sky and ground."""
    start = ScenarioStart(position=[0.0, 0.0, 2.0])
    scenario = Scenario(duration=0.02, start=start, sensors=SensorsConfig(use=["depth_camera"]))
    path = write(fly(scenario, [], {}), tmp_path / "flight.mcap", "dh_drone")
    with AnyReader([path]) as bag:
        by_rosbags = {
            each.topic: bag.deserialize(data, each.msgtype) for each, _, data in bag.messages()
        }
    with path.open("rb") as file:
        messages = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        by_support = {channel.topic: message for _, channel, _, message in messages}
    for read in (by_rosbags, by_support):
        colour = read["/dh_drone/camera/image_raw"]
        assert (colour.encoding, colour.step, colour.header.frame_id) == (
            "rgb8",
            480,
            "camera_optical",
        )
        pixels = np.frombuffer(bytes(colour.data), np.uint8).reshape(colour.height, colour.width, 3)
        sky, ground = pixels[5].mean(axis=0), pixels[-5].mean(axis=0)
        assert sky[2] > sky[0] + 20 and abs(sky - ground).max() > 20
        depth = read["/dh_drone/camera/depth/image_raw"]
        assert (depth.encoding, depth.step, len(depth.data)) == ("16UC1", 320, 320 * 120)
        info = read["/dh_drone/camera/depth/camera_info"]
        assert (info.width, info.height, info.distortion_model) == (160, 120, "plumb_bob")
        assert list(info.k)[0] == pytest.approx(80.0 / np.tan(1.047 / 2.0))
        f = info.k[0]  # the optical axis is in the middle of 320 x 240 pixels, of which each second
        assert list(info.k) == [f, 0.0, 79.75, 0.0, f, 59.75, 0.0, 0.0, 1.0]
        assert list(info.p) == [f, 0.0, 79.75, 0.0, 0.0, f, 59.75, 0.0, 0.0, 0.0, 1.0, 0.0]
    assert not any("camera" in name for name in read_flight(path).signals)

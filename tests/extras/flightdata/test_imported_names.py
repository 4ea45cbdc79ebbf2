"""Logs of signals whose names ROS 2 would refuse, read by others and by us."""

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory
from rosbags.highlevel import AnyReader

from workbench.commands.cli import main
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.extras.flightdata.importing import write_flight
from workbench.logs.flight_reader import log_topics, read_flight
from workbench.logs.imported import signal_topics

pytestmark = pytest.mark.usefixtures("unheld")

NAMES_ROS_REFUSES = (
    "csv.höhe",
    "csv.hohe",
    "csv.höhé",
    "csv.高度",
    "csv.größe.x",
    "csv.zellen_ü.2",
    "csv.7",
    "csv.mixed.0",
    "csv.mixed.x",
    "csv.motors.0.speed",
    "csv.motors.1.speed",
    "csv.places.07",
    "csv.places.7",
    "höhe.x",
    "hohe.x",
    "flug.x",
    "csv.m1_a.p",
    "csv.m1a.q",
    "t1_a.p",
    "t1a.q",
)


def test_an_imported_log_is_read_whatever_its_signals_are_called(tmp_path):
    """By our reader, and by two that take the rules of ROS 2 for names."""
    time = np.arange(0.0, 1.0, 0.1)
    signals = {
        name: make_series(name, "m", time, time + place, end=1.0)
        for place, name in enumerate(NAMES_ROS_REFUSES)
    }
    path = tmp_path / "made.mcap"
    flight = Flight("made", tmp_path / "made", "made up", signals, end=1.0)
    write_flight(flight, path)
    again = read_flight(path)
    assert list(again.signals) == list(signals)
    for name, signal in signals.items():
        np.testing.assert_array_equal(again[name].values, signal.values)
    with path.open("rb") as file:
        messages = make_reader(file, decoder_factories=[DecoderFactory()]).iter_decoded_messages()
        by_support = {channel.topic: message for _, channel, _, message in messages}
    with AnyReader([path]) as bag:
        by_rosbags = {
            each.topic: bag.deserialize(data, each.msgtype) for each, _, data in bag.messages()
        }
    for read in (by_support, by_rosbags):
        table = read["/dh_drone/csv"]
        last = {
            "csv.höhe": table.hohe_2,
            "csv.hohe": table.hohe,
            "csv.höhé": table.hohe_3,
            "csv.高度": table.n,
            "csv.größe.x": table.gro_e.x,
            "csv.zellen_ü.2": table.zellen_u[2],
            "csv.7": table.n_7,
            "csv.mixed.0": table.mixed.n_0,
            "csv.motors.1.speed": table.motors.n_1.speed,
            "höhe.x": read["/dh_drone/hohe_2"].x,
            "hohe.x": read["/dh_drone/hohe"].x,
            "flug.x": read["/dh_drone/flug"].x,
            "csv.m1_a.p": table.m1_a.p,
            "csv.m1a.q": table.m1a.q,
            "t1_a.p": read["/dh_drone/t1_a"].p,
            "t1a.q": read["/dh_drone/t1a"].q,
        }
        assert last == {name: signals[name].values[-1] for name in last}
    exported = [each.name for topic, *_ in signal_topics(flight) for each in topic.columns.values()]
    assert set(signals) <= set(exported)
    topics, _ = log_topics(path)
    assert [each.name for topic in topics for each in topic.columns.values()] == exported
    assert [topic.short for topic in topics] == ["csv", "höhe", "hohe", "flug", "t1_a", "t1a"]


def test_topics_whose_names_differ_little_are_exported_to_different_files(tmp_path):
    """A file name has no slash, and some file systems ignore case."""
    time = np.arange(0.0, 1.0, 0.1)
    signals = {
        name: make_series(name, "m", time, time, end=1.0)
        for name in ("t1/a.q", "t1_a.q", "T1_A.q", "t1_a_2.q")
    }
    path = tmp_path / "made.mcap"
    write_flight(Flight("made", tmp_path / "made", "made up", signals, end=1.0), path)
    assert main(["export", str(path), "--output", str(tmp_path / "out")]) == 0
    assert {file.stem for file in (tmp_path / "out").iterdir()} == {
        *("t1_a", "t1_a_2", "T1_A_3", "t1_a_2_2"),
    }

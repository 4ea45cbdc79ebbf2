"""What is in a log, as the `mcap` package and ROS 2's decoder read it, and what may go wrong."""

import json
import os
import pickle
import resource
import signal
import struct
import subprocess
import sys
import zlib
from io import BytesIO
from pathlib import Path

import numpy as np
import pytest
import yaml
import zstandard
from mcap.data_stream import ReadDataStream
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.records import Chunk, MessageIndex
from mcap.stream_reader import StreamReader
from mcap.writer import MCAP0_MAGIC
from mcap_ros2.decoder import DecoderFactory

from tests.jointed import drone, joint, link
from workbench.common.errors import WorkbenchError
from workbench.gains.gains import load_gains
from workbench.link.backplane import Published, Sampled
from workbench.link.topics import topic_from
from workbench.logs import flight_log, mcap_writer
from workbench.logs.contents import scenario_text
from workbench.logs.flight_log import FlightLog, LoggedFlight
from workbench.logs.flight_reader import open_log, read_flight
from workbench.logs.mcap_writer import MCAP_CHUNK_BYTES
from workbench.logs.record import read_log
from workbench.scenario.scenario import Action, Push, Scenario, VehicleConfig
from workbench.scenario.scenario_file import load_scenario, parse_scenario

pytestmark = pytest.mark.usefixtures("unheld")

ROOT = Path(__file__).resolve().parents[2]
PAPER = "time position velocity acceleration force_torque"


def test_the_packages_own_reader_passes_it(log):
    with log.open("rb") as file:
        assert list(StreamReader(file, validate_crcs=True).records)
    with log.open("rb") as file:
        reader = make_reader(file, validate_crcs=True)
        summary = reader.get_summary()
        count = sum(1 for _ in reader.iter_messages())
        half = sum(1 for _ in reader.iter_messages(starting_at=700_000_000))
    assert summary.statistics.message_count == count
    assert summary.statistics.chunk_count == len(summary.chunk_indexes) > 1
    assert 0 < half < count


def test_the_index_leads_to_each_message(log):
    data = log.read_bytes()
    with log.open("rb") as file:
        summary = make_reader(file).get_summary()
    found = 0
    for chunk in summary.chunk_indexes:
        body = BytesIO(data[chunk.chunk_start_offset + 9 :])
        plain = zstandard.decompress(Chunk.read(ReadDataStream(body)).data)
        assert len(plain) == chunk.uncompressed_size
        for channel, offset in chunk.message_index_offsets.items():
            assert data[offset] == Opcode.MESSAGE_INDEX
            index = MessageIndex.read(ReadDataStream(BytesIO(data[offset + 9 :])))
            assert index.channel_id == channel
            for t_ns, place in index.records:
                code, _, *head = struct.unpack_from("<BQHIQ", plain, place)
                assert (code, head[0], head[2]) == (Opcode.MESSAGE, channel, t_ns)
                assert chunk.message_start_time <= t_ns <= chunk.message_end_time
                found += 1
    assert found == summary.statistics.message_count


def test_the_summary_stands_where_the_footer_says_and_its_sum_is_right(log):
    data = log.read_bytes()
    begin, offsets, crc = struct.unpack("<QQI", data[-28:-8])
    assert data[-37] == Opcode.FOOTER
    assert data[begin - 13] == Opcode.DATA_END
    assert crc == zlib.crc32(data[begin:-12])
    at = begin
    while offsets < len(data) - 37:
        group, start, length = struct.unpack_from("<BQQ", data, offsets + 9)
        assert (data[offsets], start, data[start]) == (Opcode.SUMMARY_OFFSET, at, group)
        at, offsets = start + length, offsets + 9 + 17
    assert data[at] == Opcode.SUMMARY_OFFSET


def test_everything_is_decoded_as_it_was_published(log, flown):
    with log.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        found = {}
        for _, channel, message, decoded in reader.iter_decoded_messages(log_time_order=False):
            found.setdefault(channel.topic, []).append((message, decoded))
    by_number = {topic.id: topic for topic in flown.topics}
    for topic in flown.topics:
        sent = [
            (sampled.published, by_number[number].unpack(payload))
            for sampled in flown.samples
            for number, payload in sampled.published.payloads
            if number == topic.id
        ]
        name = "/tf" if topic.name.endswith("/frames") else topic.name
        got = found.get(name, [])
        assert len(got) == len(sent), name
        for (published, values), (message, decoded) in zip(sent, got, strict=True):
            assert message.log_time == published.t_ns
            assert message.publish_time == published.wall_ns
            for field, value in values.items():
                if decoded.__class__.__name__.endswith(("Data", "State", "Velocity", "Time")):
                    got_value = getattr(decoded, field)
                    sent_value = list(value) if isinstance(value, tuple) else value
                    assert repr(got_value) == repr(sent_value)  # NaN is NaN
    assert {f"/dh_drone/{name}_data" for name in PAPER.split()} <= found.keys()
    states = [decoded for _, decoded in found["/dh_drone/exact_state"]]
    got = [[*s.q_wb, *s.p_wb, *s.w_wb, *s.v_wb] for s in states]
    assert got == [list(sampled.state) for sampled in flown.samples]


def test_what_everybody_did_stands_with_its_step(log, flown):
    with log.open("rb") as file:
        reader = make_reader(file, decoder_factories=[DecoderFactory()])
        actions = [
            (decoded.step, decoded.by, json.loads(decoded.action))
            for *_, decoded in reader.iter_decoded_messages(topics=["/dh_drone/actions"])
        ]
    assert actions == [
        (296, "operator", {"velocity": [1.0, 0.1, 1 / 3]}),
        (304, "operator", {"yaw_rate": 0.3, "set": {"kp_velocity_x": 5.1}}),
        (
            896,
            "operator",
            {"push": {"force": [1.0, 0.0, 0.0], "point": [0.0, 0.0, 0.0], "duration": 0.1}},
        ),
        (1000, "operator", {"request": "land"}),
    ]


def test_scenario_gains_topics_and_versions_stand_at_the_beginning(log, flown, tmp_path):
    with log.open("rb") as file:
        reader = make_reader(file)
        attached = {each.name: each.data for each in reader.iter_attachments()}
        metadata = {each.name: each.metadata for each in reader.iter_metadata()}
        summary = reader.get_summary()
    begin = min(chunk.chunk_start_offset for chunk in summary.chunk_indexes)
    assert all(index.offset < begin for index in summary.attachment_indexes)
    assert all(index.offset < begin for index in summary.metadata_indexes)
    for name, data in attached.items():
        (tmp_path / name).write_bytes(data)
    assert load_scenario(tmp_path / "scenario.yaml") == flown.scenario
    gains = load_gains(tmp_path / "gains.yaml")
    assert (gains.vehicle, dict(gains.gains)) == (flown.vehicle, flown.values)
    topics = tuple(map(topic_from, json.loads(attached["topics.json"])))
    assert [topic.name for topic in topics] == [topic.name for topic in flown.topics]
    assert metadata["settings"] == {"kp_velocity_z": "3.7"}
    assert set(metadata["versions"]) == {
        "physics",
        "workbench",
        "drake",
        "numpy",
        "numba",
        "python",
        "platform",
    }


LIMIT = '<limit lower="-1" upper="1" effort="9" velocity="9"/>'


def test_joints_in_a_log_have_the_unit_of_their_own_motion(tmp_path):
    """One turns and one slides, so no unit of a whole field says it."""
    parts = (
        joint("swing", "revolute", "base", "arm", more=LIMIT)
        + link("arm", 0.1)
        + joint("leg", "prismatic", "base", "foot", more=LIMIT)
        + link("foot", 0.1)
    )
    scenario = Scenario(vehicle=VehicleConfig(model=drone(tmp_path, parts)), duration=0.25)
    flight = LoggedFlight(tmp_path / "a.mcap", scenario, {})
    flight.run(lambda share: None)
    wanted = {
        "position": {"swing": "rad", "leg": "m"},
        "velocity": {"swing": "rad/s", "leg": "m/s"},
    }
    found = read_flight(tmp_path / "a.mcap").signals
    for field, units in wanted.items():
        for name, unit in units.items():
            assert found[f"joint_states.{field}.{name}"].unit == unit
    shown = open_log(tmp_path / "a.mcap").signals
    units = {shown[f"joint_states.name.{k}"].values[0]: k for k in range(2)}
    assert shown[f"joint_states.position.{units['swing']}"].unit == "rad"
    assert shown[f"joint_states.position.{units['leg']}"].unit == "m"


def test_files_of_a_scenario_are_named_from_the_root(flown, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    Path("my_world.yaml").write_text("obstacles: []\n")
    log = FlightLog(Path("a.mcap"), (), Scenario(world="my_world.yaml"), {}, {}, "x")
    log.close()
    found = yaml.safe_load(read_log(Path("a.mcap")).scenario_text)
    assert found["world"] == str(tmp_path / "my_world.yaml")


def test_the_scenario_of_a_log_states_what_differs_from_the_defaults():
    """Actions, too; numbers of numpy are numbers, and a reader gets the same scenario."""
    script = [
        Action(at=np.float64(0.5), velocity=[np.float64(0.1), 0.0, 0.0]),
        Action(at=1.0, push=Push(force=[1.0, 0.0, 0.0])),
        Action(),
    ]
    scenario = Scenario(script=script)
    text = scenario_text(scenario)
    assert yaml.safe_load(text) == {
        "script": [
            {"at": 0.5, "velocity": [0.1, 0.0, 0.0]},
            {"at": 1.0, "push": {"force": [1.0, 0.0, 0.0]}},
            {},
        ]
    }
    assert parse_scenario(Path("scenario.yaml"), text) == scenario


def test_chunks_are_of_64_to_256_kilobytes(log):
    with log.open("rb") as file:
        chunks = make_reader(file).get_summary().chunk_indexes
    assert 64_000 <= MCAP_CHUNK_BYTES <= 256_000
    assert all(MCAP_CHUNK_BYTES <= chunk.uncompressed_size <= 256_000 for chunk in chunks[:-1])


WRITER = """
import pickle, sys
from pathlib import Path
from workbench.logs.flight_log import FlightLog
flown, path = pickle.load(sys.stdin.buffer), Path(sys.argv[1])
log = FlightLog(path, *flown[:5])
for sampled in flown[5]:
    log.write(sampled)
print(len(flown[5]), flush=True)
sys.stdin.buffer.read()
"""


def test_a_log_after_sigkill_is_readable_but_for_the_last_chunk(flown, tmp_path):
    path = tmp_path / "killed.mcap"
    given = (flown.topics, flown.scenario, {}, flown.values, flown.vehicle, flown.samples)
    writer = subprocess.Popen(
        [sys.executable, "-c", WRITER, path],
        cwd=ROOT,
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
    )
    try:
        writer.stdin.write(pickle.dumps(given))
        writer.stdin.flush()
        assert int(writer.stdout.readline()) == len(flown.samples)
    finally:
        os.kill(writer.pid, signal.SIGKILL)
        writer.communicate(timeout=60)
    record = read_log(path)
    assert "was not closed" in record.remark
    states = np.array([sampled.state for sampled in flown.samples])
    kept = len(record.states)
    assert record.states.tobytes() == states[:kept].tobytes()
    # what is missing fills less than a chunk, even without what stands around the messages
    missing = [p for s in flown.samples[kept + 1 :] for _, p in s.published.payloads]
    assert 0 < kept < len(states)
    assert sum(map(len, missing)) < MCAP_CHUNK_BYTES


FULL = """
import logging, pickle, resource, signal, sys
from pathlib import Path
from workbench.logs.flight_log import FlightLog
logging.basicConfig(format="%(message)s")
flown, path = pickle.load(sys.stdin.buffer), Path(sys.argv[1])
signal.signal(signal.SIGXFSZ, signal.SIG_IGN)
resource.setrlimit(resource.RLIMIT_FSIZE, (int(sys.argv[2]), resource.RLIM_INFINITY))
log = FlightLog(path, *flown[:5])
for sampled in flown[5]:
    log.write(sampled)
log.act(1.0, None, "nobody")
log.close()
log.close()
"""


def run_full(flown, path: Path, size: int) -> subprocess.CompletedProcess:
    """Write a log where a file may have so many bytes: that is what a full disk looks like."""
    given = (flown.topics, flown.scenario, {}, flown.values, flown.vehicle, flown.samples)
    return subprocess.run(
        [sys.executable, "-B", "-c", FULL, path, str(size)],  # no half module either
        cwd=ROOT,
        input=pickle.dumps(given),
        capture_output=True,
    )


def test_a_full_disk_ends_the_log_and_not_the_flight(flown, log, tmp_path):
    path = tmp_path / "full.mcap"
    size = log.stat().st_size * 2 // 3
    done = run_full(flown, path, size)
    assert done.returncode == 0, done.stderr.decode()
    said = done.stderr.decode().splitlines()
    assert len(said) == 1
    assert "the log ends at" in said[0] and "the flight continues without it" in said[0]
    record = read_log(path)
    assert "was not closed" in record.remark
    kept = len(record.states)
    assert 0 < kept < len(flown.samples)
    assert path.stat().st_size < size  # what was half written is cut off
    assert record.states.tolist() == [list(s.state) for s in flown.samples[:kept]]


def test_a_disk_that_is_full_at_once_is_a_sentence(flown, tmp_path):
    done = run_full(flown, tmp_path / "full.mcap", 1000)
    assert b"WorkbenchError" in done.stderr.splitlines()[-1]
    assert b"full.mcap: cannot be written" in done.stderr


def test_the_limit_is_that_of_the_other_process_only():
    assert resource.getrlimit(resource.RLIMIT_FSIZE)[0] == resource.RLIM_INFINITY


def test_a_payload_that_is_none_ends_the_log_once(flown, tmp_path, caplog):
    log = FlightLog(
        tmp_path / "a.mcap", flown.topics, flown.scenario, {}, flown.values, flown.vehicle
    )
    log.write(flown.samples[3])
    bad = Sampled(Published(30_000_000, 0, ((flown.topics[0].id, b"?"),)), (0.0,) * 13)
    for _ in range(3):
        log.write(bad)
        log.write(flown.samples[1])
    log.close()
    assert [record.getMessage() for record in caplog.records] == [log.said]
    assert f"a.mcap: the log ends at {flown.samples[3].published.t_ns * 1e-9:.3f} s: " in log.said
    assert "does not fit" in log.said


def test_events_between_samples_are_written(flown, tmp_path):
    path = tmp_path / "a.mcap"
    log = FlightLog(path, flown.topics, flown.scenario, {}, flown.values, flown.vehicle)
    topic = next(topic for topic in flown.topics if topic.name.endswith("/events"))
    log.publish(Published(12_000_000, 1, ((topic.id, topic.pack([2, "a rotor stopped"])),)))
    log.close()
    record = read_log(path)
    assert log.said == record.remark == ""
    assert record.flight["events.said"].values.tolist() == ["a rotor stopped"]
    assert record.flight["events.severity"].time.tolist() == [0.012]


def test_nothing_is_written_after_close(write, flown):
    path = write()
    size = path.stat().st_size
    log = FlightLog(path, flown.topics, flown.scenario, {}, flown.values, flown.vehicle)
    log.close()
    small = path.stat().st_size
    log.write(flown.samples[0])
    log.act(0.0, flown.done[0], "operator")
    log.close()
    assert small == path.stat().st_size < size


def test_an_older_log_is_overwritten_and_nothing_else(flown, tmp_path, write):
    def begin(path):
        FlightLog(path, (), Scenario(), {}, {}, "x").close()

    begin(write())
    notes = tmp_path / "notes.txt"
    notes.write_text("important")
    with pytest.raises(WorkbenchError, match=r"notes\.txt: is not a log, and is not overwritten"):
        begin(notes)
    assert notes.read_text() == "important"
    with pytest.raises(WorkbenchError, match="is a folder"):
        begin(tmp_path)
    with pytest.raises(WorkbenchError, match="there is no folder"):
        begin(tmp_path / "no" / "a.mcap")
    (tmp_path / "empty.mcap").touch()
    begin(tmp_path / "empty.mcap")


def test_a_writer_that_fails_at_its_start_says_where(tmp_path, monkeypatch):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(mcap_writer.McapWriter, "add_attachment", full)
    with pytest.raises(WorkbenchError, match=r"a\.mcap: cannot be written: No space left"):
        FlightLog(tmp_path / "a.mcap", (), Scenario(), {}, {}, "x")


@pytest.mark.parametrize("moved", [False, True])
def test_a_log_whose_file_is_gone_is_told_and_the_flight_goes_on(tmp_path, monkeypatch, moved):
    """What is written to a deleted file is lost without any error; one that was moved is whole."""
    monkeypatch.setattr(flight_log, "FILE_CHECK_PERIOD_S", 0.0)
    path, other = tmp_path / "flight.mcap", tmp_path / "other.mcap"
    flight = LoggedFlight(path, Scenario(duration=1.0), {})

    def lose(share):
        if share >= 0.5 and path.exists():
            path.rename(other) if moved else path.unlink()

    flight.run(lose)
    assert flight.session.time == pytest.approx(1.0)
    assert flight.said.startswith(f"{path}: the log ends at ")
    assert "moved or deleted" in flight.said
    assert not path.exists()
    if moved:
        assert other.read_bytes().endswith(MCAP0_MAGIC)
        assert read_log(other).scenario().duration == 1.0


def test_a_log_whose_file_is_gone_when_it_is_ended_is_told(tmp_path):
    path = tmp_path / "flight.mcap"
    flight = LoggedFlight(path, Scenario(duration=0.1), {})
    path.unlink()
    path.write_text("another file")
    flight.run(lambda share: None)
    assert "moved or deleted" in flight.said
    assert path.read_text() == "another file"


@pytest.mark.parametrize("look", [0.0, 1e9])
def test_a_log_that_another_program_shortens_is_told_and_has_no_gap(tmp_path, monkeypatch, look):
    """A write goes to where the last one ended: zeros before it would hide what is behind them."""
    monkeypatch.setattr(flight_log, "FILE_CHECK_PERIOD_S", look)
    path = tmp_path / "flight.mcap"
    flight, cut = LoggedFlight(path, Scenario(duration=2.0), {}), []

    def shorten(share):
        if share >= 0.5 and not cut:
            cut.append(path.stat().st_size * 3 // 4)
            os.truncate(path, cut[0])

    flight.run(shorten)
    assert flight.session.time == pytest.approx(2.0)
    assert flight.said.startswith(f"{path}: the log ends at ")
    assert "another program has shortened or overwritten the file" in flight.said
    assert path.stat().st_size == cut[0]
    assert "was not closed" in read_log(path).remark

"""A log read again, whole, cut short or damaged."""

import random
import re
import struct

import numpy as np
import pytest
import zstandard
from mcap.opcode import Opcode
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC, CompressionType, Writer

from workbench.common.errors import WorkbenchError
from workbench.logs.contents import GAINS_ATTACHMENT, SCENARIO_ATTACHMENT
from workbench.logs.record import LogRecord, read_log

pytestmark = pytest.mark.usefixtures("unheld")


@pytest.fixture(scope="module")
def record(log) -> LogRecord:
    return read_log(log)


@pytest.fixture
def read(tmp_path):
    """Read bytes as a log."""

    def read_bytes(data: bytes) -> LogRecord:
        path = tmp_path / "some.mcap"
        path.write_bytes(data)
        return read_log(path)

    return read_bytes


def test_a_record_has_what_was_flown(record, flown):
    assert record.remark == ""
    assert record.vehicle == "dh_drone"
    assert record.physics_step == 1 / 1024
    assert record.scenario() == flown.scenario
    assert record.settings == flown.settings
    assert record.values == flown.values
    assert [done.action for done in record.done] == flown.done
    assert {done.by for done in record.done} == {"operator"}
    assert record.states.tolist() == [list(sampled.state) for sampled in flown.samples]
    assert record.duration == pytest.approx(flown.samples[-1].published.t_ns * 1e-9)


def test_series_are_what_was_published(record, flown):
    velocity = next(topic for topic in flown.topics if topic.name.endswith("velocity_data"))
    sent = [
        (sampled.published.t_ns * 1e-9, velocity.unpack(payload)["v_z"])
        for sampled in flown.samples
        for number, payload in sampled.published.payloads
        if number == velocity.id
    ]
    series = record.flight["velocity_data.v_z"]
    assert series.unit == "m/s"
    assert np.column_stack([series.time, series.values]).tolist() == [list(row) for row in sent]


def test_texts_of_several_lengths_and_arrays_are_series(record):
    modes = record.flight["drone_state.condition"].values
    assert {"hovering", "cruising", "landing"} & set(modes)
    assert len(set(map(len, modes))) > 1
    charge = record.flight["drone_state.charge"].values
    assert len(charge) == len(modes) and 0.9 < charge[-1] < charge[0] <= 1.0
    assert [series.name for series in record.flight.several("rotors.thrust")] == [
        f"rotors.thrust.{index}" for index in range(4)
    ]
    assert record.flight["gps.latitude"].unit == "deg"
    field = record.flight["magnetometer.magnetic_field.z"]
    assert field.unit == "T" and -45e-6 < field.values.mean() < -43e-6


def test_all_names_are_series(record):
    names = record.flight.names()
    assert len(names) == len(set(names)) > 100
    for name in names:
        series = record.flight[name]
        assert series.time.shape == series.values.shape, name


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("velocity_data.vx", "did you mean 'v_x'"),
        ("velocity_dat.v_x", "did you mean 'velocity_data'"),
        ("rotors.thrusts", "did you mean 'thrust."),
    ],
)
def test_an_unknown_field_names_near_ones(record, name, said):
    with pytest.raises(WorkbenchError, match="velocity_data|rotors") as caught:
        record.flight.several(name)
    assert said in str(caught.value)


def test_a_log_cut_at_any_byte_is_read_as_far_as_it_goes(log, flown, read):
    data = log.read_bytes()
    dice = random.Random(1)
    cuts = {
        *range(0, 30),
        *range(len(data) - 30, len(data)),
        *dice.choices(range(len(data)), k=50),
    }
    states = np.array([sampled.state for sampled in flown.samples])
    kept = {}
    for cut in sorted(cuts):
        try:
            record = read(data[:cut])
        except WorkbenchError as error:
            assert "\n" not in str(error)
            kept[cut] = -1
            continue
        kept[cut] = len(record.states)
        assert record.states.tobytes() == states[: kept[cut]].tobytes(), cut
        assert record.remark == "" or "was not closed" in record.remark
        if (ended := re.search(r"ends at ([0-9.]+) s", record.remark)) and kept[cut]:
            last = flown.samples[kept[cut] - 1].published.t_ns * 1e-9
            assert last - 5.01e-4 <= float(ended[1]) < last + 1 / 128  # a sensor may come later
        assert "damaged" not in record.remark
    counts = [count for _, count in sorted(kept.items())]
    assert counts == sorted(counts), "a longer file has no less"
    assert counts[-1] == len(states)
    assert 0 in counts and len(set(counts)) > 3


def test_a_damaged_log_is_a_sentence_or_has_right_states(log, flown, read):
    data = log.read_bytes()
    dice = random.Random(2)
    known = {np.array(sampled.state).tobytes() for sampled in flown.samples}
    for _ in range(40):
        hurt = bytearray(data)
        for _ in range(dice.choice((1, 1, 4))):
            hurt[dice.randrange(len(hurt))] ^= 1 << dice.randrange(8)
        try:
            record = read(bytes(hurt))
            record.flight.names()
            states, _ = record.states, record.done
        except WorkbenchError:
            continue
        assert {row.tobytes() for row in states} <= known


def test_damage_is_told(log, read):
    data = bytearray(log.read_bytes())
    with log.open("rb") as file:
        first, *_ = make_reader(file).get_summary().chunk_indexes
    data[first.chunk_start_offset + first.chunk_length // 2] ^= 255
    record = read(bytes(data))
    assert record.remark == "1 damaged parts were left out"
    assert len(record.states) > 0


@pytest.mark.parametrize(
    ("data", "said"),
    [
        (b"", "is empty"),
        (b"t,v\n1,2\n", "is not an MCAP file"),
        (MCAP0_MAGIC, "nothing can be read"),
        (MCAP0_MAGIC + bytes(200), "nothing can be read"),
        (MCAP0_MAGIC + b"\xff" * 200, "nothing can be read"),
    ],
)
def test_what_is_no_log_is_refused(read, data, said):
    with pytest.raises(WorkbenchError, match="some.mcap") as caught:
        read(data)
    assert said in str(caught.value)


def test_a_log_of_another_program_is_refused(tmp_path):
    path = tmp_path / "other.mcap"
    with path.open("wb") as file:
        writer = Writer(file)
        writer.start()
        writer.finish()
    with pytest.raises(WorkbenchError, match="but not a log of the workbench"):
        read_log(path)


def test_a_folder_and_a_missing_file_are_refused(tmp_path):
    with pytest.raises(WorkbenchError, match="is a folder"):
        read_log(tmp_path)
    with pytest.raises(WorkbenchError, match="no such file"):
        read_log(tmp_path / "none.mcap")


def remade(log, path, *, attached=None, topic="/dh_drone/wind", t_ns=0, chunk=b"") -> LogRecord:
    """Write a log again with something else in it, and read it."""
    with log.open("rb") as file, path.open("wb") as other:
        reader, writer = make_reader(file), Writer(other, 4096, CompressionType.ZSTD)
        writer.start("ros2", "test")
        for each in reader.iter_metadata():
            writer.add_metadata(each.name, each.metadata)
        for each in reader.iter_attachments():
            data = (attached or {}).get(each.name, each.data)
            writer.add_attachment(0, 0, each.name, each.media_type, data)
        for schema, channel, message in reader.iter_messages():
            if channel.topic != "/dh_drone/wind":
                continue
            new = writer.register_schema(schema.name, schema.encoding, schema.data)
            number = writer.register_channel(topic, channel.message_encoding, new)
            for time in (0, t_ns):
                writer.add_message(number, time, message.data, 0)
            break
        writer.finish()
    if chunk:
        data = path.read_bytes()
        path.write_bytes(data[: len(MCAP0_MAGIC)] + chunk + data[len(MCAP0_MAGIC) :])
    return read_log(path)


def test_what_no_log_of_ours_has_is_left_out_and_told(log, tmp_path, case):
    assert len(remade(log, tmp_path / "a.mcap", t_ns=10**9).flight["wind.wind.0"].time) == 2
    for what, left, changes in (
        ("beyond 64 bits with a sign", 1, {"t_ns": 2**63}),
        ("beyond any flight", 1, {"t_ns": 2**62}),
        ("a NUL in a topic", 0, {"topic": "/dh_drone/wi\0nd"}),
        ("a path as a topic", 0, {"topic": "/../../etc"}),
        ("a newline in a topic", 0, {"topic": "/a\nb"}),
        ("a chunk of a frame that states 3 GB", 2, {"chunk": zstd_chunk(1000, 3 * 10**9)}),
        ("a chunk that states 3 GB", 2, {"chunk": zstd_chunk(3 * 10**9, None)}),
    ):
        with case(what):
            record = remade(log, tmp_path / "a.mcap", **changes)
            assert sum(len(topic.t_ns) for topic in record.topics.values()) == left
            assert record.remark[1:] == " damaged parts were left out"


def test_attachments_that_cannot_be_read_are_sentences(log, tmp_path, case):
    deep, bomb = b"[" * 100_000, b"a: &a [1, 1]\nb: [*a, *a]\n"
    for what, data, said in (
        ("a character that YAML has not", b"title: \0", "its scenario cannot be read"),
        ("no mapping", b"- 1", "its scenario cannot be read"),
        ("aliases", bomb, "a.mcap/scenario.yaml:2: has an alias"),
        ("nested", deep, "is nested more than"),
        ("too long", b"#" * 2_000_000, "has more than 1 MB"),
    ):
        with case(what):
            record = remade(log, tmp_path / "a.mcap", attached={SCENARIO_ATTACHMENT: data})
            with pytest.raises(WorkbenchError, match=said) as caught:
                record.scenario()
            assert "\n" not in str(caught.value) and str(caught.value).startswith(str(tmp_path))
    with pytest.raises(WorkbenchError, match="a.mcap/gains.yaml:1: is nested more than"):
        remade(log, tmp_path / "a.mcap", attached={GAINS_ATTACHMENT: deep})
    for name, data in (
        (GAINS_ATTACHMENT, b"\0"),
        (GAINS_ATTACHMENT, b"gains: {a: x}"),
        (SCENARIO_ATTACHMENT, b"\xff"),
    ):
        with case((name, data[:9])), pytest.raises(WorkbenchError, match="not a log of the workbe"):
            remade(log, tmp_path / "a.mcap", attached={name: data})


def zstd_chunk(size: int, stated: int | None) -> bytes:
    """Return a chunk of zeros that states a size, with a frame that states another one."""
    parameters = zstandard.ZstdCompressionParameters(write_content_size=False)
    packed = zstandard.ZstdCompressor(compression_params=parameters).compress(bytes(1000))
    if stated is not None:  # RFC 8878: eight bytes for the size, in one segment
        packed = packed[:4] + bytes([0xE0]) + struct.pack("<Q", stated) + packed[6:]
    body = struct.pack("<QQQII", 0, 0, size, 0, 4) + b"zstd" + struct.pack("<Q", len(packed))
    return struct.pack("<BQ", Opcode.CHUNK, len(body) + len(packed)) + body + packed

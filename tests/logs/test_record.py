"""A log read again, whole, cut short or damaged."""

import random

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap.writer import MCAP0_MAGIC, Writer

from workbench.common.errors import WorkbenchError
from workbench.logs.record import LogRecord, read_log


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
    series = record.series("velocity_data.v_z")
    assert series.unit == "m/s"
    assert np.column_stack([series.time, series.values]).tolist() == [list(row) for row in sent]
    assert record.series("/dh_drone/velocity_data.v_z") is series


def test_texts_of_several_lengths_and_arrays_are_series(record):
    modes = record.series("drone_state.condition").values
    assert {"hovering", "cruising", "landing"} & set(modes)
    assert len(set(map(len, modes))) > 1
    charge = record.series("drone_state.charge").values
    assert len(charge) == len(modes) and 0.9 < charge[-1] < charge[0] <= 1.0
    assert [series.name for series in record.several("rotors.thrust")] == [
        f"rotors.thrust.{index}" for index in range(4)
    ]
    assert record.series("gps.latitude").unit == "deg"
    field = record.series("magnetometer.magnetic_field.z")
    assert field.unit == "T" and -45e-6 < field.values.mean() < -43e-6


def test_all_names_are_series(record):
    names = record.names()
    assert len(names) == len(set(names)) > 100
    for name in names:
        series = record.series(name)
        assert series.time.shape == series.values.shape, name


@pytest.mark.parametrize(
    ("name", "said"),
    [
        ("velocity_data.vx", "did you mean 'v_x'"),
        ("velocity_dat.v_x", "did you mean 'velocity_data'"),
        ("rotors.thrust", "has 4 fields: name one, as rotors.thrust.0"),
        ("velocity_data", "has 6 fields"),
    ],
)
def test_an_unknown_field_names_near_ones(record, name, said):
    with pytest.raises(WorkbenchError, match="velocity_data|rotors") as caught:
        record.series(name)
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
            record.names()
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

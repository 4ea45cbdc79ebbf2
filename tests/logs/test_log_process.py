"""A log is read in a held process, whose answer is as foreign as the log."""

import errno
import gzip
import json
import threading
from pathlib import Path

import numpy as np
import pytest
from mcap.writer import MCAP0_MAGIC

from tests.logs.test_record import zstd_chunk
from workbench.common.errors import WorkbenchError
from workbench.logs import log_child, log_process
from workbench.logs.array_files import MAX_ARRAY_FILE_BYTES, ArrayReader, ArrayWriter
from workbench.logs.flight_reader import open_log, read_flight
from workbench.logs.readers import log_reader
from workbench.logs.readers.log_reader import LogReader
from workbench.logs.record import read_log
from workbench.logs.replay import replay


@pytest.fixture
def asked(monkeypatch):
    """Note the arguments of `run_limited`, and go on as before."""
    found, run = [], log_process.run_limited

    def noted(module, request, **limits):
        found.append({"module": module, "request": request, **limits})
        return run(module, request, **limits)

    monkeypatch.setattr(log_process, "run_limited", noted)
    return found


def answering(monkeypatch, answer):
    """Let the process answer what a function makes of the request."""
    monkeypatch.setattr(
        log_process, "run_limited", lambda module, request, **limits: answer(request)
    )


def test_every_log_is_read_by_a_process_that_may_read_its_files_alone(
    log, asked, case, monkeypatch
):
    reader = LogReader("made", "made", lambda *_: False, lambda _: None, 1, companions=("-a.txt",))
    monkeypatch.setattr(log_reader, "log_readers", lambda: (reader,))
    for read, file, beside in (
        (read_log, log, []),
        (read_flight, log, ["flight-a.txt"]),
        (open_log, str(log), ["flight-a.txt"]),
    ):
        with case(file):
            read(file)
            (said,) = asked
            asked.clear()
            path = Path(file)
            assert said["module"] == "workbench.logs.log_child"
            assert said["reads"] == [path, *map(path.with_name, beside)]
            assert said["writes"] == [said["request"]["folder"]]
            assert said["seconds"] <= 5 and said["megabytes"] <= 512


def test_a_compressed_file_may_take_twice_as_much_as_a_plain_one(tmp_path, monkeypatch):
    """3 s and 4 s per megabyte, of which a compressed file counts double."""
    allowed = []

    def refuse(module, request, *, seconds, **limits):
        allowed.append(seconds)
        raise log_process.LimitedError("enough")

    monkeypatch.setattr(log_process, "run_limited", refuse)
    for start in (b"plain", b"\x1f\x8b"):
        path = tmp_path / "a.mcap"
        path.write_bytes(start + bytes(2_000_000 - len(start)))
        with pytest.raises(WorkbenchError, match="enough"):
            read_log(path)
    assert allowed == [11.0, 19.0]


def test_a_log_of_another_process_replays_to_the_bit(log):
    assert replay(read_log(log)).equal


@pytest.mark.usefixtures("unheld")
def test_a_compressed_log_is_the_log(log, tmp_path, case):
    for name, data in {"a.mcap": log.read_bytes()}.items():
        with case(name):
            plain, packed = tmp_path / name, tmp_path / f"{name}.gz"
            plain.write_bytes(data)
            packed.write_bytes(gzip.compress(data))
            one, other = read_flight(plain), read_flight(packed)
            assert (other.name, other.remarks, other.source) == (one.name, one.remarks, packed)
            assert other.parameters == one.parameters
            for signal in one.signals.values():
                assert other[signal.name].values.tobytes() == signal.values.tobytes()
            packed.write_bytes(gzip.compress(data)[: len(gzip.compress(data)) * 2 // 3])
            assert "it was cut" in read_flight(packed).remarks[0]
            packed.write_bytes(gzip.compress(data[:20]))
            with pytest.raises(WorkbenchError, match=rf"{name}\.gz: ") as caught:
                read_flight(packed)
            assert "unpacked" not in str(caught.value)


def test_progress_is_told_while_the_process_works(log, monkeypatch):
    heard, half = [], threading.Event()

    def answer(request):
        (Path(request["folder"]) / "progress").write_bytes(bytes(50))
        assert half.wait(60.0)
        (Path(request["folder"]) / "progress").unlink()
        return json.loads(json.dumps(log_child.read_to_arrays(request)))

    def tell(share):
        heard.append(share)
        if share == 0.5:
            half.set()

    answering(monkeypatch, answer)
    read_log(log, tell)
    assert {0.5, 1.0} <= set(heard) and heard[-1] == 1.0


def test_an_answer_that_is_no_log_is_a_sentence(log, monkeypatch, case):
    good = {}

    def keep(request):
        good.update(json.loads(json.dumps(log_child.read_to_arrays(request))))
        return good

    answering(monkeypatch, keep)
    record = read_log(log)
    imu = next(each for each in good["log"]["topics"] if each["name"].endswith("/imu"))

    def spoilt(**changes):
        topics = [imu | changes]
        return {"log": good["log"] | {"topics": topics}}

    kind, count, at = imu["t_ns"]
    for name, said in {
        "nothing": {},
        "no table": {"log": []},
        "no texts": {"log": good["log"] | {"laws": 3}},
        "no number": {"log": good["log"] | {"physics_step": "x"}},
        "objects": spoilt(t_ns=["|O", 1, 0]),
        "too many": spoilt(t_ns=[kind, 10**15, at]),
        "beyond the end": spoilt(t_ns=[kind, count, at + 10**9]),
        "before the beginning": spoilt(t_ns=[kind, count, -8]),
        "no count": spoilt(t_ns=[kind, "x", at]),
        "one too few": spoilt(t_ns=[kind, count - 1, at]),
        "no place": spoilt(stamps_ns=7),
        "points without clouds": spoilt(sizes=[kind, count, at], cloud=None),
    }.items():

        def wrong(request, said=said):
            log_child.read_to_arrays(request)
            return said

        with case(name):
            answering(monkeypatch, wrong)
            with pytest.raises(WorkbenchError, match="answered what is no log") as caught:
                read_log(log)
            assert "\n" not in str(caught.value)
    assert record.duration > 0.0


def test_arrays_come_back_as_they_were(tmp_path, monkeypatch):
    monkeypatch.setattr("workbench.logs.array_files.MAX_ARRAY_FILE_BYTES", 100)
    rng = np.random.default_rng(5)
    given = [
        rng.standard_normal(77),
        np.arange(9, dtype=np.uint8),
        np.array([True, False]),
        np.array([-(2**63), 2**63 - 1]),
        np.zeros(0),
        np.array(["a", "", "ü", "a"], dtype=object),
        np.zeros(0, dtype=object),
        np.arange(20.0)[::2],
    ]
    writer = ArrayWriter(tmp_path)
    places = json.loads(json.dumps([writer.add(each) for each in [*given, given[0]]]))
    assert places[0] == places[-1]
    assert all(file.stat().st_size <= 100 for file in tmp_path.iterdir())
    reader = ArrayReader(tmp_path)
    for one, place in zip(given, places, strict=False):
        other = reader.get(place)
        assert other.tolist() == one.tolist() and other.dtype == one.dtype
    assert reader.get(places[-1]) is reader.get(places[0])
    assert MAX_ARRAY_FILE_BYTES < 128_000_000  # the largest file of a held process


def test_a_chunk_that_states_too_much_costs_no_more_than_itself(log, tmp_path):
    """In the limits of a small file: zstandard reserves what a frame states."""
    data, path = log.read_bytes(), tmp_path / "a.mcap"
    at = len(MCAP0_MAGIC)
    path.write_bytes(data[:at] + zstd_chunk(1000, 3 * 10**9) + data[at:])
    record, whole = read_log(path), read_log(log)
    assert record.remark == "1 damaged parts were left out"
    assert record.states.tobytes() == whole.states.tobytes()


def test_a_full_folder_for_temporary_files_is_said(log, monkeypatch):
    """Python looks for one that takes a file, and raises if none does."""

    def none_is_usable(*_):
        raise FileNotFoundError(errno.ENOENT, "No usable temporary directory found")

    monkeypatch.setattr(log_process, "TemporaryDirectory", none_is_usable)
    with pytest.raises(WorkbenchError, match="No usable temporary .* set TMPDIR"):
        read_flight(log)

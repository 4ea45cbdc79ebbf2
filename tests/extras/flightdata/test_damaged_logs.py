"""Readers of logs that others wrote, on damaged copies: a flight or a sentence, in bounds."""

import json
import math
import os
import random
import resource
import signal
import struct
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.extras.flightdata.foreign_files import blackbox, dataflash, ulog
from tests.extras.flightdata.test_readers import MAPPING, SHARED, made_up_blackbox, real, usd_log
from tests.extras.flightdata.tlog_writer import ATTITUDE, frame, tlog
from workbench.common.errors import WorkbenchError
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.extras.flightdata.importing import write_flight
from workbench.extras.flightdata.readers.blackbox import read_blackbox
from workbench.extras.flightdata.readers.dataflash import read_dataflash
from workbench.extras.flightdata.readers.ulog import read_ulog
from workbench.logs.flight_contents import contents_of_flight
from workbench.logs.flight_reader import read_flight
from workbench.logs.imported import imported_flight, signal_topics
from workbench.logs.readers.log_reader import LogFile, log_readers
from workbench.logs.record import read_log

LIBRARY_READERS = {each.format: each for each in log_readers() if each.needs_plain}
FEW, FEWER = 40, 3
"""Copies of each, and where each takes a process; `test_mutated_files.py` reads many."""
SECONDS, MEGABYTES = 4, 3000
"""That reading one may take."""


def damaged(data: bytes, seed: int) -> bytes:
    """Return a copy that is cut, swapped, overwritten, drawn out or has huge numbers."""
    chance = random.Random(seed)
    copy = bytearray(data)
    for _ in range(chance.randint(1, 4)):
        if not copy:
            break
        at = chance.randrange(len(copy))
        size = chance.randint(1, min(64, len(copy) - at))
        kind = chance.randrange(7)
        if kind == 0:
            del copy[at:]
        elif kind == 1:
            other = chance.randrange(len(copy))
            copy[at : at + size], copy[other : other + size] = (
                copy[other : other + size],
                copy[at : at + size],
            )
        elif kind == 2:
            copy[at : at + size] = chance.randbytes(size)
        elif kind == 3:
            copy[at : at + 8] = struct.pack("<Q", chance.choice((2**64 - 1, 2**63, 0, 10**15)))
        elif kind == 4:
            copy[at:at] = copy[at : at + size] * chance.randint(1, 2000)
        elif kind == 5:
            copy[at] ^= 1 << chance.randrange(8)
        else:
            del copy[at : at + size]
    return bytes(copy)


def copies(data: bytes, count: int, path: Path) -> Iterator[int]:
    """Write damaged copies to a path, one after the other."""
    for seed in range(count):
        path.write_bytes(damaged(data, seed))
        yield seed


def own_formats(folder: Path) -> dict[str, bytes]:
    """Return small files of formats that are read in this process, by their names."""
    rows = [(1_000_000 + 1000 * i, 90.0 * np.sin(i), 1.0) for i in range(60)]
    time = np.arange(0.0, 3.0, 0.02)
    names = ("imu.angular_velocity.x", "estimate.x", "rotors.speed.0")
    signals = {name: make_series(name, "1", time, np.sin(time)) for name in names}
    write_flight(Flight("m", folder / "m", "made", signals, end=3.0), folder / "m.mcap")
    table = "t;gx;m1;v\n" + "".join(f"{10 * i};{i};{1000 + i};{11100 - i}\n" for i in range(80))
    return {"usd": usd_log(rows), "m.mcap": (folder / "m.mcap").read_bytes()} | {
        "own.csv": table.encode()
    }


def survive(data: bytes, count: int, path: Path, mapping: Path | None = None) -> int:
    """Read damaged copies, and return how many were flights."""
    flights = 0
    for seed in copies(data, count, path):
        try:
            contents_of_flight(read_flight(path, mapping))
            flights += 1
        except WorkbenchError as error:
            assert str(path) in str(error) or str(path.parent) in str(error), error
        except BaseException as failure:
            failure.add_note(f"of the copy {seed} of {path.name}")
            raise
    return flights


@pytest.mark.usefixtures("unheld")
def test_damaged_copies_give_a_flight_or_a_sentence(tmp_path, case):
    for name, data in own_formats(tmp_path).items():
        with case(name):  # a table needs a mapping
            assert (survive(data, FEW, tmp_path / name) > 0) == (name != "own.csv")
    mapping = tmp_path / "map.yaml"
    mapping.write_text(MAPPING)
    table = own_formats(tmp_path)["own.csv"]
    assert survive(table, FEW, tmp_path / "own.csv", mapping) > 0
    assert survive(MAPPING.encode(), FEW, mapping) == 0  # a mapping is no log
    (tmp_path / "own.csv").write_bytes(table)
    for _ in copies(MAPPING.encode(), FEW, mapping):
        try:
            read_flight(tmp_path / "own.csv", mapping)
        except WorkbenchError as error:
            assert str(tmp_path) in str(error)


@real
@pytest.mark.usefixtures("unheld")
def test_damaged_copies_of_real_logs(tmp_path, case):
    import gzip

    whole = gzip.decompress((SHARED / "nanobench/B2_circle_fast_rep1.csv.gz").read_bytes())
    table = b"\n".join(whole.splitlines()[:400])
    usd = (SHARED / "crazypad/motor_data/normal_flight/E9_log00").read_bytes()[:40_000]
    for name, data in (("n.csv", table), ("usd", usd), ("n.csv.gz", gzip.compress(table))):
        with case(name):
            assert survive(data, FEW // 4, tmp_path / name) > 0


def foreign() -> dict[str, bytes]:
    """Return small files of formats that libraries read, by the format."""
    attitudes = ((1000 + 10 * i, 0.01 * i, 0, 0, 0, 0, 0) for i in range(100))
    frames = [(10**15 + i, frame(ATTITUDE, each)) for i, each in enumerate(attitudes)]
    found = {
        "Betaflight blackbox log": made_up_blackbox(100),
        "MAVLink telemetry log": tlog(frames),
    }
    if SHARED.exists():
        # The head has the parameters and formats; cut there, a file is read as far as it goes.
        found["PX4 ULog"] = (SHARED / "px4_ulog/sample.ulg").read_bytes()[:150_000]
        found["ArduPilot DataFlash log"] = (SHARED / "ardupilot/test.BIN").read_bytes()
    return found


def test_damaged_copies_that_libraries_read(tmp_path, case):
    """In their processes, as they come: all that a library may do wrong becomes a sentence."""
    for kind, data in foreign().items():
        with case(kind):
            if package := LIBRARY_READERS[kind].package:
                pytest.importorskip(package)
            survive(data, FEWER, tmp_path / "some")


def test_a_log_that_pyulog_would_read_in_circles_is_a_sentence_at_once(tmp_path):
    """On this head pyulog goes back by more than it has read, for ever; on that one we counted."""
    pytest.importorskip("pyulog")
    data = foreign().get("PX4 ULog")
    if data is None:
        pytest.skip("put the real flights into ../shared/flights")
    path = tmp_path / "endless.ulg"
    for seed in (23, 105):  # the second says that it has four thousand million motors
        path.write_bytes(damaged(data, seed))
        assert _fork("PX4 ULog", path) in (0, 1), seed
    path.write_bytes(damaged(data, 23))
    with pytest.raises(WorkbenchError, match="ends beyond the end of the file"):
        read_flight(path)


def test_a_dataflash_log_whose_messages_lose_their_fields_is_read_up_to_there(tmp_path):
    """Two of the thousand copies: a definition is damaged, and a later message with it."""
    pytest.importorskip("pymavlink")
    data = foreign().get("ArduPilot DataFlash log")
    if data is None:
        pytest.skip("put the real flights into ../shared/flights")
    path = tmp_path / "damaged.bin"
    for seed in (446, 861):
        path.write_bytes(damaged(data, seed))
        assert "read up to there" in " ".join(read_flight(path).remarks), seed


def _fork(kind: str, path: Path) -> int:
    """Read a file in a fork; 0: a flight, 1: a sentence, 2: another exception, else a signal."""
    child = os.fork()
    if child:
        return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1])
    nowhere = os.open(os.devnull, os.O_WRONLY)
    os.dup2(nowhere, 1)
    os.dup2(nowhere, 2)
    resource.setrlimit(resource.RLIMIT_CPU, (SECONDS, SECONDS + 1))
    signal.signal(signal.SIGXCPU, signal.SIG_DFL)
    # of the memory beside what the fork has from its parent, which has run other tests
    own = int(Path("/proc/self/statm").read_text().split()[0]) * resource.getpagesize()
    resource.setrlimit(resource.RLIMIT_AS, (own + MEGABYTES * 10**6,) * 2)
    try:
        LIBRARY_READERS[kind].read(LogFile(path))
        os._exit(0)
    except WorkbenchError:
        os._exit(1)
    except BaseException:
        os._exit(2)


def test_a_field_that_would_be_a_huge_array_is_refused(tmp_path):
    """One of a hundred thousand copies asked for 3 GB: element 99,999,999 of an array."""
    path = tmp_path / "huge.bbl"
    text = made_up_blackbox(100)
    for place in (b"99999999", b"00000000099999999", b"1000"):
        path.write_bytes(text.replace(b"vbatLatest", b"debug[%b]" % place))
        with pytest.raises(WorkbenchError, match="is beyond element 999 of an array") as caught:
            signal_topics(read_flight(path))
        assert str(path) in str(caught.value)
    path.write_bytes(text.replace(b"vbatLatest", b"debug[0007]"))
    assert signal_topics(read_flight(path))


def test_numbers_that_are_none_in_a_log_of_ardupilot_do_not_count(tmp_path, case):
    """A damaged definition makes floats of whole numbers."""
    pytest.importorskip("pymavlink")
    path = tmp_path / "a.bin"
    stamps = list(range(1_000_000, 1_050_000, 1000))
    for wrong in (math.nan, math.inf, -math.inf):
        parameters = [("RCMAP_THROTTLE", wrong), ("MOT_PWM_TYPE", wrong), ("FRAME_CLASS", wrong)]
        cores = [(1.0,) if i % 2 else (wrong,) for i in range(50)]
        for estimator in (cores, [(wrong,)] * 50):
            with case(wrong, estimator[1]):
                messages = [
                    ("PARM", "Nf", ("Name", "Value"), stamps[:3], parameters),
                    ("XKF4", "f", ("PI",), stamps, estimator),
                    ("XKF1", "Bfff", ("C", "PN", "PE", "PD"), stamps, [(1, 4.0, 5.0, 6.0)] * 50),
                    ("RCOU", "h", ("C1",), stamps, [(1500,)] * 50),
                    ("MSG", "Z", ("Message",), stamps[:1], [("ArduCopter V4.5.7",)]),
                ]
                path.write_bytes(dataflash(messages))
                flight = read_dataflash(path)
                assert flight["motors.command_1"].values.tolist() == [0.5] * 50
                assert ("estimate.x" in flight) == (estimator is cores)


def test_huge_numbers_in_headers_of_a_blackbox_log_are_no_exception(tmp_path, case):
    path = tmp_path / "a.bbl"
    for name, text in (
        ("motorOutput", f"{10**400},{10**401}"),
        ("Firmware revision", f"Betaflight {'4' * 5000}.5.0"),
    ):
        with case(name):
            path.write_bytes(blackbox([0, 1000], [[1], [2]], ["motor[0]"], {name: text}))
            contents_of_flight(read_blackbox(path))


def test_numbers_that_are_none_in_a_log_of_px4_do_not_count(tmp_path, case):
    pytest.importorskip("pyulog")
    path = tmp_path / "a.ulg"
    stamps = list(range(1_000_000, 1_050_000, 1000))
    for wrong in (math.nan, math.inf):
        for count, function, speeds in ((1.0, wrong, 1), (wrong, 101.0, math.isinf(wrong))):
            with case(count, function):
                fields = {
                    "esc_count": ("float", [count] * 50),
                    "esc[0].esc_rpm": ("float", [3000.0] * 50),
                    "esc[0].actuator_function": ("float", [function] * 50),
                }
                path.write_bytes(ulog([("esc_status", 0, stamps, fields)]))
                assert ("rotors.speed.0" in read_ulog(path)) == speeds


def test_a_number_that_is_no_float_in_a_description_is_damage(tmp_path):
    """Of a hundred thousand copies one had a rate of 400 digits."""
    path = tmp_path / "small.bbl"
    path.write_bytes(made_up_blackbox(100))
    write_flight(read_flight(path), tmp_path / "small.mcap")
    record = read_log(tmp_path / "small.mcap")
    described = json.loads(record.imported)
    described["signals"][0]["rate"] = 10**400
    with pytest.raises(WorkbenchError, match="its description of the signals is damaged"):
        imported_flight(replace(record, imported=json.dumps(described)))

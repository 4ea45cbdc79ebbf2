"""Readers of logs that others wrote, on damaged copies: a flight or a sentence, in bounds."""

import json
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

from tests.logs.test_flight_reader import MAPPING, SHARED, made_up_blackbox, real, usd_log
from workbench.common.errors import WorkbenchError
from workbench.logs.flight_contents import contents_of
from workbench.logs.flight_reader import read_flight
from workbench.logs.flight_record import FlightRecord, make_signal
from workbench.logs.imported import flight_of, log_of, write_flight
from workbench.logs.readers.any_log import READERS

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
    signals = {name: make_signal(name, "1", time, np.sin(time)) for name in names}
    write_flight(FlightRecord("m", folder / "m", "made", signals, end=3.0), folder / "m.mcap")
    table = "t;gx;m1;v\n" + "".join(f"{10 * i};{i};{1000 + i};{11100 - i}\n" for i in range(80))
    return {"usd": usd_log(rows), "m.mcap": (folder / "m.mcap").read_bytes()} | {
        "own.csv": table.encode()
    }


def survive(data: bytes, count: int, path: Path, mapping: Path | None = None) -> int:
    """Read damaged copies, and return how many were flights."""
    flights = 0
    for seed in copies(data, count, path):
        try:
            contents_of(read_flight(path, mapping))
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
    found = {"Betaflight blackbox log": made_up_blackbox(100)}
    if SHARED.exists():
        # The head has the parameters and formats; cut there, a file is read as far as it goes.
        found["PX4 ULog"] = (SHARED / "px4_ulog/sample.ulg").read_bytes()[:150_000]
        found["ArduPilot DataFlash log"] = (SHARED / "ardupilot/test.BIN").read_bytes()
    return found


def test_damaged_copies_that_libraries_read(tmp_path, case):
    """In their processes, as they come: all that a library may do wrong becomes a sentence."""
    for kind, data in foreign().items():
        with case(kind):
            pytest.importorskip(READERS[kind][0])
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
        READERS[kind][2](path)
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
            log_of(read_flight(path))
        assert str(path) in str(caught.value)
    path.write_bytes(text.replace(b"vbatLatest", b"debug[0007]"))
    assert log_of(read_flight(path)).topics


def test_a_number_that_is_no_float_in_a_description_is_damage(tmp_path):
    """Of a hundred thousand copies one had a rate of 400 digits."""
    path = tmp_path / "small.bbl"
    path.write_bytes(made_up_blackbox(100))
    record = log_of(read_flight(path))
    described = json.loads(record.imported)
    described["signals"][0]["rate"] = 10**400
    with pytest.raises(WorkbenchError, match="its description of the signals is damaged"):
        flight_of(replace(record, imported=json.dumps(described)))

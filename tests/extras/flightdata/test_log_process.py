"""Logs of other programs are read in a held process, too."""

import gzip
from pathlib import Path

import pytest

from tests.extras.flightdata.test_readers import MAPPING, SHARED, made_up_blackbox, usd_log
from workbench.common.errors import WorkbenchError
from workbench.logs import log_process
from workbench.logs.flight_reader import read_flight

TABLE = "t;gx;m1;v\n" + "".join(f"{10 * i};{i};{1000 + i};{11100 - i}\n" for i in range(80))


@pytest.fixture
def asked(monkeypatch):
    """Note the arguments of `run_limited`, and go on as before."""
    found, run = [], log_process.run_limited

    def noted(module, request, **limits):
        found.append({"module": module, "request": request, **limits})
        return run(module, request, **limits)

    monkeypatch.setattr(log_process, "run_limited", noted)
    return found


def test_every_log_is_read_by_a_process_that_may_read_its_files_alone(tmp_path, asked, case):
    table, mapping, usd, bbl = (tmp_path / n for n in ("own.csv", "map.yaml", "log07", "a.bbl.gz"))
    table.write_text(TABLE)
    mapping.write_text(MAPPING)
    usd.write_bytes(usd_log([(1000 * i, 1.0, 1.0) for i in range(9)]))
    bbl.write_bytes(gzip.compress(made_up_blackbox(50)))
    for read, file, beside in (
        (lambda path: read_flight(path, mapping), table, ["map.yaml", "own"]),
        (lambda path: read_flight(path, str(mapping)), str(table), ["map.yaml", "own"]),
        (read_flight, usd, ["log07"]),
        (read_flight, bbl, ["a"]),
    ):
        with case(file):
            read(file)
            (said,) = asked
            asked.clear()
            path = Path(file)
            *named, stem = beside
            names = [path.name, *named, f"{stem}_metadata.yaml", f"{stem}.mapping.yaml"]
            assert said["module"] == "workbench.logs.log_child"
            assert said["reads"] == [path.with_name(name) for name in names]
            assert said["writes"] == [said["request"]["folder"]]
            assert said["seconds"] <= 5 and said["megabytes"] <= 512


@pytest.mark.usefixtures("unheld")
def test_a_compressed_log_is_the_log(tmp_path, case):
    files = {"a.bbl": made_up_blackbox(100)}
    if SHARED.exists():
        files["a.ulg"] = (SHARED / "px4_ulog/sample.ulg").read_bytes()
    for name, data in files.items():
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

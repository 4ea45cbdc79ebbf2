"""`workbench export`."""

import csv
import sys

import numpy as np
import pytest
from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

from workbench.logs.flight_log import FlightLog
from workbench.logs.record import read_log
from workbench.scenario.scenario import Scenario
from workbench.scenario.sensors_config import SensorsConfig


@pytest.fixture(scope="module")
def scanned(logged, tmp_path_factory):
    """The log of a flight with a lidar in a room."""
    scenario = Scenario(duration=0.3, world="room", sensors=SensorsConfig(use=["lidar"]))
    return logged(scenario, tmp_path_factory.mktemp("logs") / "scanned.mcap")


def rows(path):
    return list(csv.reader(path.read_text(encoding="utf-8").splitlines()))


def test_each_topic_is_a_table_with_units(run, log, out):
    said = run("export", log, "--output", out)
    assert said.code == 0, said.err
    assert {path.stem for path in out.iterdir()} == set(read_log(log).topics)
    table = rows(out / "velocity_data.csv")
    assert table[0] == [
        "t [s]",
        *(f"v_{x} [m/s]" for x in "xyz"),
        *(f"w_{x} [rad/s]" for x in "xyz"),
    ]
    assert len(table) == 1 + len(read_log(log).states)
    assert rows(out / "drone_state.csv")[0][:3] == ["t [s]", "mode [1]", "condition"]


def test_numbers_are_read_back_exactly(run, log, out):
    assert run("export", log, "--output", out).code == 0
    record = read_log(log)
    table = np.array(rows(out / "exact_state.csv")[1:], dtype=float)
    assert table[:, 1:].tobytes() == record.states.tobytes()
    read = np.array(rows(out / "velocity_data.csv")[1:], dtype=np.float32)
    assert read[:, 1].tobytes() == record.flight["velocity_data.v_x"].values.tobytes()


def test_the_default_folder_is_named_as_the_log(run, log, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert run("export", log).code == 0
    assert (tmp_path / "out" / "flight" / "imu.csv").exists() is False
    assert (tmp_path / "out" / "flight" / "tf.csv").exists()


def test_parquet_without_pyarrow_is_refused(refused, log, out, monkeypatch):
    monkeypatch.setitem(sys.modules, "pyarrow", None)
    said = refused("export", log, "--format", "parquet", "--output", out)
    assert "Parquet needs pyarrow" in said
    assert not out.exists()


@pytest.mark.slow
def test_parquet_has_units_in_its_metadata(run, log, out):
    parquet = pytest.importorskip("pyarrow.parquet", reason="install the extra `parquet` to try it")
    assert run("export", log, "--format", "parquet", "--output", out).code == 0
    table = parquet.read_table(out / "velocity_data.parquet")
    assert table.schema.field("v_x").metadata == {b"unit": b"m/s"}
    found = read_log(log).flight["velocity_data.v_x"].values
    assert table["v_x"].to_numpy().tobytes() == found.tobytes()


def test_an_unknown_format_is_refused(refused, log):
    assert "unknown --format 'xls'" in refused("export", log, "--format", "xls")


def test_a_log_without_messages_is_refused(refused, tmp_path):
    FlightLog(tmp_path / "a.mcap", (), Scenario(), {}, {}, "x").close()
    assert "nothing to export" in refused("export", tmp_path / "a.mcap")


def test_the_lidars_clouds_are_a_table_of_points(run, scanned, out):
    """Oracle: the log as MCAP's own reader decodes it."""
    said = run("export", scanned, "--output", out, "--json")
    assert said.code == 0, said.err
    with scanned.open("rb") as stream:
        reader = make_reader(stream, decoder_factories=[DecoderFactory()])
        clouds = [
            np.column_stack(
                [
                    np.full(each.decoded_message.width, 1e-9 * each.message.log_time),
                    np.frombuffer(each.decoded_message.data, "<f4").reshape(-1, 3),
                ]
            )
            for each in reader.iter_decoded_messages(topics=["/dh_drone/lidar_cloud"])
        ]
    table = rows(out / "lidar_cloud_points.csv")
    assert table[0] == ["t [s]", "x [m]", "y [m]", "z [m]"]
    assert len(clouds) > 1 and len(clouds[0]) > 100
    assert np.array(table[1:], dtype=float) == pytest.approx(np.concatenate(clouds), rel=1e-6)
    written = {each["file"]: each["rows"] for each in said.json["tables"]}
    assert written[str(out / "lidar_cloud_points.csv")] == len(table) - 1
    assert set(written) == set(map(str, out.iterdir()))

"""`workbench log` and `workbench import` of logs of other programs."""

import json
from pathlib import Path

import numpy as np
import pytest

from tests.extras.flightdata.test_readers import MAPPING, usd_log
from tests.logs.test_step_response import fly
from workbench.common.flight import Flight
from workbench.common.series import make_series
from workbench.logs import flight_reader


@pytest.fixture
def usd(tmp_path):
    """Return a Crazyflie's log with a gap."""
    rows = [(1000 * i, float(i % 7), 1.0) for i in range(400) if not 100 < i < 150]
    path = tmp_path / "log03"
    path.write_bytes(usd_log(rows))
    return path


def test_log_says_what_is_in_it(run, usd):
    said = run("log", usd)
    assert said.code == 0
    assert "log03: Crazyflie usd log, Crazyflie" in said.out
    row = next(line for line in said.out.splitlines() if line.startswith("imu"))
    assert row.split() == [
        "imu",
        "angular_velocity.y",
        "rad/s",
        "1000.0",
        "0.00",
        "0.40",
        "1",
        "0.05",
    ]
    assert "rotor lag" in said.out and "the log has no commands" in said.out


def test_log_as_json(run, usd):
    found = json.loads(run("log", usd, "--json").out)
    gyro = next(each for each in found["signals"] if each["name"] == "imu.angular_velocity.y")
    assert gyro["gaps"] == [[pytest.approx(0.1), pytest.approx(0.15)]]
    assert gyro["samples"] == 351 and found["parameters"]["usd_version"] == 2
    assert not any(each["can"] for each in found["findable"])


def test_remarks_have_number_and_place(run, tmp_path):
    """In the text, in the JSON of each command, and in an imported log."""
    path = tmp_path / "own.csv"
    rows = [f"{10 * i},{i}" for i in (*range(100, 200), *range(80))]
    path.write_text("\n".join(["t,g", *rows]))
    (tmp_path / "own.mapping.yaml").write_text(
        "time: {column: t, unit: ms}\ncolumns: {g: {signal: imu.angular_velocity.x, unit: dps}}"
    )
    place = "line 102, at 1.990 s"
    said = run("log", path)
    assert f"goes back by 1.990 s: {place}: the 80 lines" in said.out
    copy = tmp_path / "own.mcap"
    for words in (["log", path], ["import", path, "--save", copy], ["log", copy]):
        found = json.loads(run(*words, "--json").out)
        (detail,) = found["remark_details"]
        assert (detail["count"], detail["place"]) == (80, place)
        assert found["remarks"] == [detail["text"]] and place in detail["text"]
    pictured = run("plot", path, "imu.angular_velocity.x", "--save", tmp_path / "a.png", "--json")
    assert place in json.loads(pictured.out)["remark"] and place in pictured.err


def test_import_stores_what_log_says(run, usd, tmp_path):
    output = tmp_path / "new" / "log03.mcap"
    assert run("import", usd, "--save", output).code == 0
    before, after = (json.loads(run("log", path, "--json").out) for path in (usd, output))
    for key in ("format", "remarks", "remark_details", "parameters", "firmware"):
        assert before[key] == after[key]
    for old, new in zip(before["signals"], after["signals"], strict=True):
        assert old.pop("end") == pytest.approx(new.pop("end"), abs=1e-9)
        assert old == new


def test_a_step_response_is_drawn_and_told_as_json(run, tmp_path):
    table, mapping = tmp_path / "flight.csv", tmp_path / "flight.mapping.yaml"
    np.savetxt(table, np.column_stack(fly(duration=20.0)), delimiter=",", header="t,want,got")
    mapping.write_text(
        "time: {column: '# t', unit: s}\ncolumns:\n"
        "  want: {signal: rate_setpoint.w_x, unit: rad/s}\n"
        "  got: {signal: imu.angular_velocity.x, unit: rad/s}\n"
    )
    output = tmp_path / "step.png"
    said = run("plot", table, "--step-response", "roll_rate", "--save", output, "--json")
    found = said.json
    assert said.code == (0 if found["trusted"] else 1)
    assert len(found["time"]) == len(found["values"]) == len(found["low"]) > 10
    assert found["files"] == [str(output)] and output.exists()


def test_what_cannot_be_done_is_a_sentence(run, refused, usd, tmp_path, case):
    table = tmp_path / "own.csv"
    table.write_text("t;gx;m1;v\n1;2;3;4\n2;2;3;4\n")
    mapping = tmp_path / "map.yaml"
    mapping.write_text(MAPPING)
    assert run("log", table, "--mapping", mapping).code == 0
    for command, said in (
        (("log", table), "--mapping"),
        (("log", tmp_path / "gone"), "no such file"),
        (("log", usd, "--html", tmp_path / "a.html"), "has no attitude"),
        (("import", usd, "--save", tmp_path / "a.csv"), "end in .mcap"),
        (("plot", usd, "imu", "--span", "3", "1"), "let it end after it begins"),
        (("plot", usd, "imu", "--span", "30", "31"), "nothing between"),
        (("plot", usd, "--over", usd), "name some"),
        (("plot", usd, "--step-response", "roll_rate"), "has no rate_setpoint.w_x"),
        (("replay", _imported(run, usd)), "nothing to fly again"),
        (("estimate", _imported(run, usd)), "comes from another program"),
    ):
        with case(command):
            assert said in refused(*command)
    assert not (tmp_path / "a.html").exists()


def _imported(run, usd: Path) -> Path:
    path = usd.with_name("x.mcap")
    assert run("import", usd, "--save", path).code == 0
    return path


def test_a_log_s_own_name_leads_to_no_other_folder(run, tmp_path, monkeypatch):
    time = np.linspace(0.0, 2.0, 20)
    signals = {"a.b": make_series("a.b", "m", time, time)}
    flight = Flight("../../elsewhere", tmp_path / "a.ulg", "ULog", signals, end=2.0)
    monkeypatch.setattr(flight_reader, "read_flight", lambda *_: flight)
    folder = tmp_path / "here"
    folder.mkdir()
    monkeypatch.chdir(folder)
    assert run("import", "a.ulg").code == 0
    assert [each.name for each in tmp_path.rglob("*.mcap")] == ["_.._elsewhere.mcap"]
    assert [each.name for each in folder.iterdir()] == ["out"]

"""`workbench fly`."""

import csv
import math

import numpy as np
import pytest

from workbench.commands.cli import main
from workbench.common.errors import FlightBrokenError
from workbench.common.resources import list_scenarios, list_worlds
from workbench.logs.flight_reader import read_flight
from workbench.session.session import Session

SHIPPED = [
    *("all-sensors", "estimate-complementary", "estimate-ekf", "figure-eight", "full-speed"),
    *("hover", "lidar-trial", "network", "paper-steps", "square", "take-crate"),
    *("take-off-and-land", "to-the-wall", "touch-down", "windy"),
]
SUMMARY = [
    "duration",
    "distance",
    "max_speed",
    "max_height",
    "min_height",
    "end",
    "max_tilt",
    "turned_over",
    "max_yaw_rate",
    "max_rotor_use",
    "final_mode",
    "battery_used",
    "touch_down_speed",
    "least_clearance",
]


def columns(path):
    """Return a log's columns by name."""
    header, *rows = csv.reader(path.read_text().splitlines())
    return dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def test_the_shipped_scenarios_are_listed_with_their_titles(run):
    assert list_scenarios() == SHIPPED
    said = run("fly", "--list")
    assert said.code == 0
    names = [line.split()[0] for line in said.out.splitlines() if line.startswith("  ")]
    assert names == [*SHIPPED, *list_worlds()]
    listed = run("fly", "--list", "--json").json
    titles = {each["name"]: each["title"] for each in (*listed["scenarios"], *listed["worlds"])}
    assert all(titles[name] in said.out and titles[name] for name in names)


def test_json_sums_the_flight_up(run, out):
    said = run("fly", "hover", "--duration", "0.5", "--output", out, "--json")
    assert said.code == 0
    assert list(said.json) == [
        "title",
        *SUMMARY,
        "failsafes",
        "slack_time",
        "sensors",
        "estimate",
        "files",
    ]
    assert said.json["duration"] == 0.5
    assert said.json["max_height"] == pytest.approx(1.5, abs=1e-3)
    assert said.json["min_height"] == pytest.approx(1.5, abs=1e-3)
    assert said.json["end"] == pytest.approx([0.0, 0.0, 1.5], abs=1e-3)
    assert said.json["turned_over"] is None
    assert said.json["final_mode"] == "hovering"
    assert said.json["touch_down_speed"] is None
    assert said.json["least_clearance"] is None
    assert said.json["sensors"] == []
    assert said.json["files"] == [str(out / "hover.csv"), str(out / "hover.png")]
    assert {path.name for path in out.iterdir()} == {"hover.csv", "hover.png"}


def test_csv_takes_the_log_elsewhere(run, out, tmp_path):
    states = tmp_path / "new" / "states.csv"
    said = run("fly", "hover", "--duration", "0.25", "--csv", states, "--output", out, "--no-plots")
    assert said.code == 0
    assert not out.exists()
    log = columns(states)
    assert log["t [s]"][-1] == pytest.approx(0.25)
    assert log["p_W.z [m]"] == pytest.approx(1.5, abs=1e-3)


@pytest.mark.slow
def test_a_take_off_and_landing_is_summed_up_as_one(run, out):
    said = run("fly", "take-off-and-land", "--output", out, "--no-plots")
    assert said.code == 0
    lines = {line[:16].strip(): line[16:].split() for line in said.out.splitlines()[1:]}
    assert lines["final mode"] == ["off"]
    assert lines["lowest height"][1:] == ["m"]
    assert lines["end"][:2] == ["0.00", "0.00"]
    assert lines["max yaw rate"] == ["0.0", "deg/s"]
    assert "turned over" not in said.err
    assert 0.3 < float(lines["touch-down speed"][0]) <= 0.5


def test_people_get_degrees_of_tilt_and_turn(run, write, out):
    """It begins with 0.5 rad of roll and 2 rad/s about the vertical."""
    start = (
        "start: {position: [0, 0, 20], roll_pitch_yaw: [0.5, 0, 0], angular_velocity: [0, 0, 2]}"
    )
    said = run(
        "fly", write("turn.yaml", f"duration: 0.25\n{start}\n"), "--output", out, "--no-plots"
    )
    lines = {line[:16].strip(): line[16:].split() for line in said.out.splitlines()[1:]}
    assert lines["max tilt"] == ["28.6", "deg"]
    rate, unit = lines["max yaw rate"]
    assert float(rate) == pytest.approx(math.degrees(2.0), rel=0.02) and unit == "deg/s"


def test_who_turns_over_is_told_so(run, write, out):
    start = (
        "start: {position: [0, 0, 20], roll_pitch_yaw: [1.5, 0, 0], angular_velocity: [15, 0, 0]}"
    )
    path = write("roll.yaml", f"duration: 0.25\n{start}\n")
    said = run("fly", path, "--output", out, "--no-plots", "--json")
    assert 0.0 < said.json["turned_over"] < 0.1
    assert "the drone turned over at 0.0 s" in said.err


def test_a_bad_scenario_is_named_with_its_line(case, refused, write, out):
    for text, line, word in [
        ("title: x\ndurtion: 3\n", 2, "did you mean 'duration'?"),
        ("title: x\nduration: long\n", 2, "a number"),
        ("title: x\nduration: -1\n", 2, "positive"),
        ("title: x\nduration: .inf\n", 2, "positive"),
        ("duration: 1\nduration: 2\n", 2, "second time"),
        ("duration: 1\nstart: {mode: off}\n", 2, "in quotes"),
        ("duration: 1\nstart: 3\n", 2, "key: value"),
        ("duration: 1\nstart: {position: [0, 0, .nan]}\n", 2, "three finite numbers"),
        ("duration: 1\nstart: {position: [0, 0, -1]}\n", 2, "below the ground"),
        ("script: 5\n", 1, "a list"),
        ("script:\n  - {at: 1, velocty: [0, 0, 0]}\n", 2, "did you mean 'velocity'?"),
        ("script:\n  - {at: 1, velocity: [0, 0]}\n", 2, "three finite numbers"),
        ("script:\n  - {at: 1, velocity: 3}\n", 2, "a list"),
        ("script:\n  - {at: .nan}\n", 2, "time in seconds"),
        ("script:\n  - {at: 1, yaw_rate: .inf}\n", 2, "finite"),
        ("script:\n  - {at: 1, request: fly}\n", 2, "take_off"),
        ("script:\n  - {at: 1, request: take_off, height: .nan}\n", 2, "height"),
        ("script:\n  - at: 1\n    set: {kp_rol: 1}\n", 3, "did you mean 'kp_roll'?"),
        ("script:\n  - at: 1\n    set: {kp_roll: 1e9}\n", 3, "a number"),
        ("script:\n  - at: 1\n    set: {kp_roll: 99999}\n", 3, "0 .. 2500"),
        ("figure_eight: {period: 0}\n", 1, "positive"),
        ("figure_eight:\n  laps: 0\n", 2, "1 or more"),
        ("figure_eight:\n  laps: 1.5\n", 2, "whole number"),
        ("rates: {physics_step: 0}\n", 1, "physics_step"),
        ("rates:\n  control_period: 0.003\n", 2, "multiple"),
        ("vehicle: {model: dh_dron}\n", 1, "did you mean 'dh_drone'?"),
        ("vehicle:\n  gains: gone.yaml\n", 2, "no such file"),
        ("vehicle:\n  args: {mass: 2}\n", 2, "in quotes"),
        ("- a\n- b\n", 1, "key: value"),
        ("{", 1, "not YAML"),
    ]:
        with case(text, line, word):
            path = write("bad.yaml", text)
            sentence = refused("fly", path, "--output", out)
            assert f"{path}:{line}: " in sentence
            assert word in sentence
            assert not out.parent.exists()


@pytest.mark.parametrize(
    ("command", "word"),
    [
        (["fly"], "workbench fly hover"),
        (["fly", "hovr"], "did you mean 'hover'?"),
        (["fly", "gone.yaml"], "gone.yaml"),
        (["fly", "hover", "--duration", "-1"], "positive"),
        (["fly", "hover", "--set", "kp_roll=-1"], "0 .. 2500"),
    ],
)
def test_bad_input_is_a_sentence_and_leaves_nothing(refused, out, command, word):
    assert word in refused(*command, "--output", out)
    assert not out.parent.exists()


def test_no_file_is_left_where_the_flight_fails(refused, monkeypatch, out):
    def fails(session, progress):
        raise WorkbenchError("the flight broke off after 1.000 s: as a test")

    from workbench.common.errors import WorkbenchError

    monkeypatch.setattr(Session, "run", fails)
    assert "broke off" in refused("fly", "hover", "--output", out)
    assert not out.parent.exists()


def test_what_was_flown_before_a_flight_broke_off_is_written(run, monkeypatch, out):
    def breaks(session, progress):
        session.tick(0.5)
        raise FlightBrokenError("the flight broke off after 0.500 s: as a test")

    monkeypatch.setattr(Session, "run", breaks)
    said = run("fly", "hover", "--sensors", "imu", "--output", out)
    assert said.code == 1
    assert "the flight broke off after 0.500 s: as a test; what was flown" in said.err
    assert columns(out / "hover.csv")["t [s]"][-1] == pytest.approx(0.5, abs=0.01)
    assert (out / "hover-imu.csv").is_file()


def test_a_log_in_a_folder_that_cannot_be_is_refused(refused, tmp_path, out):
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    assert f"{blocker}/states.csv" in refused("fly", "hover", "--csv", blocker / "states.csv")
    assert f"{tmp_path}: is a folder" in refused("fly", "hover", "--csv", tmp_path, "--output", out)
    assert list(tmp_path.iterdir()) == [blocker]


def test_an_interrupted_flight_says_that_its_log_is_there(tmp_path, out, monkeypatch, capsys):
    def run_until_interrupted(session, progress):
        session.tick(0.25)
        progress(0.01)
        raise KeyboardInterrupt

    monkeypatch.setattr(Session, "run", run_until_interrupted)
    log = tmp_path / "flight.mcap"
    assert main(["fly", "hover", "--no-plots", "--output", str(out), "--log", str(log)]) == 130
    last = capsys.readouterr().err.splitlines()[-1]
    assert last == f"workbench: interrupted; {log} has the flight until then"
    assert "velocity_data.v_x" in read_flight(log)

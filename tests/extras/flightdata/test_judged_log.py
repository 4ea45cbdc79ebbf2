"""Logs of other programs judged by specs."""

import dataclasses
import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from tests.logs.test_judged_log import check_metrics, step, write_spec
from workbench.commands import progress
from workbench.commands.cli import main
from workbench.common.resources import find_model
from workbench.design.regress.running import regress
from workbench.design.regress.spec import LogConfig, SpecCase
from workbench.logs.flight_reader import read_flight
from workbench.logs.judged_log import judged_log, read_case
from workbench.logs.readers.rotations import EULER_ANGLE_NAMES
from workbench.plant.loading import load_vehicle

pytestmark = pytest.mark.usefixtures("unheld")

__all__ = ["step"]

SHARED = Path(__file__).parents[3] / "../shared/flights/given"
real = pytest.mark.skipif(not SHARED.exists(), reason="put the real flights into ../shared/flights")


@pytest.fixture
def run(capsys):
    """Run a command, and return what it prints, and what it says besides."""

    def running(*words, code: int = 0) -> str:
        assert main([str(word) for word in words]) == code
        said = capsys.readouterr()
        assert "Traceback" not in said.err
        return said.err if code == 2 else said.out

    return running


@pytest.mark.slow
def test_a_table_gives_the_metrics_of_the_flight_that_it_is_of(case, step):
    """A CSV has the samples of the flight itself, so nothing differs but its last digits."""
    check_metrics(case, step, "flight.csv", 1e-6)


TAU, DELAY, RATE = 0.08, 0.02, 500.0
"""Of a loop of first order that was made up [s], and rate of its log [Hz]."""


def write_steps(path: Path, edges: dict[float, float], noisy: float = 0.0, **columns) -> None:
    """Write a CSV of a first-order loop's answer to a setpoint that jumps, and its mapping.

    y(t) = sum of a (1 - exp(-(t - edge - DELAY) / TAU)): the closed form, sampled.
    """
    t = np.arange(0.0, 8.0, 1.0 / RATE)
    u, y = np.zeros_like(t), np.zeros_like(t)
    before = 0.0
    for edge, value in edges.items():
        u += (value - before) * (t >= edge - 1e-9)
        since = np.maximum(t - edge - DELAY, 0.0)
        y += (value - before) * (1.0 - np.exp(-since / TAU))
        before = value
    y += noisy * np.random.default_rng(1).standard_normal(len(t))
    table = {"t": t, "u": u, "y": y, **{n: np.broadcast_to(v, t.shape) for n, v in columns.items()}}
    rows = [",".join(f"{v:.9g}" for v in row) for row in zip(*table.values(), strict=True)]
    path.write_text("\n".join([",".join(table), *rows]), encoding="utf-8")
    names = {
        "u": {"signal": "rate_setpoint.w_x", "unit": "rad/s"},
        "y": {"signal": "imu.angular_velocity.x", "unit": "rad/s"},
        **{name: {"signal": f"motors.command_{name[1:]}", "unit": "1"} for name in columns},
    }
    mapping = {"time": {"column": "t", "unit": "s"}, "columns": names}
    path.with_suffix(".mapping.yaml").write_text(yaml.safe_dump(mapping), encoding="utf-8")


def test_each_step_of_a_log_is_held_against_the_limit(case, tmp_path):
    """A first-order loop rises in tau ln 9 and settles to 2 % in tau ln 50 behind its delay."""
    write_steps(tmp_path / "flight.csv", {1.0: 1.0, 3.0: -1.0, 5.0: 0.5, 5.1: 0.6, 5.2: 0.5})
    limits = {
        "steps": [2, 2],
        "rise_time": {"max": 0.17},
        "settling_time": {"max": 0.32},
        "overshoot": {"max": 20},
        "peak": {"max": 1.5},
    }
    log = {"name": "x", "log": "flight.csv", "loop": "roll_rate", "limits": limits}
    (result,) = regress([write_spec(tmp_path, log)], read_log=read_case)
    found = {check.name: check.value for check in result.checks}
    assert found["steps"] == 2.0  # the quick ones at the end are none
    for begin, size in ((1.0, 1.0), (3.0, 2.0)):
        at = f" of the step at {begin:.2f} s"
        for name, expected in (
            ("rise_time", TAU * np.log(9.0)),
            ("settling_time", DELAY + TAU * np.log(50.0)),
        ):
            with case(name, begin):
                assert found[name + at] == pytest.approx(expected, abs=1.5 / RATE)
        assert found["peak" + at] == pytest.approx(size, abs=1e-3)
    assert result.failures == [
        "rise_time of the step at 1.00 s is 0.176 s, and should be at most 0.17 s: 0.006 s above",
        "rise_time of the step at 3.00 s is 0.176 s, and should be at most 0.17 s: 0.006 s above",
        "settling_time of the step at 1.00 s is 0.334 s, and should be at most 0.32 s: 0.014 s "
        "above",
        "settling_time of the step at 3.00 s is 0.334 s, and should be at most 0.32 s: 0.014 s "
        "above",
        "peak of the step at 3.00 s is 2 rad/s, and should be at most 1.5 rad/s: 0.5 rad/s above",
    ]


def test_what_a_log_cannot_give_fails_or_is_skipped_with_a_sentence(case, tmp_path):
    write_steps(tmp_path / "still.csv", {}, m1=0.4, m2=0.5, m3=0.4, m4=0.996)
    write_steps(tmp_path / "steps.csv", {1.0: 1.0})
    table = [
        # log, metric, value or what is said
        ("still.csv", "trim", 0.596),
        ("still.csv", "saturation", 100.0),
        ("still.csv", "mean_rotor_use", 0.574),
        ("still.csv", "rise_time", "the setpoint has no step that is constant for 0.3 s"),
        ("still.csv", "lag", "the setpoint does not move"),
        ("still.csv", "measured_rise_time", "not reliable: the setpoint never moves"),
        ("still.csv", "hover_thrust", "the log has no speeds of the rotors"),
        ("still.csv", "peak_speed", "the log has no velocity_data.v_x .. or estimate.v_x .."),
        ("still.csv", "maximum of tilt", "the log has no attitude.q_w .."),
        ("still.csv", "mean of charge", "use battery.voltage"),
        ("steps.csv", "saturation", "has no motor commands"),
        ("steps.csv", "trim", "has no motor commands"),
        ("steps.csv", "lag", 0.07),
        ("steps.csv", "noise of imu.angular_velocity.x", 0.0),
    ]
    for file in ("still.csv", "steps.csv"):
        limits = {row[1]: {"min": -1e9, "max": 1e9} for row in table if row[0] == file}
        strict = {"name": "strict", "log": file, "loop": "roll_rate", "limits": limits}
        lax = {**strict, "name": "lax", "log": {"file": file, "missing": "skip"}}
        found = regress([write_spec(tmp_path, strict, lax)], read_log=read_case)
        asked, waived = ({check.name: check for check in each.checks} for each in found)
        assert not found[0].passed and found[1].passed and not found[1].skipped
        for _, metric, wanted in (row for row in table if row[0] == file):
            with case(file, metric):
                if isinstance(wanted, str):
                    assert wanted in asked[metric].sentence and not asked[metric].met
                    assert waived[metric].skipped and wanted in waived[metric].doubt
                else:
                    assert asked[metric].value == pytest.approx(wanted, abs=0.02)
                    assert waived[metric].met and not waived[metric].skipped


def test_a_gap_is_no_value_and_a_small_one_is_said(tmp_path):
    write_steps(tmp_path / "flight.csv", {1.0: 1.0})
    path = tmp_path / "flight.csv"
    head, *rows = path.read_text().splitlines()
    spec = write_spec(
        tmp_path,
        {
            "name": "x",
            "log": {"file": "flight.csv", "span": [0, 8]},
            "limits": {"maximum of imu.angular_velocity.x": {"max": 0.5}},
        },
    )
    for lost, said in (
        (400, "above (the log has imu.angular_velocity.x for 90 % of"),
        (2000, None),
    ):
        path.write_text("\n".join([head, *rows[:1500], *rows[1500 + lost :]]), encoding="utf-8")
        (result,) = regress([spec], read_log=read_case)
        expected = said or "and 80 % are needed: name a span without gaps"
        assert expected in result.failures[0]


def write_speeds(path: Path, angle: list[str]) -> None:
    """Write a CSV of four rotors at constant speeds and of angles in 8 s, and its mapping."""
    time = np.arange(0.0, 8.0, 0.02)
    rows = [f"{t:.9g},400,410,420,430,{a},{a},{a}" for t, a in zip(time, angle, strict=True)]
    path.write_text("\n".join(["t,a,b,c,d,roll,pitch,yaw", *rows]))
    names = {
        **{name: {"signal": f"rotors.speed.{i}", "unit": "rad/s"} for i, name in enumerate("abcd")},
        **{name: {"signal": f"estimate.{name}", "unit": "rad"} for name in EULER_ANGLE_NAMES},
    }
    mapping = {"time": {"column": "t", "unit": "s"}, "columns": names}
    path.with_suffix(".mapping.yaml").write_text(yaml.safe_dump(mapping))


def test_the_array_that_is_known_least_decides(tmp_path):
    """A force needs thrusts and attitude; the attitude is missing in 3 of 8 s."""
    write_speeds(tmp_path / "flight.csv", ["" if 100 < i < 250 else "0.1" for i in range(400)])
    limits = {"mean of force_z": {"max": 1e3}, "peak_thrust": {"max": 1e3}}
    spec = write_spec(tmp_path, {"name": "x", "log": "flight.csv", "limits": limits})
    (result,) = regress([spec], read_log=read_case)
    (sentence,) = result.failures
    assert sentence.startswith("mean of force_z does not exist")
    assert "the log has the attitude for 63 % of 0 .. 7.98 s" in sentence


def test_each_rotor_has_the_speed_of_the_motor_that_the_order_names(tmp_path):
    write_speeds(tmp_path / "flight.csv", ["0.1"] * 400)
    wanted = {"mean of speed_1": 420, "mean of speed_2": 410, "mean of speed_3": 430}
    limits = {name: [value - 0.1, value + 0.1] for name, value in wanted.items()}
    log = {"file": "flight.csv", "order": [3, 2, 4, 1]}
    (result,) = regress(
        [write_spec(tmp_path, {"name": "x", "log": log, "limits": limits})], read_log=read_case
    )
    assert result.passed, result.failures


def test_thrusts_are_those_of_the_curve_of_each_rotor(tmp_path):
    """T = k w^2 + l w."""
    write_speeds(tmp_path / "flight.csv", ["0.1"] * 400)
    drone = load_vehicle(find_model("dh_drone"))
    rotors = tuple(dataclasses.replace(each, linear_motor_constant=2e-3) for each in drone.rotors)
    flight = read_flight(tmp_path / "flight.csv")
    vehicle = dataclasses.replace(drone, rotors=rotors)
    found = judged_log(flight, vehicle, SpecCase(), LogConfig()).recording
    for place, speed in enumerate((400.0, 410.0, 420.0, 430.0)):
        thrust = rotors[place].motor_constant * speed**2 + 2e-3 * speed
        assert found.thrusts[:, place] == pytest.approx(thrust)


def test_wrong_cases_of_logs_are_sentences_with_their_line(case, run, tmp_path):
    write_steps(tmp_path / "flight.csv", {1.0: 1.0}, m1=0.5)
    limits = "limits: {trim: {max: 1}}"
    table = [
        ("log: gone.ulg", limits, "there is no gone.ulg beside the spec"),
        ("log: {file: flight.csv, span: [5]}", limits, "span must be two times in seconds"),
        ("log: {file: flight.csv, span: [9, 12]}", limits, "lasts from 0 to 7.998 s"),
        ("log: {file: flight.csv, missing: perhaps}", limits, "missing must be fail or skip"),
        ("log: {file: flight.csv, number: -1}", limits, "number must be 1 or more"),
        ("log: {file: flight.csv, number: 2}", limits, "has one log: --log-number 2"),
        ("log: {file: flight.csv, order: [1, 1]}", limits, "order must have the number of each"),
        ("log: {file: flight.csv, mapping: no.yaml}", limits, "there is no no.yaml"),
        ("log: {}", limits, "log must name a file"),
        ("log: {plane: 3}", limits, "plane"),
        ("log: ours.workbench.yaml", limits, "is not a known kind of log"),
        ("log: flight.csv\n    axis: x", limits, "axis belongs to a flight"),
        ("log: flight.csv\n    set: {kp_roll: 3}", limits, "set belongs to a flight"),
        ("log: flight.csv\n    loop: rol_rate", limits, "unknown loop 'rol_rate'"),
        ("log: flight.csv\n    loop: x", limits, "has no setpoint.x"),
        ("log: flight.csv", "limits: {rise_time: {max: 1}}", "rise_time needs a signal and a comm"),
        ("log: {file: flight.csv, span: [2, 10]}", limits, "lasts from 0 to 7.998 s"),
        ("log: flight.csv", "limits: {lag: {max: 1}}", "lag needs an axis, or a log and a loop"),
        ("log: flight.csv", "limits: {mean of imu.f_z: {max: 1}}", "unknown signal of flight.csv"),
        ("axis: x\n    amplitude: 1\n    loop: v_x", limits, "loop belongs to a log"),
        (
            "axis: x\n    amplitude: 1",
            "limits: {measured_final: {max: 1}}",
            "needs a log and a loop",
        ),
    ]
    path = tmp_path / "ours.workbench.yaml"
    for keys, demands, said in table:
        with case(keys, demands):
            path.write_text(f"cases:\n  - name: one\n    {keys}\n    {demands}\n", encoding="utf-8")
            sentence = run("regress", path, code=2)
            assert said in sentence and "ours.workbench.yaml" in sentence


def test_the_command_tells_of_skipped_cases(run, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    write_steps(tmp_path / "flight.csv", {1.0: 1.0})
    limits = {"rise_time": {"max": 0.2}, "trim": {"max": 0.1}}
    cases = [
        {"name": "there", "log": {"file": "flight.csv", "missing": "skip"}, "loop": "roll_rate"},
        {"name": "gone", "log": {"file": "gone.ulg", "missing": "skip"}, "loop": "roll_rate"},
    ]
    write_spec(tmp_path, *({**each, "limits": limits} for each in cases))
    files = ["-j", "1", "--junit", "r.xml", "--html", "r.html"]
    said = run("regress", "ours.workbench.yaml", *files)
    assert "ours.workbench.yaml: there: skipped: trim: " in said
    assert "ours.workbench.yaml: gone: skipped: there is no log gone.ulg" in said
    assert "the case passed, 1 skipped" in said
    assert '<skipped message="there is no log gone.ulg"' in (tmp_path / "r.xml").read_text()
    assert "skipped" in (tmp_path / "r.html").read_text()
    found = json.loads(run("regress", "ours.workbench.yaml", "-j", "1", "--json"))["cases"]
    assert [len(each["skipped"]) for each in found] == [1, 1]
    assert [each["skipped"] for each in found[0]["checks"]] == [False, True]


@pytest.mark.slow
def test_a_log_is_pinned_and_another_one_noticed(run, capsys, tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    motors = {f"m{number}": 0.5 for number in (1, 2, 3, 4)}
    write_steps(tmp_path / "flight.csv", {1.0: 1.0, 3.0: -1.0}, noisy=0.002, **motors)
    words = ["pin", "ours.workbench.yaml", "--from-log", "flight.csv", "--loop", "roll_rate"]
    monkeypatch.setattr(progress, "FIRST_DELAY_S", 0.0)
    assert main([*words]) == 0
    said, told = capsys.readouterr()
    assert "workbench: pinning and proving flight.csv: 0 %" in told
    assert "pinned to the present values" in said and "left out: peak_tilt" in said
    assert "exists already" in run(*words, code=2)
    gone = run("pin", "new.workbench.yaml", "--from-log", "gone.csv", code=2)
    assert "gone.csv: no such file" in gone and "new.workbench.yaml" not in gone
    assert "is for a step" in run(*words, "--force", "--set", "kp_roll=3", code=2)
    motors["m3"] = 0.7
    write_steps(tmp_path / "flight.csv", {1.0: 1.0, 3.0: -1.0}, noisy=0.002, **motors)
    assert "trim is 0.2, and should be at most 0.1" in run("regress", "ours.workbench.yaml", code=1)
    for change in (("--set", "kp_roll=3"), ("--vary", "mass=1.1"), ("--seed", 1)):
        refused = run("regress", "ours.workbench.yaml", *change, code=2)
        assert f"flight: is judged from a log, which {change[0]} cannot" in refused
    # A step that is cut short tells no rise time, and the spec would judge it.
    write_steps(tmp_path / "flight.csv", {1.0: 1.0, 3.0: -1.0, 3.31: 1.0}, noisy=0.002, **motors)
    assert "left out: settling_time: the step" in run(*words, "--force")
    assert "settling_time" not in Path("ours.workbench.yaml").read_text(encoding="utf-8")
    write_steps(tmp_path / "flight.csv", {1.0: 1.0, 3.0: -1.0}, noisy=0.002, **motors)
    spec = "a flight.workbench.yaml"  # what is to be done next can be copied into a shell
    said = run("pin", spec, *words[2:], "--log-number", "1")
    assert f"next: workbench regress '{spec}', or pytest '{spec}'" in said
    assert "number: 1" in Path(spec).read_text(encoding="utf-8")
    run("regress", spec)


@real
def test_real_flights_are_judged(case, tmp_path):
    """The lag is that of NanoBench's PID flights, 0.53 s, found by another way; see prediction."""
    drone = Path(__file__).parents[2] / "drones" / "nanobench.urdf"
    circle = {
        "name": "circle",
        "log": {"file": str(SHARED / "nanobench/B2_circle_fast_rep1.csv.gz"), "span": [6, 20]},
        "loop": "x",
        "limits": {
            "lag": [0.48, 0.58],
            "tracking_error": [0.3, 0.45],
            "peak_tilt": [0.3, 0.4],
            "peak_speed": [1.2, 1.6],
            "mean of battery.voltage": [3.2, 3.7],
            "trim": {"max": 0.1},
            "saturation": {"max": 3},
        },
    }
    fast = {
        "name": "1 kHz",
        "log": str(SHARED / "crazyflie_1khz/log15.gz"),
        "limits": {"noise of imu.angular_velocity.x": [0.1, 0.3], "saturation": [0, 0]},
    }
    head = {"vehicle": {"model": str(drone)}, "controller": "crazyflie"}
    for result in regress([write_spec(tmp_path, circle, fast, **head)], read_log=read_case):
        with case(result.case):
            assert result.passed, result.failures

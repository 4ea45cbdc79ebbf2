"""`workbench step`."""

import csv
import dataclasses
import json
import re

import control
import pytest

from workbench.commands import step
from workbench.design.load_metrics import LOAD_NUMBERS
from workbench.design.load_step import fly_load_step
from workbench.design.step_metrics import STEP_NUMBERS
from workbench.design.step_response import fly_step
from workbench.scenario.loads import LOAD_NAMES

pytestmark = pytest.mark.usefixtures("pictures_here")
PNG = b"\x89PNG"


def test_json_is_the_response_of_the_python_call(run, out):
    said = run(
        "step", "--axis", "x", "--amplitude", "1", "--duration", "3", "--output", out, "--json"
    )
    assert said.code == 0
    found = said.json
    response = fly_step("x", 1.0, duration=3.0)
    metrics = response.metrics.to_json()
    assert {name: found[name] for name in metrics} == metrics
    theirs = control.step_info([0.0, 0.5, 1.0], [0.0, 1.0, 2.0]).keys()
    assert metrics.keys() - theirs == {"SteadyStateError", "withheld"}
    assert found["coupling"] == dataclasses.asdict(response.coupling)
    assert found["peak_rotor_use"] == response.peak_rotor_use
    assert (found["axis"], found["amplitude"]) == ("x", 1.0)


def test_a_step_from_a_drift_in_wind_is_told(run, out):
    windy = ("step", "--axis", "x", "--amplitude", "1", "--set", "wind_x=6", "--output", out)
    said = run(*windy, "--no-plots", "--duration", "2")
    edge, drift = re.search(r"at (\S+) s it is steady, at (\S+) m/s", said.err).groups()
    rows = list(csv.DictReader((out / "step-x.csv").read_text().splitlines()))
    (before,) = [row for row in rows if float(row["t [s]"]) == float(edge)]
    assert float(before["v_W.x [m/s]"]) == pytest.approx(float(drift), abs=1e-3)
    assert float(drift) > 0.2
    assert "withheld" not in said.err


def test_who_flies_is_chosen_and_told(run, out):
    command = ("step", "--axis", "z", "--duration", "0.5", "--no-plots", "--output", out)
    said = run(*command, "--fly-on", "compiled", "--verbose")
    assert said.code == 0
    assert "compiled code flies: as is asked for" in said.err
    said = run(*command, "--fly-on", "diagram", "--verbose")
    assert "the diagram flies: as is asked for" in said.err
    assert "flies:" not in run(*command).err


def test_plot_and_log_are_written_and_nothing_else(run, out, monkeypatch):
    monkeypatch.undo()  # the picture is drawn by a process, as users have it
    said = run("step", "--axis", "yaw", "--duration", "0.5", "--output", out)
    assert said.code == 0
    assert {path.name for path in out.iterdir()} == {"step-yaw.csv", "step-yaw.png"}
    assert (out / "step-yaw.png").read_bytes()[:4] == PNG
    rows = list(csv.reader((out / "step-yaw.csv").read_text().splitlines()))
    assert rows[0][0] == "t [s]"
    assert float(rows[-1][0]) == pytest.approx(1.5)
    assert "step-yaw.png" in said.err


def test_the_table_speaks_python_controls_words(run, out):
    said = run("step", "--duration", "0.5", "--output", out, "--no-plots")
    words = [line.split()[0] for line in said.out.splitlines()[1:]]
    assert words[:8] == list(STEP_NUMBERS)
    assert words[8:] == ["peak_rotor_use", "coupling", "coupling", "coupling"]
    assert not list(out.glob("*.png"))


def test_what_has_not_settled_has_no_numbers_and_says_why(run, out):
    words = ("step", "--axis", "z", "--duration", "0.6", "--output", out, "--no-plots")
    said = run(*words)
    lines = {line.split()[0]: line.split()[1] for line in said.out.splitlines()[1:]}
    for name in ("rise_time", "settling_time", "overshoot", "steady_state_error"):
        assert lines[name] == "—", name
    assert float(lines["peak"]) > 0.0
    assert "was flown for 0.594 s; fly it for 5 s" in said.err
    found = run(*words, "--json").json
    assert found["RiseTime"] is None
    assert found["withheld"].startswith("by the linear model, the step needs")


@pytest.mark.slow
def test_settings_gains_and_xacro_arguments_reach_the_flight(run, out, write):
    gains = write("slow.yaml", "gains: {kp_velocity_z: 1.0}\n")
    short = ("step", "--duration", "1", "--output", out, "--no-plots", "--json")
    usual = run(*short).json["Peak"]
    slow = run(*short, "--gains", gains).json["Peak"]
    back = run(*short, "--gains", gains, "--set", "kp_velocity_z=4.4").json
    light = run(*short, "--arg", "mass:=1.6").json
    assert slow < 0.8 * usual
    assert back["Peak"] == pytest.approx(usual, abs=0.05)
    assert light["peak_rotor_use"] < run(*short).json["peak_rotor_use"]


def test_a_response_that_says_nothing_is_null_in_json(run, out):
    said = run(
        "step",
        "--axis",
        "x",
        "--set",
        "kp_velocity_x=0",
        "--duration",
        "0.5",
        "--output",
        out,
        "--json",
    )
    assert said.code == 0
    assert said.json["SettlingTime"] is None


@pytest.mark.slow
def test_a_lost_flight_is_measured_and_said(run, out):
    words = ("step", "--axis", "x", "--set", "kp_pitch=2400", "--duration", "2", "--output", out)
    said = run(*words)
    assert said.code == 1
    *_, line = said.out.splitlines()
    assert line.startswith("the flight is lost at t = 1.")
    assert "s: upside down and " in line
    assert "settling_time" in said.out
    assert {path.name for path in out.iterdir()} == {"step-x.csv", "step-x.png"}
    again = run(*words, "--json")
    assert again.code == 1
    assert f"t = {1.0 + again.json['diverged_at']:.3f} s" in line
    assert again.json["trouble"] == line
    assert "Overshoot" in again.json
    good = run("step", "--duration", "0.5", "--output", out, "--json").json
    assert (good["diverged_at"], good["trouble"]) == (None, "")


def test_bad_input_is_a_sentence_and_leaves_nothing(case, refused, out):
    for options, word in [
        (["--amplitude", "0"], "amplitude"),
        (["--amplitude", "nan"], "amplitude"),
        (["--amplitude", "99"], "max_climb_rate"),
        (["--axis", "yaw", "--amplitude", "1"], "max_yaw_rate"),
        (["--duration", "0"], "0.1 s or more"),
        (["--duration", "-1"], "0.1 s or more"),
        (["--duration", "nan"], "0.1 s or more"),
        (["--duration", "601"], "0.1 s or more, and 600 s at most"),
        (["--duration", "1e12"], "600 s at most"),
        (["--duration", "soon"], "soon"),
        (["--set", "kp_roll"], "NAME=VALUE"),
        (["--set", "kp_roll=nan"], "kp_roll"),
        (["--set", "kp_roll=inf"], "0 .. 2500"),
        (["--set", "kp_rol=1"], "did you mean 'kp_roll'?"),
        (["--arg", "mass=2"], "NAME:=VALUE"),
        (["--arg", "mas:=2"], "did you mean 'mass'?"),
        (["--arg", "mass:=heavy"], ".xacro"),
        (["--arg", "mass:=-1"], "Give a mass above"),
        (["--arg", "mass:=50"], "too heavy"),
        (["--model", "dh_dron"], "did you mean 'dh_drone'?"),
        (["--model", "gone.urdf"], "gone.urdf"),
    ]:
        with case(options, word):
            assert word in refused("step", "--output", out, *options)
            assert not out.parent.exists()


def test_a_place_where_nothing_can_be_written_is_refused_before_the_flight(refused, tmp_path):
    blocker = tmp_path / "file"
    blocker.write_text("in the way")
    assert f"{blocker}/sub/step-z.csv: cannot be written" in refused(
        "step", "--output", blocker / "sub"
    )
    assert list(tmp_path.iterdir()) == [blocker]


@pytest.mark.slow
def test_a_load_is_that_of_the_python_call_with_log_and_picture(run, out):
    words = ("step", "--load", "torque_yaw", "--amplitude", "0.02", "--duration", "2")
    found = run(*words, "--output", out, "--json").json
    flown = fly_load_step("torque_yaw", 0.02, duration=2.0)
    assert found["PeakTime"] == flown.metrics.peak_time
    assert found["SettlingTime"] == flown.metrics.settling_time
    assert found["peak_rotor_use"] == flown.peak_rotor_use
    assert (found["load"], found["amplitude"]) == ("torque_yaw", 0.02)
    assert {path.name for path in out.iterdir()} == {"step-torque_yaw.csv", "step-torque_yaw.png"}
    assert (out / "step-torque_yaw.png").read_bytes()[:4] == PNG
    said = run(*words, "--output", out, "--no-plots")
    lines = [line.split()[0] for line in said.out.splitlines()]
    assert lines == ["step", *LOAD_NUMBERS, "peak_rotor_use"]
    assert "rad/s  of the yaw rate" in said.out


def test_a_step_from_a_tilted_hover_says_when_it_begins(run, out):
    """In crosswind, which turns it steadily about the vertical."""
    words = ("step", "--axis", "roll", "--no-plots", "--duration", "1", "--output", out)
    ran = run(*words, "--set", "wind_y=-4", "--json")
    time = re.search(r"at ([0-9.]+) s the setpoint steps from that of the hover", ran.err)
    rows = list(csv.reader((out / "step-roll.csv").read_text().splitlines()))
    assert 1.0 < float(time[1]) == json.loads(ran.out)["edge"] < 10.0
    assert "withheld" not in ran.err
    assert float(rows[-1][0]) == pytest.approx(float(time[1]) + 1.0)
    assert "that of the hover" not in run(*words).err


def test_a_drone_that_is_lost_before_its_step_has_no_numbers(run, out):
    lost = ("--set", "kd_pitch=0", "--set", "kp_pitch=400", "--set", "wind_y=20")
    words = ("step", "--axis", "pitch", "--no-plots", "--duration", "0.25", "--output", out)
    ran = run(*words, *lost)
    assert ran.code == 1
    assert "the flight is lost at t = 2." in ran.out
    for number in ("steady_state_value", "coupling roll"):
        assert re.search(rf"{number} +— ", ran.out)
    assert "that of the hover" not in ran.err


def test_a_load_acts_in_hover_alone(run, out):
    said = run("step", "--load", "force_x", "--at", "vx=3", "--output", out)
    assert said.code == 2
    assert "leave --at out" in said.err
    said = run("step", "--load", "force_x", "--axis", "z", "--output", out)
    assert said.code == 2
    assert "not allowed with argument --load" in said.err
    said = run("step", "--axis", "z", "--acts", "1", "--output", out)
    assert said.code == 2
    assert "give --acts with a --load only" in said.err


def test_the_loads_of_the_command_are_those_of_the_table():
    assert step.LOAD_CHOICES == LOAD_NAMES

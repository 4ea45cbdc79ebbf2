"""`workbench fly --rotor-commands`: physics by hand, and tables that cannot be flown."""

import csv

import numpy as np
import pytest

from workbench.common.resources import find_model
from workbench.plant.loading import load_vehicle

GRAVITY = 9.81


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(find_model("dh_drone"))


@pytest.fixture
def table(write, vehicle):
    """Write a table of shares of the hover thrust, equal for all rotors."""
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    hover = constants * vehicle.hover_speeds**2

    def write_table(*rows):
        lines = [",".join(map(repr, [float(t), *(share * hover).tolist()])) for t, share in rows]
        return write("table.csv", "\n".join(["t,f1,f2,f3,f4", *lines]) + "\n")

    return write_table


def fly(run, table, out, *options):
    said = run("fly", "hover", "--rotor-commands", table, "--output", out, "--json", *options)
    assert said.code == 0, said.err
    header, *rows = csv.reader((out / "hover.csv").read_text().splitlines())
    return said.json, dict(zip(header, np.array(rows, dtype=float).T, strict=True))


def test_hover_thrust_hovers(run, table, out):
    summary, log = fly(run, table((0.0, 1.0)), out, "--duration", "0.5")
    assert log["p_W.z [m]"] == pytest.approx(1.5, abs=1e-6)
    assert summary["final_mode"] == "open loop"
    assert summary["battery_used"] is None
    assert np.isnan(log["mode [1]"]).all()


def test_a_tenth_more_thrust_accelerates_by_a_tenth_of_gravity_after_the_lag(
    run, table, out, vehicle
):
    _, log = fly(run, table((0.0, 1.0), (0.5, 1.1)), out, "--duration", "1")
    time, v_z = log["t [s]"], log["v_W.z [m/s]"]
    assert v_z[time <= 0.5] == pytest.approx(0.0, abs=1e-9)
    late = (time > 0.65) & (time < 0.85)  # slow yet: the air takes 5 mm/s² per (m/s)²
    slope = np.polyfit(time[late], v_z[late], 1)
    assert slope[0] == pytest.approx(0.1 * GRAVITY, rel=1e-3)
    # The line meets zero later by the rotors' lag, and a step of 1 ms of the sampled plant.
    lag = -slope[1] / slope[0] - 0.5
    assert 0.0 < lag - vehicle.rotors[0].time_constant_up < 2e-3


def test_rotors_begin_at_the_first_rows_speeds(run, table, out, vehicle):
    _, log = fly(run, table((0.0, 0.5)), out, "--duration", "0.1")
    speed = vehicle.hover_speeds[0] * np.sqrt(0.5)
    assert log["speed.1 [rad/s]"] == pytest.approx(speed, rel=1e-9)


def test_the_scenarios_start_is_used(run, table, out, write):
    scenario = write("hover.yaml", "duration: 0.25\nstart: {position: [1.0, 2.0, 7.0]}\n")
    said = run("fly", scenario, "--rotor-commands", table((0.0, 1.0)), "--output", out, "--json")
    assert said.json["max_height"] == pytest.approx(7.0, abs=1e-6)
    assert said.json["duration"] == 0.25
    assert "open loop, table.csv" in said.json["title"]


@pytest.mark.parametrize(
    ("text", "line", "word"),
    [
        ("t,f1,f2,f3,f4\n0,1,1,1\n", 2, "4 columns"),
        ("t,f1,f2,f3,f4\n0,1,1,1,one\n", 2, "'one'"),
        ("0,1,1,1,nan\n", 1, "'nan'"),
        ("0,1,1,1,1\n1,1,-1,1,1\n", 2, "rotor 2"),
        ("0,1,1,1,1\n1,1,1,1,1000\n", 2, "rotor 4"),
        ("0,1,1,1,1\n0,1,1,1,1\n", 2, "rise"),
        ("1,1,1,1,1\n", 1, "1 s"),
    ],
)
def test_a_bad_table_is_named_with_its_line(refused, write, out, text, line, word):
    path = write("table.csv", text)
    sentence = refused("fly", "hover", "--rotor-commands", path, "--output", out)
    assert f"{path}:{line}: " in sentence
    assert word in sentence
    assert not out.parent.exists()


def test_a_missing_table_and_gains_without_a_controller_are_refused(refused, table, out, tmp_path):
    gone = tmp_path / "gone.csv"
    assert str(gone) in refused("fly", "hover", "--rotor-commands", gone, "--output", out)
    assert "without controller" in refused(
        "fly", "hover", "--rotor-commands", table((0.0, 1.0)), "--set", "kp_roll=1", "--output", out
    )


def test_it_flies_in_its_world(run, table, out, write, vehicle):
    """Without thrust it falls on a table of 1 m, and rests there."""
    box = "{name: table, shape: {box: [4, 4, 1]}, position: [0, 0, 0.5]}"
    world = write("world.yaml", f"obstacles: [{box}]")
    _, log = fly(run, table((0.0, 0.0)), out, "--duration", "1", "--world", world)
    assert log["p_W.z [m]"][-1] == pytest.approx(1.0 + vehicle.ground_clearance, abs=2e-3)


def test_without_a_controller_there_are_no_sensors_either(refused, table, out):
    rows = table((0.0, 1.0))
    said = refused("fly", "hover", "--rotor-commands", rows, "--sensors", "imu", "--output", out)
    assert "leave out --controller, --set, --gains, --sensors" in said


def test_what_the_table_replaces_is_said(run, table, write, out):
    """The script of a scenario takes off and lands; a table of commands does neither."""
    scenario = write(
        "climb.yaml",
        "script: [{at: 0.1, request: take_off}]\nestimator: ekf\n"
        "sensors: {use: [imu, gps]}\nduration: 0.1\n",
    )
    said = run("fly", scenario, "--rotor-commands", table((0.0, 1.0)), "--output", out)
    assert said.code == 0
    told = "the table flies alone, without what climb has: a script, sensors, the estimator ekf"
    assert f"workbench: {told}" in said.err.splitlines()
    hover = ("fly", "hover", "--duration", "0.1", "--rotor-commands", table((0.0, 1.0)))
    assert "without what" not in run(*hover, "--output", out).err


def test_a_law_does_not_go_with_a_table(refused, table):
    said = refused("fly", "hover", "--rotor-commands", table((0.0, 1.0)), "--controller", "pid")
    assert "leave out --controller" in said

"""`workbench judge`."""

import csv
import math
import re

import numpy as np
import pytest

from workbench.analysis.judging import judge_plant_input
from workbench.analysis.queries import JudgePlantInput
from workbench.analysis.subject import AnalysedVehicle
from workbench.commands.judge import map_result
from workbench.common.resources import controllers_dir
from workbench.control.controller_file import load_controller
from workbench.design.judge.operating_map import MAP_DIRECTIONS, OperatingMap
from workbench.scenario.scenario import Scenario

pytestmark = pytest.mark.usefixtures("pictures_here")
LOOPS = load_controller().loops
PNG = b"\x89PNG"
PD = (controllers_dir() / "pd.py").read_text(encoding="utf-8")


def table_row(text, name):
    """Numbers of the first row of a printed table that begins with a name."""
    line = next(each for each in text.splitlines() if each.startswith(f"{name} "))
    return [float(cell) for cell in line.split()[1:]]


@pytest.mark.slow
@pytest.mark.parametrize("law", ["pd", pytest.param("lqi", marks=pytest.mark.slow)])
def test_the_apps_margin_at_the_plants_input_is_that_of_the_command(run, tmp_path, law):
    name, value = {"pd": ("kp_pitch", 300.0), "lqi": ("q_tilt", 9000.0)}[law]
    options = ("--controller", law, "--set", f"{name}={value}", "--no-plots", "--json")
    said = run("judge", *options, "--output", tmp_path).json
    subject = AnalysedVehicle(Scenario(controller=law), {})
    *_, found = judge_plant_input(subject, JudgePlantInput({name: value}), None)
    assert found[0] == pytest.approx(said["plant_input"]["disk_margin"], rel=1e-12)
    assert found[1] == pytest.approx(said["plant_input_holding"]["disk_margin"], rel=1e-12)
    *_, other = judge_plant_input(subject, JudgePlantInput({}), None)
    assert other[0] != pytest.approx(found[0], rel=1e-3)


@pytest.mark.slow
def test_pictures_are_written_and_nothing_else(run, out):
    said = run("judge", "--loop", "pitch", "--output", out)
    assert said.code == 0, said.err
    names = {"judge-pitch.png", "judge-phase.png", "judge-rates.png"}
    assert {path.name for path in out.iterdir()} == names
    assert all(path.read_bytes()[:4] == PNG for path in out.iterdir())
    assert "judge-pitch.png" in said.err


def test_away_from_hover_the_table_has_a_loop_a_row(run, out):
    said = run("judge", "--at", "vx=4", "--cut", "error", "--no-plots", "--output", out)
    assert said.code == 0
    lines = said.out.splitlines()
    assert "at vx=4" in lines[0]
    head = next(index for index, line in enumerate(lines) if line.startswith("loop "))
    names = [line.split()[0] for line in lines[head + 2 : head + 8]]
    assert names == [loop.name for loop in LOOPS if not loop.hold]
    assert not any(line.startswith("position_") for line in lines)
    assert "position loops and steps are left out" in said.out
    assert not out.exists()


def test_an_unstable_loop_is_named_and_ends_as_1(run, out):
    said = run("judge", "--at", "vx=1", "--set", "kp_pitch=2000", "--no-plots", "--output", out)
    assert said.code == 1
    assert "grows through pitch" in said.err
    assert "unstable" in said.out
    assert "Traceback" not in said.err


@pytest.mark.slow
def test_a_law_that_states_no_loops_is_judged_by_the_rest(run, out, write):
    law = write(
        "lifts.py",
        "from workbench.controllers import gain\n\n"
        'PARAMETERS = [gain("k", "1/s", (-50.0, 50.0), 5.0, "of rates")]\n\n\n'
        "def update(measured, setpoint, g, vehicle, memory, dt, loops):\n"
        "    w_x, w_y, w_z = measured.w_WB\n"
        "    k = -0.01 * g.k\n"
        "    return (vehicle.mass * 9.81, k * w_x, k * w_y, k * w_z), ()\n",
    )
    options = ("--controller", law, "--at", "vx=0", "--no-plots", "--output", out)
    said = run("judge", *options, "--set", "k=-20")
    assert said.code == 1, said.err
    assert "a mode grows through the law, which states no loops" in said.err


@pytest.mark.slow
def test_what_grows_or_is_lost_has_no_numbers(run, out):
    said = run("judge", "--set", "kp_pitch=2000", "--no-plots", "--output", out)
    assert said.code == 1
    rows = {line.split()[0]: line.split()[1:] for line in said.out.splitlines() if line.strip()}
    assert rows["peak"] == rows["rise_time"] == ["-"] * 8
    assert "a mode grows, so the linear model has no numbers" in said.out
    assert re.search("the x step has no numbers: the flight is lost at t = .*upside down", said.out)
    assert "with these gains a mode grows even at 1024 Hz" in said.out
    assert "no rate" not in said.out


@pytest.mark.slow
def test_rounding_is_shown_as_nothing(run, out):
    said = run("judge", "--no-plots", "--output", out)
    rows = {line.split()[0]: line.split()[1:] for line in said.out.splitlines() if line.strip()}
    assert rows["overshoot"][4:6] == rows["undershoot"][4:6] == ["0", "0"]
    assert "e-1" not in said.out


def test_sensitivities_are_a_table_and_a_picture(run, out):
    said = run("judge", "--sensitivity", "--axis", "yaw", "--output", out, "--json")
    assert said.code == 0
    found = {each["metric"]: each for each in said.json["sensitivities"]}
    assert found["rise_time"]["elasticities"]["kp_yaw_rate"] == pytest.approx(-1.07, abs=0.1)
    assert found["overshoot"]["elasticities"]["kp_roll"] is None
    assert {path.name for path in out.iterdir()} == {"judge-sensitivity-yaw.png"}


def test_a_map_is_a_table_and_a_picture(run, out):
    said = run("judge", "--map", "speed,climb", "--output", out)
    assert said.code == 0
    assert "weakest: " in said.out
    names = {path.name for path in out.iterdir()}
    assert names == {"judge-map-speed-climb.csv", "judge-map-speed-climb.png"}
    rows = list(csv.reader((out / "judge-map-speed-climb.csv").read_text().splitlines()))
    assert len(rows) == 82


def test_a_map_has_its_phase_margins_in_degrees_in_json_and_table(tmp_path):
    """π / 6 and π / 4 rad."""
    axis, shares = np.array([0.0, 1.0]), np.array([[0.5, 0.6]])
    angles = np.array([[math.pi / 6.0, math.pi / 4.0]])
    rows = *MAP_DIRECTIONS[:2], axis, axis[:1], angles, shares, shares, (("roll", "yaw"),)
    found = OperatingMap("made", *rows)
    assert np.array(map_result(found)["phase_margin_deg"]) == pytest.approx(
        np.array([[30.0, 45.0]])
    )
    found.write_csv(tmp_path / "map.csv")
    table = csv.DictReader((tmp_path / "map.csv").read_text().splitlines())
    assert [float(row["phase_margin_deg [deg]"]) for row in table] == pytest.approx([30.0, 45.0])


def test_bad_input_is_a_sentence_and_leaves_nothing(case, refused, out):
    for options, word in [
        (["--loop", "pich"], "did you mean 'pitch'"),
        (["--at", "vx=fast"], "vx=5"),
        (["--at", "speed=5"], "operating point"),
        (["--at", "vx=5", "--loop", "position_x"], "hover only"),
        (["--map", "speed"], "two"),
        (["--map", "speed,sped"], "did you mean 'speed'"),
        (["--map", "speed,speed"], "two directions"),
        (["--map", "speed,tilt", "--sensitivity"], "not allowed"),
        (["--sensitivity", "--at", "vx=5"], "--at"),
        (["--sensitivity", "--axis", "w"], "axis"),
        (["--axis", "y"], "--sensitivity"),
        (["--axis", "x", "--map", "speed,tilt"], "--sensitivity"),
        (["--cut", "middle"], "--cut"),
        (["--set", "kp_rol=1"], "kp_roll"),
        (("--sensitivity", "--vary", "mass=1.1"), "leave the variation out"),
    ]:
        with case(options, word):
            assert word in refused("judge", "--output", out, *options)
            assert not out.parent.exists()


@pytest.mark.parametrize(
    "at", ["vx=0.1", pytest.param("hover", marks=pytest.mark.slow)], ids=["moving", "hover"]
)
def test_it_says_where_the_phase_went_and_what_noise_does(run, out, at):
    """Steps are flown from hover alone, and noise is that of hover."""
    options = ("--at", at, "--set", "gyro_lowpass=40", "--no-plots", "--output", out)
    said = run("judge", "--estimator", "ekf", *options, "--json")
    assert said.code == 0
    phase = {each["loop"]: each for each in said.json["phase"]}
    pitch = phase["pitch"]
    parts = ("law", "filters", "estimator", "delay", "hold", "rotors")
    margin = next(each for each in said.json["loops"] if each["loop"] == "pitch")
    total = sum(pitch[part] for part in parts)
    phase_margin = math.radians(margin["actuator"]["phase_margin_deg"])
    assert total + math.pi == pytest.approx(phase_margin, abs=1e-6)
    assert pitch["filters"] < -0.1
    told = run("judge", "--estimator", "ekf", *options).out
    loops, _, turned = told.partition("where the phase went, at the crossover [deg]:")
    shown = table_row(loops, "pitch")
    of, units = margin["actuator"], {"phase_margin_deg": 1.0, "delay_margin": 1e3}
    for name in ("gain_margin", "gain_reduction_margin", *units, "disk_margin"):
        wanted = units.get(name, 1.0) * of[name]
        assert shown.pop(0) == pytest.approx(wanted, rel=5e-3, abs=0.051), name
    speed, hertz, *angles = table_row(turned, "pitch")
    assert (speed, 2.0 * math.pi * hertz) == pytest.approx(2 * (pitch["crossover"],), rel=5e-3)
    columns = re.search(r"at \[Hz\](.*)phase of L", turned)[1].split()
    degrees = [math.degrees(pitch[part]) for part in columns]
    assert angles[:-1] == pytest.approx(degrees, abs=0.051) and {"law", "filters"} < {*columns}
    assert angles[-1] == pytest.approx(of["phase_margin_deg"] - 180.0, abs=0.051)
    if at == "hover":
        assert [each["sensor"] for each in said.json["noise"]][-1] == "all"
        assert "what the noise of sensors does" in told


@pytest.mark.slow
def test_a_law_without_loops_is_judged_at_the_plants_input(run, refused, tmp_path):
    law = tmp_path / "bare.py"
    law.write_text(f"{PD}\nLOOPS = []\n", encoding="utf-8")
    said = run("judge", "--controller", law, "--output", tmp_path / "out")
    assert said.code == 0, said.err
    assert "bare states no LOOPS, so none is judged or drawn" in said.err
    assert "at the plant's input" in said.out and "loops, opened" not in said.out
    assert [each.name for each in (tmp_path / "out").iterdir()] == ["judge-rates.png"]
    assert "bare states no LOOPS: add them" in refused(
        "judge", "--controller", law, "--loop", "pitch"
    )

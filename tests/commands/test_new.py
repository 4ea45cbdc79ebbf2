"""`workbench new`: a data sheet becomes a description that flies, or a sentence says why not."""

import math
import os
import pty
import subprocess
import sys

import pytest

from workbench.plant.description import read_description
from workbench.plant.loading import load_vehicle

F450 = ("--mass", "1.4kg", "--diagonal", "450mm", "--propeller", "10x4.5")
STRONG = ("--max-thrust", "850g")


def test_a_data_sheet_becomes_a_description(run, tmp_path):
    target = tmp_path / "f450.urdf.xacro"
    said = run("new", tmp_path / "f450", *F450, *STRONG, "--battery", "4S 5000mAh", "--json")
    assert (said.code, said.err) == (0, f"workbench: wrote {target}\n")
    told = said.json
    vehicle = load_vehicle(target)
    assert not read_description(target).remarks
    assert vehicle.mass == pytest.approx(1.4)
    assert [math.hypot(*rotor.p_BR[:2]) for rotor in vehicle.rotors] == pytest.approx([0.225] * 4)
    thrusts = [rotor.max_thrust for rotor in vehicle.rotors]
    assert thrusts == pytest.approx([0.85 * 9.80665] * 4)
    for figure in told["figures"]:
        assert figure["source"]
    values = {figure["name"]: figure["value"] for figure in told["figures"]}
    assert vehicle.inertia.diagonal() == pytest.approx([values["ixx"]] * 2 + [values["izz"]])
    first = vehicle.rotors[0]
    assert first.motor_constant == pytest.approx(values["motor_constant"])
    assert first.moment_constant == pytest.approx(values["moment_constant"])
    assert first.max_rot_velocity == pytest.approx(values["max_speed"])
    assert first.time_constant_up == pytest.approx(values["time_constant"])
    assert first.inertia == pytest.approx(values["rotor_inertia"])
    assert first.inertia == pytest.approx(0.012 * 0.254**2 / 12.0, rel=0.05)  # a rod of 12 g
    assert told["thrust_to_weight"] == pytest.approx(vehicle.thrust_to_weight)
    assert 600.0 < told["hover_time"] < 2400.0
    assert told["next"] == f"workbench check --model {target}"


def test_a_battery_of_the_data_sheet_is_described(run, tmp_path):
    """Four cells of 3.5 V empty and 4.2 V full, and 3 mohm each at 5 A h."""
    said = run("new", tmp_path / "a", *F450, *STRONG, "--battery", "4S 5000mAh")
    battery = load_vehicle(tmp_path / "a.urdf.xacro").battery
    assert battery.capacity == pytest.approx(5.0 * 3600.0)
    (empty, least), (full, most) = battery.open_circuit_voltage
    assert (empty, full) == (0.0, 1.0)
    assert (least, most) == pytest.approx((14.0, 16.8))
    assert battery.resistance == pytest.approx(0.012)
    told = run(
        "new", tmp_path / "a", *F450, *STRONG, "--battery", "4S 5000mAh", "--force", "--json"
    )
    seconds = 0.56 * 14.8 * 5.0 * 3600.0 / told.json["hover_power"]
    assert told.json["hover_time"] == pytest.approx(seconds)
    assert battery.hover_duration == pytest.approx(seconds)
    assert "battery_resistance 0.012 ohm" in " ".join(said.out.split())
    for size in ("4S", "14.8V"):
        said = run("new", tmp_path / "a", *F450, *STRONG, "--battery", size, "--force")
        assert load_vehicle(tmp_path / "a.urdf.xacro").battery is None
        assert "no battery is described without its capacity: give both, as" in said.err


def test_sensors_are_described_with_usual_numbers(run, refused, tmp_path):
    target = tmp_path / "a.urdf.xacro"
    assert run("new", target, *F450, *STRONG, "--sensors", "imu, gps").code == 0
    plain = load_vehicle(target)
    assert [each.name for each in plain.sensors] == ["imu", "gps"]
    assert run("new", target, *F450, *STRONG, "--sensors", "all", "--force").code == 0
    assert not read_description(target).remarks
    vehicle = load_vehicle(target)
    assert {type(each).__name__ for each in vehicle.sensors} == {
        *("Imu", "Gps", "Barometer", "Magnetometer", "RangeFinder", "Lidar", "DepthCamera")
    }
    assert (vehicle.mass, vehicle.I_BBcm_B) == (plain.mass, plain.I_BBcm_B)
    words = ("fly", "hover", "--model", target, "--duration", "0.3", "--json", "--no-plots")
    flown = run(*words, "--sensors", "all", "--output", tmp_path / "out", "--no-noise")
    assert flown.code == 0, flown.err
    assert {each["kind"] for each in flown.json["sensors"]} == {
        *("imu", "gps", "barometer", "magnetometer", "range_finder", "lidar", "depth_camera")
    }
    height = (tmp_path / "out" / "hover-range_finder.csv").read_text().splitlines()[-1]
    assert 1.3 < float(height.split(",")[1]) < 1.5  # from 1.5 m, under the body
    said = refused("new", tmp_path / "b", *F450, *STRONG, "--sensors", "imu,gsp")
    assert "unknown kind of a sensor 'gsp': did you mean 'gps'?" in said


@pytest.mark.slow
def test_a_new_drone_with_a_battery_hovers_as_one_without(run, tmp_path):
    """PD gains without compensated sag sank by 4 cm, and the check of hover failed."""
    size = "--battery", "4S 5000mAh"
    for name, more in (("weak", size), ("strong", ())):
        assert run("new", tmp_path / name, *F450, *STRONG, *more).code == 0
    weak, strong = (
        run("hover", "--model", tmp_path / f"{name}.urdf.xacro", "--json", "--no-plots")
        for name in ("weak", "strong")
    )
    assert (weak.code, strong.code) == (0, 0), weak.err
    drifts = [said.json["hover"]["drift"] for said in (weak, strong)]
    assert drifts[0] == pytest.approx(drifts[1], abs=1e-3)


@pytest.mark.parametrize(
    ("layout", "rotors"),
    [("x", 4), ("plus", 4), ("x", 6), ("plus", 8), ("coaxial", 6), ("coaxial", 8)],
)
def test_every_layout_can_be_controlled(run, tmp_path, layout, rotors):
    """`load_vehicle` refuses what its rotors cannot control; each pair has opposite turns."""
    words = ("--mass", "4kg", "--arm", "0.4m", "--propeller", "12x4", "--max-thrust", "2kg")
    target = tmp_path / "mine.xacro"
    assert run("new", target, *words, "--rotor-count", rotors, "--layout", layout).code == 0
    vehicle = load_vehicle(target)
    front = [rotor for rotor in vehicle.rotors if abs(rotor.p_BR[1]) < 1e-9 < rotor.p_BR[0]]
    assert len(vehicle.rotors) == rotors
    assert len(front) == (1 if layout == "plus" else 0)
    assert sum(rotor.direction for rotor in vehicle.rotors) == 0
    assert max(vehicle.hover_speeds) == pytest.approx(min(vehicle.hover_speeds))


def test_a_thrust_curve_counts_more_than_coefficients(run, write, tmp_path):
    """Thrust 1e-5 w² and torque 2 % of it, in g and N m, with a column that is not read."""
    speeds = [3000, 6000, 9000]
    thrusts = [1e-5 * (rpm * math.pi / 30.0) ** 2 for rpm in speeds]
    rows = [
        f"{r},{t / 0.00980665!r},{0.02 * t!r},warm" for r, t in zip(speeds, thrusts, strict=True)
    ]
    curve = write("curve.csv", "\n".join(["rpm, thrust_g, torque_Nm, note", *rows]))
    assert run("new", tmp_path / "a", *F450, "--thrust-curve", curve).code == 0
    rotor = load_vehicle(tmp_path / "a.urdf.xacro").rotors[0]
    assert rotor.motor_constant == pytest.approx(1e-5, rel=1e-5)
    assert rotor.moment_constant == pytest.approx(0.02, rel=1e-5)
    assert rotor.max_rot_velocity == pytest.approx(300.0 * math.pi, rel=1e-5)


def test_an_estimate_is_replaced_in_the_file(run, tmp_path):
    assert run("new", tmp_path / "a", *F450, *STRONG).code == 0
    path = tmp_path / "a.urdf.xacro"
    before = load_vehicle(path)
    path.write_text(path.read_text().replace('name="mass" value="1.4"', 'name="mass" value="2.8"'))
    assert load_vehicle(path).inertia == pytest.approx(2.0 * before.inertia)


def test_what_cannot_be_is_a_sentence(case, refused, tmp_path):
    for words, said in [
        ((), "--mass is missing: give the all-up mass with battery, as 1.4kg"),
        (("--mass", "1400"), "is 1400 kg, but a multirotor has 0.005 to 500 kg"),
        (("--mass", "1,4kg"), "is not a number with a unit: write it as 1.2kg or 1200g"),
        (("--mass", "-1kg"), "is not a number with a unit: write it as 1.2kg"),
        (("--mass", "1.4lightyears"), "has no known unit (these are kg, g, lb, oz)"),
        (("--mass", "nan"), "is not a number with a unit"),
        ((*F450, "--arm", "1m"), "not allowed with argument --diagonal"),
        (F450, "nothing says how strong the motors are"),
        ((*F450, "--motor-kv", "920KV"), "nothing says how strong the motors are"),
        ((*F450, *STRONG, "--propeller", "15x5"), "propellers of 0.381 m touch each other"),
        ((*F450, *STRONG, "--propeller", "4.5x10"), "is not a propeller: write diameter x pitch"),
        (
            (*F450, *STRONG, "--rotor-count", "5"),
            "5 rotors cannot be laid out as x: it is for 4, 6",
        ),
        ((*F450, *STRONG, "--motor-mass", "400g"), "leave too little of a mass of 1.4 kg"),
        ((*F450, *STRONG, "--battery", "four"), "write it as 4S or 14.8V"),
        ((*F450, "--max-thrust", "300g"), "it cannot fly: 4 rotors of at most 2.94 N lift less"),
        ((*F450, "--thrust-curve", "none.csv"), "none.csv: no such file"),
    ]:
        with case(words, said):
            assert said in refused("new", tmp_path / "a", *words)
            assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("name", ["a.urdf", "a.sdf", "-a", "a b"])
def test_a_name_that_will_not_do_is_refused(refused, tmp_path, name):
    assert "name it as my_quad.urdf.xacro" in refused("new", tmp_path / name, *F450, *STRONG)


def test_nothing_is_overwritten_without_force(run, refused, write):
    path = write("a.urdf.xacro", "mine")
    assert "exists already: name another file, or give --force" in refused(
        "new", path, *F450, *STRONG
    )
    assert path.read_text() == "mine"
    assert run("new", path, *F450, *STRONG, "--force").code == 0
    assert "<robot" in path.read_text()


def test_it_asks_on_a_terminal(tmp_path):
    """A wrong answer is asked again; an empty one leaves out what may be left out."""
    ours, theirs = pty.openpty()
    answers = "heavy\n1.4kg\n450mm\n10x4.5\n\n920KV\n3S 5000mAh\n"
    os.write(ours, answers.encode())
    done = subprocess.run(
        [sys.executable, "-m", "workbench", "new", "f450"],
        cwd=tmp_path,
        stdin=theirs,
        capture_output=True,
        text=True,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(sys.path)},
    )
    os.close(ours)
    os.close(theirs)
    assert done.returncode == 0, done.stderr
    assert done.stderr.count("mass, all-up mass with battery, as 1.4kg: ") == 2
    assert "the mass 'heavy' is not a number with a unit" in done.stderr
    assert "hover time" in done.stdout
    assert load_vehicle(tmp_path / "f450.urdf.xacro").mass == pytest.approx(1.4)


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("--max-thrust 850", "850 N a rotor is 124 times the usual 6.86 N of a drone of 1.4 kg"),
        ("--max-thrust 850", "with 4 rotors: did you mean 850 g?"),
        ("--max-thrust 850g --battery 30S", "30 cells in series, and multirotors have 1 to 14: di"),
        ("--max-thrust 850g --battery 30S", "did you mean 3S?"),
        ("--max-thrust 850g --motor-mass 0.2g", "its mass of a motor, 0.0002 kg, is outside of"),
        ("--max-thrust 850g --battery 4S,500Ah", "its battery capacity, 500 A h, is outside of"),
        ("--motor-kv 9000KV --battery 4S", "its tips would move at"),
    ],
)
def test_a_slip_of_a_unit_is_told(run, tmp_path, words, said):
    sheet = ["--mass", "1.4kg", "--diagonal", "450mm", "--propeller", "10x4.5"]
    target = str(tmp_path / "a.urdf.xacro")
    made = run("new", target, *sheet, *words.split(), "--json")
    assert made.code == 0
    assert any(said in each for each in made.json["warnings"]), made.json["warnings"]
    assert said in run("new", target, *sheet, *words.split(), "--force").err


def test_a_plausible_data_sheet_has_no_warnings(run, tmp_path):
    sheet = [
        "--mass",
        "1.4kg",
        "--diagonal",
        "450mm",
        "--propeller",
        "10x4.5",
        "--max-thrust",
        "850g",
    ]
    made = run("new", str(tmp_path / "a"), *sheet, "--battery", "4S 5000mAh", "--json")
    assert made.json["warnings"] == []

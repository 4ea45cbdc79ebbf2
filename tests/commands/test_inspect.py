"""What `workbench inspect` says of the shipped drone and of files that are wrong."""

import dataclasses
import json

import numpy as np
import pytest

from workbench.commands.cli import main
from workbench.control.controller_file import load_controller
from workbench.dynamics.air.settings import calm_air
from workbench.ipc import call_filter, sandbox
from workbench.plant.gravity import GRAVITY
from workbench.plant.loading import load_vehicle

URDF = """<robot name="plate"><link name="base">
  <inertial><mass value="1"/><inertia ixx="0.01" iyy="0.01" izz="0.05"/></inertial>
  <visual><geometry><mesh filename="package://gone/body.dae"/></geometry></visual></link></robot>"""
ROTORS = """
defaults: {motor_constant: 1.0e-5, moment_constant: 0.02, max_rot_velocity: 1000,
  time_constant_up: 0.02, time_constant_down: 0.03}
rotors:
  - {name: a, position: [0.2, 0.2, 0], direction: cw}
  - {name: b, position: [-0.2, 0.2, 0], direction: ccw}
  - {name: c, position: [-0.2, -0.2, 0], direction: cw}
  - {name: d, position: [0.2, -0.2, 0], direction: ccw}
"""


@pytest.fixture
def plate(tmp_path):
    """A drone with an inertia to repair, and a mesh that is not there."""
    (tmp_path / "plate.rotors.yaml").write_text(ROTORS)
    path = tmp_path / "plate.urdf"
    path.write_text(URDF)
    return path


def read_json(capsys, *words: str):
    assert main(["inspect", *words, "--json"]) == 0
    return json.loads(capsys.readouterr().out)


def test_a_kernel_without_limits_for_processes_is_named(capsys, plate, monkeypatch):
    said = "limits of the kernel: this kernel has no seccomp filters and no Landlock"
    assert main(["inspect", str(plate)]) == 0
    assert said not in capsys.readouterr().out
    for module in (sandbox, call_filter):
        monkeypatch.setattr(module, "system_call", lambda *_: -1)
    assert main(["inspect", str(plate)]) == 0
    assert said in capsys.readouterr().out.partition("\nmissing\n")[2]
    assert any(said in text for text in read_json(capsys, str(plate))["warnings"])


def test_json_says_what_a_program_needs(capsys):
    data = read_json(capsys, "dh_drone")
    assert data["name"] == "dh_drone"
    assert data["mass"] == pytest.approx(1.9)
    assert np.shape(data["com"]) == (3,)
    assert np.shape(data["inertia"]) == (3, 3)
    assert data["thrust_to_weight"] == pytest.approx(4 * 8.54858e-6 * 1100**2 / (1.9 * 9.81))
    first = data["rotors"][0]
    assert first["name"] == "propeller1_joint"
    assert first["axis"] == pytest.approx([0, 0, 1])
    assert first["direction"] == -1
    assert first["thrust_coefficient"] == 8.54858e-6
    assert first["moment_coefficient"] == 0.016
    assert (first["time_constant_up"], first["time_constant_down"]) == (0.0125, 0.025)
    assert first["max_speed"] == 1100.0
    sensors = {sensor["name"]: sensor for sensor in data["sensors"]}
    names = {"lidar", "gps", "camera", "imu", "barometer", "range_finder", "magnetometer"}
    assert set(sensors) == names
    assert (sensors["lidar"]["type"], sensors["lidar"]["rate"]) == ("gpu_lidar", 10.0)
    assert sensors["camera"]["frame"] == "camera_link"
    (noise,) = sensors["barometer"]["noise"]["noise"]
    assert noise["stddev"] > 0.0
    assert len(sensors["imu"]["noise"]["angular_velocity"]) == 3
    assert data["warnings"] == []


def test_json_has_all_that_the_plant_flies_with(tmp_path, capsys):
    """Every field of a rotor that the plant reads, each with a value of its own, and the air's."""
    path = tmp_path / "plate.urdf"
    path.write_text(URDF)
    more = "rotor_drag_coefficient: 3.0e-5, rolling_moment_coefficient: 2.0e-6, inertia: 4.0e-5, "
    more += "inflow_coefficient: 1.0e-6, ground_effect_coefficient: 11.0, propeller_radius: 0.12, "
    more += "linear_motor_constant: 1.0e-4, "
    battery = (
        "battery: {capacity: 18000, resistance: 0.02, open_circuit_voltage: [[0, 9], [1, 12]]}"
    )
    text = ROTORS.replace("defaults: {", "defaults: {" + more) + battery
    (tmp_path / "plate.rotors.yaml").write_text(text)
    data = read_json(capsys, str(path))
    vehicle = load_vehicle(path)
    renamed = {
        "p_BR": "position",
        "axis_B": "axis",
        "motor_constant": "thrust_coefficient",
        "moment_constant": "moment_coefficient",
        "max_rot_velocity": "max_speed",
    }
    drawn = {"velocity_slowdown"}
    for rotor, told in zip(vehicle.rotors, data["rotors"], strict=True):
        fields = {f.name for f in dataclasses.fields(rotor)} - drawn
        for name in fields:
            value = getattr(rotor, name)
            assert value or name == "joint", f"give {name} a value above"
            assert told[renamed.get(name, name)] == (
                list(value) if isinstance(value, tuple) else value
            )
    assert (vehicle.rotors[0].inertia, vehicle.rotors[0].rotor_drag_coefficient) == (4e-5, 3e-5)
    air = calm_air(vehicle)
    assert (data["drag_area"], data["air_density"]) == (air.drag_area, air.air_density)
    assert data["gravity"] == GRAVITY
    assert data["battery"] == {
        "capacity": 18000.0,
        "resistance": 0.02,
        "open_circuit_voltage": [[0.0, 9.0], [1.0, 12.0]],
        "hover_duration": None,
        "sag_compensation": None,
    }
    assert data["not_flown"] == []
    assert data["battery_duration"] == load_controller().table.find("battery_duration").default
    assert main(["inspect", str(path)]) == 0
    said = capsys.readouterr().out
    for words in ("1e-06 N per rad/s", "11 (r/4h)²", "0.0001 N s", "12 V full"):
        assert words in said
    assert data["ground_clearance"] == vehicle.ground_clearance
    stated = battery.replace("}", ", hover_duration: 900, sag_compensation: 0.5}")
    (tmp_path / "plate.rotors.yaml").write_text(text.replace(battery, stated))
    assert read_json(capsys, str(path))["battery_duration"] == 900.0
    assert main(["inspect", str(path)]) == 0
    assert "hovers 15 min, 50 % of its sag compensated" in capsys.readouterr().out


def test_warnings_are_sentences_with_the_file(plate, capsys):
    warnings = read_json(capsys, str(plate))["warnings"]
    assert all(warning.startswith(str(plate)) for warning in warnings)
    assert any("inertia of link 'base'" in warning for warning in warnings)
    assert any("body.dae is not found" in warning for warning in warnings)


def test_people_get_tables_a_tree_and_remarks(plate, capsys):
    assert main(["inspect", str(plate)]) == 0
    said = capsys.readouterr().out
    heads = "thrust to weight|rotors (4)|hover speed|inertia kg m²|body drag|rotor drag|frames"
    for words in (*heads.split("|"), "not stated", "repaired", "missing"):
        assert words in said
    assert said.count(str(plate)) == 1  # in the title, and not again with each remark


def test_the_tree_shows_what_hangs_where(capsys):
    assert main(["inspect", "dh_drone"]) == 0
    lines = capsys.readouterr().out.splitlines()
    assert any(line.startswith("base_link (0 0 0, ") for line in lines)
    assert "├─ IMU_link by IMU_joint (0 0 0, 0.015 kg)" in lines


def test_a_drone_without_rotors_is_shown_and_refused(plate, capsys):
    plate.with_name("plate.rotors.yaml").unlink()
    assert main(["inspect", str(plate)]) == 2
    said = capsys.readouterr()
    assert "base (0 0 0, 1 kg)" in said.out
    assert "no rotors are declared" in said.err


def test_rotors_may_come_from_a_file_elsewhere(plate, tmp_path, capsys):
    elsewhere = tmp_path / "elsewhere"
    elsewhere.mkdir()
    plate.with_name("plate.rotors.yaml").rename(elsewhere / "mine.yaml")
    data = read_json(capsys, str(plate), "--rotors", str(elsewhere / "mine.yaml"))
    assert [rotor["name"] for rotor in data["rotors"]] == list("abcd")


def test_what_is_possible_and_unlikely_is_said(plate, capsys):
    beside = plate.with_name("plate.rotors.yaml")
    beside.write_text(ROTORS.replace("1.0e-5", "1.0e-2"))
    assert any("thrust-to-weight" in text for text in read_json(capsys, str(plate))["warnings"])


def test_arguments_and_packages_reach_the_description(capsys):
    assert read_json(capsys, "dh_drone", "--arg", "mass:=2.5")["mass"] == pytest.approx(2.5)


def test_a_package_that_is_given_is_used(plate, tmp_path, capsys):
    package = tmp_path / "elsewhere"
    package.mkdir()
    (package / "body.dae").write_text("<no mesh/>")
    words = (str(plate), "--package", f"gone={package}")
    (warning,) = [each for each in read_json(capsys, *words)["warnings"] if "body.dae" in each]
    assert "not found" not in warning


def test_write_stores_a_model_that_reads_the_same(plate, tmp_path, capsys):
    folder = tmp_path / "out"
    before = read_json(capsys, str(plate), "--write", str(folder))
    assert before["files"] == [str(folder / "plate.urdf")]
    after = read_json(capsys, str(folder / "plate.urdf"))
    assert after["mass"] == pytest.approx(before["mass"])
    assert np.array(after["inertia"]) == pytest.approx(np.array(before["inertia"]))
    for one, other in zip(before["rotors"], after["rotors"], strict=True):
        assert other["position"] == pytest.approx(one["position"])
        assert other["direction"] == one["direction"]


def test_write_spares_the_description_itself_and_follows_no_links(plate, tmp_path, capsys):
    before = plate.read_text()
    assert main(["inspect", str(plate), "--write", str(plate.parent)]) == 2
    assert plate.read_text() == before
    folder = tmp_path / "out"
    folder.mkdir()
    (folder / "plate.urdf").symlink_to(tmp_path / "outside")
    assert main(["inspect", str(plate), "--write", str(folder)]) == 2
    assert not (tmp_path / "outside").exists()
    assert "is a link" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["gone"], "unknown model 'gone'"),
        (["dh_drone", "--arg", "mass"], "not a xacro argument"),
        (["dh_drone", "--package", "x"], "not a package"),
        (["dh_drone", "--package", "x=/nowhere/at/all"], "/nowhere/at/all"),
        (["dh_drone", "--arg", "masse:=2"], "did you mean 'mass'"),
        (["dh_drone", "--rotors", "gone.yaml"], "gone.yaml: no such file"),
        (["models/gone.sdf"], "models/gone.sdf: no such file"),
        (["dh_drone", "--write", "/proc/none"], "/proc/none"),
        ([], "the following arguments are required"),
    ],
)
def test_bad_input_is_one_sentence(words, said, capsys):
    assert main(["inspect", *words]) == 2
    error = capsys.readouterr().err
    assert said in error
    assert error.count("\n") == 1


def test_nothing_is_left_behind_where_writing_fails(plate, tmp_path, capsys):
    plate.write_text(URDF.replace("</robot>", ""))
    assert main(["inspect", str(plate), "--write", str(tmp_path / "out")]) == 2
    assert not (tmp_path / "out").exists()
    assert f"{plate}:" in capsys.readouterr().err

"""The files that the docs show are read and flown as they stand."""

import re
import shlex
from pathlib import Path

import pytest
from PIL import Image

from workbench.commands.cli import _parser, main
from workbench.control.mode import FlightMode
from workbench.gains.gains import load_gains
from workbench.scenario.scenario import Scenario, VehicleConfig, load_scenario
from workbench.session.session import Session

DOCS = Path(__file__).parents[2] / "docs"
FILES = DOCS / "files.md"


def shown(language: str, first_line: str = "", page: Path = FILES) -> str:
    pattern = rf"```{language}\n({re.escape(first_line)}.*?)```"
    found = re.search(pattern, page.read_text(encoding="utf-8"), re.DOTALL)
    assert found
    return found[1]


def test_every_command_of_the_pages_is_understood(case):
    """Slow tests run them; here their words are read as the command line reads them."""
    lines = []
    for page in (DOCS.parent / "README.md", *DOCS.glob("*.md")):
        blocks = re.findall(r"```(?:sh|console|)\n(.*?)```", page.read_text("utf-8"), re.DOTALL)
        joined = "\n".join(blocks).replace("\\\n", "")
        lines += [line for line in joined.splitlines() if line.startswith("workbench ")]
    assert len(lines) > 50
    for line in lines:
        with case(line):
            words = shlex.split(line, comments=True)[1:]
            assert _parser().parse_args(words).command == words[0]


@pytest.mark.slow
def test_the_scenario_flies_and_lands(tmp_path):
    path = tmp_path / "scenario.yaml"
    path.write_text(shown("yaml", "# scenario"), encoding="utf-8")
    scenario = load_scenario(path)
    session = Session(scenario)
    session.tick(7.5)
    assert session.get("kp_velocity_x") == 6.0
    session.run()
    assert session.controller.name == "pid"
    assert session.recording().mode.max() == FlightMode.LANDING
    assert session.snapshot().mode is FlightMode.OFF
    assert session.vehicle.mass == pytest.approx(2.0)


def test_the_gain_file_is_read(tmp_path):
    path = tmp_path / "gains.yaml"
    path.write_text(shown("yaml", "# gains"), encoding="utf-8")
    assert load_gains(path).gains == {"kp_velocity_z": 3.0, "max_climb_rate": 2.0}


def test_a_description_flies_with_the_rotors_beside_it(tmp_path):
    inertia = '<inertia ixx="0.01" iyy="0.01" izz="0.02"/>'
    text = f'<robot name="x"><link name="b"><inertial><mass value="1"/>{inertia}</inertial></link>'
    (tmp_path / "x.urdf").write_text(f"{text}</robot>")
    beside = tmp_path / "x.rotors.yaml"
    beside.write_text(shown("yaml", "# rotors", DOCS / "descriptions.md"), encoding="utf-8")
    session = Session(Scenario(vehicle=VehicleConfig(model=str(tmp_path / "x.urdf"))))
    session.tick(1.0)
    assert [rotor.name for rotor in session.vehicle.rotors][0] == "front_left"
    assert session.snapshot().p_WB[2] == pytest.approx(1.5, abs=0.01)


def test_the_rotor_commands_fly(tmp_path, capsys):
    table = tmp_path / "rotors.csv"
    table.write_text(shown("csv"), encoding="utf-8")
    words = ["fly", "hover", "--rotor-commands", str(table), "--duration", "2", "--no-plots"]
    assert main([*words, "--output", str(tmp_path / "out")]) == 0
    assert "max height" in capsys.readouterr().out


def test_the_modes_are_numbered_as_written():
    text = FILES.read_text(encoding="utf-8").replace("\n", " ")
    for mode in FlightMode:
        assert f"{mode.label} {mode.value}" in text


def test_the_sensors_of_the_page_measure(tmp_path):
    path = tmp_path / "sensors.yaml"
    path.write_text(shown("yaml", "# sensors", DOCS / "sensors.md"), encoding="utf-8")
    session = Session(load_scenario(path))
    session.tick(0.5)
    status = {sensor.kind: sensor for sensor in session.snapshot().sensors}
    assert set(status) == {"imu", "gps", "lidar", "depth_camera"}
    assert status["lidar"].asked_rate == 20.0
    assert session.reading("gps").stamp <= 0.3


def test_the_python_of_the_sensors_page_runs(capsys):
    code = shown("python", page=DOCS / "sensors.md")
    exec(compile(code, "sensors.md", "exec"), {"__name__": "__main__"})
    assert capsys.readouterr().out.strip()


def test_the_pictures_of_the_sensors_page_are_written(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    code = shown("python", "import numpy", page=DOCS / "sensors.md")
    exec(compile(code, "sensors.md", "exec"), {"__name__": "__main__"})
    with Image.open("depth.png") as depth, Image.open("colour.png") as colour:
        assert depth.size == colour.size == (320, 240)
        assert 3000 < depth.getextrema()[1] <= 10_000
    assert capsys.readouterr().out.strip()


def test_the_air_of_the_page_blows(tmp_path):
    path = tmp_path / "air.yaml"
    path.write_text(shown("yaml", "# air", DOCS / "air.md"), encoding="utf-8")
    session = Session(load_scenario(path))
    session.run()
    wind = session.recording().wind_W
    assert wind[:100].max() == 0.0
    assert wind[:, 1].max() > 5.0  # the gust
    assert session.get("rotor_1") == 0.9

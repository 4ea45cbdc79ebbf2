"""The formats are found by their entry points, and loaded when a file is read in one of them."""

import subprocess
import sys

import pytest

from tests.docs.test_pages import blocks
from tests.plant.conftest import quad
from tests.plant.test_rotor_reader import model, motor, read
from workbench.commands.cli import main
from workbench.common.errors import WorkbenchError
from workbench.plant.description import read_description
from workbench.plant.worlds.reading import read_world

__all__ = ["model", "quad"]

XACRO = 'xmlns:xacro="http://www.ros.org/wiki/xacro"'
PROPERTIES = (("kf", "1e-9"), ("km", "1e-11"), ("thrust2weight", "3"))
READERS = ("sdf", "mjcf", "gazebo_world", "pybullet", "mjcf_actuators")


def test_xacro_may_stand_for_sdf(write):
    model = '<model name="m"><link name="${1 + 1}"/></model>'
    text = f'<sdf version="1.9" {XACRO}><xacro:if value="1">{model}</xacro:if></sdf>'
    assert read_description(write(text, "a.sdf.xacro")).base_link == "2"


def test_properties_alone_count(model):
    rotors, _ = read(model(properties=PROPERTIES))
    assert rotors[0].moment_constant == pytest.approx(0.01)


def test_properties_beside_motor_models_are_noted(model):
    rotors, remarks = read(model(*[motor(i) for i in range(4)], properties=PROPERTIES))
    assert rotors[0].moment_constant == 0.02
    assert remarks == [("ignored", "properties")]


def test_a_sidecar_goes_before_properties_and_says_so(model, tmp_path):
    text = "rotors: [{joint: spin_2, direction: cw, motor_constant: 3.0e-5, moment_constant: 0.02, "
    text += "time_constant_up: 0.01, time_constant_down: 0.02, max_rot_velocity: 900}]"
    (tmp_path / "rotors.yaml").write_text(text)
    rotors, remarks = read(model(properties=PROPERTIES))
    assert [rotor.motor_constant for rotor in rotors] == [3e-5]
    assert remarks == [("ignored", "rotors")]


@pytest.mark.parametrize("name", ["world.txt", "drone.urdf"])
def test_other_files_are_no_worlds(write, name):
    path = write("x", name)
    with pytest.raises(WorkbenchError) as caught:
        read_world(path)
    assert str(caught.value) == f"{path}: a world is a .yaml file, or a .sdf or .world of Gazebo"


@pytest.mark.parametrize("flight", [(), ("--scenario", "hover", "--at-time", "0.1")])
def test_what_is_left_out_of_a_world_is_said_once(capsys, tmp_path, flight):
    path = tmp_path / "town.sdf"
    path.write_text('<sdf version="1.9"><world name="w"><road name="r"/></world></sdf>')
    assert main(["frames", "--world", str(path), *flight]) == 0
    assert capsys.readouterr().err.count("<road> of the world") == 1


def test_arguments_of_an_sdf_file_are_refused(tmp_path):
    path = tmp_path / "a.sdf"
    with pytest.raises(WorkbenchError, match="only a xacro file takes arguments"):
        read_description(path, {"mass": "2"})


def test_the_world_on_the_page_is_there(write):
    text = next(block.text for block in blocks("formats.md") if block.file == "yard.sdf")
    assert read_world(write(text, "yard.sdf")).names == ("wall::link",)


def loaded(*lines: str) -> set[str]:
    """Return the modules that a fresh interpreter has after these lines."""
    code = "\n".join(["import sys", *lines, "print(*sys.modules)"])
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True)
    return set(done.stdout.split())


def test_a_urdf_loads_neither_readers_nor_entry_points(write, quad):
    path = write(quad, "quad.urdf")
    line = "from workbench.plant.description import read_description"
    found = loaded(line, f"read_description({str(path)!r})")
    assert not [name for name in found if name.startswith("workbench.extras")]
    assert "workbench.plant.formats.urdf" in found
    assert not [name for name in found - loaded(line) if name.startswith("importlib.metadata")]


def test_a_format_loads_its_own_reader_alone(write):
    path = write('<sdf version="1.9"><model name="m"><link name="l"/></model></sdf>', "a.sdf")
    line = "from workbench.plant.description import read_description"
    found = loaded(line, f"read_description({str(path)!r})")
    here = {each for each in READERS if f"workbench.extras.formats.{each}" in found}
    assert here == {"sdf"}

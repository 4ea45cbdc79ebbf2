"""Oracle: the table as written."""

import dataclasses
import math

import numpy as np
import pytest

from workbench.common.errors import WorkbenchError
from workbench.systems.rotor_playback import load_rotor_commands, make_rotor_playback


@pytest.fixture
def write(tmp_path):
    def write_table(text: str):
        path = tmp_path / "table.csv"
        path.write_text(text)
        return path

    return write_table


def fault(path, vehicle) -> str:
    with pytest.raises(WorkbenchError) as caught:
        load_rotor_commands(path, vehicle)
    said = str(caught.value)
    assert said.startswith(str(path))
    assert "\n" not in said
    return said


@pytest.mark.parametrize("header", ["", "t [s],f1 [N],f2 [N],f3 [N],f4 [N]\n", "\ufeff"])
def test_thrusts_become_the_speeds_that_make_them(write, vehicle, header):
    commands = load_rotor_commands(write(f"{header}0,1,2,3,4\n\n0.5, 4,3,2,1\n"), vehicle)
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    assert commands.time.tolist() == [0.0, 0.5]
    assert constants * commands.speeds**2 == pytest.approx(
        np.array([[1.0, 2.0, 3.0, 4.0], [4.0, 3.0, 2.0, 1.0]])
    )


def test_a_thrust_curve_with_a_linear_part_is_inverted(write, vehicle):
    rotors = tuple(dataclasses.replace(r, linear_motor_constant=2e-3) for r in vehicle.rotors)
    curved = dataclasses.replace(vehicle, rotors=rotors)
    (speeds,) = load_rotor_commands(write("0,1,2,3,4\n"), curved).speeds
    made = rotors[0].motor_constant * speeds**2 + 2e-3 * speeds
    assert made == pytest.approx([1.0, 2.0, 3.0, 4.0])


def test_a_row_holds_until_the_next_and_the_last_for_ever(write, vehicle):
    commands = load_rotor_commands(write("0,1,1,1,1\n0.5,2,2,2,2\n0.75,3,3,3,3\n"), vehicle)
    source = make_rotor_playback(commands)
    context = source.CreateDefaultContext()
    constant = vehicle.rotors[0].motor_constant
    for time, thrust in ((0, 1), (0.49, 1), (0.5, 2), (0.74, 2), (0.75, 3), (2.0, 3), (1e3, 3)):
        context.SetTime(time)
        speed = math.sqrt(thrust / constant)
        assert source.get_output_port().Eval(context) == pytest.approx([speed] * 4)


@pytest.mark.parametrize(
    ("text", "line", "word"),
    [
        ("0,1,1,1,1\n1,2,2,2\n", 2, "4 columns"),
        ("0,1,1,1,1\n1,2,2,two,2\n", 2, "'two'"),
        ("0,1,1,1,1\n1,2,2,nan,2\n", 2, "'nan'"),
        ("0,1,1,1,1\n1,2,2,-2,2\n", 2, "rotor 3"),
        ("0,1,1,1,1\n1,2,200,2,2\n", 2, "rotor 2"),
        ("0.1,1,1,1,1\n", 1, "0.1 s"),
        ("0,1,1,1,1\n0,1,1,1,1\n", 2, "rise"),
        ("0,1,1,1,1\n\n2,1,1,1,1\n1,1,1,1,1\n", 4, "rise"),
    ],
)
def test_what_cannot_be_flown_is_named_with_its_line(write, vehicle, text, line, word):
    path = write(text)
    said = fault(path, vehicle)
    assert said.startswith(f"{path}:{line}: ")
    assert word in said


@pytest.mark.parametrize("text", ["", "t,a,b,c,d\n", "\n\n"])
def test_an_empty_table_is_refused(write, vehicle, text):
    assert "no row" in fault(write(text), vehicle)


def test_a_missing_table_is_named(tmp_path, vehicle):
    assert "no such file" in fault(tmp_path / "gone.csv", vehicle)

"""Oracle: the files as written."""

import pytest

from workbench.errors import WorkbenchError
from workbench.gains import load_gains, vehicle_gains
from workbench.parameters import defaults
from workbench.resources import find_model, list_models

TEXT = """vehicle: quad
origin: by hand
gains:
  kp_roll: 120
  max_tilt: 0.5
"""


@pytest.fixture
def write(tmp_path):
    def write_gains(text: str):
        path = tmp_path / "gains.yaml"
        path.write_text(text)
        return path

    return write_gains


def fault(path) -> str:
    with pytest.raises(WorkbenchError) as caught:
        load_gains(path)
    said = str(caught.value)
    assert "\n" not in said
    return said


def test_a_gain_file_is_read(write):
    file = load_gains(write(TEXT))
    assert (file.vehicle, file.origin) == ("quad", "by hand")
    assert file.gains == {"kp_roll": 120.0, "max_tilt": 0.5}
    assert all(type(value) is float for value in file.gains.values())


def test_vehicle_and_origin_may_be_left_out(write):
    file = load_gains(write("gains: {kp_roll: 1.0}\n"))
    assert (file.vehicle, file.origin, file.gains) == ("", "", {"kp_roll": 1.0})


@pytest.mark.parametrize(
    ("old", "new", "line", "word"),
    [
        ("kp_roll", "kp_rol", 4, "did you mean 'kp_roll'"),
        ("120", "-1", 4, "0 .. 2500"),
        ("120", "fast", 4, "'fast'"),
        ("120", ".nan", 4, "number"),
        ("120", ".inf", 4, "0 .. 2500"),
        ("120", "", 4, "number"),
        ("120", "true", 4, "number"),
        ("0.5", "[0.5]", 5, "number"),
        ("origin", "orign", 2, "did you mean 'origin'"),
        ("max_tilt: 0.5", "max_tilt: 5.0", 5, "0.05 .. 1.2 rad"),
    ],
)
def test_what_cannot_be_is_named_with_its_line(write, old, new, line, word):
    assert old in TEXT
    path = write(TEXT.replace(old, new))
    said = fault(path)
    assert said.startswith(f"{path}:{line}: ")
    assert word in said


@pytest.mark.parametrize("text", ["vehicle: quad\n", "gains: 3\n", "gains: [1]\n", "gains:\n"])
def test_a_file_without_gains_is_refused(write, text):
    path = write(text)
    assert fault(path).startswith(f"{path}:1: a gain file has 'gains:'")


def test_a_vehicles_gains_are_the_defaults_and_its_own(write, tmp_path):
    write("gains: {kp_roll: 99.0}\n")
    values = vehicle_gains(tmp_path / "drone.urdf")
    assert values == {**defaults(), "kp_roll": 99.0}


def test_a_vehicle_without_a_gain_file_has_the_defaults(tmp_path):
    assert vehicle_gains(tmp_path / "drone.urdf") == defaults()


@pytest.mark.parametrize("model", list_models())
def test_shipped_gains_are_for_the_vehicle_they_lie_beside(model):
    path = find_model(model).parent / "gains.yaml"
    file = load_gains(path)
    assert file.vehicle == model
    assert file.origin
    assert set(file.gains) <= set(defaults())

"""Oracle: the files as written."""

import dataclasses

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model, list_models
from workbench.control.controller_file import load_controller
from workbench.gains.gain_choice import Gain, choose_gains, flight_gains, rule_gains
from workbench.gains.gains import load_gains
from workbench.plant.loading import load_vehicle

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


@pytest.fixture(scope="module")
def shipped():
    return load_vehicle(find_model("dh_drone"))


@pytest.fixture
def vehicle(shipped, tmp_path):
    """The shipped drone, in a folder of its own."""
    return dataclasses.replace(shipped, source=tmp_path / "drone.urdf")


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


def test_what_cannot_be_is_named_with_its_line(case, write):
    for old, new, line, word in [
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
    ]:
        with case(old, new, line, word):
            assert old in TEXT
            path = write(TEXT.replace(old, new))
            said = fault(path)
            assert said.startswith(f"{path}:{line}: ")
            assert word in said


@pytest.mark.parametrize("text", ["vehicle: quad\n", "gains: 3\n", "gains: [1]\n", "gains:\n"])
def test_a_file_without_gains_is_refused(write, text):
    path = write(text)
    assert fault(path).startswith(f"{path}:1: a gain file has 'gains:'")


def test_a_vehicle_without_a_gain_file_has_the_rules(vehicle):
    assert flight_gains(vehicle) == {**load_controller().table.defaults(), **rule_gains(vehicle)}


def test_a_vehicles_own_gain_file_goes_on_top_of_the_rule(vehicle, write):
    write("gains: {kp_roll: 99.0}\n")
    assert flight_gains(vehicle) == {
        **load_controller().table.defaults(),
        **rule_gains(vehicle),
        "kp_roll": 99.0,
    }


def test_every_layer_goes_on_top_of_the_one_before_and_says_so(vehicle, write, tmp_path):
    own = write("gains: {kp_roll: 99.0, kp_pitch: 98.0, max_speed: 7.0}\n")
    file = tmp_path / "other.yaml"
    file.write_text("gains: {kp_roll: 55.0, kp_pitch: 54.0}\n")
    chosen = choose_gains(vehicle, str(file), {"kp_roll": 11.0})
    assert chosen["kp_roll"] == Gain(11.0, "--set")
    assert chosen["kp_pitch"] == Gain(54.0, str(file))
    assert chosen["max_speed"] == Gain(7.0, str(own))
    assert chosen["kd_roll"] == Gain(rule_gains(vehicle)["kd_roll"], "rule")
    assert chosen["max_height"] == Gain(120.0, "default")
    values = flight_gains(vehicle, str(file), {"kp_roll": 11.0})
    assert values == {name: gain.value for name, gain in chosen.items()}
    assert list(values) == list(load_controller().table.defaults())


def test_what_is_wrong_in_any_layer_is_refused(vehicle, write):
    with pytest.raises(WorkbenchError, match="no such file"):
        flight_gains(vehicle, "gone.yaml")
    with pytest.raises(WorkbenchError, match="did you mean 'kp_roll'"):
        flight_gains(vehicle, settings={"kp_rol": 1.0})
    path = write("gains: {kp_roll: fast}\n")
    with pytest.raises(WorkbenchError, match=f"{path}:1: .*number"):
        flight_gains(vehicle)


def test_the_shipped_drone_flies_with_its_own_gains(shipped):
    """All that the rule would give are in its file, so that the rule can change without it."""
    chosen = choose_gains(shipped)
    assert chosen["kp_roll"].value == 225.0
    for name in rule_gains(shipped):
        assert chosen[name].origin.endswith("dh_drone/gains.yaml"), name


@pytest.mark.parametrize("model", list_models())
def test_shipped_gains_are_for_the_vehicle_they_lie_beside(model):
    path = find_model(model).parent / "gains.yaml"
    file = load_gains(path)
    assert file.vehicle == model
    assert file.origin
    assert set(file.gains) <= set(load_controller().table.defaults())

"""The battery of gz-sim's plugin and of a sidecar, worked out by hand."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.gains.gain_choice import flight_gains, make_profile
from workbench.plant.description import read_description
from workbench.plant.formats.urdf_writer import stored_files
from workbench.plant.loading import make_vehicle
from workbench.plant.vehicle import BatteryPack

PLUGIN = """<gazebo><plugin filename="gz-sim-linear-battery-plugin-system" name="{name}">{rows}
  </plugin></gazebo></robot>"""
ROWS = """<voltage>12.6</voltage><capacity>5</capacity><resistance>0.02</resistance>
  <open_circuit_voltage_constant_coef>12.6</open_circuit_voltage_constant_coef>
  <open_circuit_voltage_linear_coef>-3.0</open_circuit_voltage_linear_coef>"""
SIDECAR = """battery: {{capacity: {capacity}, resistance: 1.0e-2, open_circuit_voltage: {points}}}
defaults: {{motor_constant: 1.0e-5, moment_constant: 0.02, max_rot_velocity: 1000,
  time_constant_up: 0.02, time_constant_down: 0.03}}
rotors:
  - {{joint: joint_0, direction: cw}}
  - {{joint: joint_1, direction: ccw}}
  - {{joint: joint_2, direction: cw}}
  - {{joint: joint_3, direction: ccw}}
"""


@pytest.fixture
def powered(quad, write):
    """Write the quadrotor with a battery plugin."""

    def write_powered(rows: str, name: str = "gz::sim::systems::LinearBatteryPlugin"):
        return write(quad.replace("</robot>", PLUGIN.format(rows=rows, name=name)))

    return write_powered


def test_gazebos_battery_is_a_line(powered):
    """5 A h are 18000 C; empty, E0 + E1 is left."""
    description = read_description(powered(ROWS))
    assert description.battery == BatteryPack(18000.0, 0.02, ((0.0, pytest.approx(9.6)), (1, 12.6)))
    assert make_vehicle(description).battery == description.battery
    assert not any("battery" in remark.text for remark in description.remarks)


def test_a_battery_that_says_too_little_is_not_used(powered):
    description = read_description(powered("<voltage>12.6</voltage>"))
    assert description.battery is None
    assert any("has no <capacity>" in remark.text for remark in description.remarks)


def test_a_sidecars_battery_counts_more_and_is_stored(powered, tmp_path):
    path = powered(ROWS)
    points = "[[0, 9], [0.2, 10.8], [1, 12.6]]"
    beside = path.with_name("quad.rotors.yaml")
    beside.write_text(SIDECAR.format(capacity=3600, points=points))
    description = read_description(path)
    assert description.battery == BatteryPack(3600.0, 0.01, ((0, 9), (0.2, 10.8), (1, 12.6)))
    ((name, data), *_) = stored_files(description)
    stored = tmp_path / "stored" / name
    stored.parent.mkdir()
    stored.write_bytes(data)
    assert read_description(stored).battery == description.battery


def test_a_battery_says_how_long_it_hovers_and_what_is_compensated(powered, tmp_path):
    path = powered(
        f"{ROWS}<hoverDuration>900</hoverDuration><sagCompensation>0.5</sagCompensation>"
    )
    description = read_description(path)
    battery = description.battery
    assert (battery.hover_duration, battery.sag_compensation) == (900.0, 0.5)
    vehicle = make_vehicle(description)
    values = flight_gains(vehicle)
    assert (values["battery_duration"], values["sag_compensation"]) == (900.0, 0.5)
    assert flight_gains(vehicle, settings={"battery_duration": 60.0})["battery_duration"] == 60.0
    kept = make_profile(vehicle, values, "flown").gains
    assert "drag_area" in kept and "battery_duration" not in kept  # a later edit of it counts
    ((name, data), *_) = stored_files(description)
    stored = tmp_path / "stored" / name
    stored.parent.mkdir()
    stored.write_bytes(data)
    assert read_description(stored).battery == battery
    beside = path.with_name("quad.rotors.yaml")
    points = "[[0, 9], [1, 12]], hover_duration: 800, sag_compensation: 1"
    beside.write_text(SIDECAR.format(capacity=9, points=points))
    other = read_description(path).battery
    assert (other.hover_duration, other.sag_compensation) == (800.0, 1.0)
    for wrong, text in (("hover_duration: 0", "positive time"), ("sag_compensation: 2", "0 to 1")):
        beside.write_text(SIDECAR.format(capacity=9, points=f"[[0, 9], [1, 12]], {wrong}"))
        with pytest.raises(WorkbenchError, match=rf"quad\.rotors\.yaml:1: .*{text}"):
            read_description(path)


@pytest.mark.parametrize(
    ("capacity", "points"),
    [
        (0, "[[0, 9], [1, 12]]"),
        (9, "[]"),
        (9, "[[0, 9]]"),
        (9, "[[0, 9], [1]]"),
        (9, "[[0, 9], [0.9, 12]]"),
        (9, "[[0, 12], [1, 9]]"),
        (9, "[[0, .nan], [1, 12]]"),
        (9, "[[0.5, 9], [0, 10], [1, 12]]"),
    ],
)
def test_a_battery_that_cannot_be_is_named_with_its_line(powered, capacity, points):
    path = powered("")
    beside = path.with_name("quad.rotors.yaml")
    beside.write_text(SIDECAR.format(capacity=capacity, points=points))
    with pytest.raises(WorkbenchError, match=r"quad\.rotors\.yaml:1: .*battery"):
        read_description(path)

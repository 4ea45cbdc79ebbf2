"""What a Context holds at the start of a flight, and what may be changed in it."""

from dataclasses import replace

import pytest

from workbench.common.errors import WorkbenchError
from workbench.control.controller_file import load_controller
from workbench.control.guidance import Reference
from workbench.diagram.workbench import make_workbench
from workbench.parameters.flight_parameters import MAX_WEAKENED_ROTORS
from workbench.plant.sensors import CORE_SENSORS
from workbench.scenario.scenario import Scenario, SensorsConfig, VehicleConfig
from workbench.session.live_context import LiveContext
from workbench.setup import make_setup
from workbench.systems.pilot import PilotCommand

KINDS = tuple(each.kind for each in CORE_SENSORS)
"""The shipped drone has one of each."""
CHEAP = [kind for kind in KINDS if kind != "depth_camera"]


def bench_of(args, **more):
    vehicle = VehicleConfig("dh_drone", args)
    return make_workbench(make_setup(Scenario(vehicle=vehicle, **more)))


def with_values(bench, values):
    """Return a diagram whose flights begin with other values."""
    return replace(bench, setup=replace(bench.setup, values=values))


@pytest.fixture(scope="module")
def full():
    """Everything but the camera, in a world with obstacles."""
    return bench_of({}, sensors=SensorsConfig(use=CHEAP, noise=False), world="room")


@pytest.fixture(scope="module")
def bare():
    """A drone without an IMU, on which nothing is switched on, in an empty world."""
    return bench_of({"imu": "false"})


def test_a_value_is_set_where_it_belongs_and_read_back(case, full):
    for system in [*CHEAP, "obstacles", "rotors", "air"]:
        with case(system):
            rows = {"obstacles": "warning_distance", "rotors": "rotor_2", "air": "wind_y"}
            row = load_controller().table.find(rows.get(system, f"{system}_fault"))
            live = LiveContext(full)
            assert live.get(row) == row.default
            live.set({row.name: row.maximum})
            assert live.get(row) == row.maximum


def test_a_row_acts_on_every_sensor_of_its_kind(full):
    live = LiveContext(full)
    live.set({"range_finder_fault": 3.0})
    faults = {
        mounted.choice.sensor.kind: mounted.system.GetMyContextFromRoot(live.root)
        .get_numeric_parameter(0)
        .GetAtIndex(0)
        for mounted in full.sensing.mounted
    }
    assert faults == {kind: 3.0 if kind == "range_finder" else 0.0 for kind in CHEAP}


@pytest.mark.parametrize(
    ("name", "words"),
    [
        ("gps_fault", ("nothing in this flight uses it", "--sensors gps`, or", "--estimator ekf")),
        ("range_finder_fault", ("switch the range finder on", "--sensors range_finder")),
        ("imu_fault", ("dh_drone has no imu",)),
        ("warning_distance", ("world with obstacles", "--world room")),
        ("rotor_5", ("dh_drone has 4 rotors",)),
        (f"rotor_{MAX_WEAKENED_ROTORS}", ("dh_drone has 4 rotors",)),
    ],
)
def test_what_is_not_there_is_answered_with_a_remedy(bare, name, words):
    live, row = LiveContext(bare), load_controller().table.find(name)
    for act in (lambda: live.set({row.name: row.maximum}), lambda: live.get(row)):
        with pytest.raises(WorkbenchError) as caught:
            act()
        said = str(caught.value)
        assert not [word for word in (name, *words) if word not in said]
        assert "\n" not in said


def test_of_a_set_with_one_parameter_that_is_not_there_nothing_is_set(bare):
    live = LiveContext(bare)
    with pytest.raises(WorkbenchError, match="gps_fault cannot be set"):
        live.set({"wind_x": 3.0, "gps_fault": 1.0})
    assert live.get(load_controller().table.find("wind_x")) == 0.0


def test_faults_among_the_values_are_set_at_the_start(full):
    faults = {"lidar_fault": 2.0, "rotor_1": 0.5}
    live = LiveContext(with_values(full, {**load_controller().table.defaults(), **faults}))
    assert live.get(load_controller().table.find("lidar_fault")) == 2.0
    assert live.get(load_controller().table.find("rotor_1")) == 0.5
    assert live.get(load_controller().table.find("imu_fault")) == 0.0


def test_a_fault_of_what_is_not_there_is_refused_and_none_is_not(bare):
    LiveContext(with_values(bare, load_controller().table.defaults()))
    with pytest.raises(WorkbenchError, match="gps_fault cannot be set"):
        LiveContext(with_values(bare, {"gps_fault": 1.0}))
    with pytest.raises(WorkbenchError, match="rotor_6 cannot be set"):
        LiveContext(with_values(bare, {"rotor_6": 0.0}))


def test_each_begins_alone(full):
    """Two flights of one diagram: what is set in one is not in the other."""
    one, other = LiveContext(full), LiveContext(full)
    one.set({"wind_x": 7.0})
    one.command = PilotCommand(Reference(1.0, *[0.0] * 7), 1.0, 1.0, 2.0)
    one.simulator.AdvanceTo(0.25)
    assert other.get(load_controller().table.find("wind_x")) == 0.0
    assert other.command == PilotCommand()
    assert other.root.get_time() == 0.0
    assert one.command == PilotCommand(Reference(1.0, *[0.0] * 7), 1.0, 1.0, 2.0)

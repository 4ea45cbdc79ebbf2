"""What a Context holds at the start of a flight, and what may be changed in it."""

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model, find_world
from workbench.control.controller import load_controller
from workbench.control.guidance import Reference
from workbench.diagram.sensor_choice import choose_sensors
from workbench.diagram.workbench import make_workbench
from workbench.gains.gains import flight_gains
from workbench.plant.description import read_description
from workbench.plant.loading import make_vehicle
from workbench.plant.worlds.reading import read_world
from workbench.scenario.parameters import MOST_ROTORS, SENSOR_KINDS, parameter_table
from workbench.scenario.scenario import Rates, Scenario, SensorsConfig
from workbench.session.live_context import LiveContext
from workbench.systems.pilot import Wish

CHEAP = [kind for kind in SENSOR_KINDS if kind != "depth_camera"]


def bench_of(args, scenario: Scenario, world: str = "empty"):
    description = read_description(find_model("dh_drone"), args)
    vehicle = make_vehicle(description)
    return make_workbench(
        load_controller(),
        description,
        vehicle,
        flight_gains(vehicle),
        Rates(),
        world=read_world(find_world(world), {}),
        sensors=choose_sensors(vehicle, scenario),
        seed=scenario.sensors.seed,
    )


@pytest.fixture(scope="module")
def scenario():
    return Scenario(sensors=SensorsConfig(use=CHEAP, noise=False))


@pytest.fixture(scope="module")
def full(scenario):
    """Everything but the camera, in a world with obstacles."""
    return bench_of({}, scenario, "room")


@pytest.fixture(scope="module")
def bare():
    """A drone without an IMU, on which nothing is switched on, in an empty world."""
    return bench_of({"imu": "false"}, Scenario())


def test_a_value_is_set_where_it_belongs_and_read_back(case, full, scenario):
    for system in [*CHEAP, "obstacles", "rotors", "air"]:
        with case(system):
            rows = {"obstacles": "warning_distance", "rotors": "rotor_2", "air": "wind_y"}
            row = parameter_table().find(rows.get(system, f"{system}_fault"))
            live = LiveContext(full, scenario)
            assert live.get(row) == row.default
            live.set({row.name: row.maximum})
            assert live.get(row) == row.maximum


def test_a_row_acts_on_every_sensor_of_its_kind(full, scenario):
    live = LiveContext(full, scenario)
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
        (f"rotor_{MOST_ROTORS}", ("dh_drone has 4 rotors",)),
    ],
)
def test_what_is_not_there_is_answered_with_a_remedy(bare, name, words):
    live, row = LiveContext(bare, Scenario()), parameter_table().find(name)
    for act in (lambda: live.set({row.name: row.maximum}), lambda: live.get(row)):
        with pytest.raises(WorkbenchError) as caught:
            act()
        said = str(caught.value)
        assert not [word for word in (name, *words) if word not in said]
        assert "\n" not in said


def test_of_a_set_with_one_parameter_that_is_not_there_nothing_is_set(bare):
    live = LiveContext(bare, Scenario())
    with pytest.raises(WorkbenchError, match="gps_fault cannot be set"):
        live.set({"wind_x": 3.0, "gps_fault": 1.0})
    assert live.get(parameter_table().find("wind_x")) == 0.0


def test_faults_among_the_values_are_set_at_the_start(full, scenario):
    live = LiveContext(
        full, scenario, {**parameter_table().defaults(), "lidar_fault": 2.0, "rotor_1": 0.5}
    )
    assert live.get(parameter_table().find("lidar_fault")) == 2.0
    assert live.get(parameter_table().find("rotor_1")) == 0.5
    assert live.get(parameter_table().find("imu_fault")) == 0.0


def test_a_fault_of_what_is_not_there_is_refused_and_none_is_not(bare):
    LiveContext(bare, Scenario(), parameter_table().defaults())
    with pytest.raises(WorkbenchError, match="gps_fault cannot be set"):
        LiveContext(bare, Scenario(), {"gps_fault": 1.0})
    with pytest.raises(WorkbenchError, match="rotor_6 cannot be set"):
        LiveContext(bare, Scenario(), {"rotor_6": 0.0})


def test_each_begins_alone(full, scenario):
    """Two flights of one diagram: what is set in one is not in the other."""
    one, other = LiveContext(full, scenario), LiveContext(full, scenario)
    one.set({"wind_x": 7.0})
    one.wish = Wish(Reference(1.0, *[0.0] * 7), 1.0, 1.0, 2.0)
    one.simulator.AdvanceTo(0.25)
    assert other.get(parameter_table().find("wind_x")) == 0.0
    assert other.wish == Wish()
    assert other.root.get_time() == 0.0
    assert one.wish == Wish(Reference(1.0, *[0.0] * 7), 1.0, 1.0, 2.0)

"""Oracle: the shipped drone has four rotors and a sensor of each kind, the palm quad none."""

import dataclasses

import pytest

from workbench.common.errors import WorkbenchError
from workbench.common.resources import find_model
from workbench.control.controller_file import load_controller
from workbench.gains.gain_choice import flight_gains
from workbench.parameters.parameter_table import (
    check_parameters,
    check_settings,
    vehicle_parameters,
)
from workbench.plant.loading import load_vehicle
from workbench.plant.sensors import CORE_SENSORS, added_sensors, sensor_kinds
from workbench.scenario.scenario import Action, Scenario
from workbench.session.session import Session

TABLE = load_controller().table


@pytest.fixture(scope="module")
def vehicle():
    return load_vehicle(find_model("dh_drone"))


def test_a_quadrotor_has_four_of_the_rotor_rows(vehicle):
    names = [row.name for row in vehicle_parameters(vehicle, TABLE)]
    assert [name for name in names if name.startswith("rotor_")] == [f"rotor_{k}" for k in "1234"]
    added = {each.kind for each in added_sensors()}
    assert (
        len(names) == len([row for row in TABLE.rows if row.system not in {*added, "cables"}]) - 8
    )


def test_faults_are_rows_of_the_sensors_that_there_are(vehicle):
    blind = dataclasses.replace(vehicle, sensors=())
    systems = {row.system for row in vehicle_parameters(vehicle, TABLE)}
    assert systems.issuperset(each.kind for each in CORE_SENSORS)
    assert {row.system for row in vehicle_parameters(blind, TABLE)}.isdisjoint(sensor_kinds())
    with pytest.raises(WorkbenchError, match="lidar_fault cannot be set: dh_drone has no lidar"):
        check_parameters(blind, ["lidar_fault"], TABLE)


def test_what_is_not_there_is_refused_before_the_flight(vehicle):
    said = "rotor_9 cannot be set: dh_drone has 4 rotors"
    with pytest.raises(WorkbenchError, match=said):
        flight_gains(vehicle, "", {"rotor_9": 0.5})
    with pytest.raises(WorkbenchError, match=said):
        Session(Scenario(script=[Action(at=5.0, set={"rotor_9": 0.0})]))


def test_defaults_may_be_given_for_what_is_not_there(vehicle):
    defaults = {row.name: row.default for row in TABLE}
    check_settings(vehicle, defaults, TABLE)
    with pytest.raises(WorkbenchError, match="rotor_8 cannot be set"):
        check_settings(vehicle, defaults | {"rotor_8": 0.5}, TABLE)

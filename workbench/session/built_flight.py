"""What a scenario flies, built: read, varied, given its gains, and put into a diagram."""

from collections.abc import Mapping
from dataclasses import dataclass
from typing import TYPE_CHECKING

from pydrake.geometry import Meshcat

from workbench.control.controller import Controller, with_estimator
from workbench.control.flight_law import law_constants
from workbench.diagram.sensor_choice import choose_sensors
from workbench.diagram.workbench import Workbench, make_workbench
from workbench.estimation.estimators import Estimator
from workbench.gains.gains import flight_gains, remark_on_owner
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import Payload, payload_of
from workbench.plant.variation import varied
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import World
from workbench.scenario.configured import (
    read_configured,
    read_configured_world,
    tell_remarks,
    tell_world,
)
from workbench.scenario.parameters import check_settings
from workbench.scenario.scenario import Scenario, check_scenario, flown_controller, flown_tables
from workbench.session.script import scenario_feedforward, scenario_path

if TYPE_CHECKING:
    from workbench.systems.bridge import Bridge


@dataclass(frozen=True)
class BuiltFlight:
    """A scenario's diagram, and what it was built from.

    Attributes:
        scenario: that was built.
        vehicle: as the controller knows it.
        controller: that flies it.
        world: in which it flies.
        values: of all parameters, by name.
        bench: the diagram.
    """

    scenario: Scenario
    vehicle: Vehicle
    controller: Controller
    world: World
    values: Mapping[str, float]
    bench: Workbench


def build_flight(
    scenario: Scenario,
    settings: Mapping[str, float] | None,
    meshcat: Meshcat | None,
    bridge: "Bridge | None",
    picture_period: float,
    estimator: Estimator | None = None,
) -> BuiltFlight:
    """Read and build what a scenario names; arguments and exceptions are those of `Session`.

    An estimator of the user's own that flew before flies on, whatever its file has by now.
    """
    check_scenario(scenario)
    description = read_configured(scenario.vehicle)
    vehicle = make_vehicle(description)
    variation = scenario.vehicle.variation
    tell_remarks(description, vehicle)
    controller = flown_controller(scenario)
    if estimator:
        controller = with_estimator(controller, estimator)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, controller)
    remark_on_owner(scenario.vehicle.gains, vehicle.name, controller)
    world = read_configured_world(scenario)
    tell_world(world)
    bench = make_workbench(
        controller,
        varied(description, vehicle, variation),
        vehicle,
        values,
        scenario.rates,
        scenario_path(scenario),
        meshcat,
        world,
        choose_sensors(vehicle, scenario),
        scenario.sensors.seed,
        variation,
        bridge,
        picture_period,
        scenario_feedforward(scenario),
        scenario.estimator,
        scenario.sensors.noise,
    )
    _check_script(scenario, vehicle, payload_of(values))
    return BuiltFlight(scenario, vehicle, controller, world, values, bench)


def _check_script(scenario: Scenario, vehicle: Vehicle, payload: Payload) -> None:
    """Refuse what a script sets, before it flies: rows and payloads that the vehicle cannot have.

    Args:
        scenario: with the script.
        vehicle: as the controller knows it.
        payload: at the start.
    """
    tables = zip(scenario.script, flown_tables(scenario), strict=True)
    for action, table in sorted(tables, key=lambda each: each[0].at):
        check_settings(vehicle, action.set, table)
        carried = {name: value for name, value in action.set.items() if name in Payload._fields}
        if carried:
            payload = payload._replace(**carried)
            law_constants(vehicle, payload)

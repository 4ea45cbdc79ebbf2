"""What flies: everything that a scenario names, read once."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from workbench.common.parameter import HOOKS, hooks_are_open
from workbench.common.resources import find_file
from workbench.control.controller import LIMITS_GROUP, Controller
from workbench.control.controller_file import with_setpoints
from workbench.control.law_constants import law_constants
from workbench.estimation.estimators import Estimator, find_estimator
from workbench.gains.gain_choice import flight_gains, warn_of_other_vehicle
from workbench.gains.gains import load_gains
from workbench.parameters.parameter_table import ParameterTable, check_settings
from workbench.parameters.servo_parameters import servo_parameters
from workbench.plant.description import Description
from workbench.plant.home import DEFAULT_HOME, Home
from workbench.plant.loading import make_vehicle
from workbench.plant.payload import Payload, payload_of
from workbench.plant.tree import without_loads
from workbench.plant.variation import Variation, varied_description
from workbench.plant.vehicle import Vehicle
from workbench.plant.worlds.world import World
from workbench.scenario.configured import (
    log_remarks,
    log_world_remarks,
    read_configured,
    read_configured_world,
    warn_of_gyro_bias,
)
from workbench.scenario.flown_controller import at_own_period, flown_controller, script_controllers
from workbench.scenario.scenario import Rates, Scenario
from workbench.scenario.scenario_check import check_scenario
from workbench.scenario.sensor_choice import SensorChoice, choose_sensors, log_absent_sensors


@dataclass(frozen=True, eq=False)
class Setup:
    """What flies: diagrams, linear models and compiled flights are made of it, and read no names.

    Attributes:
        scenario: start, script, rates, variation and seed; its control period is that of the law.
        description: of the vehicle, as the controller knows it.
        vehicle: its record.
        controller: whose law flies, with the user's own estimator if any.
        estimator: provides the motion to the law; None for the truth.
        settings: parameter values over those of the vehicle and its gain file, by name.
        values: of all parameters, by name.
        gains_vehicle: name of the vehicle that the gain file is for, "" without one.
        world: the surroundings.
        sensors: the active ones, in the vehicle's order.
    """

    scenario: Scenario
    description: Description
    vehicle: Vehicle
    controller: Controller
    estimator: Estimator | None
    settings: Mapping[str, float]
    values: Mapping[str, float]
    gains_vehicle: str
    world: World
    sensors: tuple[SensorChoice, ...]

    @property
    def rates(self) -> Rates:
        """Periods of all sampled systems."""
        return self.scenario.rates

    @property
    def variation(self) -> Variation:
        """How the flying vehicle differs from the one that the controller knows."""
        return self.scenario.vehicle.variation

    @cached_property
    def flown(self) -> Description:
        """The description of the flying vehicle."""
        return varied_description(self.description, self.vehicle, self.variation)

    @cached_property
    def flown_vehicle(self) -> Vehicle:
        """Its record."""
        return self.vehicle if self.flown is self.description else make_vehicle(self.flown)

    @property
    def table(self) -> ParameterTable:
        """The parameters that can change in flight."""
        return self.controller.table

    @property
    def home(self) -> Home:
        """The place of the world's origin on the earth."""
        return self.world.home or DEFAULT_HOME

    def of_system(self, system: str) -> dict[str, Any]:
        """Return the values of one system's parameters by name."""
        return {row.name: self.values[row.name] for row in self.table.of(system)}

    def gains_of(self, law: Controller) -> tuple[str, dict[str, float]]:
        """Return the gain file and settings for a law; a gain of another law is another gain."""
        settings = {name: value for name, value in self.settings.items() if name in law.table}
        if self.controller.unscheduled != law.unscheduled:
            own = {row.name for row in self.controller.parameters if row.group != LIMITS_GROUP}
            settings = {name: value for name, value in settings.items() if name not in own}
        fits = self.controller.name in (law.name, law.unscheduled)
        return self.scenario.vehicle.gains if fits else "", settings

    def with_settings(self, settings: Mapping[str, float]) -> "Setup":
        """Return the setup with other values of some parameters.

        Raises:
            WorkbenchError: for an unknown name, a value out of range, or a parameter that the
                vehicle does not have.
        """
        changed = self.table.checked(settings)
        check_settings(self.vehicle, settings, self.table)
        setup = replace(
            self, settings={**self.settings, **settings}, values={**self.values, **changed}
        )
        _check_script(setup)
        return setup

    def varied(self, variation: Variation) -> "Setup":
        """Return the setup with another variation of the flying vehicle.

        Raises:
            WorkbenchError: if a number of it is out of its limits.
        """
        variation.check()
        vehicle = replace(self.scenario.vehicle, variation=variation)
        return replace(self, scenario=replace(self.scenario, vehicle=vehicle))

    def without_dropped_loads(self) -> "Setup":
        """Return the setup without loads and their cables if its values open the hooks."""
        vehicle = self.vehicle.with_hooks(hooks_are_open(self.values))
        if vehicle is self.vehicle:
            return self
        model = without_loads(self.description.model)
        return replace(
            self,
            description=replace(self.description, model=model),
            vehicle=vehicle,
            settings={name: x for name, x in self.settings.items() if name != HOOKS},
            values={**self.values, HOOKS: 0.0},  # of a vehicle that has none
            controller=with_servos_of(vehicle, self.controller),
        )

    def with_scenario(self, scenario: Scenario) -> "Setup":
        """Return the setup with another start, script, duration, rates or sensors.

        Vehicle, law, gains, estimator and world stay, whatever the scenario names.

        Raises:
            WorkbenchError: if the scenario cannot be flown.
        """
        check_scenario(scenario, controller=self.controller)
        sensors = choose_sensors(self.vehicle, scenario)
        setup = replace(self, scenario=scenario, sensors=sensors)
        _check_script(setup)
        return setup


def make_setup(
    scenario: Scenario | Setup | None = None,
    settings: Mapping[str, float] | None = None,
    *,
    description: Description | None = None,
    vehicle: Vehicle | None = None,
    controller: Controller | None = None,
) -> Setup:
    """Read everything that a scenario names.

    Args:
        scenario: what to fly; the default one hovers. A setup stays as it is.
        settings: parameter values over those of the vehicle and its gain file, by name.
        description: of its vehicle, if already read.
        vehicle: of that description, if already made.
        controller: in place of the scenario's.

    Raises:
        WorkbenchError: if something cannot be read, or the scenario cannot be flown.
    """
    if isinstance(scenario, Setup):
        return scenario.with_settings(settings) if settings else scenario
    scenario = scenario or Scenario()
    controller = controller or flown_controller(scenario)
    scenario = at_own_period(scenario, controller)
    check_scenario(scenario, controller=controller)
    description = description or read_configured(scenario.vehicle)
    vehicle = vehicle or make_vehicle(description)
    controller = with_servos_of(vehicle, controller)
    gains = scenario.vehicle.gains
    setup = Setup(
        scenario=scenario,
        description=description,
        vehicle=vehicle,
        controller=controller,
        estimator=controller.estimator or find_estimator(scenario.estimator),
        settings=dict(settings or {}),
        values=flight_gains(vehicle, gains, settings, controller),
        gains_vehicle=load_gains(find_file(gains), controller).vehicle if gains else "",
        world=read_configured_world(scenario),
        sensors=choose_sensors(vehicle, scenario),
    )
    _check_script(setup)
    return setup


def with_servos_of(vehicle: Vehicle, law: Controller) -> Controller:
    """Return a law with the setpoints of a vehicle's servos that it does not command."""
    return with_setpoints(law, servo_parameters(vehicle, law.servos))


def _check_script(setup: Setup) -> None:
    """Refuse actions of a script with rows or payloads that the vehicle cannot have.

    Raises:
        WorkbenchError: for the first one.
    """
    payload, script = payload_of(setup.values), setup.scenario.script
    laws = script_controllers(setup.scenario, setup.controller)
    for action, law in sorted(zip(script, laws, strict=True), key=lambda each: each[0].at):
        law = with_servos_of(setup.vehicle, law)
        law.table.checked(action.set)
        check_settings(setup.vehicle, action.set, law.table)
        carried = {name: value for name, value in action.set.items() if name in Payload._fields}
        if carried:
            payload = payload._replace(**carried)
            law_constants(setup.vehicle, payload)


def log_setup(setup: Setup) -> None:
    """Log where vehicle and world differ from their files, doubts on gains, and idle settings."""
    scenario, vehicle = setup.scenario, setup.vehicle
    log_remarks(setup.description, vehicle)
    warn_of_gyro_bias(vehicle, scenario, setup.values)
    warn_of_other_vehicle(scenario.vehicle.gains, setup.gains_vehicle, vehicle.name)
    log_absent_sensors(vehicle, scenario.sensors)
    log_world_remarks(setup.world)

"""What to fly, by name: the caller need not read scenarios, which would load parts of Drake."""

import dataclasses
from collections.abc import Mapping
from dataclasses import dataclass, field

from workbench.common.resources import find_file, find_model, find_scenario, find_world
from workbench.control.controller_file import load_controller
from workbench.estimation.estimators import find_estimator
from workbench.gains.gains import flown_by
from workbench.scenario.flown_controller import at_own_period, flown_controller
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.scenario.scenario_check import check_scenario
from workbench.scenario.scenario_file import load_scenario
from workbench.scenario.sensor_choice import for_other_vehicle


@dataclass(frozen=True)
class Choice:
    """What to fly; values that are "" or None stay as in the scenario.

    Attributes:
        scenario: name of a shipped one, or path of a file; "" for the default one, which hovers.
        model: name of a shipped model, or path of a description; it does not use the scenario's
            arguments and gains, and what it says of sensors by name, also which are in use: these
            belong to the scenario's own model.
        world: name of a shipped world, or path of a file.
        gains: path of a gain file.
        sensors: active sensors, by name or kind; "all" for all.
        args: values of arguments of the drone's xacro file, by name.
        packages: folders that the description refers to, by name of the package.
        controller: name of a shipped one, or path of a file.
        estimator: name in `ESTIMATORS`, or path of a file.
    """

    scenario: str = ""
    model: str = ""
    world: str = ""
    gains: str = ""
    sensors: tuple[str, ...] | None = None
    args: Mapping[str, str] = field(default_factory=dict)
    packages: Mapping[str, str] = field(default_factory=dict)
    controller: str = ""
    estimator: str = ""

    def check(self) -> None:
        """Check that all named files exist, without reading them.

        Raises:
            WorkbenchError: for the first one that is missing.
        """
        for name, find in (
            (self.scenario, find_scenario),
            (self.model, find_model),
            (self.world, find_world),
            (self.gains, find_file),
        ):
            if name:
                find(name)
        if self.controller:
            load_controller(self.controller)
        if self.estimator:
            find_estimator(self.estimator)

    def load(self) -> Scenario:
        """Return the scenario.

        Raises:
            WorkbenchError: if a file is missing or invalid.
        """
        self.check()
        scenario = Scenario()
        if self.scenario:
            scenario = load_scenario(find_scenario(self.scenario), self.controller, self.estimator)
        if self.model:
            scenario.vehicle = VehicleConfig(model=self.model)
            scenario.sensors = for_other_vehicle(scenario.sensors)
        scenario.controller = self.controller or scenario.controller
        scenario.estimator = self.estimator or scenario.estimator
        scenario.vehicle.args |= self.args
        scenario.vehicle.packages |= self.packages
        if self.gains:
            scenario.vehicle.gains = self.gains
        if self.sensors is not None:
            scenario.sensors = dataclasses.replace(scenario.sensors, use=list(self.sensors))
        scenario.controller = flown_by(scenario.controller, scenario.vehicle.gains)
        scenario.world = self.world or scenario.world
        law = flown_controller(scenario)
        check_scenario(scenario, controller=law)
        return at_own_period(scenario, law)


def with_arguments(what: Choice | Scenario, args: Mapping[str, str]) -> Choice | Scenario:
    """Return the choice with values for more arguments of its drone's xacro file."""
    if isinstance(what, Choice):
        return dataclasses.replace(what, args={**what.args, **args})
    vehicle = dataclasses.replace(what.vehicle, args={**what.vehicle.args, **args})
    return dataclasses.replace(what, vehicle=vehicle)

"""The model, vehicle, scenario and sensors that options choose."""

import argparse
import dataclasses
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

from workbench.commands.options import NO_SENSORS
from workbench.commands.printing import print_message
from workbench.estimation.settings import ESTIMATORS, TRUTH

if TYPE_CHECKING:
    from workbench.design.executor.executor import Executor
    from workbench.scenario.scenario import Scenario, VehicleConfig
    from workbench.setup import Setup


def flown_with(args: argparse.Namespace) -> str:
    """Return the values of a flight, for its title."""
    parts = [args.gains] if args.gains else []
    parts += [f"{name}={value:g}" for name, value in args.set]
    parts += [f"--vary {name}={value:g}" for name, value in args.vary]
    if not parts:
        return "with its own gains"
    return f"with {', '.join(parts[:-1])} and {parts[-1]}" if len(parts) > 1 else f"with {parts[0]}"


def with_model(scenario: "Scenario", args: argparse.Namespace) -> "Scenario":
    """Set the model from the command line in a scenario, and return it.

    A different model drops the arguments and gains of the scenario, and what it says of sensors by
    name, also which are in use: all that was for its own model.

    Raises:
        WorkbenchError: if there is no such model or file.
    """
    from workbench.common.resources import find_file, find_model
    from workbench.scenario.scenario import VehicleConfig
    from workbench.scenario.sensor_choice import for_other_vehicle

    if args.model:
        scenario.vehicle = VehicleConfig(model=args.model)
        scenario.sensors = for_other_vehicle(scenario.sensors)
    scenario.vehicle.args |= dict(args.arg)
    scenario.vehicle.packages |= dict(args.package)
    scenario.vehicle.rotors = args.rotors or scenario.vehicle.rotors
    find_model(scenario.vehicle.model)
    if scenario.vehicle.rotors:
        find_file(scenario.vehicle.rotors)
    return scenario


def chosen_model(args: argparse.Namespace) -> "VehicleConfig":
    """Return the model that the command line names, and how to read it."""
    from workbench.scenario.scenario import VehicleConfig

    return VehicleConfig(args.model, dict(args.arg), dict(args.package), args.rotors)


def chosen_setup(args: argparse.Namespace) -> "Setup":
    """Return what the command line lets fly, with its parameter values; held joints are logged."""
    from workbench.scenario.configured import log_held_joints
    from workbench.setup import make_setup

    setup = make_setup(chosen_scenario(args), dict(args.set))
    log_held_joints(setup.description)
    return setup


def chosen_scenario(args: argparse.Namespace, scenario: "Scenario | None" = None) -> "Scenario":
    """Set the vehicle and the world from the command line in a scenario, and return it.

    Args:
        args: of the command line.
        scenario: that a command has read; the default one without.
    """
    from workbench.common.parameter import is_servo_parameter
    from workbench.common.resources import find_file, find_world
    from workbench.gains.gains import flown_by
    from workbench.scenario.flown_controller import at_own_period, flown_controller
    from workbench.scenario.scenario import Scenario

    scenario = scenario or Scenario()
    with_model(scenario, args)  # names are checked before the second spent on loading Drake
    if args.gains:
        scenario.vehicle.gains = args.gains
    variation = dataclasses.replace(scenario.vehicle.variation, **dict(args.vary))
    variation.check()
    scenario.vehicle.variation = variation
    scenario.world = args.world or scenario.world
    scenario.controller = flown_by(args.controller or scenario.controller, scenario.vehicle.gains)
    scenario.estimator = args.estimator or scenario.estimator
    law = flown_controller(scenario)
    given = dict(args.set)
    law.table.checked({name: given[name] for name in given if not is_servo_parameter(name)})
    if scenario.vehicle.gains:
        find_file(scenario.vehicle.gains)
    find_world(scenario.world)
    _warn_of_unused_values(scenario.estimator, [name for name, _ in args.set])
    return at_own_period(scenario, law)


def _warn_of_unused_values(estimator: str, names: list[str]) -> None:
    """Report values set for estimators that are not in use."""
    from workbench.parameters.parameter_table import flight_table

    for other in ESTIMATORS:
        rows = {row.name for row in flight_table().of(other)}
        unused = [name for name in dict.fromkeys(names) if name in rows]
        if other != estimator and unused:
            flown = "the truth" if estimator == TRUTH else f"what {estimator} estimates"
            print_message(
                f"nothing uses {' and '.join(unused)}, because the controller gets {flown}: "
                f"add `--estimator {other}`"
            )


def with_sensors(scenario: "Scenario", args: argparse.Namespace) -> "Scenario":
    """Set the sensors from the command line in a scenario, and return it.

    A log of a flight with an estimator also has the IMU, so that `workbench estimate` can use it:
    the estimator reads the IMU within the update of the vehicle, and other sensors as they measure.
    """
    if args.sensors is not None:
        names = [name.strip() for name in args.sensors.split(",")]
        scenario.sensors.use = [name for name in names if name not in ("", NO_SENSORS)]
    if args.seed is not None:
        scenario.sensors.seed = args.seed
    if args.no_noise:
        scenario.sensors.noise = False
    logged = getattr(args, "log", None) is not None
    if logged and scenario.is_estimated and not {"imu", "all"} & {*scenario.sensors.use}:
        scenario.sensors.use = [*scenario.sensors.use, "imu"]
    return scenario


@contextmanager
def chosen_executor(scheduler: str, here: "Executor") -> Iterator["Executor"]:
    """Yield the executor: the cluster of a scheduler, with a message on its size, or the local one.

    Raises:
        WorkbenchError: if the scheduler cannot be reached, or flights by its workers would differ
            from local ones.
    """
    if not scheduler:
        yield here
        return
    from workbench.design.executor.cluster import DaskCluster

    with DaskCluster(scheduler) as cluster:
        print_message(f"flying on {cluster.workers} workers of {scheduler}")
        yield cluster

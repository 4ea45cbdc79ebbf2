"""Load and save scenarios, and find the files that they name."""

import dataclasses
import math
from pathlib import Path

from workbench.common.errors import WorkbenchError
from workbench.common.plain_files import write_atomically
from workbench.common.resources import find_file, find_model, find_world
from workbench.common.yaml_files import (
    YamlFile,
    as_record,
    check_schema,
    dump_changes,
    parse_yaml,
    read_yaml,
    with_numbers,
)
from workbench.control.installed_laws import is_shipped
from workbench.estimation.settings import ESTIMATORS
from workbench.scenario.scenario import Scenario, VehicleConfig
from workbench.scenario.scenario_check import MAX_SCENARIO_PERIODS_S, check_scenario


def load_scenario(path: Path | str, controller: str = "", estimator: str = "") -> Scenario:
    """Read and check a scenario file.

    Args:
        path: the file.
        controller: replaces the one that the file names: the name of a shipped one, or the path of
            a file. A Python file that only the scenario names is not executed.
        estimator: the same for the estimator.

    Raises:
        WorkbenchError: with file and line of the error.
    """
    path = Path(path)
    file = read_yaml(path)
    scenario = _scenario_of(file)
    scenario.controller = chosen_controller(file, scenario.controller, controller)
    scenario.estimator = _chosen(
        file, "estimator", scenario.estimator, estimator, scenario.estimator in ESTIMATORS
    )
    check_scenario(scenario, file)
    find_files(scenario.vehicle, file)
    find_scenario_world(scenario, file)
    return scenario


def parse_scenario(source: Path, text: str) -> Scenario:
    """Return the scenario of a YAML text, as a log has it; what it names is not looked for.

    Args:
        source: where the text is from, for messages.
        text: the YAML.

    Raises:
        WorkbenchError: with source and line of the error.
    """
    return _scenario_of(parse_yaml(source, text))


def _scenario_of(file: YamlFile) -> Scenario:
    check_schema(file, Scenario)
    scenario: Scenario = as_record(with_numbers(file, Scenario).data, Scenario)
    return scenario


def chosen_controller(file: YamlFile, named: str, given: str, trusted: Path | None = None) -> str:
    """Return the controller that flies.

    Args:
        file: the one that names it.
        named: name in the file.
        given: name from the caller, "" for none.
        trusted: a folder of files that may be executed if the file names them; None for none.

    Raises:
        WorkbenchError: if only the file names a controller that is not shipped: reading a scenario
            would execute its code.
    """
    return _chosen(file, "controller", named, given, is_shipped(named), trusted)


def _chosen(
    file: YamlFile, key: str, named: str, given: str, shipped: bool, trusted: Path | None = None
) -> str:
    """Return the controller or the estimator that flies.

    Args:
        file: the one that names it.
        key: of the name in the file, and name of the option.
        named: name in the file.
        given: name from the caller, "" for none.
        shipped: whether the one in the file is a shipped one.
        trusted: see `chosen_controller`.

    Raises:
        WorkbenchError: see `chosen_controller`.
    """
    if given or shipped:
        return given or named
    if "." not in named:
        return named  # not Python: the search for it lists the known names
    beside = file.path.parent / named
    path = beside if beside.is_file() else named
    if trusted and beside.resolve().is_relative_to(trusted.resolve()):
        return str(beside)
    raise WorkbenchError(
        f"{file.where(key)}{named} is Python code that would run here: if you trust it, name it "
        f"yourself, as --{key} {path}"
    )


def save_scenario(scenario: Scenario, path: Path) -> None:
    """Write the differences from the default scenario to a YAML file.

    Raises:
        WorkbenchError: if it cannot be written; an existing file then stays unchanged.
    """
    write_atomically(path, dump_changes(scenario))


def without_arrays(scenario: Scenario) -> Scenario:
    """Return a scenario with almost no recording, so that days of flight fit into memory."""
    step = scenario.rates.physics_step
    sparse = step * math.floor(MAX_SCENARIO_PERIODS_S["record_period"] / step)
    return dataclasses.replace(
        scenario,
        rates=dataclasses.replace(scenario.rates, record_period=sparse),
        sensors=dataclasses.replace(scenario.sensors, keep=False),
    )


def find_files(vehicle: VehicleConfig, file: YamlFile) -> None:
    """Resolve the files of a scenario relative to its own file, and reject missing ones."""
    for name, folder in vehicle.packages.items():
        vehicle.packages[name] = str((file.path.parent / folder).resolve())
    for key, find in (("model", find_model), ("rotors", find_file), ("gains", find_file)):
        name = getattr(vehicle, key)
        beside = file.path.parent / name
        try:
            if name and (beside.is_file() or (key == "model" and beside.is_dir())):
                setattr(vehicle, key, str(beside.resolve()))
            elif name:
                find(name)
        except (WorkbenchError, OSError) as error:
            raise WorkbenchError(f"{file.where('vehicle', key)}{error}") from None


def find_scenario_world(scenario: Scenario, file: YamlFile) -> None:
    """Resolve the world of a scenario relative to its file, and reject a missing one."""
    beside = file.path.parent / scenario.world
    try:
        if beside.is_file():
            scenario.world = str(beside.resolve())
        else:
            find_world(scenario.world)
    except (WorkbenchError, OSError) as error:
        raise WorkbenchError(f"{file.where('world')}{error}") from None

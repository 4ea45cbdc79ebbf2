"""A set of gains that the command line names: a gain file, a model, the rule or the defaults."""

from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING

from workbench.common.errors import WorkbenchError

if TYPE_CHECKING:
    from workbench.control.controller import Controller
    from workbench.plant.vehicle import Vehicle


_GAIN_FILE_SUFFIXES = (".yaml", ".yml")
"""Endings of gain files, which distinguish them from descriptions."""
RULE_SIDE, DEFAULT_SIDE = "rule", "default"


def check_gain_file_name(file: Path | None) -> None:
    """Check the name of a gain file to write, if any."""
    if file and file.suffix not in _GAIN_FILE_SUFFIXES:
        raise WorkbenchError(f"{file}: a gain file's name ends in .yaml")


def gains_of_side(side: str, vehicle: "Vehicle", law: "Controller") -> Mapping[str, float]:
    """Return the gains of one side of a comparison."""
    from workbench.common.resources import find_file, find_model
    from workbench.gains.gain_choice import flight_gains, make_profile, rule_values
    from workbench.gains.gains import load_gains
    from workbench.plant.loading import load_vehicle

    if names_gain_file(side):
        return load_gains(find_file(side), law).gains
    if side == RULE_SIDE:
        values = rule_values(vehicle, law)
    elif side == DEFAULT_SIDE:
        values = law.table.defaults()
    else:
        values = flight_gains(load_vehicle(find_model(side)), controller=law)
    return make_profile(vehicle, values, "", law).gains


def names_gain_file(side: str) -> bool:
    """Return whether a side of a comparison is a gain file."""
    return Path(side).suffix in _GAIN_FILE_SUFFIXES


def names_gain_model(side: str) -> bool:
    """Return whether a side of a comparison is a model."""
    return not names_gain_file(side) and side not in (RULE_SIDE, DEFAULT_SIDE)


def holds_gains(path: Path) -> bool:
    """Return whether a file is a gain file: parameters of a Crazyflie are YAML, too."""
    from workbench.common.yaml_files import read_yaml

    try:
        return path.suffix in _GAIN_FILE_SUFFIXES and "gains" in read_yaml(path).data
    except WorkbenchError:  # of what it is, the reader of autopilots' files says
        return False

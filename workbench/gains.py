"""Gain files: the values of live parameters that belong to a vehicle, as YAML."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import WorkbenchError, unknown_name
from workbench.parameters import checked, defaults, find_parameter
from workbench.resources import find_gains
from workbench.yaml_files import read_yaml

_KEYS = ("vehicle", "origin", "gains")


@dataclass(frozen=True)
class GainFile:
    """A set of parameter values with the vehicle they are for and where they come from."""

    vehicle: str
    origin: str
    gains: Mapping[str, float]


def load_gains(path: Path) -> GainFile:
    """Read and check a gain file.

    Raises:
        WorkbenchError: naming file and line of what is wrong.
    """
    file = read_yaml(path)
    for key in file.data:
        if key not in _KEYS:
            raise WorkbenchError(f"{file.where(key)}{unknown_name('key', str(key), _KEYS)}")
    gains = file.data.get("gains")
    if not isinstance(gains, dict):
        raise WorkbenchError(
            f"{file.where('gains')}a gain file has 'gains:' with NAME: VALUE lines"
        )
    values = {}
    for name, value in gains.items():
        where = file.where("gains", str(name))
        values[name] = find_parameter(str(name), where).check(value, where)
    return GainFile(
        vehicle=str(file.data.get("vehicle", "")),
        origin=str(file.data.get("origin", "")),
        gains=values,
    )


def vehicle_gains(description: Path) -> dict[str, float]:
    """Return all values for a vehicle: defaults, then `gains.yaml` beside its description."""
    values = defaults()
    beside = description.parent / "gains.yaml"
    if beside.is_file():
        values.update(load_gains(beside).gains)
    return values


def flight_gains(
    description: Path, gains: str = "", settings: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return all parameter values of a flight: the vehicle's, then a gain file's, then settings.

    Args:
        description: the vehicle's description file.
        gains: a gain file's path, or "" for none.
        settings: values by name.

    Raises:
        WorkbenchError: naming what is unknown or out of range, with file and line for a file.
    """
    values = vehicle_gains(description)
    if gains:
        values |= load_gains(find_gains(gains)).gains
    return values | checked(settings or {})


def remark_on_owner(path: str, vehicle: str) -> None:
    """Say so where a gain file was found on another vehicle; normalised as gains are, it may do."""
    owner = load_gains(find_gains(path)).vehicle if path else ""
    if owner and owner != vehicle:
        logging.getLogger("workbench").warning(
            "the gains in %s are for '%s', and '%s' flies with them", path, owner, vehicle
        )

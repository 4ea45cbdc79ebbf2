"""Gain files: the values of live parameters that belong to a vehicle, as YAML."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

from workbench.errors import WorkbenchError, unknown_name
from workbench.gain_rule import rule_gains
from workbench.parameters import checked, defaults, find_parameter
from workbench.plant.vehicle import Vehicle
from workbench.resources import find_file
from workbench.vehicle_parameters import check_settings
from workbench.yaml_files import read_yaml

_KEYS = ("vehicle", "origin", "gains")


@dataclass(frozen=True)
class GainFile:
    """A set of parameter values with the vehicle they are for and where they come from."""

    vehicle: str
    origin: str
    gains: Mapping[str, float]


@dataclass(frozen=True)
class Gain:
    """A parameter's value, and where it comes from: default, rule, a file, or --set."""

    value: float
    origin: str


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


def vehicle_gains(vehicle: Vehicle) -> dict[str, float]:
    """Return all values for a vehicle: defaults, the rule's, `gains.yaml` beside its description.

    Raises:
        WorkbenchError: if that file is wrong.
    """
    return flight_gains(vehicle)


def flight_gains(
    vehicle: Vehicle, gains: str = "", settings: Mapping[str, float] | None = None
) -> dict[str, float]:
    """Return all parameter values of a flight: the vehicle's, then a gain file's, then settings.

    Args:
        vehicle: what flies.
        gains: a gain file's path, or "" for none.
        settings: values by name.

    Raises:
        WorkbenchError: naming what is unknown or out of range, with file and line for a file.
    """
    chosen = choose_gains(vehicle, gains, settings)
    return {name: choice.value for name, choice in chosen.items()}


def choose_gains(
    vehicle: Vehicle, gains: str = "", settings: Mapping[str, float] | None = None
) -> dict[str, Gain]:
    """Return what `flight_gains` does, each value with where it comes from.

    Arguments and exceptions are those of `flight_gains`.
    """
    layers: list[tuple[str, Mapping[str, float]]] = [
        ("default", defaults()),
        ("rule", rule_gains(vehicle)),
    ]
    beside = vehicle.source.parent / "gains.yaml"
    if beside.is_file():
        layers.append((str(beside), load_gains(beside).gains))
    if gains:
        layers.append((gains, load_gains(find_file(gains)).gains))
    layers.append(("--set", checked(settings or {})))
    check_settings(vehicle, settings or {})
    return {name: Gain(value, origin) for origin, layer in layers for name, value in layer.items()}


def remark_on_owner(path: str, vehicle: str) -> None:
    """Say so where a gain file was found on another vehicle; normalised as gains are, it may do."""
    owner = load_gains(find_file(path)).vehicle if path else ""
    if owner and owner != vehicle:
        logging.getLogger("workbench").warning(
            "the gains in %s are for '%s', and '%s' flies with them", path, owner, vehicle
        )

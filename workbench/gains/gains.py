"""Which values a flight has: defaults, the rule, gain files and settings, one over the other."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.resources import find_file
from workbench.gains.profiles import GainFile, gains_at, load_gains, save_gains
from workbench.gains.rule import rule_gains
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import PARAMETERS, checked, defaults
from workbench.scenario.vehicle_parameters import check_settings

__all__ = [
    "Gain",
    "GainFile",
    "choose_gains",
    "flight_gains",
    "gains_at",
    "load_gains",
    "make_profile",
    "remark_on_owner",
    "rule_values",
    "save_gains",
    "vehicle_gains",
]


@dataclass(frozen=True)
class Gain:
    """A parameter's value, and where it comes from: default, rule, a file, or --set."""

    value: float
    origin: str


def vehicle_gains(vehicle: Vehicle) -> dict[str, float]:
    """Return all values for a vehicle: defaults, the rule's, `gains.yaml` beside its description.

    Raises:
        WorkbenchError: if that file is wrong.
    """
    return flight_gains(vehicle)


def rule_values(vehicle: Vehicle) -> dict[str, float]:
    """Return all values for a vehicle without any gain file: defaults, and the rule's."""
    return {**defaults(), **rule_gains(vehicle)}


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


def make_profile(vehicle: Vehicle, values: Mapping[str, float], origin: str) -> GainFile:
    """Return the gain file of a vehicle: its controller's rows, and what else its rule gives.

    Args:
        vehicle: its name goes into the file.
        values: parameter values by name; those of other rows are left out.
        origin: a sentence on where they come from.
    """
    ruled = rule_gains(vehicle)
    rows = [row.name for row in PARAMETERS if row.system == "controller" or row.name in ruled]
    return GainFile(vehicle.name, origin, {name: values[name] for name in rows if name in values})


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

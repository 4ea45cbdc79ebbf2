"""Which values a flight has: defaults, the rule, gain files and settings, one over the other."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.own_file import own_errors
from workbench.common.resources import find_file
from workbench.control.controller import Controller
from workbench.gains.profiles import GainFile, gains_at, load_gains, owner_of, save_gains
from workbench.plant.drag import drag_area
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import check_settings, parameter_table

__all__ = [
    "Gain",
    "GainFile",
    "choose_gains",
    "flight_gains",
    "gains_at",
    "load_gains",
    "make_profile",
    "remark_on_owner",
    "rule_gains",
    "rule_values",
    "save_gains",
]


DIGITS = 3
"""Of a value that a rule gives."""


@dataclass(frozen=True)
class Gain:
    """A parameter's value, and where it comes from: default, rule, a file, or --set."""

    value: float
    origin: str


def rule_gains(vehicle: Vehicle, controller: Controller | None = None) -> dict[str, float]:
    """Return the values of those live parameters that follow from the vehicle, by name.

    They are within the limits of the parameter table; the formulas stand with the controller.

    Raises:
        WorkbenchError: if the controller's rule fails.
    """
    table = parameter_table(controller)
    law = table.controller
    values: dict[str, float] = {}
    if law.rule is not None:
        with own_errors(law.file, "rule"):
            values = dict(law.rule(vehicle))
    values["drag_area"] = drag_area(vehicle.mass)
    found = {}
    for name, value in values.items():
        row = table.find(name, f"{law.file}: rule: ")
        found[name] = min(row.maximum, max(row.minimum, float(f"{value:.{DIGITS}g}")))
    return found


def rule_values(vehicle: Vehicle, controller: Controller | None = None) -> dict[str, float]:
    """Return all values for a vehicle without any gain file: defaults, and the rule's."""
    return {**parameter_table(controller).defaults(), **rule_gains(vehicle, controller)}


def flight_gains(
    vehicle: Vehicle,
    gains: str = "",
    settings: Mapping[str, float] | None = None,
    controller: Controller | None = None,
) -> dict[str, float]:
    """Return all parameter values of a flight: the vehicle's, then a gain file's, then settings.

    Args:
        vehicle: what flies.
        gains: a gain file's path, or "" for none.
        settings: values by name.
        controller: whose parameters they are; the default one where none is given.

    Raises:
        WorkbenchError: naming what is unknown or out of range, with file and line for a file.
    """
    chosen = choose_gains(vehicle, gains, settings, controller)
    return {name: choice.value for name, choice in chosen.items()}


def make_profile(
    vehicle: Vehicle,
    values: Mapping[str, float],
    origin: str,
    controller: Controller | None = None,
) -> GainFile:
    """Return the gain file of a vehicle: its controller's rows, and what else its rule gives.

    Args:
        vehicle: its name goes into the file.
        values: parameter values by name; those of other rows are left out.
        origin: a sentence on where they come from.
        controller: whose rows; the default one's where none is given.
    """
    table, ruled = parameter_table(controller), rule_gains(vehicle, controller)
    rows = [row.name for row in table if row.system == "controller" or row.name in ruled]
    kept = {name: values[name] for name in rows if name in values}
    return GainFile(vehicle.name, origin, kept, controller=table.controller.name)


def choose_gains(
    vehicle: Vehicle,
    gains: str = "",
    settings: Mapping[str, float] | None = None,
    controller: Controller | None = None,
) -> dict[str, Gain]:
    """Return what `flight_gains` does, each value with where it comes from.

    Arguments and exceptions are those of `flight_gains`.
    """
    table = parameter_table(controller)
    layers: list[tuple[str, Mapping[str, float]]] = [
        ("default", table.defaults()),
        ("rule", rule_gains(vehicle, controller)),
    ]
    beside = vehicle.source.parent / "gains.yaml"
    # those are of one controller; another one begins with its rule
    law = table.controller
    if beside.is_file() and owner_of(beside) in (law.name, law.unscheduled):
        layers.append((str(beside), load_gains(beside, table.controller).gains))
    if gains:
        layers.append((gains, load_gains(find_file(gains), table.controller).gains))
    layers.append(("--set", table.checked(settings or {})))
    check_settings(vehicle, settings or {}, table)
    return {name: Gain(value, origin) for origin, layer in layers for name, value in layer.items()}


def remark_on_owner(path: str, vehicle: str, controller: Controller | None = None) -> None:
    """Say so where a gain file was found on another vehicle; normalised as gains are, it may do."""
    owner = load_gains(find_file(path), controller).vehicle if path else ""
    if owner and owner != vehicle:
        logging.getLogger("workbench").warning(
            "the gains in %s are for '%s', and '%s' flies with them", path, owner, vehicle
        )

"""The gains that a vehicle flies with: stated ones, those of a file, or those of a rule."""

import logging
from collections.abc import Mapping
from dataclasses import dataclass

from workbench.common.own_file import user_code_errors
from workbench.common.resources import find_file
from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default
from workbench.gains.gains import GainFile, load_gains, owner_of
from workbench.parameters.parameter_table import check_settings
from workbench.plant.drag import drag_area
from workbench.plant.vehicle import Vehicle

RULE_VALUE_DIGITS = 3
"""Number of significant digits of a value from a rule."""
_BATTERY_PARAMETERS = {"battery_duration": "hover_duration", "sag_compensation": "sag_compensation"}
"""Attribute of a battery that gives a parameter."""


@dataclass(frozen=True)
class Gain:
    """The value of a parameter, and its origin: default, rule, a file, or --set."""

    value: float
    origin: str


def rule_gains(vehicle: Vehicle, controller: Controller | None = None) -> dict[str, float]:
    """Return the values of the live parameters that follow from the vehicle, by name.

    They are within the limits of the parameter table. The formulas are part of the controller.

    Raises:
        WorkbenchError: if the controller's rule fails.
    """
    law = controller_or_default(controller)
    values: dict[str, float] = {}
    if law.rule is not None:
        with user_code_errors(law.file, "rule"):
            values = dict(law.rule(vehicle))
    values["drag_area"] = drag_area(vehicle.mass)
    if vehicle.battery:
        stated = {name: getattr(vehicle.battery, of) for name, of in _BATTERY_PARAMETERS.items()}
        values |= {name: value for name, value in stated.items() if value is not None}
    found = {}
    for name, value in values.items():
        row = law.table.find(name, f"{law.file}: rule: ")
        found[name] = min(row.maximum, max(row.minimum, float(f"{value:.{RULE_VALUE_DIGITS}g}")))
    return found


def rule_values(vehicle: Vehicle, controller: Controller | None = None) -> dict[str, float]:
    """Return all values for a vehicle without a gain file: defaults, and those of the rule."""
    law = controller_or_default(controller)
    return {**law.table.defaults(), **rule_gains(vehicle, law)}


def flight_gains(
    vehicle: Vehicle,
    gains: str = "",
    settings: Mapping[str, float] | None = None,
    controller: Controller | None = None,
) -> dict[str, float]:
    """Return all parameter values of a flight: of the vehicle, then a gain file, then settings.

    Args:
        vehicle: what flies.
        gains: path of a gain file, or "" for none.
        settings: values by name.
        controller: of the parameters; None for the default one.

    Raises:
        WorkbenchError: for an unknown name or a value out of range, with file and line for a file.
    """
    chosen = choose_gains(vehicle, gains, settings, controller)
    return {name: choice.value for name, choice in chosen.items()}


def make_profile(
    vehicle: Vehicle,
    values: Mapping[str, float],
    origin: str,
    controller: Controller | None = None,
) -> GainFile:
    """Return the gain file of a vehicle: its controller's parameters, and other values of its rule.

    Args:
        vehicle: its name goes into the file.
        values: parameter values by name; others are left out.
        origin: of the values, as a sentence.
        controller: of the parameters; None for the default one.
    """
    law = controller_or_default(controller)
    ruled = rule_gains(vehicle, law)
    names = ruled.keys() - _BATTERY_PARAMETERS.keys()  # the description has those
    rows = [row.name for row in law.table if row.system == "controller" or row.name in names]
    kept = {name: values[name] for name in rows if name in values}
    return GainFile(vehicle.name, origin, kept, controller=law.name)


def choose_gains(
    vehicle: Vehicle,
    gains: str = "",
    settings: Mapping[str, float] | None = None,
    controller: Controller | None = None,
) -> dict[str, Gain]:
    """Return the values of `flight_gains`, each with its origin.

    Arguments and exceptions are the same as for `flight_gains`.
    """
    law = controller_or_default(controller)
    table = law.table
    layers: list[tuple[str, Mapping[str, float]]] = [
        ("default", table.defaults()),
        ("rule", rule_gains(vehicle, law)),
    ]
    beside = vehicle.source.parent / "gains.yaml"
    # they are for one controller; another one begins with its rule
    if beside.is_file() and owner_of(beside) in (law.name, law.unscheduled):
        layers.append((str(beside), load_gains(beside, law).gains))
    if gains:
        layers.append((gains, load_gains(find_file(gains), law).gains))
    layers.append(("--set", table.checked(settings or {})))
    check_settings(vehicle, settings or {}, table)
    return {name: Gain(value, origin) for origin, layer in layers for name, value in layer.items()}


def warn_of_other_vehicle(path: str, owner: str, vehicle: str) -> None:
    """Remark on a gain file for another vehicle; as gains are normalised, it may still work."""
    if owner and owner != vehicle:
        logging.getLogger("workbench").warning(
            "the gains in %s are for '%s', but '%s' flies with them", path, owner, vehicle
        )

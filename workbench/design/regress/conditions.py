"""What a spec was flown with, so that a failure can say what is not as it was."""

import dataclasses
import math
from collections.abc import Mapping

from workbench.control.controller import load_controller
from workbench.design.regress.verdict import Difference
from workbench.gains.gains import flight_gains
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import parameter_table
from workbench.scenario.scenario import Scenario
from workbench.scenario.vehicle_parameters import vehicle_parameters

SAME, TINY = 1e-6, 1e-12
"""Largest difference, relative and absolute, between values that count as the same."""
_ROTOR_CONSTANTS = (
    "direction",
    "motor_constant",
    "moment_constant",
    "time_constant_up",
    "time_constant_down",
    "max_rot_velocity",
    "rotor_drag_coefficient",
    "rolling_moment_coefficient",
)
_WHERE_STATED = (
    "inflow_coefficient",
    "ground_effect_coefficient",
    "propeller_radius",
    "linear_motor_constant",
)
"""Constants of rotors that are left out where they are 0: baselines may be older than these."""


def conditions(
    vehicle: Vehicle, scenario: Scenario, settings: Mapping[str, float]
) -> dict[str, float]:
    """Return all numbers that a spec's flights have in common, by name.

    Args:
        vehicle: what flies.
        scenario: with which gain file, rates and variation of the plant.
        settings: parameter values over those of the vehicle.
    """
    controller = load_controller(scenario.controller)
    values = flight_gains(vehicle, scenario.vehicle.gains, settings, controller)
    rows = vehicle_parameters(vehicle, parameter_table(controller))
    found = {row.name: values[row.name] for row in rows}
    found["mass"] = vehicle.mass
    found |= {f"center_of_mass_{axis}": p for axis, p in zip("xyz", vehicle.p_BoBcm_B, strict=True)}
    for i, row in enumerate("xyz"):
        for j, column in list(enumerate("xyz"))[i:]:
            found[f"inertia_{row}{column}"] = vehicle.I_BBcm_B[i][j]
    for number, rotor in enumerate(vehicle.rotors, start=1):
        for name in _ROTOR_CONSTANTS:
            found[f"rotor {number} {name}"] = float(getattr(rotor, name))
        stated = {name: float(getattr(rotor, name)) for name in _WHERE_STATED}
        found |= {f"rotor {number} {name}": value for name, value in stated.items() if value}
        for axis, place in zip("xyz", rotor.p_BR, strict=True):
            found[f"rotor {number} p_{axis}"] = place
    if vehicle.battery:
        found["battery capacity"] = vehicle.battery.capacity
        found["battery resistance"] = vehicle.battery.resistance
        for index, point in enumerate(vehicle.battery.open_circuit_voltage):
            found[f"battery point {index} charge"], found[f"battery point {index} voltage"] = point
    for name, value in dataclasses.asdict(scenario.rates).items():
        found[f"rates {name}"] = value
    for name, value in dataclasses.asdict(scenario.vehicle.variation).items():
        found[f"variation {name}"] = float(value)
    return found


def differences(baseline: Mapping[str, float], now: Mapping[str, float]) -> tuple[Difference, ...]:
    """Return what is not the same, in the order of now, then what is no more.

    A live parameter that the baseline is too old to have was at its default.
    """
    known = {**parameter_table().defaults(), **baseline}
    names = [*now, *(name for name in baseline if name not in now)]
    found = [Difference(name, known.get(name, math.nan), now.get(name, math.nan)) for name in names]
    return tuple(
        each
        for each in found
        if not math.isclose(each.baseline, each.now, rel_tol=SAME, abs_tol=TINY)
    )

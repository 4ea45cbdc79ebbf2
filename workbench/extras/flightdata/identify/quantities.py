"""The quantities to identify, and a vehicle with their values."""

import dataclasses
import math
from dataclasses import dataclass

import numpy as np

from workbench.extras.flightdata.identify.flight import IdentificationFlight
from workbench.logs.motor_commands import FULL_SHARE_COMMANDS
from workbench.plant.vehicle import Vehicle

DRAG_DERIVATIVE_STEP = 0.01
"""Step of drag for a derivative [1/s]."""


@dataclass(frozen=True)
class IdentifiedQuantity:
    """A quantity to identify.

    Attributes:
        name: its own.
        start: initial value of the search.
        step: for a derivative.
        prior: standard deviation of prior knowledge, infinite for none.
        needs: channels that depend on it: "force" (along z), "level" (force across), "turn".
    """

    name: str
    start: float
    step: float
    prior: float
    needs: str


def identifiable_quantities(
    flight: IdentificationFlight, vehicle: Vehicle
) -> list[IdentifiedQuantity]:
    """Return the quantities that a log can identify.

    Factors are logarithms, so that they stay positive. The bias of the accelerometer along z has a
    prior of 0.1 m/s², as in hover it is hardly distinguishable from thrust.
    """
    free = math.inf
    gyro = IdentifiedQuantity("gyro_delay", 0.003, 0.0005, 0.01, "turn")
    if flight.gyro_lowpass:
        known = math.sqrt(2.0) / (2.0 * math.pi * flight.gyro_lowpass)
        gyro = IdentifiedQuantity("gyro_delay", known, 0.0005, 0.5 * known, "turn")
    found = [
        IdentifiedQuantity("lag", 0.0, 0.01, 1.5, "force"),
        IdentifiedQuantity("delay", 0.0, 0.0005, 0.03, "force"),
    ]
    if flight.kind == FULL_SHARE_COMMANDS:
        found += [
            IdentifiedQuantity("curve_0", 0.0, 0.002, 0.3, "force"),
            IdentifiedQuantity("curve_1", 0.2, 0.002, 3.0, "force"),
            IdentifiedQuantity("curve_2", 0.8, 0.002, 3.0, "force"),
        ]
        if flight.voltage is not None:
            found.append(IdentifiedQuantity("voltage", 1.0, 0.01, 0.5, "force"))
    else:
        found.append(IdentifiedQuantity("thrust", 0.0, 0.002, free, "force"))
    found += [
        gyro,
        IdentifiedQuantity("inertia_x", 0.0, 0.01, 2.0, "turn"),
        IdentifiedQuantity("inertia_y", 0.0, 0.01, 2.0, "turn"),
        IdentifiedQuantity("inertia_z", 0.0, 0.01, 2.0, "turn"),
        IdentifiedQuantity("spin_up", spin_up(vehicle), 0.01, free, "turn"),
        IdentifiedQuantity("center_x", 0.0, 1e-3, free, "turn"),
        IdentifiedQuantity("center_y", 0.0, 1e-3, free, "turn"),
        IdentifiedQuantity("turn", 0.0, 1e-3, free, "turn"),
        IdentifiedQuantity("drag", 0.0, DRAG_DERIVATIVE_STEP, free, "level"),
        IdentifiedQuantity("climb_drag", 0.0, DRAG_DERIVATIVE_STEP, free, "climb"),
        IdentifiedQuantity("bias_x", 0.0, 0.01, free, "level"),
        IdentifiedQuantity("bias_y", 0.0, 0.01, free, "level"),
        IdentifiedQuantity("bias_z", 0.0, 0.01, 0.1, "force"),
    ]
    return found


def with_quantities(vehicle: Vehicle, values: dict[str, float]) -> Vehicle:
    """Return the vehicle with the given values; other numbers stay the same.

    Args:
        vehicle: the described one.
        values: by name, see `identifiable_quantities`.
    """
    get = values.get
    thrust = math.exp(get("thrust", 0.0))
    lag = math.exp(get("lag", 0.0))
    turn = get("turn", 0.0)
    root = np.exp([0.5 * get(f"inertia_{axis}", 0.0) for axis in "xyz"])
    x, y, z = vehicle.p_BoBcm_B
    half = 0.5 * vehicle.span
    center = (x + half * get("center_x", 0.0), y + half * get("center_y", 0.0), z)
    speeds = float(np.sum(vehicle.hover_speeds)) / math.sqrt(thrust)
    pull = vehicle.mass / speeds
    hover = speeds / len(vehicle.rotors)
    rotors = [
        dataclasses.replace(
            rotor,
            motor_constant=rotor.motor_constant * thrust * (1.0 + rotor.direction * turn),
            linear_motor_constant=rotor.linear_motor_constant
            * thrust
            * (1.0 + rotor.direction * turn),
            time_constant_up=rotor.time_constant_up * lag,
            time_constant_down=rotor.time_constant_down * lag,
            inertia=values["spin_up"]
            * rotor.moment_constant
            * rotor.motor_constant
            * thrust
            * hover
            if "spin_up" in values
            else rotor.inertia,
            rotor_drag_coefficient=pull * values["drag"]
            if "drag" in values
            else rotor.rotor_drag_coefficient,
            inflow_coefficient=pull * values["climb_drag"]
            if "climb_drag" in values
            else rotor.inflow_coefficient,
        )
        for rotor in vehicle.rotors
    ]
    return dataclasses.replace(
        vehicle,
        p_BoBcm_B=center,
        I_BBcm_B=tuple(map(tuple, vehicle.inertia * np.outer(root, root))),
        rotors=tuple(rotors),
    )


def spin_up(vehicle: Vehicle) -> float:
    """Return a rotor's angular momentum in hover over its drag torque [s]: how spinning up weighs.

    For a thrust that goes with the squared speed, and the mean of all rotors.
    """
    hover = float(np.mean(vehicle.hover_speeds))
    shares = [
        rotor.inertia / (rotor.moment_constant * rotor.motor_constant * hover)
        for rotor in vehicle.rotors
    ]
    return float(np.mean(shares))

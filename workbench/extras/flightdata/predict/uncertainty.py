"""Vehicles that may have flown a log: drawn from an uncertainty."""

import dataclasses
from dataclasses import dataclass

import numpy as np

from workbench.plant.vehicle import Vehicle

DrawnVehicle = tuple[Vehicle, tuple[float, float, float]]
"""A vehicle that may have flown, and the wind [m/s]."""


@dataclass(frozen=True)
class Uncertainty:
    """Standard deviations of log-normal factors on the vehicle, and of the wind.

    Attributes:
        mass: of its factor.
        inertia: of its factor.
        rotor_lag: of its factor.
        thrust: of the factor on rotor thrust at a given speed.
        drag: of the factor on rotor drag and on the loss of thrust by inflow.
        wind: of each level component of a steady wind [m/s].
    """

    mass: float = 0.02
    inertia: float = 0.1
    rotor_lag: float = 0.1
    thrust: float = 0.02
    drag: float = 0.3
    wind: float = 2.0


def drawn_vehicle(
    vehicle: Vehicle, uncertainty: Uncertainty, random: np.random.Generator
) -> DrawnVehicle:
    """Return a random vehicle within the uncertainty, and a wind [m/s]."""
    drawn = random.standard_normal(7)
    deviations = np.array(dataclasses.astuple(uncertainty)[:5])
    factors = Uncertainty(*np.exp(drawn[:5] * deviations).tolist())
    wind = (uncertainty.wind * float(drawn[5]), uncertainty.wind * float(drawn[6]), 0.0)
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (factors.inertia * vehicle.inertia).tolist()
    rows = ((xx, xy, xz), (xy, yy, yz), (xz, yz, zz))
    rotors = tuple(
        dataclasses.replace(
            rotor,
            time_constant_up=factors.rotor_lag * rotor.time_constant_up,
            time_constant_down=factors.rotor_lag * rotor.time_constant_down,
            motor_constant=factors.thrust * rotor.motor_constant,
            rotor_drag_coefficient=factors.drag * rotor.rotor_drag_coefficient,
            inflow_coefficient=factors.drag * rotor.inflow_coefficient,
        )
        for rotor in vehicle.rotors
    )
    mass = factors.mass * vehicle.mass
    real = dataclasses.replace(vehicle, mass=mass, I_BBcm_B=rows, rotors=rotors)
    return real, wind

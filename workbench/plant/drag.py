"""Drag of a moving vehicle, from its `Vehicle` record alone."""

import math
from typing import NamedTuple

import numpy as np

from workbench.plant.gravity import AIR_DENSITY
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle

BODY_DENSITY_KG_M3 = 1000.0
"""Assumed density of a drone, that of water [kg/m³]."""


def drag_area(mass: float) -> float:
    """Return drag coefficient times area of a body, estimated from its mass [m²].

    The body is taken as a cube with the density of water and a drag coefficient of 1, a little
    below the 1.05 of a cube face on (Hoerner, Fluid-Dynamic Drag, 1965, chapter 3).

    Args:
        mass: all-up [kg].
    """
    return math.cbrt(mass / BODY_DENSITY_KG_M3) ** 2


class DragRates(NamedTuple):
    """Deceleration by drag of a hovering vehicle that begins to move.

    Attributes:
        across: by the rotors, perpendicular to their axes, over speed [1/s].
        squared: by the body, over squared speed [1/m].
        yaw: by the rotors, about the vertical, over yaw rate [1/s].
    """

    across: float
    squared: float
    yaw: float


def drag_rates(vehicle: Vehicle, area: float | None = None) -> DragRates:
    """Return the decelerations by the rotors of a vehicle, at hover speed, and by its body.

    Args:
        vehicle: with its payload.
        area: see `drag_area` [m²]; estimated from the mass if not given.
    """
    area = drag_area(vehicle.mass) if area is None else area
    frame = thrust_frame(vehicle)
    coefficients = [rotor.rotor_drag_coefficient for rotor in vehicle.rotors]
    pulls = np.array(coefficients) * frame.hover_speeds
    arms = np.array([rotor.p_BR[:2] for rotor in frame.rotors]) - frame.p_ToTcm_T[:2]
    return DragRates(
        across=float(pulls.sum()) / vehicle.mass,
        squared=0.5 * AIR_DENSITY * area / vehicle.mass,
        yaw=float(pulls @ (arms**2).sum(axis=1) / frame.inertia_T[2, 2]),
    )

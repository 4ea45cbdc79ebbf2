"""Tells a hard hit: a change of velocity that neither the rotors nor the air can make."""

import numpy as np

from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle

LEAST = 0.6
"""A change of velocity of a hard hit, beyond what flying makes [m/s]; a landing makes 0.4."""


def hit_speed(vehicle: Vehicle, before: np.ndarray, after: np.ndarray, duration: float) -> float:
    """Return by how much a hit changed a velocity [m/s], 0 where flying explains the change.

    Args:
        vehicle: that flies.
        before: velocity (3) [m/s].
        after: velocity (3) [m/s].
        duration: between the two [s].
    """
    change = float(np.linalg.norm(after - before))
    flown = (1.0 + vehicle.thrust_to_weight) * GRAVITY * max(0.0, duration)
    return change if change > LEAST + flown else 0.0

"""Thrusts and wind as arrows beside the drone, as plain numbers for Meshcat and the Qt view."""

import numpy as np

from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.session.snapshot import Snapshot
from workbench.systems.sensors.mounting import unit_rotation

DISC_RADIUS_SHARE = 0.35
"""Radius of a rotor's disc, as a share of the rotor's distance from the centre."""
HOVER_ARROW_RADII = 2.0
"""Length of the thrust arrow of a hovering rotor, in radii of its disc."""
WIND_ARROW_M_PER_M_S = 0.25
"""Length of the wind arrow per m/s [m]."""
MIN_ARROW_WIND_M_S = 0.05
"""Least wind speed with an arrow [m/s]."""


def drawn_disc_radius(vehicle: Vehicle) -> float:
    """Return the drawn radius of a rotor's disc [m]; no description states it."""
    ways = np.array([rotor.p_BR for rotor in vehicle.rotors]) - np.asarray(vehicle.p_BoBcm_B)
    return DISC_RADIUS_SHARE * float(np.linalg.norm(ways, axis=1).mean())


def arrow_ends(vehicle: Vehicle, now: Snapshot) -> tuple[np.ndarray, np.ndarray]:
    """Return tails and tips of arrows in W (N + 1, 3) [m]: of each rotor's thrust, and of the wind.

    The wind arrow ends in the centre of mass, and has no length in calm air.
    """
    R_WB = unit_rotation(np.array(now.q_WB))
    hubs = np.array([rotor.p_BR for rotor in vehicle.rotors]) @ R_WB.T + now.p_WB
    axes = np.array([rotor.axis_B for rotor in vehicle.rotors]) @ R_WB.T
    full = HOVER_ARROW_RADII * drawn_disc_radius(vehicle) * len(hubs) / (vehicle.mass * GRAVITY)
    tips = hubs + full * np.array(now.thrusts)[:, None] * axes
    centre = R_WB @ np.asarray(vehicle.p_BoBcm_B) + now.p_WB
    wind = np.asarray(now.wind) if np.linalg.norm(now.wind) > MIN_ARROW_WIND_M_S else np.zeros(3)
    return np.vstack([hubs, centre - WIND_ARROW_M_PER_M_S * wind]), np.vstack([tips, centre])

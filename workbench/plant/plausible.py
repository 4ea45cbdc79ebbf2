"""Is what was understood a drone? Numbers that are possible, and most often a slip of a unit."""

import math

import numpy as np

from workbench.plant.vehicle import Vehicle

_STRONGEST = 20.0
"""Thrust-to-weight; racing quadrotors have 15."""
_WIDEST = 10.0
"""Between rotors [m]."""
_UNEVEN = 2.5
"""Between the hover speeds of one drone's rotors."""


def doubts(vehicle: Vehicle) -> list[str]:
    """Return a clause for each number of a vehicle that is unlikely, with what to look at."""
    found = []
    if vehicle.thrust_to_weight > _STRONGEST:
        found.append(
            f"a thrust-to-weight of {vehicle.thrust_to_weight:.3g} is unlikely: are masses in kg, "
            "motor constants in N s² (not per RPM²), the largest speed in rad/s (not RPM)?"
        )
    if vehicle.span > _WIDEST:
        found.append(f"its rotors are {vehicle.span:.3g} m apart: are lengths in m?")
    for axis, moment in zip("xyz", np.diag(vehicle.inertia), strict=True):
        gyration = math.sqrt(moment / vehicle.mass)
        if gyration > vehicle.span:
            found.append(
                f"its moment of inertia about {axis}, {moment:.3g} kg m², is that of its mass "
                f"{gyration:.3g} m away, and its rotors are {vehicle.span:.3g} m apart: is it in "
                "kg m²?"
            )
    speeds = [speed for speed in vehicle.hover_speeds if speed > 0.0]
    if max(speeds) > _UNEVEN * min(speeds):
        found.append(
            f"to hover its rotors turn at {min(speeds):.3g} to {max(speeds):.3g} rad/s: are their "
            "places and the centre of mass as they should be?"
        )
    return found

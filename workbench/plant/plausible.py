"""Find implausible numbers of a vehicle, which most often come from a wrong unit.

The limits admit every published description that was tried, from a Crazyflie of 27 g to heavy
lifters of 12 kg, and catch an error by a factor of a hundred or a thousand.
"""

import math
from collections.abc import Iterator

import numpy as np

from workbench.plant.rotors import Rotor, propeller_diameter, propeller_inertia
from workbench.plant.vehicle import Vehicle

_ARM = 0.2
"""Usual arm over the cube root of mass [m kg^-1/3]. Multirotors of all sizes are similar, with mass
proportional to the cube of length (Kumar, Michael: Opportunities and challenges with autonomous
micro aerial vehicles, Int. J. Robotics Research 31(11), 2012): 0.13 for a Crazyflie, 0.28 for
lifters."""
_ARMS = (0.25, 4.0)
"""Plausible range of the arm, as shares of the usual arm."""
_SLIPS = ((300.0, 3000.0, "millimetres"), (50.0, 300.0, "centimetres"), (15.0, 50.0, "inches"))
"""Factors of likely unit errors, with the unit given instead of metres."""
_GYRATION = (0.1, 1.5)
"""Plausible range of the radius of gyration over the longest arm. Published ones have 0.3 to 0.8:
motors alone are a tenth of the mass at the ends of the arms, which yields 0.2, and almost no mass
lies beyond them."""
_WEAKEST, _STRONGEST = 1.2, 20.0
"""Plausible range of thrust-to-weight: less cannot resist a gust; racing quadrotors have 15."""
_FASTEST = 300.0
"""Largest plausible speed of a blade tip [m/s]: near that of sound, 340, they gain no thrust."""
_OVERLAP = 1.6
"""Limit of diameter over distance to the next hub; published ones have up to 1, except coaxial."""
_LAGS = (5e-4, 0.5)
"""Plausible range of time constants of rotors [s]; published ones have 0.01 to 0.1."""
_TORQUE = (0.005, 1.0)
"""Plausible range of drag torque over thrust and diameter: 0.05 to 0.1 is usual, 0.45 published."""
_SPINNING = (0.07, 30.0)
"""Plausible range of the inertia of a rotor over that of a propeller with its thrust. Published
ones have 0.2 to 2; it depends on the fifth power of the diameter, which is accurate to a fifth, and
motor bells add to it."""
_UNEVEN = 2.5
"""Limit of the ratio between hover speeds of the rotors of one drone."""


def doubts(vehicle: Vehicle) -> list[str]:
    """Return a clause for each implausible number of a vehicle, with what to check."""
    return [
        *_of_the_arms(vehicle),
        *_of_the_inertia(vehicle),
        *_of_the_thrust(vehicle),
        *_of_the_rotors(vehicle),
    ]


def _of_the_arms(vehicle: Vehicle) -> Iterator[str]:
    farthest, nearest = _longest_arm(vehicle), min(vehicle.rotors, key=lambda r: _arm(vehicle, r))
    usual = _ARM * vehicle.mass ** (1.0 / 3.0)
    share = _arm(vehicle, farthest) / usual
    if _ARMS[0] <= share <= _ARMS[1]:
        return
    rotor = farthest if share > 1.0 else nearest
    slips = [unit for least, most, unit in _SLIPS if least <= share < most]
    asked = "are lengths in m and masses in kg?"
    if slips:
        asked = f"were {slips[0]} written for metres?"
    yield (
        f"{rotor.name} is {_arm(vehicle, rotor):.3g} m from the centre of mass; a "
        f"{vehicle.mass:.3g} kg multirotor has arms of about {usual:.1g} m: {asked}"
    )


def _of_the_inertia(vehicle: Vehicle) -> Iterator[str]:
    arm = _arm(vehicle, _longest_arm(vehicle))
    for axis, moment in zip("xyz", np.diag(vehicle.inertia), strict=True):
        gyration = math.sqrt(moment / vehicle.mass)
        if not _GYRATION[0] * arm <= gyration <= _GYRATION[1] * arm:
            yield (
                f"its moment of inertia about {axis}, {moment:.3g} kg m², is that of its mass "
                f"{gyration:.2g} m from the centre, and its rotors are {arm:.2g} m from there, "
                f"which makes about {vehicle.mass * (0.5 * arm) ** 2:.1g} kg m²: is it in kg m²?"
            )


def _of_the_thrust(vehicle: Vehicle) -> Iterator[str]:
    ratio = vehicle.thrust_to_weight
    if ratio > _STRONGEST:
        yield (
            f"a thrust-to-weight of {ratio:.3g} is unlikely: are masses in kg, motor constants in "
            "N s² (not per RPM²), the largest speed in rad/s (not RPM)?"
        )
    if ratio < _WEAKEST:
        yield (
            f"a thrust-to-weight of {ratio:.3g} leaves next to nothing to climb and to steer with, "
            "and drones have about 2: are mass, motor constant and largest speed correct?"
        )
    speeds = [speed for speed in vehicle.hover_speeds if speed > 0.0]
    if max(speeds) > _UNEVEN * min(speeds):
        yield (
            f"to hover its rotors turn at {min(speeds):.3g} to {max(speeds):.3g} rad/s: are their "
            "positions and the centre of mass correct?"
        )


def _of_the_rotors(vehicle: Vehicle) -> Iterator[str]:
    """Yield implausible numbers, each of the first rotor that has it; most rotors are alike."""
    for clauses in (_of_speed, _of_size, _of_lag, _of_torque, _of_spinning):
        for rotor in vehicle.rotors:
            said = clauses(vehicle, rotor)
            if said:
                yield f"{rotor.name}: {said}"
                break


def _of_speed(vehicle: Vehicle, rotor: Rotor) -> str:
    tip = 0.5 * _diameter(rotor) * rotor.max_rot_velocity
    if tip <= _FASTEST:
        return ""
    return (
        f"with its motor constant it is some {_diameter(rotor):.2g} m across, and at its largest "
        f"speed, {rotor.max_rot_velocity:.4g} rad/s, its tips would move at {tip:.0f} m/s, but "
        "sound at 340: are speeds in rad/s (not RPM)?"
    )


def _of_size(vehicle: Vehicle, rotor: Rotor) -> str:
    beside = [math.dist(rotor.p_BR[:2], other.p_BR[:2]) for other in vehicle.rotors]
    room = min((each for each in beside if each > 0.2 * max(beside)), default=math.inf)
    if _diameter(rotor) <= _OVERLAP * room:
        return ""
    return (
        f"its motor constant, {rotor.motor_constant:.3g} N s², is that of a propeller of some "
        f"{_diameter(rotor):.2g} m, and the next one is {room:.2g} m away: are motor constants in "
        "N s², and lengths in m?"
    )


def _of_lag(vehicle: Vehicle, rotor: Rotor) -> str:
    lags = (rotor.time_constant_up, rotor.time_constant_down)
    if _LAGS[0] <= min(lags) and max(lags) <= _LAGS[1]:
        return ""
    return (
        f"its time constants are {lags[0]:.3g} and {lags[1]:.3g} s, and rotors have 0.01 to 0.1 s: "
        "are they in s?"
    )


def _of_torque(vehicle: Vehicle, rotor: Rotor) -> str:
    share = rotor.moment_constant / _diameter(rotor)
    if _TORQUE[0] <= share <= _TORQUE[1]:
        return ""
    return (
        f"its moment constant is {rotor.moment_constant:.3g} m, and a propeller of its thrust has "
        f"about {0.07 * _diameter(rotor):.1g} m: is it drag torque over thrust, in m?"
    )


def _of_spinning(vehicle: Vehicle, rotor: Rotor) -> str:
    usual = propeller_inertia(_diameter(rotor))
    if rotor.inertia == 0.0 or _SPINNING[0] <= rotor.inertia / usual <= _SPINNING[1]:
        return ""
    return (
        f"its inertia about its axis is {rotor.inertia:.3g} kg m², and a propeller of its thrust "
        f"has about {usual:.1g} kg m²: is it the rotor's own, or a placeholder?"
    )


def _diameter(rotor: Rotor) -> float:
    """Return an estimate of the propeller diameter of a rotor [m], from its largest thrust."""
    linear = rotor.linear_motor_constant / rotor.max_rot_velocity
    return propeller_diameter(rotor.motor_constant + linear)


def _longest_arm(vehicle: Vehicle) -> Rotor:
    return max(vehicle.rotors, key=lambda rotor: _arm(vehicle, rotor))


def _arm(vehicle: Vehicle, rotor: Rotor) -> float:
    """Return the distance of a rotor from the centre of mass [m]."""
    return math.dist(rotor.p_BR, vehicle.p_BoBcm_B)

"""Find implausible numbers of a vehicle, which most often come from a wrong unit.

The limits are in `plant.ranges`.
"""

import math
from collections.abc import Iterator

import numpy as np

from workbench.plant import ranges
from workbench.plant.gravity import GRAVITY
from workbench.plant.rotors import Rotor, propeller_diameter, propeller_inertia
from workbench.plant.vehicle import Vehicle

_ARM_PER_CBRT_MASS = 0.2
"""Usual arm over the cube root of mass [m kg^-1/3]. Multirotors of all sizes are similar, with mass
proportional to the cube of length (Kumar, Michael: Opportunities and challenges with autonomous
micro aerial vehicles, Int. J. Robotics Research 31(11), 2012): 0.13 for a Crazyflie, 0.28 for
lifters."""
_UNIT_ERROR_FACTORS = (
    (300.0, 3000.0, "millimetres"),
    (50.0, 300.0, "centimetres"),
    (15.0, 50.0, "inches"),
)
"""Factors of likely unit errors, with the unit given instead of metres."""

FULL_SPEED_SHARE = 1.0
"""Largest speed of a rotor whose speed is a share of the full one."""


def implausible_values(vehicle: Vehicle) -> list[str]:
    """Return a clause for each implausible number of a vehicle, with what to check."""
    return [
        *_of_the_arms(vehicle),
        *_of_the_inertia(vehicle),
        *_of_the_thrust(vehicle),
        *_of_the_rotors(vehicle),
        *_of_the_drag(vehicle),
        *filter(None, _of_the_rest(vehicle)),
    ]


def _of_the_arms(vehicle: Vehicle) -> Iterator[str]:
    farthest, nearest = (
        _longest_arm(vehicle),
        min(vehicle.rotors, key=lambda r: _arm_length(vehicle, r)),
    )
    usual = _ARM_PER_CBRT_MASS * vehicle.mass ** (1.0 / 3.0)
    share = _arm_length(vehicle, farthest) / usual
    if ranges.ARM_RATIO_RANGE.holds(share):
        return
    rotor = farthest if share > 1.0 else nearest
    slips = [unit for least, most, unit in _UNIT_ERROR_FACTORS if least <= share < most]
    asked = "are lengths in m and masses in kg?"
    if slips:
        asked = f"were {slips[0]} written for metres?"
    yield (
        f"{rotor.name} is {_arm_length(vehicle, rotor):.3g} m from the centre of mass; a "
        f"{vehicle.mass:.3g} kg multirotor has arms of about {usual:.1g} m: {asked}"
    )


def _of_the_inertia(vehicle: Vehicle) -> Iterator[str]:
    arm = _arm_length(vehicle, _longest_arm(vehicle))
    for axis, moment in zip("xyz", np.diag(vehicle.inertia), strict=True):
        gyration = math.sqrt(moment / vehicle.mass)
        if not ranges.GYRATION_RANGE.holds(gyration / arm):
            yield (
                f"its moment of inertia about {axis}, {moment:.3g} kg m², is that of its mass "
                f"{gyration:.2g} m from the centre, and its rotors are {arm:.2g} m from there, "
                f"which makes about {vehicle.mass * (0.5 * arm) ** 2:.1g} kg m²: is it in kg m²?"
            )


def _of_the_thrust(vehicle: Vehicle) -> Iterator[str]:
    ratio = vehicle.thrust_to_weight
    if ratio > ranges.THRUST_TO_WEIGHT_RANGE.most:
        yield (
            f"a thrust-to-weight of {ratio:.3g} is unlikely: are masses in kg, motor constants in "
            "N s² (not per RPM²), the largest speed in rad/s (not RPM)?"
        )
    if ratio < ranges.THRUST_TO_WEIGHT_RANGE.least:
        yield (
            f"a thrust-to-weight of {ratio:.3g} leaves next to nothing to climb and to steer with, "
            "and drones have about 2: are mass, motor constant and largest speed correct?"
        )
    speeds = [speed for speed in vehicle.hover_speeds if speed > 0.0]
    if not ranges.HOVER_SPEED_RATIO_RANGE.holds(max(speeds) / min(speeds)):
        yield (
            f"to hover its rotors turn at {min(speeds):.3g} to {max(speeds):.3g} rad/s: are their "
            "positions and the centre of mass correct?"
        )


def _of_the_rotors(vehicle: Vehicle) -> Iterator[str]:
    """Yield implausible numbers, each of the first rotor that has it; most rotors are alike.

    A propeller's size follows from its motor constant, unless speeds are shares of the full one, as
    in a Gazebo model whose motors take 0 to 1.
    """
    for clauses in (_of_speed, _of_size, _of_lag, _of_torque, _of_spinning):
        for rotor in vehicle.rotors:
            if clauses is not _of_lag and rotor.max_rot_velocity <= FULL_SPEED_SHARE:
                continue
            said = clauses(vehicle, rotor)
            if said:
                yield f"{rotor.name}: {said}"
                break


def _of_speed(vehicle: Vehicle, rotor: Rotor) -> str:
    tip = 0.5 * _diameter(rotor) * rotor.max_rot_velocity
    if ranges.TIP_SPEED_RANGE.holds(tip):
        return ""
    return (
        f"with its motor constant it is some {_diameter(rotor):.2g} m across, and at its largest "
        f"speed, {rotor.max_rot_velocity:.4g} rad/s, its tips would move at {tip:.0f} m/s, but "
        "sound at 340: are speeds in rad/s (not RPM)?"
    )


def _of_size(vehicle: Vehicle, rotor: Rotor) -> str:
    beside = [math.dist(rotor.p_BR[:2], other.p_BR[:2]) for other in vehicle.rotors]
    room = min((each for each in beside if each > 0.2 * max(beside)), default=math.inf)
    if ranges.ROTOR_OVERLAP_RANGE.holds(_diameter(rotor) / room):
        return ""
    return (
        f"its motor constant, {rotor.motor_constant:.3g} N s², is that of a propeller of some "
        f"{_diameter(rotor):.2g} m, and the next one is {room:.2g} m away: are motor constants in "
        "N s², and lengths in m?"
    )


def _of_lag(vehicle: Vehicle, rotor: Rotor) -> str:
    lags = (rotor.time_constant_up, rotor.time_constant_down)
    if all(map(ranges.ROTOR_LAG_RANGE.holds, lags)):
        return ""
    return (
        f"its time constants are {lags[0]:.3g} and {lags[1]:.3g} s, and rotors have 0.01 to 0.1 s: "
        f"{ranges.ROTOR_LAG_RANGE.meant(max(lags)) or 'are they in s?'}"
    )


def _of_torque(vehicle: Vehicle, rotor: Rotor) -> str:
    share = rotor.moment_constant / _diameter(rotor)
    if ranges.ROTOR_TORQUE_RANGE.holds(share):
        return ""
    return (
        f"its moment constant is {rotor.moment_constant:.3g} m, and a propeller of its thrust has "
        f"about {0.07 * _diameter(rotor):.1g} m: is it drag torque over thrust, in m?"
    )


def _of_spinning(vehicle: Vehicle, rotor: Rotor) -> str:
    usual = propeller_inertia(_diameter(rotor))
    if rotor.inertia == 0.0 or ranges.ROTOR_INERTIA_RANGE.holds(rotor.inertia / usual):
        return ""
    return (
        f"its inertia about its axis is {rotor.inertia:.3g} kg m², and a propeller of its thrust "
        f"has about {usual:.1g} kg m²: is it the rotor's own, or a placeholder?"
    )


def _of_the_drag(vehicle: Vehicle) -> Iterator[str]:
    """Yield implausible forces and moments at 1 m/s, of all rotors in hover."""
    weight = vehicle.mass * GRAVITY
    arm = _arm_length(vehicle, _longest_arm(vehicle))

    def total(name: str) -> float:
        return sum(
            getattr(rotor, name) * speed
            for rotor, speed in zip(vehicle.rotors, vehicle.hover_speeds.tolist(), strict=True)
        )

    for name, limit, whole, unit in (
        ("rotor_drag_coefficient", ranges.ROTOR_DRAG_RANGE, weight, "N"),
        ("rolling_moment_coefficient", ranges.ROLLING_MOMENT_RANGE, weight * arm, "N m"),
        ("inflow_coefficient", ranges.INFLOW_LOSS_RANGE, weight, "N"),
    ):
        share = abs(total(name)) / whole
        if not limit.holds(share):
            yield (
                f"its {limit.quantity}, is {share:.3g}, and rotors have 0.002 to 0.15: is "
                f"{name}, {getattr(vehicle.rotors[0], name):.3g}, in {unit} per rad/s and m/s?"
            )


def _of_the_rest(vehicle: Vehicle) -> Iterator[str]:
    """Yield a clause, or "", for each number with a range of its own."""
    yield ranges.MASS_RANGE.clause(vehicle.mass)
    rotor = vehicle.rotors[0]
    yield ranges.GROUND_EFFECT_RANGE.clause(rotor.ground_effect_coefficient)
    if rotor.ground_effect_coefficient and rotor.propeller_radius:
        share = 2.0 * rotor.propeller_radius / _diameter(rotor)
        if not ranges.PROPELLER_RADIUS_RANGE.holds(share):
            yield (
                f"its propeller radius, {rotor.propeller_radius:.3g} m, is {share:.3g} times that "
                "of a propeller of its thrust: is it in m?"
            )
    if vehicle.battery:
        yield ranges.CHARGE_RANGE.clause(vehicle.battery.capacity)
        yield ranges.RESISTANCE_RANGE.clause(
            vehicle.battery.resistance or ranges.RESISTANCE_RANGE.least
        )
        yield ranges.VOLTAGE_RANGE.clause(vehicle.battery.open_circuit_voltage[-1][1])


def _diameter(rotor: Rotor) -> float:
    """Return an estimate of the propeller diameter of a rotor [m], from its largest thrust."""
    linear = rotor.linear_motor_constant / rotor.max_rot_velocity
    return propeller_diameter(rotor.motor_constant + linear)


def _longest_arm(vehicle: Vehicle) -> Rotor:
    return max(vehicle.rotors, key=lambda rotor: _arm_length(vehicle, rotor))


def _arm_length(vehicle: Vehicle, rotor: Rotor) -> float:
    """Return the distance of a rotor from the centre of mass [m]."""
    return math.dist(rotor.p_BR, vehicle.p_BoBcm_B)

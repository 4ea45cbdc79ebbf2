"""A logged flight, flown again with other gains or another law, and how sure that is.

What the model cannot explain of the log is kept as a disturbance over time, see `disturbed`, and
acts again. Every vehicle of a sample of uncertain ones explains the log with a disturbance of its
own; the band is what they make of the other law. So it is wide where the answer depends on what is
not known, and has no width where it does not: with its own law each of them flies the log.
"""

import dataclasses
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from workbench.control.controller import Controller
from workbench.design.predict.disturbed import CLOSES, compiled_disturbed
from workbench.design.predict.flown import ERROR, Craft, compiled_flights, estimate_of, make_craft
from workbench.design.predict.motion import Motion, resampled, rotation
from workbench.design.predict.past import Past
from workbench.plant.drag import AIR_DENSITY, drag_area
from workbench.plant.vehicle import Vehicle

COVERED = 0.95
"""Share of the sampled vehicles whose flights lie in the band."""
FLOOR = 1e-3
"""Least half width of the band of a position [m]: of the log's own rounding."""


class Law(NamedTuple):
    """A law and its gains.

    Attributes:
        controller: the law.
        gains: of all its parameters, by name.
    """

    controller: Controller
    gains: dict[str, float]


class Uncertainty(NamedTuple):
    """Standard deviations of factors on what flies, whose logarithms are normal, and of the wind.

    Attributes:
        mass: of the factor.
        inertia: likewise, and so the next three.
        rotor_lag: see there.
        thrust: of rotors at their speed.
        drag: of the rotors, and what inflow takes from their thrust.
        wind: of each level component of a steady wind [m/s].
    """

    mass: float = 0.02
    inertia: float = 0.1
    rotor_lag: float = 0.1
    thrust: float = 0.02
    drag: float = 0.3
    wind: float = 2.0


@dataclass(frozen=True)
class WhatIf:
    """A flight that was, and the one that would have been.

    Attributes:
        flight: its name.
        time: from the start of the log on (k) [s].
        logged: states (k, 13), see `rigid_body.State`.
        again: with its own law, which shows how exactly the disturbance explains it (k, 13).
        other: with the other law (k, 13).
        low: lower edges of the band of position and velocity (k, 6) [m, m/s].
        high: upper edges.
        disturbance: force in W [N] and moment in B [N·m] (k, 6).
        lost: sampled vehicles whose flight with the other law does not stay in the air.
        drawn: sampled vehicles.
    """

    flight: str
    time: np.ndarray
    logged: np.ndarray
    again: np.ndarray
    other: np.ndarray
    low: np.ndarray
    high: np.ndarray
    disturbance: np.ndarray
    lost: int
    drawn: int

    @property
    def difference(self) -> np.ndarray:
        """Other flight less the log, position and velocity (k, 6)."""
        places = [4, 5, 6, 10, 11, 12]
        return np.asarray(self.other[:, places] - self.logged[:, places])


def what_if(
    motion: Motion,
    vehicle: Vehicle,
    flown: Law,
    other: Law,
    period: float,
    steps: int,
    uncertainty: Uncertainty | None = None,
    draws: int = 40,
    seed: int = 0,
    progress: Callable[[float], None] | None = None,
) -> WhatIf | None:
    """Return a logged flight with another law; None where it is never in the air.

    Args:
        motion: the flight.
        vehicle: as its law knows it.
        flown: the law that flew.
        other: the one that would have.
        period: between their updates [s].
        steps: of physics in one.
        uncertainty: of the vehicle.
        draws: how many vehicles are sampled, the nominal one besides.
        seed: of the sample.
        progress: takes the share done.
    """
    first, last = motion.airborne
    if last - first < 2:
        return None
    uncertainty = uncertainty or Uncertainty()
    nominal = make_craft(vehicle, flown.controller, flown.gains, period, steps)
    course = _course(motion, first, last, period)
    own = _law(motion, vehicle, flown, nominal, first)
    changed_craft = make_craft(vehicle, other.controller, other.gains, period, steps)
    changed = _law(motion, vehicle, other, changed_craft, first)
    again, pushes = _follow(course, own, vehicle, nominal)
    random = np.random.default_rng(seed)
    flights, lost = [], 0
    for number in range(draws + 1):
        real, wind, found = vehicle, (0.0, 0.0, 0.0), pushes
        if number:
            real, wind = _drawn(vehicle, uncertainty, random)
            craft = make_craft(vehicle, flown.controller, flown.gains, period, steps, real)
            found = _follow(course, own, real, craft._replace(wind=wind))[1]
        craft = make_craft(vehicle, other.controller, other.gains, period, steps, real)
        states = _refly(course, changed, found, real, craft._replace(wind=wind))
        if number == 0:
            nominal_flight = states
        if _stays(states, course.targets):
            flights.append(states)
        else:
            lost += 1
        if progress:
            progress((number + 1) / (draws + 1))
    low, high = _band(flights or [nominal_flight])
    check = _refly(course, own, pushes, vehicle, nominal)
    return WhatIf(
        flight=motion.name,
        time=course.time,
        logged=course.targets,
        again=check,
        other=nominal_flight,
        low=low,
        high=high,
        disturbance=np.vstack([pushes, pushes[-1:]])[:, [0, 1, 2, 6, 7, 8]],
        lost=lost,
        drawn=draws + 1,
    )


class _Course(NamedTuple):
    """The log at the updates of the law.

    Attributes:
        time: (K+1).
        targets: states (K+1, 13).
        errors: of the estimate (K, 11).
        voltage: (K).
    """

    time: np.ndarray
    targets: np.ndarray
    errors: np.ndarray
    voltage: np.ndarray


class _Begun(NamedTuple):
    """A law where the flight begins.

    Attributes:
        law: which one.
        memory: (k).
        updates: done before.
        speeds: of the rotors (n).
        references: (K, 8).
        voltages: (K).
    """

    law: Law
    memory: np.ndarray
    updates: float
    speeds: np.ndarray
    references: np.ndarray
    voltages: np.ndarray


def _course(motion: Motion, first: int, last: int, period: float) -> _Course:
    begin = motion.period * first
    updates = math.floor(motion.period * (last - first) / period + 1e-9)
    time = begin + period * np.arange(updates + 1)

    def at(values: np.ndarray) -> np.ndarray:
        return resampled(values, motion.period, time)

    q, q_known = at(motion.q), at(motion.q_known)
    q /= np.linalg.norm(q, axis=1)[:, None]
    q_known /= np.linalg.norm(q_known, axis=1)[:, None]
    p, v = at(motion.p), at(motion.v)
    targets = np.column_stack([q, p, rotation(q).apply(at(motion.w)), v])
    errors = np.zeros((updates + 1, ERROR))
    errors[:, 0:3], errors[:, 3:6] = at(motion.p_known) - p, at(motion.v_known) - v
    errors[:, 8:11] = (rotation(q).inv() * rotation(q_known)).as_rotvec()
    return _Course(time, targets, errors[:-1], at(motion.voltage[:, None])[:-1, 0])


def _law(motion: Motion, vehicle: Vehicle, law: Law, craft: Craft, first: int) -> _Begun:
    listen = compiled_flights(law.controller).listen
    past = Past(motion, vehicle, law.controller, law.gains, craft, listen)
    start = past.start(np.array([first]))
    last = motion.airborne[1]
    duration = craft.period * math.floor(motion.period * (last - first) / craft.period + 1e-9)
    references = past.references(np.array([first]), duration)[0]
    times = motion.period * first + craft.period * np.arange(len(references))
    voltage = resampled(motion.voltage[:, None], motion.period, times)[:, 0] / past.full_voltage
    return _Begun(
        law,
        start.memory[0],
        float(start.counts[0]),
        start.speeds[0],
        references,
        np.where(np.isfinite(voltage), voltage, 1.0),
    )


def _pressure(vehicle: Vehicle) -> float:
    return 0.5 * AIR_DENSITY * drag_area(vehicle.mass)


def _follow(
    course: _Course, begun: _Begun, real: Vehicle, craft: Craft
) -> tuple[np.ndarray, np.ndarray]:
    follow, _ = compiled_disturbed(begun.law.controller)
    states, pushes = follow(
        course.targets,
        begun.speeds,
        begun.memory,
        begun.updates,
        course.errors,
        begun.references,
        begun.voltages,
        np.ones(len(craft.rotors)),
        _pressure(real),
        estimate_of(craft.period),
        1.0 / CLOSES,
        craft,
    )
    return states, pushes


def _refly(
    course: _Course, begun: _Begun, pushes: np.ndarray, real: Vehicle, craft: Craft
) -> np.ndarray:
    _, refly = compiled_disturbed(begun.law.controller)
    return np.asarray(
        refly(
            course.targets[0],
            begun.speeds,
            begun.memory,
            begun.updates,
            course.errors,
            begun.references,
            begun.voltages,
            np.ones(len(craft.rotors)),
            pushes,
            _pressure(real),
            estimate_of(craft.period),
            craft,
        )
    )


def _drawn(
    vehicle: Vehicle, uncertainty: Uncertainty, random: np.random.Generator
) -> tuple[Vehicle, tuple[float, float, float]]:
    """Return a vehicle out of the uncertain ones, and a wind [m/s]."""
    drawn = random.standard_normal(7)
    factors = Uncertainty._make([*np.exp(drawn[:5] * uncertainty[:5]).tolist(), 0.0])
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
    return dataclasses.replace(vehicle, mass=mass, I_BBcm_B=rows, rotors=rotors), wind


def _stays(states: np.ndarray, logged: np.ndarray) -> bool:
    """Return whether a flight is not lost: it stays finite, above the ground, and not far off."""
    if not np.isfinite(states).all():
        return False
    size = 5.0 + 5.0 * float(np.ptp(logged[:, 4:7], axis=0).max())
    return bool(np.abs(states[:, 4:7] - logged[:, 4:7]).max() < size)


def _band(flights: list[np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
    """Return the band of position and velocity (k, 6) of flights."""
    all_of = np.array([states[:, [4, 5, 6, 10, 11, 12]] for states in flights])
    tail = 0.5 * (1.0 - COVERED)
    low, high = np.quantile(all_of, (tail, 1.0 - tail), axis=0)
    return low - FLOOR, high + FLOOR

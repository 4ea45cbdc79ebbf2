"""What flies and when, as compiled code reads it."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.control.flight_law import law_constants, packed
from workbench.dynamics.rigid_body import rigid_body
from workbench.dynamics.vehicle_step import rotor_rows
from workbench.plant.payload import NO_PAYLOAD, Payload, laden
from workbench.plant.rotors import Rotor
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.battery import PERIOD, hover_power, voltage_curve, voltage_drop


class Supply(NamedTuple):
    """What a battery supplies that is full at the start.

    Attributes:
        curve: see `battery.voltage_curve` (p, 2); of no rows where no battery is stated.
        drop: see `battery.voltage_drop`.
        used: charge that an update takes, over power [N^-3/2].
        every: steps of physics from one update to the next.
    """

    curve: np.ndarray
    drop: float
    used: float
    every: int


class Crafts(NamedTuple):
    """What flies with each of m candidates; n rotors.

    Attributes:
        body: (m, 18) of the law's constants, see `flight_law.packed`.
        rotors: (m, n, 12) of the same.
        rigid: (m, 16) what moves, see `rigid_body.RigidBody`.
        turning: (m, n, 26) see `dynamics.rotor_rows`.
        speeds: (m, n) of the rotors at the start [rad/s].
        seen: (m, 2) see `variation.Delays.seen`.
        acting: (m, 2) see `variation.Delays.acting`.
        clearances: (m) height of the body's origin at which it stands on the ground [m].
        estimate: see `acceleration_estimate.sampled_estimate`.
        supply: of all of them, see `Supply`.
    """

    body: np.ndarray
    rotors: np.ndarray
    rigid: np.ndarray
    turning: np.ndarray
    speeds: np.ndarray
    seen: np.ndarray
    acting: np.ndarray
    clearances: np.ndarray
    estimate: tuple[float, float]
    supply: Supply

    def chosen(self, which: np.ndarray) -> "Crafts":
        """Return some of them, and some perhaps more than once, by their numbers."""
        return Crafts._make([*(part[which] for part in self[:8]), *self[8:]])


def make_crafts(
    vehicle: Vehicle,
    variations: Sequence[Variation],
    rates: Rates,
    battery_duration: float,
    payloads: Sequence[Payload] | None = None,
) -> Crafts:
    """Return a vehicle that differs in some ways from what its law believes.

    Args:
        vehicle: as its law believes, without its payload.
        variations: (m) how it differs.
        rates: of physics and control.
        battery_duration: time that a full battery hovers [s].
        payloads: (m) what it carries; nothing where they are not given.

    Raises:
        WorkbenchError: if a law cannot hover with the payload that it knows.
    """
    many = len(variations)
    payloads = payloads or [NO_PAYLOAD] * many
    known = {each: packed(law_constants(vehicle, each)) for each in {p.known for p in payloads}}
    delays = [each.delays(rates.physics_step, rates.control_period) for each in variations]
    rigid = [
        _flown(vehicle, each, payload) for each, payload in zip(variations, payloads, strict=True)
    ]
    turning = [
        rotor_rows([_lagged(rotor, each) for rotor in vehicle.rotors], rates.physics_step)
        for each in variations
    ]
    return Crafts(
        body=np.array([known[each.known][0] for each in payloads]),
        rotors=np.array([known[each.known][1] for each in payloads]),
        rigid=np.array(rigid),
        turning=np.array(turning),
        speeds=np.array([vehicle.hover_speeds] * many),
        seen=np.array([each.seen for each in delays]),
        acting=np.array([each.acting for each in delays]),
        clearances=np.full(many, vehicle.ground_clearance),
        estimate=sampled_estimate(rates.control_period),
        supply=_supply(vehicle, rates.physics_step, battery_duration),
    )


def _supply(vehicle: Vehicle, step: float, duration: float) -> Supply:
    if vehicle.battery is None:
        return Supply(np.empty((0, 2)), 0.0, 0.0, 1)
    return Supply(
        curve=voltage_curve(vehicle),
        drop=voltage_drop(vehicle, duration),
        used=PERIOD / hover_power(vehicle) / duration,
        every=round(PERIOD / step),
    )


def _flown(vehicle: Vehicle, variation: Variation, payload: Payload) -> np.ndarray:
    """Return what moves (16), see `rigid_body.RigidBody`."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (variation.inertia * vehicle.inertia).tolist()
    varied = dataclasses.replace(
        vehicle,
        mass=variation.mass * vehicle.mass,
        I_BBcm_B=((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)),
    )
    whole = laden(varied, payload)
    return rigid_body(whole.mass, whole.inertia, whole.p_BoBcm_B).packed()


def _lagged(rotor: Rotor, variation: Variation) -> Rotor:
    """Return a rotor with the lag of a variation."""
    lag = variation.rotor_lag
    return dataclasses.replace(
        rotor,
        time_constant_up=lag * rotor.time_constant_up,
        time_constant_down=lag * rotor.time_constant_down,
    )

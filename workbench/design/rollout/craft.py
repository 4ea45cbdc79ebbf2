"""What flies and when, as compiled code reads it."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.control.flight_law import law_constants, packed
from workbench.dynamics.rigid_body import rigid_body
from workbench.dynamics.vehicle_step import rotor_rows
from workbench.plant.rotors import Rotor
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates
from workbench.systems.acceleration_estimate import sampled_estimate


class Crafts(NamedTuple):
    """What flies with each of m candidates; n rotors.

    Attributes:
        body: (m, 18) of the law's constants, see `flight_law.packed`.
        rotors: (m, n, 11) of the same.
        rigid: (m, 16) what moves, see `rigid_body.RigidBody`.
        turning: (m, n, 24) see `dynamics.rotor_rows`.
        speeds: (m, n) of the rotors at the start [rad/s].
        seen: (m, 2) see `variation.Delays.seen`.
        acting: (m, 2) see `variation.Delays.acting`.
        clearances: (m) height of the body's origin at which it stands on the ground [m].
        estimate: see `acceleration_estimate.sampled_estimate`.
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

    def chosen(self, which: np.ndarray) -> "Crafts":
        """Return some of them, and some perhaps more than once, by their numbers."""
        return Crafts._make([*(part[which] for part in self[:8]), self.estimate])


def make_crafts(vehicle: Vehicle, variations: Sequence[Variation], rates: Rates) -> Crafts:
    """Return a vehicle that differs in some ways from what its law believes.

    Args:
        vehicle: as its law believes.
        variations: (m) how it differs.
        rates: of physics and control.
    """
    body, rotors = packed(law_constants(vehicle))
    many = len(variations)
    delays = [each.delays(rates.physics_step, rates.control_period) for each in variations]
    rigid = [
        rigid_body(
            each.mass * vehicle.mass, each.inertia * vehicle.inertia, vehicle.p_BoBcm_B
        ).packed()
        for each in variations
    ]
    turning = [
        rotor_rows([_lagged(rotor, each) for rotor in vehicle.rotors], rates.physics_step)
        for each in variations
    ]
    return Crafts(
        body=np.array([body] * many),
        rotors=np.array([rotors] * many),
        rigid=np.array(rigid),
        turning=np.array(turning),
        speeds=np.array([vehicle.hover_speeds] * many),
        seen=np.array([each.seen for each in delays]),
        acting=np.array([each.acting for each in delays]),
        clearances=np.full(many, vehicle.ground_clearance),
        estimate=sampled_estimate(rates.control_period),
    )


def _lagged(rotor: Rotor, variation: Variation) -> Rotor:
    """Return a rotor with the lag of a variation."""
    lag = variation.rotor_lag
    return dataclasses.replace(
        rotor,
        time_constant_up=lag * rotor.time_constant_up,
        time_constant_down=lag * rotor.time_constant_down,
    )

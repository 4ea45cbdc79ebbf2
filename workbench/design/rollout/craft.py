"""What flies and when, as compiled code reads it."""

import dataclasses
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from workbench.design.rollout.rigid_body import rigid_body
from workbench.plant.rotors import Rotor, wrench_matrix
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.air.drag import rotor_rows
from workbench.systems.flight_law import law_constants, packed
from workbench.systems.rotor_response import rotor_period


class Crafts(NamedTuple):
    """What flies with each of m candidates; n rotors.

    Attributes:
        body: (m, 17) of the law's constants, see `flight_law.packed`.
        rotors: (m, n, 20) of the same.
        rigid: (m, 16) what moves, see `rigid_body.RigidBody`.
        effects: (m, n, 6) force and moment about the body's origin in B a thrust [1, m].
        blades: (m, n, 8) see `air.drag.rotor_rows`.
        speeds: (m, n) of the rotors at the start [rad/s].
        delays: (m) control periods by which the law sees the state late.
        clearances: (m) height of the body's origin at which it stands on the ground [m].
        estimate: see `acceleration_estimate.sampled_estimate`.
    """

    body: np.ndarray
    rotors: np.ndarray
    rigid: np.ndarray
    effects: np.ndarray
    blades: np.ndarray
    speeds: np.ndarray
    delays: np.ndarray
    clearances: np.ndarray
    estimate: tuple[float, float]

    def chosen(self, which: np.ndarray) -> "Crafts":
        """Return some of them, and some perhaps more than once, by their numbers."""
        return Crafts._make([*(part[which] for part in self[:8]), self.estimate])


def make_crafts(vehicle: Vehicle, variations: Sequence[Variation], period: float) -> Crafts:
    """Return a vehicle that differs in some ways from what its law believes.

    Args:
        vehicle: as its law believes.
        variations: (m) how it differs.
        period: of control [s].
    """
    constants = law_constants(vehicle, period)
    turning = [[_answer(rotor, each, period) for rotor in vehicle.rotors] for each in variations]
    packs = [packed(constants._replace(rotors=rows)) for rows in turning]
    many = len(variations)
    return Crafts(
        body=np.array([body for body, _ in packs]),
        rotors=np.array([rotors for _, rotors in packs]),
        rigid=np.array([rigid_body(vehicle, each).packed() for each in variations]),
        effects=np.array([wrench_matrix(vehicle.rotors, (0.0, 0.0, 0.0)).T] * many),
        blades=np.array([rotor_rows(vehicle.rotors)] * many),
        speeds=np.array([vehicle.hover_speeds] * many),
        delays=np.array([int(each.control_delay) for each in variations]),
        clearances=np.full(many, vehicle.ground_clearance),
        estimate=sampled_estimate(period),
    )


def _answer(rotor: Rotor, variation: Variation, period: float) -> list[float]:
    """Return the constants of a rotor's answer."""
    lag = variation.rotor_lag
    up, down = lag * rotor.time_constant_up, lag * rotor.time_constant_down
    varied = dataclasses.replace(rotor, time_constant_up=up, time_constant_down=down)
    return rotor_period(varied, period)

"""What flies and when, as compiled code reads it."""

import dataclasses
from typing import NamedTuple

import numpy as np

from workbench.design.rollout.rigid_body import RigidBody, rigid_body
from workbench.plant.rotors import wrench_matrix
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.air.drag import rotor_rows
from workbench.systems.flight_law import law_constants, packed, unpacked
from workbench.systems.noise import noise_seed
from workbench.systems.rotor_response import rotor_period


class Craft(NamedTuple):
    """What flies, for all candidates of a batch alike; n rotors.

    Attributes:
        body: of the law's constants, see `flight_law.packed`.
        rotors: (n, 20) of the same.
        estimate: see `acceleration_estimate.sampled_estimate`.
        rigid: what moves.
        effects: (n, 6) force and moment about the body's origin in B a thrust [1, m].
        blades: (n, 8) see `air.drag.rotor_rows`.
        speeds: (n) of the rotors at the start [rad/s].
        clearance: height of the body's origin at which it stands on the ground [m].
        seed: of the turbulence.
    """

    body: np.ndarray
    rotors: np.ndarray
    estimate: tuple[float, float]
    rigid: RigidBody
    effects: np.ndarray
    blades: np.ndarray
    speeds: np.ndarray
    clearance: float
    seed: float


class Schedule(NamedTuple):
    """When things happen; instants are numbers of control periods from the start.

    Attributes:
        step: of physics [s].
        period: of control [s].
        steps: of physics in a control period.
        edge: instant at which the command steps.
        end: last instant.
        stride: the first and every stride-th instant after it are kept.
        delay: periods by which the law sees the state late.
    """

    step: float
    period: float
    steps: int
    edge: int
    end: int
    stride: int
    delay: int


def make_craft(vehicle: Vehicle, period: float, seed: int) -> Craft:
    """Return a vehicle that is as its law believes.

    Args:
        vehicle: its record.
        period: of control [s].
        seed: of a flight's noise, as in a scenario.
    """
    body, rotors = packed(law_constants(vehicle, period))
    return Craft(
        body=body,
        rotors=np.ascontiguousarray(rotors),
        estimate=sampled_estimate(period),
        rigid=rigid_body(vehicle, Variation()),
        effects=np.ascontiguousarray(wrench_matrix(vehicle.rotors, (0.0, 0.0, 0.0)).T),
        blades=rotor_rows(vehicle.rotors),
        speeds=vehicle.hover_speeds,
        clearance=vehicle.ground_clearance,
        seed=float(noise_seed(seed, "air")),
    )


def varied_craft(craft: Craft, vehicle: Vehicle, period: float, variation: Variation) -> Craft:
    """Return a craft whose body and rotors differ from what its law believes.

    Args:
        craft: of the vehicle, see `make_craft`.
        vehicle: its record.
        period: of control [s].
        variation: how it differs.
    """
    lag = variation.rotor_lag
    turning = [
        dataclasses.replace(
            rotor,
            time_constant_up=lag * rotor.time_constant_up,
            time_constant_down=lag * rotor.time_constant_down,
        )
        for rotor in vehicle.rotors
    ]
    rotors = craft.rotors.copy()
    answers = unpacked(craft.body, rotors).rotors  # a view
    answers[:] = [rotor_period(rotor, period) for rotor in turning]
    return craft._replace(rotors=rotors, rigid=rigid_body(vehicle, variation))

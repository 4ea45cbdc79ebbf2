"""What flies: vehicles that differ in some ways from what their law knows."""

import dataclasses
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from workbench.control.law_constants import law_constants
from workbench.design.rollout.fields import packed_dtype
from workbench.design.rollout.lanes import LANES, LaneWorkspace
from workbench.design.rollout.record import law_dtype, law_record
from workbench.dynamics.rigid_body import rigid_body
from workbench.dynamics.rotors import RotorConstants
from workbench.plant.payload import NO_PAYLOAD, Payload, vehicle_with_payload
from workbench.plant.rotors import Rotor
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates

BODY_DTYPE = packed_dtype({"mass": (), "inertia": (6,), "inverse": (6,), "p_BoBcm_B": (3,)})
"""See `rigid_body.RigidBody`."""
ROTOR_DTYPE = packed_dtype(
    {name: (3,) if name in ("p_BR", "axis_B") else () for name in RotorConstants._fields}
)
"""See `RotorConstants`."""


class VehicleBatch(NamedTuple):
    """K vehicles with n rotors.

    Attributes:
        law: (K) what the law knows, see `record.law_dtype`.
        bodies: (K) see `BODY_DTYPE`.
        rotors: (K, n) see `ROTOR_DTYPE`.
        speeds: (K, n) of the rotors at the start [rad/s].
        sensing_delays: (K, 2) see `variation.Delays.sensing_delay`.
        command_delays: (K, 2) see `variation.Delays.command_delay`.
        lags: (K) time constants of the quickest rotors [s].
    """

    law: np.ndarray
    bodies: np.ndarray
    rotors: np.ndarray
    speeds: np.ndarray
    sensing_delays: np.ndarray
    command_delays: np.ndarray
    lags: np.ndarray

    def chosen(self, which: Any) -> "VehicleBatch":
        """Return some of them, and some perhaps more than once, by their numbers."""
        return VehicleBatch(*(part[which] for part in self))

    def furnish(self, room: LaneWorkspace) -> None:
        """Write what does not change in flight into a room, whose lanes they are (up to 16)."""
        lanes = np.minimum(np.arange(LANES), len(self.bodies) - 1)
        for name in BODY_DTYPE.fields or ():
            room.bodies[name][0] = self.bodies[name][lanes].T
        for name in ROTOR_DTYPE.fields or ():
            values = self.rotors[name][lanes]  # lanes come last in a room
            room.rotors[name] = values.transpose(*range(1, values.ndim), 0)


def make_vehicle_batch(
    vehicle: Vehicle,
    variations: Sequence[Variation],
    rates: Rates,
    payloads: Sequence[Payload] | None = None,
) -> VehicleBatch:
    """Return a vehicle that differs in some ways from what its law knows.

    Args:
        vehicle: as its law knows it, without its payload.
        variations: (K) how it differs.
        rates: of physics and control.
        payloads: (K) what it carries; nothing where they are not given.

    Raises:
        WorkbenchError: if a law cannot hover with the payload that it knows.
    """
    payloads = payloads or [NO_PAYLOAD] * len(variations)
    known = {each: law_record(law_constants(vehicle, each)) for each in {p.known for p in payloads}}
    delays = [each.delays(rates.physics_step, rates.control_period) for each in variations]
    flown = zip(variations, payloads, strict=True)
    return undelayed_vehicles(
        [
            vehicle_with_payload(_varied(vehicle, variation), payload)
            for variation, payload in flown
        ],
        np.concatenate([known[each.known] for each in payloads])
        if payloads
        else np.zeros(0, law_dtype(len(vehicle.rotors))),
        np.array([vehicle.hover_speeds] * len(variations)),
    )._replace(
        sensing_delays=np.array([each.sensing_delay for each in delays]),
        command_delays=np.array([each.command_delay for each in delays]),
    )


def undelayed_vehicles(
    vehicles: Sequence[Vehicle], law: np.ndarray, speeds: np.ndarray
) -> VehicleBatch:
    """Return vehicles (K) whose laws see and act without delay.

    Args:
        vehicles: as they fly.
        law: see `VehicleBatch`.
        speeds: see `VehicleBatch`.
    """
    return VehicleBatch(
        law=law,
        bodies=body_records(vehicles),
        rotors=np.array([rotor_records(each.rotors) for each in vehicles], dtype=ROTOR_DTYPE),
        speeds=speeds,
        sensing_delays=np.zeros((len(vehicles), 2)),
        command_delays=np.zeros((len(vehicles), 2)),
        lags=np.array([min(map(_quickest, each.rotors)) for each in vehicles]),
    )


def body_records(vehicles: Sequence[Vehicle]) -> np.ndarray:
    """Return the bodies of vehicles as records (K), see `BODY_DTYPE`."""
    bodies = [rigid_body(each.mass, each.inertia, each.p_BoBcm_B) for each in vehicles]
    return np.array([tuple(each) for each in bodies], dtype=BODY_DTYPE)


def rotor_records(rotors: Sequence[Rotor]) -> np.ndarray:
    """Return rotors as records (n), see `ROTOR_DTYPE`."""
    rows = [tuple(getattr(each, name) for name in RotorConstants._fields) for each in rotors]
    return np.array(rows, dtype=ROTOR_DTYPE)


def _varied(vehicle: Vehicle, variation: Variation) -> Vehicle:
    """Return a vehicle with the mass, inertia and rotor lag of a variation."""
    (xx, xy, xz), (_, yy, yz), (_, _, zz) = (variation.inertia * vehicle.inertia).tolist()
    lag = variation.rotor_lag
    rotors = tuple(
        dataclasses.replace(
            rotor,
            time_constant_up=lag * rotor.time_constant_up,
            time_constant_down=lag * rotor.time_constant_down,
        )
        for rotor in vehicle.rotors
    )
    return dataclasses.replace(
        vehicle,
        mass=variation.mass * vehicle.mass,
        I_BBcm_B=((xx, xy, xz), (xy, yy, yz), (xz, yz, zz)),
        rotors=rotors,
    )


def _quickest(rotor: Rotor) -> float:
    return min(rotor.time_constant_up, rotor.time_constant_down)

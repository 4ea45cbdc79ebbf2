"""What differs between the candidates of a batch, as arrays."""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller
from workbench.control.flight_law import ComputerSettings
from workbench.control.guidance import Reference
from workbench.design.rollout.sensor_set import SensorSet
from workbench.design.step_response import REST_VELOCITY_M_S, STEP_START_HEIGHT_M
from workbench.dynamics.air.settings import AirSettings
from workbench.estimation.gyro import GyroSettings
from workbench.parameters.flight_parameters import MAX_WEAKENED_ROTORS
from workbench.parameters.parameter_table import flight_table
from workbench.plant.payload import Payload
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import ScenarioStart
from workbench.systems.noise import noise_seed


class Candidates(NamedTuple):
    """N candidates for a vehicle with n rotors.

    Attributes:
        gains: (N, g) of the controller, see `Controller.gains`.
        air: (N, 22) see `AirSettings`.
        shares: (N, n) of their thrust that rotors give.
        payloads: (N, 8) see `Payload`.
        gyros: (N, 7) see `GyroSettings`.
        computers: (N, 3) see `ComputerSettings`.
        commands: (N, 8) from the edge on; see `guidance.Reference`.
        before: (N, 8) the same before the edge.
        starts: (N, 13) state of the body, see `record.flight_dtype`; its place is held while no
            pilot steers.
        seeds: (N) of the turbulence.
        filters: (N, k) settings of the estimator, none on the truth; and so the next two.
        noises: (N, 5) what the noise of the sensors starts from, see `SensorSet.seeds`.
        memories: (N, size) of the estimators at the start.
    """

    gains: np.ndarray
    air: np.ndarray
    shares: np.ndarray
    payloads: np.ndarray
    gyros: np.ndarray
    computers: np.ndarray
    commands: np.ndarray
    before: np.ndarray
    starts: np.ndarray
    seeds: np.ndarray
    filters: np.ndarray
    noises: np.ndarray
    memories: np.ndarray

    def part(self, first: int, last: int) -> "Candidates":
        """Return those from `first` up to before `last`."""
        return Candidates(*(column[first:last] for column in self))


def make_candidates(
    controller: Controller,
    gains: Sequence[Mapping[str, float]] | np.ndarray,
    own: Mapping[str, float],
    rotors: int,
    commands: np.ndarray,
    starts: np.ndarray,
    seeds: Sequence[int],
    before: Sequence[float] = REST_VELOCITY_M_S,
    senses: SensorSet | None = None,
) -> Candidates:
    """Return candidates as arrays.

    What a controller designs of its gains is left to the caller.

    Args:
        controller: whose law flies.
        gains: values by name of each candidate, or an array (N, p) with a column for each of the
            controller's parameters, of which the last may be left out; within the parameter
            table's limits or not.
        own: every value, for what the candidates do not name.
        rotors: how many there are.
        commands: velocity in W and yaw rate [m/s, rad/s] for all of them (4) or each (N, 4).
        starts: state of the plant for all of them (13) or each (N, 13).
        seeds: of each one's noise (N), as in a scenario, or of all (1).
        before: velocity in W that all are commanded before the edge (3) [m/s].
        senses: what tells their laws the motion; the truth is told without them.

    Raises:
        WorkbenchError: if a name is unknown, a value no number, one of a payload out of its limits,
            or an array of another size.
    """
    weakened = [f"rotor_{number}" for number in range(1, min(rotors, MAX_WEAKENED_ROTORS) + 1)]
    parts: dict[str, Sequence[str]] = {  # names of the columns of a table of all candidates
        "gains": [row.name for row in controller.parameters],
        "air": AirSettings._fields,
        "payloads": Payload._fields,
        "gyros": GyroSettings._fields,
        "computers": ComputerSettings._fields,
        "filters": senses.settings if senses else (),
        "shares": weakened,
    }
    names = [name for part in parts.values() for name in part]
    if isinstance(gains, np.ndarray):
        table = _from_array(gains, [own[name] for name in names], controller)
    else:
        known = frozenset(row.name for row in controller.table)
        table = _from_mappings(gains, names, own, known)
    ends = np.cumsum([len(part) for part in parts.values()])
    columns = dict(zip(parts, np.split(table, ends[:-1], axis=1), strict=True))
    shares = np.ones((len(table), rotors))
    shares[:, : len(weakened)] = columns["shares"]
    references, references_before = np.zeros((2, len(table), len(Reference._fields)))
    references[:, :4] = _for_each("commands", commands, len(table), 4)
    references_before[:, :3] = before
    states = _for_each("starts", starts, len(table), 13)
    noises, memories = _initial_sensor_states(senses, states, seeds)
    return Candidates(
        gains=columns["gains"].copy(),
        air=columns["air"].copy(),
        shares=shares,
        payloads=_checked_payloads(columns["payloads"]),
        gyros=columns["gyros"].copy(),
        computers=columns["computers"].copy(),
        commands=references,
        before=references_before,
        starts=states,
        seeds=_air_seeds(seeds, len(table)),
        filters=columns["filters"].copy(),
        noises=noises,
        memories=memories,
    )


def _initial_sensor_states(
    senses: SensorSet | None, starts: np.ndarray, seeds: Sequence[int]
) -> tuple[np.ndarray, np.ndarray]:
    """Return what noises start from, and what estimators remember at the starts."""
    count = len(starts)
    if senses is None:
        return np.zeros((count, 0)), np.zeros((count, 0))
    own = seeds if len(seeds) == count else list(seeds) * count
    noises = {seed: senses.seeds(seed) for seed in set(own)}
    memories: dict[tuple[int, bytes], np.ndarray] = {}
    for seed, start in zip(own, starts, strict=True):
        key = seed, start.tobytes()
        if key not in memories:
            memories[key] = senses.memory(start, seed)
    return (
        np.array([noises[seed] for seed in own]),
        np.array(
            [memories[seed, start.tobytes()] for seed, start in zip(own, starts, strict=True)]
        ),
    )


def _checked_payloads(payloads: np.ndarray) -> np.ndarray:
    """Return payloads (N, 8) if each has numbers that a payload can have.

    Those of law and air are taken as they are; of these no body could be made.
    """
    for name, column in zip(Payload._fields, payloads.T, strict=True):
        for value in np.unique(column).tolist():
            flight_table().find(name).check(value)
    return payloads.copy()


def _air_seeds(seeds: Sequence[int], count: int) -> np.ndarray:
    """Return what the noise of each candidate's air starts from (N)."""
    if len(seeds) not in (1, count):
        raise WorkbenchError(f"there are {len(seeds)} seeds for {count} candidates: give each one")
    known = {seed: float(noise_seed(seed, "air")) for seed in set(seeds)}
    starts = np.array([known[seed] for seed in seeds])
    return starts if len(seeds) == count else np.full(count, starts[0])


def _for_each(what: str, values: np.ndarray, count: int, size: int) -> np.ndarray:
    """Return a row of numbers for every candidate.

    They stand row by row in memory, whatever they were made from: compiled code is compiled anew
    for another order.
    """
    try:
        return np.array(np.broadcast_to(np.asarray(values, dtype=float), (count, size)), order="C")
    except (TypeError, ValueError):
        raise WorkbenchError(
            f"the {what} are {' x '.join(map(str, np.shape(values))) or 'no'} numbers: give "
            f"{size}, or a row of {size} for each of the {count} candidates"
        ) from None


def _from_array(gains: np.ndarray, own: Sequence[float], controller: Controller) -> np.ndarray:
    """Return a table of all columns, the first of which are given."""
    many = len(controller.parameters)
    if gains.ndim != 2 or gains.shape[1] not in (many, many - 1):
        raise WorkbenchError(
            f"the gains are an array of {' x '.join(map(str, gains.shape)) or 'no'} numbers: give "
            f"one with a row a candidate and {many} columns, the parameters of {controller.name}"
        )
    table = np.tile(np.array(own, dtype=float), (len(gains), 1))
    table[:, : gains.shape[1]] = gains
    return table


def _from_mappings(
    gains: Sequence[Mapping[str, float]],
    names: Sequence[str],
    own: Mapping[str, float],
    known: Collection[str],
) -> np.ndarray:
    """Return a table of all columns, with a row for each mapping."""
    table = np.empty((len(gains), len(names)))
    for number, values in enumerate(gains):
        for name in values.keys() - known:
            raise unknown_name("parameter", name, known)
        whole = {**own, **values}
        try:
            table[number] = [whole[name] for name in names]
        except (TypeError, ValueError):
            raise WorkbenchError(
                f"candidate {number + 1} has a value that is not a number: give every parameter one"
            ) from None
    return table


def start_state(vehicle: Vehicle, start: ScenarioStart) -> np.ndarray:
    """Return the body's state (13), see `record.flight_dtype`, at a start in the air.

    Args:
        vehicle: whose attitude is that of the frame in which its rotors lift upwards.
        start: of a scenario; without a position, where steps begin.
    """
    attitude = RollPitchYaw(np.array(thrust_frame(vehicle).roll_pitch_yaw(start.roll_pitch_yaw)))
    q_WB = attitude.ToRotationMatrix().ToQuaternion().wxyz()
    p_WB = start.position or [0.0, 0.0, STEP_START_HEIGHT_M]
    return np.array([*q_WB, *p_WB, *start.angular_velocity, *start.velocity])

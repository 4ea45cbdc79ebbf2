"""What differs between the candidates of a batch, as arrays."""

from collections.abc import Collection, Mapping, Sequence
from typing import NamedTuple

import numpy as np
from pydrake.math import RollPitchYaw

from workbench.common.errors import WorkbenchError, unknown_name
from workbench.control.controller import Controller
from workbench.control.flight_law import ComputerSettings
from workbench.control.guidance import Reference
from workbench.design.rollout.senses import Senses
from workbench.design.step_response import HOVER, START_HEIGHT
from workbench.dynamics.air.settings import AirSettings
from workbench.estimation.gyro import GyroSettings
from workbench.plant.payload import Payload
from workbench.plant.thrust_frame import thrust_frame
from workbench.plant.vehicle import Vehicle
from workbench.scenario.parameters import MOST_ROTORS, parameter_table
from workbench.scenario.scenario import Start
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
        starts: (N, 13) state of the plant, see `rigid_body.State`; its place is held while no
            pilot steers.
        seeds: (N) of the turbulence.
        filters: (N, k) settings of the estimator, none on the truth; and so the next two.
        noises: (N, 5) what the noise of the sensors starts from, see `Senses.seeds`.
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
    before: Sequence[float] = HOVER,
    senses: Senses | None = None,
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
    weak = [f"rotor_{number}" for number in range(1, min(rotors, MOST_ROTORS) + 1)]
    parameters = [row.name for row in controller.parameters]
    many = len(parameters)
    columns = (*parameters, *AirSettings._fields)
    around: tuple[str, ...] = (*GyroSettings._fields, *ComputerSettings._fields)
    if senses:
        around += senses.settings
    names = (*columns, *Payload._fields, *around, *weak)
    if isinstance(gains, np.ndarray):
        table = _from_array(gains, [own[name] for name in names], controller)
    else:
        known = frozenset(row.name for row in parameter_table(controller))
        table = _from_mappings(gains, names, own, known)
    shares = np.ones((len(table), rotors))
    behind = len(columns) + len(Payload._fields)
    signals = behind + len(GyroSettings._fields)
    filters = signals + len(ComputerSettings._fields)
    shares[:, : len(weak)] = table[:, behind + len(around) :]
    references, earlier = (np.zeros((len(table), len(Reference._fields))) for _ in range(2))
    references[:, :4] = _for_each("commands", commands, len(table), 4)
    earlier[:, :3] = before
    begun = _for_each("starts", starts, len(table), 13)
    noises, memories = _begun(senses, begun, seeds)
    return Candidates(
        gains=table[:, :many].copy(),
        air=table[:, many : len(columns)].copy(),
        shares=shares,
        payloads=_checked(table[:, len(columns) : behind]),
        gyros=table[:, behind:signals].copy(),
        computers=table[:, signals:filters].copy(),
        commands=references,
        before=earlier,
        starts=begun,
        seeds=_air_seeds(seeds, len(table)),
        filters=table[:, filters : behind + len(around)].copy(),
        noises=noises,
        memories=memories,
    )


def _begun(
    senses: Senses | None, starts: np.ndarray, seeds: Sequence[int]
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


def _checked(payloads: np.ndarray) -> np.ndarray:
    """Return payloads (N, 8) if each has numbers that a payload can have.

    Those of law and air are taken as they are; of these no body could be made.
    """
    for name, column in zip(Payload._fields, payloads.T, strict=True):
        for value in np.unique(column).tolist():
            parameter_table().find(name).check(value)
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


def start_state(vehicle: Vehicle, start: Start) -> np.ndarray:
    """Return the plant's state (13), see `rigid_body.State`, at a start in the air.

    Args:
        vehicle: whose attitude is that of the frame in which its rotors lift upwards.
        start: of a scenario; without a position, where steps begin.
    """
    attitude = RollPitchYaw(np.array(thrust_frame(vehicle).roll_pitch_yaw(start.roll_pitch_yaw)))
    q_WB = attitude.ToRotationMatrix().ToQuaternion().wxyz()
    p_WB = start.position or [0.0, 0.0, START_HEIGHT]
    return np.array([*q_WB, *p_WB, *start.angular_velocity, *start.velocity])

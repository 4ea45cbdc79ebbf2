"""Fly one vehicle's steps with many gain sets, in compiled code."""

import copy
import dataclasses
import math
import os
from collections import deque
from collections.abc import Callable, Mapping, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from contextlib import nullcontext
from dataclasses import astuple, dataclass
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.compiled import Compiled, compile_cached
from workbench.common.errors import WorkbenchError
from workbench.common.own_file import own_errors
from workbench.control.controller import Controller, load_controller
from workbench.control.flight_law import SOURCES as LAW
from workbench.control.flight_law import known_vehicle, law_constants
from workbench.control.guidance import KnownVehicle
from workbench.design.response_metrics import ResponseMetrics, response_metrics
from workbench.design.rollout.candidates import Candidates, make_candidates, start_state
from workbench.design.rollout.crafts import Crafts, make_crafts
from workbench.design.rollout.estimate import know_by
from workbench.design.rollout.flights import (
    Schedule,
    make_clock,
    make_flights,
    make_fly,
    make_rings,
)
from workbench.design.rollout.gyro import KNOW_TRUTH
from workbench.design.rollout.motion import LANES, make_room
from workbench.design.rollout.period import Clock, make_times
from workbench.design.rollout.record import sizes_of
from workbench.design.rollout.senses import Senses
from workbench.design.step_response import EDGE, HOVER, check_duration, check_step, stepped
from workbench.estimation.estimators import Estimator
from workbench.gains.gains import flight_gains
from workbench.plant.payload import Payload
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.axes import AXES
from workbench.scenario.scenario import Rates, Scenario, Start, check_scenario
from workbench.systems.battery import voltage_drop

SOURCES = (
    *LAW,
    "estimation",
    "systems/sensors/barometer.py",
    "design/rollout",
    "design/tumbling.py",
)
"""Sources of the compiled flights, below `workbench/`."""
LARGEST = 2
SHARE = 4
"""Pieces in a chunk at most, and chunks for each thread at least if there are pieces enough: a
few milliseconds each, so that progress is told and a stop is heard."""
Work = Callable[[int, int], None]
Keep = Callable[[int, int, np.ndarray], None]
"""Takes samples (M, k, 16) of the candidates from a first up to before a last one; the array
belongs to it no longer than the call."""
VELOCITIES = (7, 8, 9, 10, 11, 12)
"""Places in the state of angular velocity and velocity."""
RESPONSES = (10, 11, 12, 9)
"""Places in the state of what steps along each of `AXES` move."""


@dataclass(frozen=True)
class Rollouts:
    """N flown steps at the same M times.

    A candidate that is lost has NaN from then on; the others fly on. It is lost when a number is
    no longer finite, when it comes down to the ground, or when it is tilted over 90 degrees and
    then turns faster than 10 rad/s or moves faster than 20 m/s.

    Attributes:
        axis: x, y, z or yaw, on which the command steps.
        time: (M) from the command's edge on [s].
        velocity_W: (N, M, 3) of the base link's origin in W [m/s].
        angular_velocity_W: (N, M, 3) in W [rad/s].
        peak_rotor_use: (N) largest share of its speed limit at which any rotor ran, 0 .. 1.
        diverged_at: (N) when it was lost, from the edge on [s]: 0 if already in the hover before,
            NaN if it flew to the end.
    """

    axis: str
    time: np.ndarray
    velocity_W: np.ndarray
    angular_velocity_W: np.ndarray
    peak_rotor_use: np.ndarray
    diverged_at: np.ndarray

    def __repr__(self) -> str:
        return f"<Rollouts of {len(self)} steps along {self.axis}: {len(self.time)} samples each>"

    def __len__(self) -> int:
        return len(self.diverged_at)

    @property
    def response(self) -> np.ndarray:
        """Velocity [m/s] or yaw rate [rad/s] on the commanded axis, (N, M)."""
        if self.axis == "yaw":
            return self.angular_velocity_W[:, :, 2]
        return self.velocity_W[:, :, AXES.index(self.axis)]


@dataclass(frozen=True)
class MeasuredSteps:
    """Metrics of N steps whose curves were not kept.

    Attributes:
        metrics: (N) each, withheld where a step did not begin at rest or has not settled; they
            mean nothing for a candidate that was lost.
        peak_rotor_use: (N) see `Rollouts`.
        diverged_at: (N) see `Rollouts`.
    """

    metrics: ResponseMetrics
    peak_rotor_use: np.ndarray
    diverged_at: np.ndarray

    def __len__(self) -> int:
        return len(self.diverged_at)


@dataclass(frozen=True)
class Flights:
    """N flights from any start.

    Attributes:
        time: (M) from the start on [s].
        states: (N, M, 13) of the plant, see `rigid_body.State`; NaN from when it was lost on.
        peak_rotor_use: (N) see `Rollouts`.
        diverged_at: (N) see `Rollouts`.
    """

    time: np.ndarray
    states: np.ndarray
    peak_rotor_use: np.ndarray
    diverged_at: np.ndarray

    def __len__(self) -> int:
        return len(self.diverged_at)

    @property
    def velocity_W(self) -> np.ndarray:
        """Of the base link's origin (N, M, 3) [m/s]."""
        return self.states[:, :, 10:13]

    @property
    def angular_velocity_W(self) -> np.ndarray:
        """(N, M, 3) [rad/s]."""
        return self.states[:, :, 7:10]


def rollout_metrics(rollouts: Rollouts, amplitude: float) -> ResponseMetrics:
    """Return the metrics of flown steps, withheld if they mean nothing, see `ResponseMetrics`.

    Args:
        rollouts: kept at every control period if the numbers are to equal those of `fly_step`.
        amplitude: of the command, [m/s] or [rad/s]; not zero.
    """
    found = response_metrics(rollouts.time, rollouts.response, amplitude)
    return found.withheld(rollouts.time[-1], amplitude)


def make_schedule(rates: Rates, edge_time: float, duration: float, stride: int) -> Schedule:
    """Return when things happen; a command comes between physics steps, see `Session`.

    Args:
        rates: periods of physics and control.
        edge_time: when the command is given [s].
        duration: flown after it [s].
        stride: of the control periods that are kept.

    Raises:
        WorkbenchError: if that makes no flight.
    """
    check_duration(duration)
    if not (1 <= stride < math.inf and int(stride) == stride):
        raise WorkbenchError(f"the stride is {stride:g}: give it a whole number, 1 or more")
    step, steps = rates.physics_step, rates.control_steps
    edge = math.ceil(edge_time / step - 1e-6)
    return Schedule(
        edge=-(-edge // steps),
        edge_time=edge_time,
        end=math.floor((edge_time + duration) / step + 1e-6) // steps,
        stride=int(stride),
    )


OPTIONS: dict[str, Any] = {
    "nogil": True,
    "error_model": "numpy",  # divisions that might raise make no vector instructions
    "fastmath": {"contract"},  # a b + c in one instruction
}
"""How flights are compiled."""


@lru_cache(maxsize=64)
def compiled_fly(controller: Controller, estimator: Estimator | None) -> Callable[..., Any]:
    """Return the flight of up to 16 candidates with a controller, compiled at its first call.

    Args:
        controller: whose law flies.
        estimator: that tells it the motion; None tells it the truth.

    Raises:
        WorkbenchError: if the law cannot be compiled.
    """
    if not controller.compiles:
        raise WorkbenchError(
            f"{controller.name} is a system of Drake's, which cannot be compiled: fly it on the "
            "full diagram"
        )
    knowing = know_by(estimator) if estimator else KNOW_TRUTH
    return compiled_flights(
        make_fly(controller, knowing), "flights by the thousand", controller, estimator
    )


def compiled_flights(
    function: Callable[..., Any],
    what: str,
    controller: Controller,
    estimator: Estimator | None,
    text: str = "",
) -> Compiled:
    """Return flights with a controller, compiled at their first call.

    Args:
        function: that flies.
        what: they are, for messages.
        controller: whose law flies.
        estimator: that tells it the motion; None for the truth.
        text: of what else the machine code depends on.
    """
    whose = "" if controller.shipped else f" with {controller.name}"
    known = f" on the estimate {estimator.name}" if estimator else ""
    return compile_cached(
        function,
        SOURCES,
        f"{what}{whose}{known}",
        parts=300 if estimator else 260,
        text=f"{text}{controller.digest}{estimator.key if estimator else ''}",
        file=str(estimator.file if estimator and estimator.file else controller.file),
        **OPTIONS,
    )


def run_chunks(
    work: Work,
    count: int,
    threads: int,
    progress: Callable[[float], None] | None = None,
    stop: Callable[[], bool] | None = None,
) -> int:
    """Do `work(first, last)` for pieces 0 .. count; return how many of them, from 0 on, are done.

    Threads help only with work that lets go of Python's lock, as compiled code may.

    Args:
        work: does the pieces from `first` up to before `last`.
        count: of pieces.
        threads: that work at a time, besides the caller's own, which waits; with 1 that works.
        progress: called with the share done, 0 .. 1, by the caller's thread.
        stop: asked after each chunk; chunks that have not begun are left when it says so.
    """
    size = max(1, min(LARGEST, -(-count // (SHARE * threads))))
    chunks = [(first, min(first + size, count)) for first in range(0, count, size)]

    def told(done: int) -> bool:
        if progress:
            progress(done / count)
        return bool(stop and stop())

    if threads == 1 or len(chunks) == 1:
        for first, last in chunks:
            work(first, last)
            if told(last):
                return last
        return count
    todo = deque(chunks)
    begun: deque[tuple[int, Future[None]]] = deque()
    done = 0
    with ThreadPoolExecutor(threads, thread_name_prefix="rollouts") as pool:
        while todo or begun:
            while todo and len(begun) <= threads:  # one waits, so that no thread does
                first, last = todo.popleft()
                begun.append((last, pool.submit(work, first, last)))
            done, chunk = begun.popleft()
            chunk.result()
            if told(done):
                todo.clear()
    return done


class PlannedFlights(NamedTuple):
    """N candidates that fly on the same schedule.

    Attributes:
        controller: whose law flies.
        candidates: N of them.
        flights: (N) their records, see `record.flight_dtype`.
        crafts: what flies, K.
        which: (N) the craft of each candidate.
        clock: when things happen.
        schedule: of all.
        senses: what tells the laws the motion; None on the truth.
    """

    controller: Controller
    candidates: Candidates
    flights: np.ndarray
    crafts: Crafts
    which: np.ndarray
    clock: Clock
    schedule: Schedule
    senses: Senses | None = None

    @property
    def size(self) -> int:
        """How many candidates there are."""
        return len(self.which)

    @property
    def time(self) -> np.ndarray:
        """Time of the samples (M) from the edge on [s]."""
        when = self.schedule
        instants = np.arange(when.edge, when.end + 1, when.stride)
        return instants * self.clock.period - when.edge_time

    def fly(
        self,
        kept: tuple[int, ...],
        keep: Keep,
        threads: int,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> tuple[np.ndarray, np.ndarray]:
        """Fly them.

        Args:
            kept: which k of the state's numbers to sample.
            keep: called with the samples of each block, by several threads.
            threads: that fly at a time.
            progress: called with the flown share, 0 .. 1.
            stop: asked every few blocks; when it returns true, no more are flown.

        Returns:
            Of those that were flown, the first of all: the largest share of its speed limit at
            which any rotor ran, and when it was lost, from the edge on [s], NaN if it was not.
        """
        fly = compiled_fly(self.controller, self.senses and self.senses.estimator)
        sensors = self.senses and self.senses.hearing
        file = self.senses and self.senses.estimator.file
        shape, rotors = (len(self.time), len(kept), LANES), self.crafts.rotors.shape[1]
        peak_use, lost_at = np.zeros(self.size), np.full(self.size, -1.0)

        def work(first_block: int, last_block: int) -> None:
            samples, room, times = np.empty(shape), make_room(rotors), make_times()
            for first in range(first_block * LANES, last_block * LANES, LANES):
                last = min(first + LANES, self.size)
                crafts = self.crafts.chosen(self.which[first:last])
                crafts.furnish(room)
                flights = self.flights[first:last].copy()  # they may be flown again
                with own_errors(file, "update") if file else nullcontext():
                    fly(
                        flights,
                        make_rings(crafts),
                        room,
                        times,
                        self.clock,
                        sensors,
                        self.schedule,
                        np.array(kept),
                        samples,
                    )
                peak_use[first:last], lost_at[first:last] = flights["peak_use"], flights["lost_at"]
                keep(first, last, samples)

        blocks = run_chunks(work, -(-self.size // LANES), threads, progress, stop)
        done = min(blocks * LANES, self.size)
        after = np.maximum(0.0, lost_at * self.clock.period - self.schedule.edge_time)
        lost = np.where(lost_at < 0.0, np.nan, after)
        return peak_use[:done], lost[:done]

    def curves(
        self,
        kept: tuple[int, ...],
        threads: int,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Fly them and keep every sample; the arguments are those of `fly`.

        Returns:
            The samples (done, M, k) of those that were flown, and what `fly` returns.
        """
        found = np.full((self.size, len(self.time), len(kept)), np.nan)

        def keep(first: int, last: int, samples: np.ndarray) -> None:
            found[first:last] = samples[:, :, : last - first].transpose(2, 0, 1)

        peak_use, lost_at = self.fly(kept, keep, threads, progress, stop)
        return found[: len(peak_use)], peak_use, lost_at


class RolloutEngine:
    """Flies steps as `fly_step` does, from hover in the same air, thousands of them a second.

    It is the same law around a rigid body of its own, so there is no ground to stand on, no
    obstacle and no sensor. The ground at z = 0 has its effect on rotors, though, and a battery that
    the description states is full at the start, lasts as long as `own` says, and weakens them.
    It has no state: threads may share it.

    Args:
        vehicle: as the law knows it.
        rates: periods of physics and control; those of a scenario that says nothing without.
        variation: how what flies differs from the vehicle.
        seed: of the turbulence, where parameters ask for any; as a scenario's.
        threads: that fly at a time, without it as many as there are cores; 1 flies in the caller's.
        own: values of all parameters by name, for what candidates do not name; without them those
            that follow from the vehicle.
        controller: whose law flies; the default one where none is given.
        senses: what tells it the motion, as `make_senses` has it of the same rates; the truth is
            told without them.

    Raises:
        WorkbenchError: if rates or variation cannot be flown.
    """

    def __init__(
        self,
        vehicle: Vehicle,
        rates: Rates | None = None,
        variation: Variation | None = None,
        *,
        seed: int = 0,
        threads: int | None = None,
        own: Mapping[str, float] | None = None,
        controller: Controller | None = None,
        senses: Senses | None = None,
    ) -> None:
        self.senses = senses
        self.controller = controller or load_controller()
        self.vehicle = vehicle
        rates = rates or Rates()
        self.rates = dataclasses.replace(rates, record_period=rates.control_period)
        check_scenario(Scenario(rates=self.rates))
        self.gains = flight_gains(vehicle, controller=self.controller) if own is None else dict(own)
        cores = len(os.sched_getaffinity(0))
        self._threads = cores if threads is None else max(1, min(threads, cores))
        self._seed = seed
        self.clock = make_clock(vehicle, self.rates, self.gains["battery_duration"])
        self._vary(variation or Variation())

    def varied(self, variation: Variation) -> "RolloutEngine":
        """Return an engine for the same vehicle with another variation; quicker than a new one.

        Raises:
            WorkbenchError: if the variation cannot be flown.
        """
        other = copy.copy(self)
        other._vary(variation)
        return other

    def fly(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        axis: str,
        amplitude: float,
        *,
        duration: float = 3.0,
        heading: float = 0.0,
        velocity: Sequence[float] = HOVER,
        stride: int = 1,
        variations: Sequence[Variation] | None = None,
        seeds: Sequence[int] | None = None,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Rollouts:
        """Fly a step with every gain set, and keep its curves: 48 bytes a sample.

        Values are taken as they are, also those beyond their parameters' limits; where a gain set
        limits speed to less than the amplitude, the law cuts the command.

        Args:
            gains: parameter values by name of each of N candidates, or an array (N, p) with
                a column for each of the controller's parameters, of which the last may be left
                out. What is not named has the vehicle's own value.
            axis: x, y, z or yaw.
            amplitude: of the command, [m/s] or [rad/s].
            duration: flown after the edge [s].
            heading: yaw of all drones at the start [rad].
            velocity: of the steady flight before the step, in W (3) [m/s].
            stride: the first and every stride-th control period after it are kept.
            variations: how each candidate's vehicle differs from what the law knows (N); without
                them as the engine's.
            seeds: of each candidate's turbulence (N); without them the engine's.
            progress: called with the flown share, 0 .. 1.
            stop: asked every few flights; when it returns true, those flown so far are returned.

        Raises:
            WorkbenchError: if that makes no step, or the gains are not what they should be.
        """
        planned = self._steps(
            gains, axis, amplitude, duration, heading, velocity, stride, variations, seeds
        )
        curves, used, lost_at = planned.curves(VELOCITIES, self._threads, progress, stop)
        return Rollouts(
            axis=axis,
            time=planned.time,
            velocity_W=curves[:, :, 3:],
            angular_velocity_W=curves[:, :, :3],
            peak_rotor_use=used,
            diverged_at=lost_at,
        )

    def measure(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        axis: str,
        amplitude: float,
        *,
        duration: float = 3.0,
        heading: float = 0.0,
        variations: Sequence[Variation] | None = None,
        seeds: Sequence[int] | None = None,
        decay: float | np.ndarray = 0.0,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> MeasuredSteps:
        """Fly a step with every gain set, and keep its metrics alone: a hundred bytes a candidate.

        Args: as for `fly`, and
            decay: as for `ResponseMetrics.settled`.

        Raises:
            WorkbenchError: as `fly` does.
        """
        planned = self._steps(
            gains, axis, amplitude, duration, heading, HOVER, 1, variations, seeds
        )
        times = planned.time
        numbers = np.full((len(dataclasses.fields(ResponseMetrics)), planned.size), np.nan)

        def keep(first: int, last: int, samples: np.ndarray) -> None:
            responses = samples[:, 0, : last - first].T
            numbers[:, first:last] = dataclasses.astuple(
                response_metrics(times, responses, amplitude)
            )

        kept = (RESPONSES[AXES.index(axis)],)
        used, lost_at = planned.fly(kept, keep, self._threads, progress, stop)
        return MeasuredSteps(
            metrics=ResponseMetrics(*numbers[:, : len(used)]).withheld(
                times[-1], amplitude, np.broadcast_to(decay, planned.size)[: len(used)]
            ),
            peak_rotor_use=used,
            diverged_at=lost_at,
        )

    def fly_from(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        starts: np.ndarray,
        commands: np.ndarray,
        *,
        duration: float = 3.0,
        stride: int = 1,
        variations: Sequence[Variation] | None = None,
        seeds: Sequence[int] | None = None,
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> Flights:
        """Fly from any motion with any command: thrown, turning, upside down.

        Args:
            gains: as for `fly`.
            starts: state of the plant, see `candidates.start_state`, for all (13) or each of the
                candidates (N, 13); rotors turn as in hover.
            commands: velocity in W [m/s] and yaw rate [rad/s] from the start on, for all (4) or
                each (N, 4).
            duration: flown [s].
            stride: the first and every stride-th control period are kept.
            variations: as for `fly`.
            seeds: as for `fly`.
            progress: as for `fly`.
            stop: as for `fly`.

        Raises:
            WorkbenchError: if the duration is not one, or the arrays do not have the right shapes.
        """
        schedule = make_schedule(self.rates, 0.0, duration, stride)
        planned = self.plan(gains, commands, starts, schedule, variations, seeds)
        return Flights(
            planned.time, *planned.curves(tuple(range(13)), self._threads, progress, stop)
        )

    def _steps(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        axis: str,
        amplitude: float,
        duration: float,
        heading: float,
        velocity: Sequence[float],
        stride: int,
        variations: Sequence[Variation] | None,
        seeds: Sequence[int] | None,
    ) -> PlannedFlights:
        """Return flights of a step with a yaw [rad]."""
        check_step(axis, amplitude)
        commands = np.array(stepped(axis, amplitude, velocity))
        schedule = make_schedule(self.rates, EDGE, duration, stride)
        start = Start(roll_pitch_yaw=[0.0, 0.0, heading], velocity=list(velocity))
        state = start_state(self.vehicle, start)
        return self.plan(gains, commands, state, schedule, variations, seeds, velocity)

    def plan(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        commands: np.ndarray,
        starts: np.ndarray,
        schedule: Schedule,
        variations: Sequence[Variation] | None,
        seeds: Sequence[int] | None,
        before: Sequence[float] = HOVER,
    ) -> PlannedFlights:
        """Return flights of candidates.

        Args:
            gains: as for `fly`.
            commands: as for `fly_from`.
            starts: as for `fly_from`.
            schedule: of all.
            variations: as for `fly`.
            seeds: as for `fly`.
            before: velocity in W that all are commanded before the edge (3) [m/s].

        Raises:
            WorkbenchError: as `fly_from` does.
        """
        rotors = len(self.vehicle.rotors)
        noise = [self._seed] if seeds is None else seeds
        candidates = make_candidates(
            self.controller, gains, self.gains, rotors, commands, starts, noise, before, self.senses
        )
        candidates = self._designed(candidates)
        count = len(candidates.gains)
        if variations is None and not candidates.payloads.any():
            crafts, which = self._crafts, np.zeros(count, dtype=int)
        else:
            crafts, which = self._different_crafts(variations, candidates.payloads)
        flights = self.begin(candidates, crafts.chosen(which), self.controller)
        return PlannedFlights(
            self.controller, candidates, flights, crafts, which, self.clock, schedule, self.senses
        )

    def begin(
        self, candidates: Candidates, crafts: Crafts, controller: Controller | None
    ) -> np.ndarray:
        """Return the records of flights that begin (N), of candidates and the craft of each.

        Their law is that of a controller; None where none flies.
        """
        return make_flights(
            sizes_of(controller, len(self.vehicle.rotors)),
            self.senses,
            candidates,
            crafts,
            self.rates,
            self.vehicle.ground_clearance,
            voltage_drop(self.vehicle, self.gains["battery_duration"]),
            self.gains["sag_compensation"],
            controller.initial_memory if controller else [],
        )

    def design(self, gains: np.ndarray, payloads: np.ndarray) -> np.ndarray:
        """Return what the controller designs of gains (N, p), with payloads (N, 8) of each.

        Raises:
            WorkbenchError: if it cannot.
        """
        vehicles: dict[Payload, KnownVehicle] = {}
        designed = []
        for own, payload in zip(gains.tolist(), payloads, strict=True):
            known = Payload(*payload.tolist()).known
            if known not in vehicles:
                vehicles[known] = known_vehicle(law_constants(self.vehicle, known))
            dt = self.rates.control_period
            designed.append(self.controller.design_with(own, vehicles[known], dt))
        return np.array(designed)

    def _designed(self, candidates: Candidates) -> Candidates:
        """Return candidates with what the controller designs of their gains."""
        if not self.controller.designed:
            return candidates
        designed = self.design(candidates.gains, candidates.payloads)
        return candidates._replace(gains=np.hstack([candidates.gains, designed]))

    def _different_crafts(
        self, variations: Sequence[Variation] | None, payloads: np.ndarray
    ) -> tuple[Crafts, np.ndarray]:
        """Return the different crafts among those of N candidates, and which of them each has."""
        count = len(payloads)
        if variations is None:
            variations = [self.variation] * count
        if len(variations) != count:
            raise WorkbenchError(
                f"there are {len(variations)} variations for {count} candidates: give each one"
            )
        numbers: dict[tuple[tuple[Any, ...], ...], int] = {}
        both = zip(map(astuple, variations), map(tuple, payloads.tolist()), strict=True)
        which = [numbers.setdefault(each, len(numbers)) for each in both]
        varied = [Variation(*each) for each, _ in numbers]
        for variation in varied:
            variation.check()
        crafts = self._crafts_of(varied, [Payload(*p) for _, p in numbers])
        return crafts, np.array(which, dtype=int)

    def _vary(self, variation: Variation) -> None:
        """Let what flies differ; the law goes on believing in the vehicle."""
        variation.check()
        self.variation = dataclasses.replace(variation)
        self._crafts = self._crafts_of([self.variation])

    def _crafts_of(
        self, variations: Sequence[Variation], payloads: Sequence[Payload] | None = None
    ) -> Crafts:
        """Return vehicles that differ."""
        return make_crafts(self.vehicle, variations, self.rates, payloads)

"""Fly one vehicle's steps with many gain sets, in compiled code."""

import copy
import dataclasses
import os
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller, load_controller
from workbench.control.flight_law import Body, known_body, law_constants
from workbench.design.response_metrics import ResponseMetrics
from workbench.design.rollout.batch import Batch
from workbench.design.rollout.candidates import Candidates, make_candidates
from workbench.design.rollout.compiled_block import compiled_measures
from workbench.design.rollout.craft import Crafts, make_crafts
from workbench.design.rollout.measuring import NUMBERS
from workbench.design.rollout.rollouts import Flights, MeasuredSteps, Rollouts
from workbench.design.rollout.schedule import Schedule, make_schedule
from workbench.design.rollout.starts import start_state
from workbench.design.step_response import EDGE, HOVER, check_step, stepped
from workbench.gains.gains import flight_gains
from workbench.plant.payload import Payload
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.axes import AXES
from workbench.scenario.scenario import Rates, Scenario, Start, check_scenario

VELOCITIES = (7, 8, 9, 10, 11, 12)
"""Places in the state of angular velocity and velocity."""
RESPONSES = (10, 11, 12, 9)
"""Places in the state of what steps along each of `AXES` move."""


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
    ) -> None:
        self.controller = controller or load_controller()
        self.vehicle = vehicle
        rates = rates or Rates()
        self.rates = dataclasses.replace(rates, record_period=rates.control_period)
        check_scenario(Scenario(rates=self.rates))
        self.gains = flight_gains(vehicle, controller=self.controller) if own is None else dict(own)
        cores = len(os.sched_getaffinity(0))
        self._threads = cores if threads is None else max(1, min(threads, cores))
        self._seed = seed
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
        batch = self._steps(
            gains, axis, amplitude, duration, heading, velocity, stride, variations, seeds
        )
        curves, flown = batch.curves(VELOCITIES, self._threads, progress, stop)
        return Rollouts(
            axis=axis,
            time=batch.time,
            velocity_W=curves[:, :, 3:],
            angular_velocity_W=curves[:, :, :3],
            peak_rotor_use=flown.peak_use,
            diverged_at=flown.lost_at,
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
        progress: Callable[[float], None] | None = None,
        stop: Callable[[], bool] | None = None,
    ) -> MeasuredSteps:
        """Fly a step with every gain set, and keep its metrics alone: a hundred bytes a candidate.

        Args: as for `fly`.

        Raises:
            WorkbenchError: as `fly` does.
        """
        batch = self._steps(gains, axis, amplitude, duration, heading, HOVER, 1, variations, seeds)
        times = batch.time
        numbers = np.full((batch.size, NUMBERS), np.nan)

        def keep(first: int, last: int, samples: np.ndarray) -> None:
            compiled_measures(times, samples[:, 0], float(amplitude), numbers[first:last])

        flown = batch.fly((RESPONSES[AXES.index(axis)],), keep, self._threads, progress, stop)
        return MeasuredSteps(
            metrics=ResponseMetrics(*numbers[: flown.done].T).withheld(times[-1], amplitude),
            peak_rotor_use=flown.peak_use,
            diverged_at=flown.lost_at,
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
            starts: state of the plant, see `starts.start_state`, for all candidates (13) or each
                (N, 13); rotors turn as in hover.
            commands: velocity in W [m/s] and yaw rate [rad/s] from the start on, for all (4) or
                each (N, 4).
            duration: flown [s].
            stride: the first and every stride-th control period are kept.
            variations: as for `fly`, and so the next three.
            seeds: see there.
            progress: see there.
            stop: see there.

        Raises:
            WorkbenchError: if the duration is none, or the arrays are not what they should be.
        """
        schedule = make_schedule(self.rates, 0.0, duration, stride)
        batch = self._batch(gains, commands, starts, schedule, variations, seeds)
        states, flown = batch.curves(tuple(range(13)), self._threads, progress, stop)
        return Flights(batch.time, states, flown.peak_use, flown.lost_at)

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
    ) -> Batch:
        """Return flights of a step with a yaw [rad]."""
        check_step(axis, amplitude)
        commands = np.array(stepped(axis, amplitude, velocity))
        schedule = make_schedule(self.rates, EDGE, duration, stride)
        start = Start(roll_pitch_yaw=[0.0, 0.0, heading], velocity=list(velocity))
        state = start_state(self.vehicle, start)
        return self._batch(gains, commands, state, schedule, variations, seeds, velocity)

    def _batch(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        commands: np.ndarray,
        starts: np.ndarray,
        schedule: Schedule,
        variations: Sequence[Variation] | None,
        seeds: Sequence[int] | None,
        before: Sequence[float] = HOVER,
    ) -> Batch:
        """Return flights of candidates."""
        rotors = len(self.vehicle.rotors)
        noise = [self._seed] if seeds is None else seeds
        candidates = make_candidates(
            self.controller, gains, self.gains, rotors, commands, starts, noise, before
        )
        candidates = self._designed(candidates)
        count = len(candidates.gains)
        if variations is None and not candidates.payloads.any():
            return Batch(
                self.controller, candidates, self._crafts, np.zeros(count, dtype=int), schedule
            )
        crafts, which = self._different_crafts(variations, candidates.payloads)
        return Batch(self.controller, candidates, crafts, which, schedule)

    def _designed(self, candidates: Candidates) -> Candidates:
        """Return candidates with what the controller designs of their gains."""
        if not self.controller.designed:
            return candidates
        bodies: dict[Payload, Body] = {}
        designed = []
        for own, payload in zip(candidates.gains.tolist(), candidates.payloads, strict=True):
            known = Payload(*payload.tolist()).known
            if known not in bodies:
                bodies[known] = known_body(law_constants(self.vehicle, known))
            dt = self.rates.control_period
            designed.append(self.controller.design_with(own, bodies[known], dt))
        return candidates._replace(gains=np.hstack([candidates.gains, np.array(designed)]))

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
        numbers: dict[tuple[tuple[float, ...], ...], int] = {}
        both = zip(map(astuple, variations), map(tuple, payloads.tolist()), strict=True)
        which = [numbers.setdefault(each, len(numbers)) for each in both]
        varied = [Variation(*each) for each, _ in numbers]  # type: ignore[arg-type]
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
        duration = self.gains["battery_duration"]
        return make_crafts(self.vehicle, variations, self.rates, duration, payloads)

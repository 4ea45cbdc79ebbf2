"""Fly one vehicle's steps with many gain sets, in compiled code."""

import copy
import dataclasses
from collections.abc import Callable, Mapping, Sequence
from dataclasses import astuple
from typing import Any

import numpy as np

from workbench.common.errors import WorkbenchError
from workbench.control.controller import Controller
from workbench.control.controller_file import controller_or_default
from workbench.control.guidance import KnownVehicle
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.design.executor.executor import available_cores
from workbench.design.rollout.candidates import Candidates, make_candidates, start_state
from workbench.design.rollout.flights import (
    FlightSchedule,
    make_clock,
    make_flights,
)
from workbench.design.rollout.planned_flights import PlannedFlights, make_schedule
from workbench.design.rollout.record import sizes_of
from workbench.design.rollout.rollouts import Flights, MeasuredSteps, Rollouts
from workbench.design.rollout.sensor_set import SensorSet, make_sensor_set, refuse_joints
from workbench.design.rollout.steps import fly_steps, measure_steps
from workbench.design.rollout.vehicle_batch import VehicleBatch, make_vehicle_batch
from workbench.design.step_response import (
    REST_VELOCITY_M_S,
    STEP_EDGE_S,
    check_step,
    stepped,
)
from workbench.gains.gain_choice import flight_gains
from workbench.plant.payload import Payload
from workbench.plant.variation import Variation
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates, Scenario, ScenarioStart
from workbench.scenario.scenario_check import check_scenario
from workbench.setup import Setup
from workbench.systems.battery import voltage_drop


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
        senses: its estimator with the sensors, see `make_sensor_set`; None for the true state.

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
        senses: SensorSet | None = None,
    ) -> None:
        refuse_joints(vehicle)
        self.senses = senses
        self.controller = controller_or_default(controller)
        self.vehicle = vehicle
        rates = rates or Rates()
        self.rates = dataclasses.replace(rates, record_period=rates.control_period)
        check_scenario(Scenario(rates=self.rates))
        self.gains = flight_gains(vehicle, controller=self.controller) if own is None else dict(own)
        cores = available_cores()
        self._threads = cores if threads is None else max(1, min(threads, cores))
        self._seed = seed
        self.clock = make_clock(vehicle, self.rates, self.gains["battery_duration"])
        self._vary(variation or Variation())

    @classmethod
    def of(cls, setup: Setup, threads: int | None = None) -> "RolloutEngine":
        """Return the engine of a setup.

        Args:
            setup: what flies.
            threads: as for the class.

        Raises:
            WorkbenchError: if its rates or variation cannot be flown.
        """
        return cls(
            setup.vehicle,
            setup.rates,
            setup.variation,
            seed=setup.scenario.sensors.seed,
            threads=threads,
            own=setup.values,
            controller=setup.controller,
            senses=make_sensor_set(setup),
        )

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
        velocity: Sequence[float] = REST_VELOCITY_M_S,
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
        return fly_steps(
            planned, axis, amplitude, duration, velocity, self._threads, progress, stop
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
            decay: as for `step_metrics`.

        Raises:
            WorkbenchError: as `fly` does.
        """
        planned = self._steps(
            gains, axis, amplitude, duration, heading, REST_VELOCITY_M_S, 1, variations, seeds
        )
        return measure_steps(
            planned, axis, amplitude, duration, decay, self._threads, progress, stop
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
        schedule = make_schedule(self.rates, STEP_EDGE_S, duration, stride)
        start = ScenarioStart(roll_pitch_yaw=[0.0, 0.0, heading], velocity=list(velocity))
        state = start_state(self.vehicle, start)
        return self.plan(gains, commands, state, schedule, variations, seeds, velocity)

    def plan(
        self,
        gains: Sequence[Mapping[str, float]] | np.ndarray,
        commands: np.ndarray,
        starts: np.ndarray,
        schedule: FlightSchedule,
        variations: Sequence[Variation] | None,
        seeds: Sequence[int] | None,
        before: Sequence[float] = REST_VELOCITY_M_S,
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
            vehicles, which = self._vehicles, np.zeros(count, dtype=int)
        else:
            vehicles, which = self._different_vehicles(variations, candidates.payloads)
        flights = self.begin(candidates, vehicles.chosen(which), self.controller)
        return PlannedFlights(
            self.controller, candidates, flights, vehicles, which, self.clock, schedule, self.senses
        )

    def begin(
        self, candidates: Candidates, vehicles: VehicleBatch, controller: Controller | None
    ) -> np.ndarray:
        """Return the records of flights that begin (N), of candidates and the vehicle of each.

        Their law is that of a controller; None where none flies.
        """
        return make_flights(
            sizes_of(controller, len(self.vehicle.rotors)),
            self.senses,
            candidates,
            vehicles,
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

    def _different_vehicles(
        self, variations: Sequence[Variation] | None, payloads: np.ndarray
    ) -> tuple[VehicleBatch, np.ndarray]:
        """Return the different vehicles among those of N candidates, and which of them each has."""
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
        vehicles = self._vehicles_of(varied, [Payload(*p) for _, p in numbers])
        return vehicles, np.array(which, dtype=int)

    def _vary(self, variation: Variation) -> None:
        """Let what flies differ; the law goes on believing in the vehicle."""
        variation.check()
        self.variation = dataclasses.replace(variation)
        self._vehicles = self._vehicles_of([self.variation])

    def _vehicles_of(
        self, variations: Sequence[Variation], payloads: Sequence[Payload] | None = None
    ) -> VehicleBatch:
        """Return vehicles that differ."""
        return make_vehicle_batch(self.vehicle, variations, self.rates, payloads)

"""Flights from instants of a log on, and along it, with a law and the vehicles that it flies.

They fly as compiled flights everywhere do, see `rollout.period`; only a prediction has the error of
an estimate, see `known`, and a disturbance, see `driven`.
"""

import math
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.control.controller import Controller
from workbench.control.law_constants import known_vehicle, law_constants
from workbench.design.rollout import compiled_flights
from workbench.design.rollout.flights import begin_flights, set_steps
from workbench.design.rollout.lane_times import DelayRings, PeriodClock, make_lane_times
from workbench.design.rollout.lanes import LANES, make_lane_workspace
from workbench.design.rollout.record import flight_dtype, law_record, sizes_of
from workbench.design.rollout.sensor_set import refuse_joints
from workbench.design.rollout.vehicle_batch import VehicleBatch, undelayed_vehicles
from workbench.extras.flightdata.predict.driven import (
    DRIVEN_FIELDS,
    PUSH_SIZE,
    make_fly_driven,
    make_run_law,
)
from workbench.extras.flightdata.predict.known import ESTIMATE_ERROR_SIZE, Observer
from workbench.plant.gravity import AIR_DENSITY
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate

PREDICT_SOURCES = (*compiled_flights.ENGINE_SOURCES, "extras/flightdata/predict")
"""What compiled predictions stand in, below `workbench/`, besides the controller."""
FOLLOW_FLAG_INDEX = 7
"""Place of a reference that says that its position counts, see `guidance.Reference`."""
DEFAULT_LAW_PERIOD_S = 1 / 128
"""Between updates of a law that states none [s]."""
PUSH_TRIALS = 3
"""Of a control period, to find its push."""
ENDLESS_S = 1e9
"""Longer than any flight, before and after its start [s]."""


class CompiledModel(NamedTuple):
    """A law, and vehicles that it flies.

    Attributes:
        controller: the law.
        gains: of the controller, and what it designs.
        vehicles: one vehicle for all flights, or one for each.
        period: between updates of the law [s].
        drag_areas: of the bodies: a number, or one of each flight [m²].
        winds: velocity of the air in W (3), or of each flight (N, 3) [m/s].
    """

    controller: Controller
    gains: np.ndarray
    vehicles: VehicleBatch
    period: float
    drag_areas: Any = 0.0
    winds: Any = (0.0, 0.0, 0.0)

    @property
    def clock(self) -> PeriodClock:
        """When things happen: updates of the law, and of nothing else."""
        one = np.ones(1)
        estimate = sampled_estimate(self.period)
        return PeriodClock(
            step=self.period,
            period=self.period,
            mode_period=math.inf,
            estimate=estimate,
            sags=False,
            battery_period=math.inf,
            used=0.0,
            charges=one,
            voltages=one,
        )


def make_compiled_model(
    vehicle: Vehicle,
    controller: Controller,
    gains: dict[str, float],
    period: float,
    flown: Sequence[Vehicle] | None = None,
) -> CompiledModel:
    """Return a law and what it flies.

    Args:
        vehicle: as the law knows it.
        controller: the law.
        gains: of all its parameters, by name.
        period: between updates of the law [s].
        flown: the vehicles that fly (N), where these are others.
    """
    refuse_joints(vehicle)
    constants = law_constants(vehicle)
    real = flown or [vehicle]
    return CompiledModel(
        controller=controller,
        gains=np.array(controller.gains(gains, known_vehicle(constants), period)),
        vehicles=undelayed_vehicles(
            real, law_record(constants), np.array([vehicle.hover_speeds] * len(real))
        ),
        period=period,
    )


class FlightStarts(NamedTuple):
    """Where N flights begin; one row in place of N is for all of them.

    Attributes:
        states: (N, 13), see `record.flight_dtype`.
        speeds: of the rotors (N, n) [rad/s].
        memory: of the law (N, k).
        counts: of its updates before the start (N).
        errors: of the estimate (N, 11), see `ESTIMATE_ERROR_SIZE`.
        voltages: see `guidance.MeasuredMotion` (N).
        shares: of their thrust that rotors give (N, n).
        pushes: that act already (N, 1, 9), see `PUSH_SIZE`.
    """

    states: np.ndarray
    speeds: np.ndarray
    memory: np.ndarray
    counts: np.ndarray
    errors: np.ndarray
    voltages: np.ndarray
    shares: np.ndarray
    pushes: np.ndarray


class FlightCourses(NamedTuple):
    """What N flights meet in K control periods; one row in place of N is for all of them.

    Attributes:
        references: (N, K, 8), see `guidance.Reference`.
        voltages: (N, K), see `guidance.MeasuredMotion`; the last one goes on.
        pushes: (N, K, 9), see `PUSH_SIZE`; the last one goes on.
        errors: of the estimate (N, K, 11); where there is none, it goes on as `Observer` has it.
        targets: states (N, K, 13) at the ends of the periods; trials correct pushes towards them.
        limits: speeds of a rotor at full command (N, K) [rad/s].
        saturated: numbers of periods in which a rotor is at its limit (N), which a flight adds to.
    """

    references: np.ndarray
    voltages: np.ndarray
    pushes: np.ndarray
    errors: np.ndarray = np.empty((1, 0, ESTIMATE_ERROR_SIZE))
    targets: np.ndarray = np.empty((1, 0, 13))
    limits: np.ndarray = np.empty((1, 0))
    saturated: np.ndarray = np.empty(1)

    def part(self, some: slice) -> "FlightCourses":
        """Return the course of some flights."""
        return FlightCourses(*(each if len(each) == 1 else each[some] for each in self))


class DrivenFunctions(NamedTuple):
    """Flights with a controller.

    Attributes:
        fly: returns each `keep`-th state (N, K/keep + 1, 13) of flights, of `CompiledModel`,
            `FlightStarts`, `FlightCourses`, `Observer`, `keep`, and trials of each control period,
            see `make_fly_driven`.
        listen: returns what the law remembers after each of K updates on logged states (K, k), of
            these (K, 13); references (K, 8); voltages (K); what the log says of the memory (K, r),
            NaN where it says nothing; places of each of these (r, 4): the number in the memory, the
            integral behind it, -1 for none, its gain, and the share of the difference that the
            integral takes; the memory to begin with (k); and `CompiledModel`.
    """

    fly: Callable[..., np.ndarray]
    listen: Callable[..., np.ndarray]


@lru_cache(maxsize=16)
def compiled_driven(controller: Controller) -> DrivenFunctions:
    """Return the functions of a controller, compiled at their first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    compiled_fly, compiled_listen = (
        compile_cached(
            function,
            PREDICT_SOURCES,
            f"{what}{whose}",
            parts=parts,
            text=controller.digest,
            file=str(controller.file),
            **compiled_flights.FLIGHT_COMPILE_OPTIONS,
        )
        for function, what, parts in (
            (make_fly_driven(controller), "predictions", 260),
            (make_run_law(controller), "the law along a log", 80),
        )
    )

    def fly(
        model: CompiledModel,
        start: FlightStarts,
        course: FlightCourses,
        observer: Observer,
        keep: int = 1,
        trials: int = 1,
    ) -> np.ndarray:
        flights = start_records(model, start)
        many, updates = len(flights), course.references.shape[1]
        states = np.empty((many, updates // keep + 1, 13))
        n = len(start.speeds[0])
        room, places = make_lane_workspace(n), make_lane_times()
        undelayed = DelayRings(np.zeros((LANES, 1, 13)), np.zeros((LANES, 1, n)))
        for first in range(0, many, LANES):
            some = slice(first, first + LANES)
            each = (
                model.vehicles if len(model.vehicles.bodies) == 1 else model.vehicles.chosen(some)
            )
            each.furnish(room)
            compiled_fly(
                flights[some],
                undelayed,
                room,
                places,
                model.clock,
                observer,
                course.part(some),
                trials,
                keep,
                states[some],
            )
        return states

    def listen(
        measured: np.ndarray,
        references: np.ndarray,
        voltages: np.ndarray,
        told: np.ndarray,
        places: np.ndarray,
        first: np.ndarray,
        model: CompiledModel,
    ) -> np.ndarray:
        n, found = len(model.vehicles.speeds[0]), np.empty((len(measured), len(first)))
        one = np.ones(1)
        rest = FlightStarts(
            states=np.eye(1, 13),
            speeds=np.zeros((1, n)),
            memory=first[None],
            counts=0.0 * one,
            errors=np.zeros((1, ESTIMATE_ERROR_SIZE)),
            voltages=one,
            shares=np.ones((1, n)),
            pushes=np.zeros((1, 1, PUSH_SIZE)),
        )
        flights = start_records(model, rest)
        compiled_listen(flights, model.clock, measured, references, voltages, told, places, found)
        return found

    return DrivenFunctions(fly, listen)


def start_records(model: CompiledModel, start: FlightStarts) -> np.ndarray:
    """Return the records of flights that begin: `record.flight_dtype` with `DRIVEN_FIELDS`."""
    vehicles, n = model.vehicles, start.speeds.shape[1]
    sizes = sizes_of(model.controller, n)
    many = max(len(start.states), len(vehicles.bodies))
    flights = np.zeros(many, flight_dtype(sizes, DRIVEN_FIELDS))
    begin_flights(flights, start.states, start.speeds, [])
    if sizes.gains:
        flights["gains"] = model.gains
    if sizes.memory:
        flights["memory"] = start.memory
    flights["law"] = vehicles.law
    set_steps(flights, np.broadcast_to(vehicles.lags, many), model.period)
    flights["error"], flights["shares"], flights["count"] = start.errors, start.shares, start.counts
    # the law flies to where its reference is, all the time, however low
    flights["holding"], flights["clearance"] = 0.0, -math.inf
    for updates in ("mode_updates", "battery_updates"):  # the next one never comes
        flights[updates] = 1.0
    air = flights["air"]
    air["wind_x"], air["wind_y"], air["wind_z"] = np.transpose(model.winds)
    air["air_density"], air["drag_area"] = AIR_DENSITY, model.drag_areas
    air["push_start"], air["push_duration"] = -ENDLESS_S, 2.0 * ENDLESS_S
    return flights

"""The records of flights that begin, and the flight of up to sixteen of them."""

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from workbench.common.jitable import give_unique_name, register_jitable
from workbench.control.controller import Controller
from workbench.control.flight_mode import HOVERING
from workbench.control.law_signals import steady_filters
from workbench.design.rollout.candidates import Candidates
from workbench.design.rollout.estimate import estimate_fields
from workbench.design.rollout.fields import set_field
from workbench.design.rollout.lane_motion import write_lane_air, write_lane_drive, write_lane_state
from workbench.design.rollout.lane_times import DelayRings, LaneTimes, PeriodClock
from workbench.design.rollout.lanes import LANES, LaneWorkspace
from workbench.design.rollout.law_update import make_law_update
from workbench.design.rollout.motion import derive_lanes, lane_acceleration
from workbench.design.rollout.period import StateSource, make_fly_period, note_peaks
from workbench.design.rollout.record import Sizes, flight_dtype
from workbench.design.rollout.sensor_set import EstimatorInputs, SensorSet
from workbench.design.rollout.vehicle_batch import VehicleBatch
from workbench.dynamics.air.settings import AirSettings
from workbench.estimation.filters import filter_is_on, lowpass
from workbench.estimation.gyro import GyroSettings, filters_gyro, gyro_filter, sample_steps
from workbench.estimation.imu import drawn_imu_bias
from workbench.plant.vehicle import Vehicle
from workbench.scenario.scenario import Rates
from workbench.session.integration import air_step
from workbench.systems.acceleration_estimate import sampled_estimate
from workbench.systems.battery import BATTERY_PERIOD_S, hover_power, voltage_curve


class FlightSchedule(NamedTuple):
    """What is flown; instants are numbers of control periods from the start.

    Attributes:
        edge: instant at which the command steps.
        edge_time: when it was given [s], up to a period earlier.
        end: last instant.
        stride: the first and every stride-th instant after it are kept.
    """

    edge: int
    edge_time: float
    end: int
    stride: int


def make_clock(vehicle: Vehicle, rates: Rates, battery_duration: float) -> PeriodClock:
    """Return when things happen in the flights of a vehicle.

    Args:
        vehicle: as its law knows it.
        rates: of physics, control and flight mode.
        battery_duration: time that a full battery hovers [s].
    """
    curve = voltage_curve(vehicle)
    return PeriodClock(
        step=rates.physics_step,
        period=rates.control_period,
        mode_period=rates.mode_period,
        estimate=sampled_estimate(rates.control_period),
        sags=vehicle.battery is not None,
        battery_period=BATTERY_PERIOD_S,
        used=BATTERY_PERIOD_S / hover_power(vehicle) / battery_duration,
        charges=curve[:, 0].copy(),
        voltages=curve[:, 1].copy(),
    )


def make_flights(
    sizes: Sizes,
    senses: SensorSet | None,
    candidates: Candidates,
    vehicles: VehicleBatch,
    rates: Rates,
    clearance: float,
    drop: float,
    sag_compensation: float,
    memory: list[float],
) -> np.ndarray:
    """Return the records of N flights that begin.

    Args:
        sizes: see `Sizes`.
        senses: what tells their laws the motion; None on the truth.
        candidates: N of them.
        vehicles: one for each.
        rates: of physics and control.
        clearance: height of the body at which it stands on the ground [m].
        drop: of the battery's voltage, see `dynamics.rotors.loaded_voltage`.
        sag_compensation: share of its sag that is compensated.
        memory: of the law at the start.
    """
    estimate = estimate_fields(senses) if senses else {}
    flights = np.zeros(len(candidates.gains), flight_dtype(sizes, estimate))
    flights["reference"], flights["following"] = candidates.before, candidates.commands
    if sizes.gains:
        flights["gains"] = candidates.gains
    flights["computer"], flights["law"] = candidates.computers, vehicles.law
    flights["shares"] = candidates.shares
    for name, column in zip(AirSettings._fields, candidates.air.T, strict=True):
        flights["air"][name] = column
    flights["air_seed"], flights["drop"] = candidates.seeds, drop
    flights["sag_compensation"] = sag_compensation
    flights["gyro"] = candidates.gyros
    _set_gyros(flights, candidates.gyros, rates)
    set_steps(flights, vehicles.lags, rates.control_period)
    for name, (periods, steps) in (
        ("sensing", vehicles.sensing_delays.T),
        ("command", vehicles.command_delays.T),
    ):
        flights[f"{name}_delay"] = periods
        flights[f"{name}_offset"] = steps * rates.physics_step
    flights["clearance"] = clearance
    if senses:
        _begin_estimates(flights, senses, candidates, rates)
    begin_flights(flights, candidates.starts, vehicles.speeds, memory)
    return flights


def begin_flights(
    flights: np.ndarray, starts: np.ndarray, speeds: np.ndarray, memory: list[float]
) -> None:
    """Let flights begin, as a `Session` does, with what else they have.

    Args:
        flights: (N) their records.
        starts: (N, 13) states of the body.
        speeds: (N, n) of the rotors [rad/s].
        memory: of the law at the start.
    """
    flights["state"] = flights["known"] = starts
    flights["speeds"] = flights["commands"] = flights["acting"] = speeds
    filtered = np.broadcast_arrays(*steady_filters(starts[:, 10:13].T))
    flights["filtered"] = np.stack(filtered, axis=1)
    flights["hold"], flights["holding"], flights["mode"] = starts[:, 4:7], 1.0, HOVERING
    if memory:
        flights["memory"] = memory
    wind, air = flights["wind"], flights["air"]
    wind[:, 0], wind[:, 1], wind[:, 2] = air["wind_x"], air["wind_y"], air["wind_z"]
    flights["charge"] = flights["open_circuit"] = flights["voltage"] = 1.0
    for name in ("push", "eddies", "mode_updates", "battery_updates", "sampled", "count"):
        flights[name] = 0.0
    flights["peak_use"], flights["lost_at"] = 0.0, -1.0


def make_delay_rings(vehicles: VehicleBatch) -> DelayRings:
    """Return the rings of flights of N vehicles, which have to be filled."""
    count, rotors = vehicles.speeds.shape
    sensing, command = (
        1 + int(each[:, 0].max(initial=0))
        for each in (vehicles.sensing_delays, vehicles.command_delays)
    )
    return DelayRings(np.zeros((count, sensing, 13)), np.zeros((count, command, rotors)))


def _set_gyros(flights: np.ndarray, gyros: np.ndarray, rates: Rates) -> None:
    """Write what follows from the settings of gyros (N, 7)."""
    for settings in np.unique(gyros, axis=0):
        same = (gyros == settings).all(axis=1)
        live = GyroSettings(*settings.tolist())
        every = sample_steps(live.gyro_rate, rates.physics_step, rates.control_steps)
        period = every * rates.physics_step
        flights["gyro_every"][same] = every
        flights["gyro_filters"][same] = filters_gyro(live, period)
        flights["gyro_filter"][same] = gyro_filter(live, period)


def set_steps(flights: np.ndarray, lags: np.ndarray, period: float) -> None:
    """Write the steps of the integrator, for the lags of the quickest rotors (N) [s]."""
    for lag in np.unique(lags):
        for prefix, turns_fast in (("", False), ("fast_", True)):
            step, third = air_step(period, float(lag), turns_fast)
            flights[f"{prefix}step"][lags == lag] = step
            flights[f"{prefix}third"][lags == lag] = third


def _begin_estimates(
    flights: np.ndarray, senses: SensorSet, candidates: Candidates, rates: Rates
) -> None:
    """Write what sensors and estimators have at the start."""
    flights["estimate"] = candidates.starts
    flights["estimator"], flights["settings"] = candidates.memories, candidates.filters
    flights["seeds"] = candidates.noises
    flights["readings"] = flights["delivered"] = np.nan
    noise = senses.inputs.imu_noise
    with np.errstate(over="ignore"):  # integers of the noise wrap around
        seeds = {
            seed: drawn_imu_bias(noise.mean, noise.spread, seed) for seed in candidates.noises[:, 0]
        }
    flights["bias"] = [seeds[seed] for seed in candidates.noises[:, 0]]
    for settings in np.unique(candidates.gyros, axis=0):
        same = (candidates.gyros == settings).all(axis=1)
        live = GyroSettings(*settings.tolist())
        period = float(flights["gyro_every"][same][0]) * rates.physics_step
        section = lowpass(live.accel_lowpass, live.accel_lowpass_order, period)
        flights["accel_filter"][same] = section
        flights["accel_filters"][same] = filter_is_on(live.accel_lowpass, period)


def make_fly_block(controller: Controller, source: StateSource) -> Callable[..., None]:
    """Return a function that flies up to 16 candidates with a controller, from start to end."""
    key = f"{controller.key}_{source.key}"
    fly_period = make_fly_period(make_law_update(controller), source, key)

    def fly(
        flights: np.ndarray,
        rings: DelayRings,
        room: LaneWorkspace,
        times: LaneTimes,
        clock: PeriodClock,
        sensors: EstimatorInputs | None,
        schedule: FlightSchedule,
        kept: np.ndarray,
        samples: np.ndarray,
    ) -> None:
        """Fly up to 16 candidates side by side; this is what gets compiled.

        Args:
            flights: their records, see `record.flight_dtype`.
            rings: see `DelayRings`.
            room: for their motion, with their constants, see `VehicleBatch.furnish`.
            times: see `LaneTimes`.
            clock: see `PeriodClock`.
            sensors: see `make_fly_period`.
            schedule: see `FlightSchedule`.
            kept: (k) which of the state's numbers to keep.
            samples: (M, k, 16) places for them from the edge on; NaN once a candidate is lost.
        """
        many = len(flights)
        write_flights(flights, rings, room)
        derive_lanes(room.bodies[0], room.rotors, clock.sags, False)
        for i in range(many):  # the first sample of an IMU is that at the start
            set_field(flights[i], "acceleration", lane_acceleration(room.bodies[0], i))
        for instant in range(schedule.end + 1):
            after_edge = instant - schedule.edge  # in control periods
            if after_edge == 0:
                for i in range(many):
                    _begin_command(flights[i])
            if after_edge >= 0 and after_edge % schedule.stride == 0:
                for i in range(many):
                    _keep_state(flights[i], kept, samples[after_edge // schedule.stride], i)
            if after_edge >= 0:
                for i in range(many):
                    if flights[i].lost_at < 0.0:
                        note_peaks(flights[i], room, i)
            if instant < schedule.end:
                fly_period(flights, rings, room, times, clock, sensors)

    return give_unique_name(fly, key)


@register_jitable(allocates=False)
def write_flights(flights: np.ndarray, rings: DelayRings, room: LaneWorkspace) -> None:
    """Write flights that begin to their lanes; one that has what is not a number is lost."""
    many = len(flights)
    for i in range(LANES):  # lanes without a flight repeat the last one
        flight = flights[min(i, many - 1)]
        if not is_finite_flight(flight):
            flight.lost_at = 0.0
        write_lane_state(flight, room, i)
        write_lane_air(flight, room, i)
        write_lane_drive(flight, room, i)
    for i in range(many):
        fill_delay_rings(flights[i], rings, i)


@register_jitable(allocates=False)
def fill_delay_rings(flight: np.record, rings: DelayRings, i: int) -> None:
    """Let the state at the start, and the commands of then, be on their way."""
    for age in range(rings.states.shape[1]):
        for k in range(13):
            rings.states[i, age, k] = flight.state[k]
    for age in range(rings.commands.shape[1]):
        for k in range(len(flight.commands)):
            rings.commands[i, age, k] = flight.commands[k]


@register_jitable(allocates=False)
def is_finite_flight(flight: np.record) -> bool:
    """Return whether all that a flight is given is a number.

    Comparisons with NaN are false: a limit that is NaN would limit nothing.
    """
    missing = False
    for number in flight.inputs:
        missing = missing or number != number
    return not missing


@register_jitable(allocates=False)
def _begin_command(flight: np.record) -> None:
    """Give the command at the edge."""
    for k in range(len(flight.reference)):
        flight.reference[k] = flight.following[k]


@register_jitable(allocates=False)
def _keep_state(flight: np.record, kept: np.ndarray, places: np.ndarray, i: int) -> None:
    """Write what is asked for of the state."""
    for k in range(len(kept)):
        places[k, i] = flight.state[kept[k]] if flight.lost_at < 0.0 else math.nan

"""What a log tells before an instant, from which a prediction starts: nothing here looks ahead.

- The share of thrust that the rotors give, and the level force in B (tilt between the measured axes
  and those of the thrust), from accelerations and commands just before.
- The estimate's error, see `known.ESTIMATE_ERROR_SIZE`: its constant part is the mean since the
  take-off, a few seconds at most.
- The law's memory. The law runs along the log on what the flight computer knew; where the log has
  the attitude and the thrust that were asked for, the integrals behind these follow them. Integrals
  of inner loops cannot be told so: gyro samples of 100 Hz alias. They begin where the model holds
  the moment that the air makes at the velocity of the start.
"""

import math
from collections.abc import Callable, Mapping
from functools import cached_property
from typing import Any, NamedTuple

import numpy as np
from scipy.signal import lfilter

from workbench.control.controller import Controller
from workbench.extras.flightdata.predict.driven import PUSH_SIZE
from workbench.extras.flightdata.predict.flown import FOLLOW_FLAG_INDEX, CompiledModel, FlightStarts
from workbench.extras.flightdata.predict.known import ESTIMATE_ERROR_SIZE
from workbench.extras.flightdata.predict.motion import (
    MIN_TURNING_COMMAND,
    LoggedMotion,
    resampled,
    rotation_matrices,
)
from workbench.plant.drag import drag_rates
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle

PAST_AVERAGE_S = 0.7
"""Time before a start over which thrust and level force are averaged [s]."""
CONSTANT_ERROR_S = 3.0
"""Time over which the constant error of the estimate is averaged [s]."""
RECENT_VELOCITY_S = 0.1
"""Time over which the velocity that determines the moment of the air is averaged [s]."""
INTEGRAL_FOLLOW_S = 0.1
"""Time in which integrals follow the setpoints in the log [s]."""
DOUBTED_THRUST_RATIO = 1.33
"""Ratio of thrust in flight to weight from which on, or below its inverse, the vehicle is in doubt.

In 33 flights of a Crazyflie it is between 0.94 and 1.04; with another drone's model it is below
0.84 or above 1.18."""
FULL_MOTOR_SIGNAL = 65535.0
"""Full scale of a motor of a Crazyflie."""
MAX_CRAZYFLIE_MASS_KG = 0.1
"""A vehicle lighter than this has a Crazyflie's motors [kg]."""
VOLTAGE_THRUST_CURVE = (
    -0.02476537915958403,
    0.06523793527519485,
    -0.026792504967750107,
    0.006776789303971145,
)
"""Coefficients of the thrust of a Crazyflie's motor over its voltage [N, N/V, N/V², N/V³], as in
its firmware."""
CRAZYFLIE_EXPONENT = 1.68
"""Exponent of the thrust over a Crazyflie's command, measured in NanoBench's flights."""
SETPOINT_INTEGRALS = (
    ("asked_x", "i_velocity_y", "velCtlPid_vyKi", -1.0),
    ("asked_y", "i_velocity_x", "velCtlPid_vxKi", -1.0),
    ("asked_z", "", "", 1.0),
    ("thrust", "i_velocity_z", "velCtlPid_vzKi", 1000.0),
)
"""For `crazyflie`: setpoint in its memory, the integral that produces it, the gain of that, and a
factor on it, in the order of `_told`."""
RATE_AXES = ("x", "y", "z")


class Effects(NamedTuple):
    """The parts of the past in use; a table of ablations leaves out one after the other.

    Attributes:
        thrust: its scale and the level force shortly before the start.
        memory: of the law, from the log; else as at rest.
        moment: of the air, balanced by the inner integrals.
        estimate: its error at the start.
        tilt: the growing error of an estimate that mistakes drag for tilt.
    """

    thrust: bool = True
    memory: bool = True
    moment: bool = True
    estimate: bool = True
    tilt: bool = True


ALL_EFFECTS = Effects()


def mean_before(values: np.ndarray, samples: np.ndarray, length: int) -> np.ndarray:
    """Return means (N, k) of values (m, k) over samples before each of N."""
    sums = np.vstack([np.zeros(values.shape[1]), np.cumsum(values, axis=0)])
    last = np.clip(samples, 1, len(values))
    first = np.maximum(last - length, 0)
    return np.asarray((sums[last] - sums[first]) / (last - first)[:, None])


def steady_thrusts(motion: LoggedMotion, vehicle: Vehicle) -> np.ndarray:
    """Return the steady thrust of each rotor for its commands (m, n) [N].

    Commands of a Crazyflie are shares of its voltage, and its thrust is on the firmware's curve;
    those of others are shares of the largest speed.
    """
    commands = np.clip(motion.commands, 0.0, 1.0)
    if vehicle.mass < MAX_CRAZYFLIE_MASS_KG and np.isfinite(motion.voltage).all():
        volts = motion.voltage[:, None] * commands
        return np.asarray(
            np.maximum(np.polynomial.polynomial.polyval(volts, VOLTAGE_THRUST_CURVE), 0.0)
        )
    largest = np.array([rotor.max_thrust for rotor in vehicle.rotors])
    return np.asarray(commands**2 * largest)


def rotor_limits(motion: LoggedMotion, vehicle: Vehicle) -> np.ndarray:
    """Return the speed at which the first rotor to be so is at its full command (m) [rad/s]."""
    full = steady_thrusts(motion._replace(commands=np.ones_like(motion.commands)), vehicle)
    largest = np.array([rotor.max_thrust for rotor in vehicle.rotors])
    constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
    return np.asarray(np.sqrt(np.minimum(full, largest) / constants).min(axis=1))


def thrust_doubt(motion: LoggedMotion, vehicle: Vehicle) -> str:
    """Return why a vehicle may not be the one that flew; "" if its thrust fits its weight."""
    first, last = motion.airborne
    if last <= first:
        return ""
    thrust = np.median(steady_thrusts(motion, vehicle)[first:last].sum(axis=1))
    share = float(thrust) / (GRAVITY * vehicle.mass)
    if 1.0 / DOUBTED_THRUST_RATIO < share < DOUBTED_THRUST_RATIO:
        return ""
    return (
        f"at the commands of {motion.name}, {vehicle.name} gives {share:.2g} times its weight as "
        "thrust: is it the drone that flew?"
    )


def voltage_doubt(motion: LoggedMotion, gains: Mapping[str, float]) -> str:
    """Return that the voltage is not known to a law that compensates for it; "" else.

    Args:
        motion: the flight.
        gains: of the law, by name.
    """
    flown = motion.voltage[slice(*motion.airborne)]
    if "vbat" not in gains or motion.speeds_shown or np.isfinite(flown).all():
        return ""
    return (
        f"{motion.name} has no battery voltage, and its motor commands are shares of it: thrust is "
        f"that of a full battery of {gains['vbat']:g} V, so predictions in closed loop may "
        "diverge; log the voltage (Crazyflie: pm.vbat)"
    )


def driven_thrust(motion: LoggedMotion, vehicle: Vehicle) -> np.ndarray:
    """Return a number proportional to the total thrust at the logged commands (m).

    For a Crazyflie it is commands^1.68 times voltage, which holds within half a second. The
    firmware's curve is steeper in the voltage, but the logged voltage is sampled at 10 Hz and sags
    with the command.
    """
    if vehicle.mass < MAX_CRAZYFLIE_MASS_KG and np.isfinite(motion.voltage).all():
        commands = np.clip(motion.commands, 0.0, 1.0)
        return np.asarray((commands**CRAZYFLIE_EXPONENT * motion.voltage[:, None]).sum(axis=1))
    return np.asarray(steady_thrusts(motion, vehicle).sum(axis=1))


def rotor_lagged(values: np.ndarray, motion: LoggedMotion, vehicle: Vehicle) -> np.ndarray:
    """Return values (m, n) after the lag of the rotors, unless the log already has it."""
    if motion.lag_shown:
        return values
    share = 1.0 - math.exp(-motion.period / vehicle.rotor_lag)
    start = (1.0 - share) * values[:1]  # steady before the log begins
    return np.asarray(lfilter([share], [1.0, share - 1.0], values, axis=0, zi=start)[0])


def air_rates(vehicle: Vehicle) -> np.ndarray:
    """Return the deceleration by the air over speed, along B's axes in hover (3) [1/s]."""
    across = drag_rates(vehicle).across
    inflow = np.array([rotor.inflow_coefficient for rotor in vehicle.rotors])
    return np.array([across, across, float(inflow @ vehicle.hover_speeds) / vehicle.mass])


class Past:
    """The state of a flight at any instant, from its log up to that instant.

    Args:
        motion: the flight.
        vehicle: as the law knows it, and as it flies.
        controller: the law.
        gains: of all its parameters, by name.
        model: of these.
        listen: see `flown.DrivenFunctions`.
    """

    def __init__(
        self,
        motion: LoggedMotion,
        vehicle: Vehicle,
        controller: Controller,
        gains: dict[str, float],
        model: CompiledModel,
        listen: Callable[..., Any],
    ) -> None:
        self._motion, self._vehicle, self._controller = motion, vehicle, controller
        self._gains, self._model = gains, model
        attitude = rotation_matrices(motion.q)
        self.force = attitude.inv().apply(
            np.gradient(motion.v, motion.period, axis=0) + [0.0, 0.0, GRAVITY]
        )
        """Specific force in B (m, 3) [m/s²]."""
        self.v_B = attitude.inv().apply(motion.v)
        self.thrust = rotor_lagged(steady_thrusts(motion, vehicle), motion, vehicle)
        self._error = (attitude.inv() * rotation_matrices(motion.q_known)).as_rotvec()
        turning = np.nonzero(motion.commands.mean(axis=1) > MIN_TURNING_COMMAND)[0]
        self._first = int(turning[0]) if len(turning) else 0
        self._listen = listen

    @property
    def estimated(self) -> bool:
        """Whether the motion known to the flight computer differs from the true one."""
        return not np.array_equal(self._motion.q_known, self._motion.q)

    @property
    def full_voltage(self) -> float:
        """Voltage that the law assumes to be full [V]; 1 if it does not use it."""
        return self._gains.get("vbat", 1.0)

    def references(self, samples: np.ndarray, duration: float) -> np.ndarray:
        """Return the references from samples (N) on, (N, K, 8)."""
        motion, period = self._motion, self._model.period
        updates = round(duration / period)
        times = motion.period * samples[:, None] + period * np.arange(updates)
        return logged_references(motion, times.ravel()).reshape(len(samples), updates, 8)

    def lift(self, samples: np.ndarray, thrust: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Return the share of a thrust (m), and the level force in B (N, 2) [N], before samples."""
        vehicle, before = self._vehicle, round(PAST_AVERAGE_S / self._motion.period)
        # a sample earlier: the last difference of velocities reaches one ahead
        force, v_B = (mean_before(each, samples - 1, before) for each in (self.force, self.v_B))
        force = vehicle.mass * (force + air_rates(vehicle) * v_B)
        given = mean_before(thrust[:, None], samples - 1, before)[:, 0]
        share = force[:, 2] / np.maximum(given, 1e-3 * vehicle.mass)
        told = samples > before  # else there is no past to go by
        return np.where(told, share, 1.0), np.where(told[:, None], force[:, :2], 0.0)

    def start(self, samples: np.ndarray, effects: Effects = ALL_EFFECTS) -> FlightStarts:
        """Return the start of predictions from samples (N)."""
        motion, vehicle = self._motion, self._vehicle
        attitude = rotation_matrices(motion.q[samples])
        n, many = len(vehicle.rotors), len(samples)
        share, level = np.ones(many), np.zeros((many, 2))
        if effects.thrust:
            share, level = self.lift(samples, self.thrust.sum(axis=1))
        pushes = np.zeros((many, 1, PUSH_SIZE))
        pushes[:, 0, 3:5] = level
        constants = np.array([rotor.motor_constant for rotor in vehicle.rotors])
        counts = np.floor(motion.period * (samples - self._first) / self._model.period)
        voltage = motion.voltage[samples]
        return FlightStarts(
            states=np.column_stack(
                [
                    motion.q[samples],
                    motion.p[samples],
                    attitude.apply(motion.w[samples]),
                    motion.v[samples],
                ]
            ),
            speeds=np.sqrt(self.thrust[samples] / constants),
            memory=self._memory(samples, counts, effects),
            counts=counts,
            errors=self._errors(samples, effects),
            voltages=np.where(np.isfinite(voltage), voltage / self.full_voltage, 1.0),
            shares=np.repeat(np.clip(share, 0.5, 2.0)[:, None], n, axis=1),
            pushes=pushes,
        )

    def _errors(self, samples: np.ndarray, effects: Effects) -> np.ndarray:
        """Return the estimate's errors at samples (N, 11)."""
        motion = self._motion
        found = np.zeros((len(samples), ESTIMATE_ERROR_SIZE))
        if not effects.estimate:
            return found
        constant = mean_before(self._error, samples + 1, round(CONSTANT_ERROR_S / motion.period))
        tilt = rotation_matrices(motion.q[samples]).apply(self._error[samples] - constant)
        found[:, 0:3] = (motion.p_known - motion.p)[samples]
        found[:, 3:6] = (motion.v_known - motion.v)[samples]
        found[:, 6] = GRAVITY * tilt[:, 1] * effects.tilt
        found[:, 7] = -GRAVITY * tilt[:, 0] * effects.tilt
        found[:, 8:11] = constant
        return found

    def _memory(self, samples: np.ndarray, counts: np.ndarray, effects: Effects) -> np.ndarray:
        """Return the memory of the law at samples (N, k)."""
        names = [state.name for state in self._controller.memory]
        if not effects.memory or not names:
            return np.tile(np.array(self._controller.initial_memory, float), (len(samples), 1))
        place = np.clip(counts.astype(int) - 1, 0, len(self._remembered) - 1)
        memory = self._remembered[place].copy()
        if "pid_rate_roll_ki" not in self._gains:  # `_held` is about the Crazyflie's integrals
            return memory
        held = np.zeros((len(samples), 3))
        if effects.moment:
            held = self._held(
                mean_before(self.v_B, samples + 1, round(RECENT_VELOCITY_S / self._motion.period))
            )
        for axis, column in zip(RATE_AXES, held.T, strict=True):
            memory[:, names.index(f"i_rate_{axis}")] = column
            memory[:, names.index(f"i_attitude_{axis}")] = 0.0
        return memory

    def _held(self, v_B: np.ndarray) -> np.ndarray:
        """Return integrals of `crazyflie`'s rates (N, 3) [deg] that balance the air's moment."""
        gains, vehicle = self._gains, self._vehicle
        hubs = np.array([rotor.p_BR for rotor in vehicle.rotors])
        drags = np.array([rotor.rotor_drag_coefficient for rotor in vehicle.rotors])
        pull = drags * vehicle.hover_speeds
        heights = hubs[:, 2] - vehicle.p_BoBcm_B[2]
        arm = float(pull @ heights)  # moment about the centre of mass over level velocity [N·s]
        unit = gains["thrust_max"] / FULL_MOTOR_SIGNAL * 0.5 * np.abs(hubs[:, 0:2]).sum(axis=0)
        roll = -arm * v_B[:, 1] / (unit[1] * gains["pid_rate_roll_ki"])
        pitch = -arm * v_B[:, 0] / (unit[0] * gains["pid_rate_pitch_ki"])
        return np.column_stack([np.clip(roll, -33.3, 33.3), np.clip(pitch, -33.3, 33.3), 0 * roll])

    @cached_property
    def _remembered(self) -> np.ndarray:
        """Return the memory of the law along the log, from the first turn of a rotor on."""
        motion, period = self._motion, self._model.period
        begin = motion.period * self._first
        time = np.arange(begin, motion.time[-1], period)

        def at(values: np.ndarray) -> np.ndarray:
            return resampled(values, motion.period, time)

        q = at(motion.q_known)
        q /= np.linalg.norm(q, axis=1)[:, None]
        w = rotation_matrices(q).apply(at(motion.w))
        measured = np.column_stack([q, at(motion.p_known), w, at(motion.v_known)])
        voltage = at(motion.voltage[:, None])[:, 0] / self.full_voltage
        told, places = self._told(at)
        first = np.array(self._controller.initial_memory, dtype=float)
        return np.asarray(
            self._listen(
                measured,
                logged_references(motion, time),
                np.where(np.isfinite(voltage), voltage, 1.0),
                told,
                places,
                first,
                self._model,
            )
        )

    def _told(self, at: Callable[[np.ndarray], np.ndarray]) -> tuple[np.ndarray, np.ndarray]:
        """Return the parts of the law's memory in the log (K, r), and their places (r, 4)."""
        motion, names = self._motion, [state.name for state in self._controller.memory]
        wanted = np.degrees(motion.attitude_setpoint) * [1.0, -1.0, 1.0]
        log = at(np.column_stack([wanted, FULL_MOTOR_SIGNAL * motion.thrust_setpoint]))
        if not {row[0] for row in SETPOINT_INTEGRALS} <= {*names} or "i_rate_x" not in names:
            return log[:, :0], np.empty((0, 4))
        share = self._model.period / INTEGRAL_FOLLOW_S
        places = []
        for asked, integral, gain, times in SETPOINT_INTEGRALS:
            factor = times * self._gains.get(gain, 0.0)
            behind = names.index(integral) if factor else -1
            places.append((names.index(asked), behind, factor or 1.0, share))
        return log, np.array(places, dtype=float)


def logged_references(motion: LoggedMotion, time: np.ndarray) -> np.ndarray:
    """Return the references at times (K, 8), see `guidance.Reference`."""
    found = np.zeros((len(time), 8))
    found[:, 4:7] = resampled(motion.setpoint, motion.period, time)
    found[:, FOLLOW_FLAG_INDEX] = 1.0
    return found

"""Flights from instants of a log on, and along it: law, estimate's error, vehicle, disturbance.

The order is that of the diagram: the law sees the state at a control instant, and what it commands
acts one physics step later. Functions are those that fly everywhere else, see `control.flight_law`
and `dynamics.vehicle_step`; here stands what only a prediction has.

The estimate's error. A flight computer that is told positions and reckons with thrust and weight
alone takes drag for tilt. With e the error of its level velocity, eta that of its level
acceleration, which is g times the error of its tilt, and d the drag over mass and speed,

    de/dt = eta + d v - L e,   deta/dt = -W e

are the slow part of a Kalman filter with the gains L [1/s] and W [1/s²]: in steady flight the tilt
is wrong by d v / g. Both begin with what the log shows at the start.

The disturbance: what a model cannot explain of a flight, as a force and a moment over time. Along a
log, closed loop, the law commands in each control period on what the flight computer knew. Force in
W and moment in B are those which bring the model to where the log has it at the period's end.
Velocities answer a held push linearly. So one trial without a push and one with it are enough, and
another one for what turning in the period changes:

    f = m (v_log - v) / T,   m = J (w_log - w) / T

Position and attitude are held by asking for velocities that close what is left of their difference
within `CLOSES`. Flown again with these pushes, the same law makes the same flight.
"""

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_law import (
    FILTERED,
    flight_law,
    known_vehicle,
    law_constants,
    packed,
    unpacked,
)
from workbench.control.flight_law import SOURCES as LAW
from workbench.control.guidance import Guidance, Setpoint
from workbench.dynamics.rigid_body import into_body, into_world, rigid_body, rotation
from workbench.dynamics.vehicle_step import FULL, rotor_rows, step_vehicle
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate

SOURCES = (*LAW, "design/predict/flown.py")
"""What compiled predictions stand in, below `workbench/`, besides the controller."""
GO_TO = np.array(Guidance(1.0, 1.0, 1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0), dtype=float)
"""The mode that flies where the setpoint is."""
FOLLOW = 7
"""Place of a reference that says that its position counts, see `guidance.Reference`."""
ERROR = 11
"""Numbers of an estimate's error: position (3) [m] and velocity (3) [m/s] in W, eta x and y [m/s²],
and the rotation from B to where B is taken to be (3) [rad]."""
PUSH = 9
"""Numbers of a disturbance: force in W (3), force in B (3) [N], and moment in B (3) [N·m]."""
PERIOD = 1 / 128
"""Between updates of a law that states none [s]."""
POSITION_GAIN = 2.0
"""At which an estimate's error of position fades [1/s]."""
CLOSES = 0.05
"""Time in which a difference of position or attitude is closed [s]."""
TRIALS = 3
"""Of a control period, to find its push."""


class Observer(NamedTuple):
    """How the estimate's error goes on, see above.

    Attributes:
        velocity_gain: L [1/s].
        tilt_gain: W [1/s²].
        drag: d [1/s].
    """

    velocity_gain: float = 7.0
    tilt_gain: float = 10.0
    drag: float = 0.41


class Craft(NamedTuple):
    """A law and the vehicle that it flies, as compiled code takes them.

    Attributes:
        gains: of the controller, and what it designs.
        known_body: what the law knows of the body, see `flight_law.packed`.
        known_rotors: likewise of the rotors.
        probes: of the loop points, all closed.
        body: see `rigid_body.RigidBody` (16).
        rotors: a row each (n, 26).
        steps: of physics in a control period, and their length [s].
        estimate: of the acceleration, see `acceleration_estimate.sampled_estimate`.
        wind: velocity of the air in W [m/s].
    """

    gains: np.ndarray
    known_body: np.ndarray
    known_rotors: np.ndarray
    probes: np.ndarray
    body: np.ndarray
    rotors: np.ndarray
    steps: tuple[int, float]
    estimate: tuple[float, float]
    wind: tuple[float, float, float] = (0.0, 0.0, 0.0)

    @property
    def period(self) -> float:
        """Between two updates of the law [s]."""
        return self.steps[0] * self.steps[1]


def make_craft(
    vehicle: Vehicle,
    controller: Controller,
    gains: dict[str, float],
    period: float,
    steps: int = 1,
    flown: Vehicle | None = None,
) -> Craft:
    """Return a law and its vehicle for compiled code.

    Args:
        vehicle: as the law knows it.
        controller: the law.
        gains: of all its parameters, by name.
        period: between updates of the law [s].
        steps: of physics between them.
        flown: the vehicle that flies, where that is another one.
    """
    constants = law_constants(vehicle)
    known_body, known_rotors = packed(constants)
    real = flown or vehicle
    step = period / steps
    return Craft(
        gains=np.array(controller.gains(gains, known_vehicle(constants), period)),
        known_body=known_body,
        known_rotors=known_rotors,
        probes=np.array(controller.closed, dtype=float),
        body=rigid_body(real.mass, real.inertia, real.p_BoBcm_B).packed(),
        rotors=rotor_rows(real.rotors, step),
        steps=(steps, step),
        estimate=sampled_estimate(steps * step),
    )


@register_jitable
def times(a, b):
    """Return the product of two quaternions (4)."""
    return (
        a[0] * b[0] - a[1] * b[1] - a[2] * b[2] - a[3] * b[3],
        a[0] * b[1] + a[1] * b[0] + a[2] * b[3] - a[3] * b[2],
        a[0] * b[2] - a[1] * b[3] + a[2] * b[0] + a[3] * b[1],
        a[0] * b[3] + a[1] * b[2] - a[2] * b[1] + a[3] * b[0],
    )


@register_jitable
def turn(x, y, z):
    """Return the quaternion of a small rotation vector, right to its third power [rad]."""
    square = x * x + y * y + z * z
    half = 0.5 - square / 48.0
    return 1.0 - square / 8.0, half * x, half * y, half * z


@register_jitable
def seen(state, error, measured):
    """Write what the flight computer takes a state (13) for, see `ERROR`."""
    tilt = turn(-error[7] / GRAVITY, error[6] / GRAVITY, 0.0)
    known = times(tilt, times(state[0:4], turn(error[8], error[9], error[10])))
    for i in range(4):
        measured[i] = known[i]
    for i in range(3):
        measured[4 + i] = state[4 + i] + error[i]
        measured[7 + i] = state[7 + i]
        measured[10 + i] = state[10 + i] + error[3 + i]


@register_jitable
def step_error(error, velocity, observer, dt):
    """Let an estimate's error go on, in place."""
    gain, tilt, drag = observer
    for i in range(2):
        slope = error[6 + i] + drag * velocity[i] - gain * error[3 + i]
        error[6 + i] -= dt * tilt * error[3 + i]
        error[3 + i] += dt * slope
    error[5] -= dt * gain * error[5]
    for i in range(3):
        error[i] -= dt * POSITION_GAIN * error[i]


@register_jitable
def fly_period(state, last, speeds, before, commands, shares, push, pressure, craft, room):
    """Let a vehicle fly for a control period, in place.

    Args:
        state: (13), see `rigid_body.State`.
        last: acceleration in the middle of the step before (6).
        speeds: of the rotors (n) [rad/s].
        before: their commands in the first physics step (n) [rad/s].
        commands: their commands from then on (n) [rad/s].
        shares: of their thrust that rotors give (n).
        push: see `PUSH`.
        pressure: half the air's density times the body's drag area [kg/m].
        craft: see `Craft`.
        room: rows for middles, slopes and speeds (3, n).
    """
    steps, step = craft.steps
    whole = np.empty(6)
    for number in range(steps):
        asked = before if number == 0 else commands
        R_WB = rotation(state[0:4])
        force = into_world(R_WB, (push[3], push[4], push[5]))
        moment = into_world(R_WB, (push[6], push[7], push[8]))
        for i in range(3):
            whole[i] = push[i] + force[i]
            whole[3 + i] = moment[i]
        after, acceleration = step_vehicle(
            state,
            last,
            speeds,
            asked,
            shares,
            craft.wind,
            whole,
            pressure,
            FULL,
            craft.body,
            craft.rotors,
            step,
            room[0],
            room[1],
            room[2],
        )
        for i in range(13):
            state[i] = after[i]
        for i in range(6):
            last[i] = acceleration[i]
        for i in range(len(speeds)):
            speeds[i] = room[2, i]


class Computer(NamedTuple):
    """What a flight computer has between two updates of its law, changed in place.

    Attributes:
        measured: what it takes the state for (13), see `rigid_body.State`.
        filtered: of the acceleration estimate.
        memory: of the law (k).
        commands: of the rotors (n) [rad/s].
        shares: of their thrust that rotors give, as the law knows it: all of it (n).
        nothing: zeros (3): neither filters nor a resolution of commands.
    """

    measured: np.ndarray
    filtered: np.ndarray
    memory: np.ndarray
    commands: np.ndarray
    shares: np.ndarray
    nothing: np.ndarray


@register_jitable
def begun(memory, commands, velocity):
    """Return a `Computer` at its start, of copies of a memory, commands, and velocity."""
    filtered = np.zeros(FILTERED)
    filtered[0:3] = velocity
    return Computer(
        np.zeros(13),
        filtered,
        memory.copy(),
        commands.copy(),
        np.ones(len(commands)),
        np.zeros(3),
    )


def make_update(controller: Controller) -> Callable[..., Any]:
    """Return a function that lets a law update on what was measured, for compiled flights.

    Its arguments are a `Computer`, the voltage (1), see `guidance.Measured`, the reference (8), the
    `Craft`, and how many updates were before.
    """
    update_in_place = flight_law(controller).update_in_place
    points = len(controller.points)

    def update(computer, voltage, reference, craft, count):
        loops = np.empty(3 * points)
        loops[: 2 * points] = craft.probes
        update_in_place(
            computer.measured,
            voltage[0],
            Setpoint(reference, GO_TO, (0.0, 0.0, 0.0)),
            craft.gains,
            computer.shares,
            unpacked(craft.known_body, craft.known_rotors),
            loops,
            craft.estimate,
            computer.nothing,
            computer.filtered,
            computer.memory,
            computer.commands,
            count,
        )

    return register_jitable(unique(update, controller.key))


class Functions(NamedTuple):
    """Compiled functions of a controller.

    Attributes:
        fly: from many starts on, see `make_fly`.
        listen: runs the law along a log, see `make_listen`.
        refly: along a log with pushes, see `make_refly`.
    """

    fly: Callable[..., Any]
    listen: Callable[..., Any]
    refly: Callable[..., Any]


@lru_cache(maxsize=16)
def compiled_flights(controller: Controller) -> Functions:
    """Return the functions of a controller, compiled at their first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    return Functions(
        *(
            compile_cached(
                function,
                SOURCES,
                f"{what}{whose}",
                parts=80,
                text=controller.digest,
                file=str(controller.file),
                error_model="numpy",
            )
            for function, what in (
                (make_fly(controller), "predictions"),
                (make_listen(controller), "the law along a log"),
                (make_refly(controller), "flights along a log"),
            )
        )
    )


def make_fly(controller: Controller) -> Callable[..., Any]:
    """Return a function that flies from many starts on with a controller."""
    update = make_update(controller)

    def fly(
        starts,
        speeds,
        memory,
        counts,
        errors,
        observer,
        references,
        voltages,
        shares,
        pushes,
        pressure,
        craft,
        keep,
    ):
        """Fly closed loop from N starts for K updates; return each `keep`-th state (N, K/keep, 13).

        Args:
            starts: states (N, 13).
            speeds: of the rotors at the start (N, n) [rad/s].
            memory: of the law (N, k).
            counts: of its updates before the start (N).
            errors: of the estimate at the start (N, 11), see `ERROR`.
            observer: how they go on, see `Observer`.
            references: (N, K, 8), see `guidance.Reference`.
            voltages: see `guidance.Measured` (N).
            shares: of their thrust that rotors give (N, n).
            pushes: (N, K or 1, 9), see `PUSH`; the last one goes on.
            pressure: see `fly_period`.
            craft: see `Craft`.
            keep: updates between two states.
        """
        many, updates = references.shape[0], references.shape[1]
        n = len(craft.rotors)
        found = np.empty((many, updates // keep + 1, 13))
        dt = craft.steps[0] * craft.steps[1]
        for i in range(many):
            state, last, error = starts[i].copy(), np.zeros(6), errors[i].copy()
            turning, before, room = speeds[i].copy(), speeds[i].copy(), np.empty((3, n))
            computer = begun(memory[i], speeds[i], state[10:13])
            for k in range(updates):
                if k % keep == 0:
                    found[i, k // keep] = state
                seen(state, error, computer.measured)
                step_error(error, state[10:12], observer, dt)
                update(computer, voltages[i : i + 1], references[i, k], craft, counts[i] + k)
                push, asked = pushes[i, min(k, pushes.shape[1] - 1)], computer.commands
                fly_period(
                    state, last, turning, before, asked, shares[i], push, pressure, craft, room
                )
                before[:] = asked
            if updates % keep == 0:
                found[i, updates // keep] = state
        return found

    return unique(fly, controller.key)


def make_listen(controller: Controller) -> Callable[..., Any]:
    """Return a function that runs a controller's law along a log."""
    update = make_update(controller)

    def listen(measured, references, voltages, told, places, first, craft):
        """Return what the law remembers after each of K updates on logged states (K, k).

        Args:
            measured: (K, 13).
            references: (K, 8).
            voltages: see `guidance.Measured` (K).
            told: what the log says of its memory (K, r); NaN where it says nothing.
            places: of each of these (r, 4): the number in the memory, the integral behind it, -1
                for none, its gain, and the share of the difference that the integral takes.
            first: the memory to begin with (k).
            craft: see `Craft`.
        """
        computer = begun(first, np.zeros(len(craft.rotors)), np.zeros(3))
        kept = computer.memory
        found = np.empty((len(measured), len(kept)))
        for k in range(len(measured)):
            computer.measured[:] = measured[k]
            update(computer, voltages[k : k + 1], references[k], craft, float(k))
            for row in range(len(places)):
                value = told[k, row]
                if not math.isnan(value):
                    number, integral = int(places[row, 0]), int(places[row, 1])
                    if integral >= 0:
                        share = places[row, 3] / places[row, 2]
                        kept[integral] += share * (value - kept[number])
                    kept[number] = value
            found[k] = kept
        return found

    return unique(listen, controller.key)


@register_jitable
def wanted(state, target, share, period, found):
    """Write angular velocity and velocity (6) in W which a period is to end with.

    Args:
        state: of the model at its begin (13).
        target: of the log at its end (13).
        share: 1 / `CLOSES` [1/s].
        period: its length [s].
        found: places (6).
    """
    back = (state[0], -state[1], -state[2], -state[3])
    between = times(target[0:4], back)
    sign, half = 2.0 if between[0] >= 0.0 else -2.0, 0.5 * period
    for i in range(3):
        turned = half * (state[7 + i] + target[7 + i])
        moved = half * (state[10 + i] + target[10 + i])
        found[i] = target[7 + i] + share * (sign * between[1 + i] - turned)
        found[3 + i] = target[10 + i] + share * (target[4 + i] - state[4 + i] - moved)


@register_jitable
def correct(push, state, asked, craft):
    """Add to a push, in place, what a period's end lacked of the velocities asked for."""
    steps, step = craft.steps
    rate = 1.0 / (steps * step)
    mass, inertia = craft.body[0], craft.body[1:7]
    R = rotation(state[0:4])
    lacks = (asked[0] - state[7], asked[1] - state[8], asked[2] - state[9])
    x, y, z = into_body(R, lacks)
    for i in range(3):
        push[i] += rate * mass * (asked[3 + i] - state[10 + i])
    push[6] += rate * (inertia[0] * x + inertia[1] * y + inertia[2] * z)
    push[7] += rate * (inertia[1] * x + inertia[3] * y + inertia[4] * z)
    push[8] += rate * (inertia[2] * x + inertia[4] * y + inertia[5] * z)


def make_refly(controller: Controller) -> Callable[..., Any]:
    """Return a function that flies along a log with pushes, or finds them."""
    update = make_update(controller)

    def refly(
        targets,
        speeds,
        memory,
        count,
        errors,
        references,
        voltages,
        shares,
        pushes,
        pressure,
        share,
        craft,
        trials,
    ):
        """Return states (K+1, 13) of a flight with pushes, which trials correct in place.

        Args:
            targets: states of the log at each update and at the end (K+1, 13); the first one is
                where the flight begins.
            speeds: of the rotors at the start (n) [rad/s].
            memory: of the law at the start (k).
            count: of its updates before.
            errors: of the estimate, see `ERROR` (K, 11).
            references: (K, 8).
            voltages: see `guidance.Measured` (K).
            shares: of their thrust that rotors give (n).
            pushes: of each control period, see `PUSH` (K, 9).
            pressure: see `fly_period`.
            share: 1 / `CLOSES` [1/s].
            craft: see `Craft`.
            trials: of each control period. The last one counts; after each one before, the push is
                corrected for what its end lacked. With 1 the pushes stay.
        """
        updates, n = len(references), len(craft.rotors)
        states, asked, room = np.empty((updates + 1, 13)), np.empty(6), np.empty((3, n))
        state, last = targets[0].copy(), np.zeros(6)
        turning, before = speeds.copy(), speeds.copy()
        computer = begun(memory, speeds, state[10:13])
        commands = computer.commands
        for k in range(updates):
            states[k] = state
            seen(state, errors[k], computer.measured)
            update(computer, voltages[k : k + 1], references[k], craft, count + k)
            wanted(state, targets[k + 1], share, craft.steps[0] * craft.steps[1], asked)
            for trial in range(trials):
                tried, end, spun = state.copy(), last.copy(), turning.copy()
                fly_period(
                    tried, end, spun, before, commands, shares, pushes[k], pressure, craft, room
                )
                if trial + 1 < trials:
                    correct(pushes[k], tried, asked, craft)
            state[:], last[:], turning[:], before[:] = tried, end, spun, commands
        states[updates] = state
        return states

    return unique(refly, controller.key)

"""Flights from instants of a log on, and along it: law, estimate's error, vehicle, disturbance.

They fly as compiled flights everywhere do, see `rollout.period`; here stands what only a prediction
has.

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
from collections.abc import Callable, Sequence
from functools import lru_cache
from typing import Any, NamedTuple

import numpy as np

from workbench.common.compiled import compile_cached
from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_law import known_vehicle, law_constants
from workbench.design.rollout import engine
from workbench.design.rollout.crafts import Crafts, prompt_crafts
from workbench.design.rollout.fields import fetch, store, take
from workbench.design.rollout.flights import begin
from workbench.design.rollout.motion import LANES, make_room
from workbench.design.rollout.period import (
    Clock,
    Knowing,
    make_fly_period,
    make_times,
    make_update,
    write_flight,
)
from workbench.design.rollout.record import flight_dtype, law_record, sizes_of
from workbench.dynamics.rigid_body import into_body, into_world, rotation
from workbench.plant.drag import AIR_DENSITY
from workbench.plant.gravity import GRAVITY
from workbench.plant.vehicle import Vehicle
from workbench.systems.acceleration_estimate import sampled_estimate

SOURCES = (*engine.SOURCES, "design/predict/flown.py")
"""What compiled predictions stand in, below `workbench/`, besides the controller."""
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
ALWAYS = 1e9
"""Longer than any flight, before and after its start [s]."""


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
    """A law, and vehicles that it flies.

    Attributes:
        controller: the law.
        gains: of the controller, and what it designs.
        crafts: one vehicle for all flights, or one for each.
        period: between updates of the law [s].
        drag_areas: of the bodies: a number, or one of each flight [m²].
        winds: velocity of the air in W (3), or of each flight (N, 3) [m/s].
    """

    controller: Controller
    gains: np.ndarray
    crafts: Crafts
    period: float
    drag_areas: Any = 0.0
    winds: Any = (0.0, 0.0, 0.0)

    @property
    def clock(self) -> Clock:
        """When things happen: updates of the law, and of nothing else."""
        one = np.ones(1)
        estimate = sampled_estimate(self.period)
        return Clock(self.period, self.period, math.inf, estimate, False, math.inf, 0.0, one, one)


def make_craft(
    vehicle: Vehicle,
    controller: Controller,
    gains: dict[str, float],
    period: float,
    flown: Sequence[Vehicle] | None = None,
) -> Craft:
    """Return a law and what it flies.

    Args:
        vehicle: as the law knows it.
        controller: the law.
        gains: of all its parameters, by name.
        period: between updates of the law [s].
        flown: the vehicles that fly (N), where these are others.
    """
    constants = law_constants(vehicle)
    real = flown or [vehicle]
    return Craft(
        controller=controller,
        gains=np.array(controller.gains(gains, known_vehicle(constants), period)),
        crafts=prompt_crafts(
            real, law_record(constants), np.array([vehicle.hover_speeds] * len(real))
        ),
        period=period,
    )


class Start(NamedTuple):
    """Where N flights begin; one row in place of N is for all of them.

    Attributes:
        states: (N, 13), see `rigid_body.State`.
        speeds: of the rotors (N, n) [rad/s].
        memory: of the law (N, k).
        counts: of its updates before the start (N).
        errors: of the estimate (N, 11), see `ERROR`.
        voltages: see `guidance.Measured` (N).
        shares: of their thrust that rotors give (N, n).
        pushes: that act already (N, 1, 9), see `PUSH`.
    """

    states: np.ndarray
    speeds: np.ndarray
    memory: np.ndarray
    counts: np.ndarray
    errors: np.ndarray
    voltages: np.ndarray
    shares: np.ndarray
    pushes: np.ndarray


class Course(NamedTuple):
    """What N flights meet in K control periods; one row in place of N is for all of them.

    Attributes:
        references: (N, K, 8), see `guidance.Reference`.
        voltages: (N, K), see `guidance.Measured`; the last one goes on.
        pushes: (N, K, 9), see `PUSH`; the last one goes on.
        errors: of the estimate (N, K, 11); where there is none, it goes on as `Observer` has it.
        targets: states (N, K, 13) at the ends of the periods; trials correct pushes towards them.
    """

    references: np.ndarray
    voltages: np.ndarray
    pushes: np.ndarray
    errors: np.ndarray = np.empty((1, 0, ERROR))
    targets: np.ndarray = np.empty((1, 0, 13))

    def part(self, some: slice) -> "Course":
        """Return the course of some flights."""
        return Course(*(each if len(each) == 1 else each[some] for each in self))


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
def seen(state, error):
    """Return what the flight computer takes a state for (13), see `ERROR`."""
    tilt = turn(-error[7] / GRAVITY, error[6] / GRAVITY, 0.0)
    known = times(tilt, times(state[0:4], turn(error[8], error[9], error[10])))
    _, _, _, _, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    p = (p_x + error[0], p_y + error[1], p_z + error[2])
    v = (v_x + error[3], v_y + error[4], v_z + error[5])
    return known + p + (w_x, w_y, w_z) + v


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
def _know(flight, clock, observer):
    """Write what the flight computer knows; its error goes on."""
    state = fetch(flight, "state")
    store(flight, "known", seen(state, flight.error))
    step_error(flight.error, state[10:13], observer, clock.period)


@register_jitable(forceinline=True)
def _look(flight, clock, observer, passed):
    return fetch(flight, "known")


@register_jitable(forceinline=True)
def _mode_state(flight):
    return fetch(flight, "known")


@register_jitable(forceinline=True)
def _never(observer, now):
    return math.inf


@register_jitable(forceinline=True)
def _no_sample(flight, observer, now):
    """Do nothing: all that is heard is in the error."""


KNOW_WRONG = Knowing(_know, _look, _mode_state, _never, _no_sample, "wrong")
"""The law knows the motion, but for the estimate's error."""


@register_jitable
def _tell(flight, course, i, k):
    """Write what a flight is told in a control period."""
    references, voltages, errors = course.references, course.voltages, course.errors
    asked, told = references[i % len(references), k], voltages[i % len(voltages)]
    for place in range(len(asked)):
        flight.reference[place] = asked[place]
    flight.voltage = told[min(k, len(told) - 1)]
    if errors.shape[1] > 0:
        error = errors[i % len(errors), k]
        for place in range(len(error)):
            flight.error[place] = error[place]


@register_jitable
def give_push(flight, push):
    """Let a push act in the next control period, see `PUSH`."""
    R_WB, air = rotation(fetch(flight, "state")[0:4]), flight.air
    x, y, z = into_world(R_WB, (push[3], push[4], push[5]))
    air.push_x, air.push_y, air.push_z = push[0] + x, push[1] + y, push[2] + z
    air.push_torque_x, air.push_torque_y, air.push_torque_z = push[6], push[7], push[8]


@register_jitable
def correct(push, state, begun, target, body, i, period):
    """Add to a push, in place, what a period's end lacks of the velocities that are wanted.

    Args:
        push: see `PUSH`.
        state: of the model at the end (13).
        begun: at the begin (13).
        target: of the log at the end (13).
        body: see `motion.BODIES`.
        i: the flight's lane.
        period: its length [s].
    """
    q_w, q_x, q_y, q_z = begun[0:4]
    between = times(target[0:4], (q_w, -q_x, -q_y, -q_z))
    sign, half, mass = 2.0 if between[0] >= 0.0 else -2.0, 0.5 * period, take(body, "mass", i)
    lacks = np.empty(3)
    for axis in range(3):
        turned = half * (begun[7 + axis] + target[7 + axis])
        moved = half * (begun[10 + axis] + target[10 + axis])
        w = target[7 + axis] + (sign * between[1 + axis] - turned) / CLOSES
        v = target[10 + axis] + (target[4 + axis] - begun[4 + axis] - moved) / CLOSES
        lacks[axis] = (w - state[7 + axis]) / period
        push[axis] += mass * (v - state[10 + axis]) / period
    x, y, z = into_body(rotation(state[0:4]), (lacks[0], lacks[1], lacks[2]))
    xx, xy, xz, yy, yz, zz = take(body, "inertia", i)
    push[6] += xx * x + xy * y + xz * z
    push[7] += xy * x + yy * y + yz * z
    push[8] += xz * x + yz * y + zz * z


@register_jitable
def _state_of(row):
    """Return a state as a tuple (13)."""
    p, w, v = (row[4], row[5], row[6]), (row[7], row[8], row[9]), (row[10], row[11], row[12])
    return (row[0], row[1], row[2], row[3]) + p + w + v


def make_fly(controller: Controller) -> Callable[..., Any]:
    """Return the flights of up to 16 vehicles with a controller."""
    key = f"{controller.key}_{KNOW_WRONG.key}"
    fly_period = make_fly_period(make_update(controller), KNOW_WRONG, key)

    def fly(flights, room, times, clock, observer, course, trials, keep, states):
        """Write each `keep`-th state (N, K/keep + 1, 13); this is what gets compiled.

        Args:
            flights: their records, see `record.flight_dtype`, with `ERROR`.
            room: of their motion, furnished, see `Crafts.furnish`.
            times: see `period.Times`.
            clock: see `period.Clock`.
            observer: see `Observer`.
            course: see `Course`.
            trials: of each control period. The last one counts; after each one before, the push is
                corrected for what its end lacked. With 1 the pushes stay.
            keep: updates between two states.
            states: places.
        """
        many, updates, pushes = len(flights), course.references.shape[1], course.pushes
        begun = flights.copy()
        for i in range(LANES):
            write_flight(flights[min(i, many - 1)], room, i)
        for k in range(updates + 1):
            if k % keep == 0:
                for i in range(many):
                    states[i, k // keep] = flights[i].state
            if k == updates:
                break
            for i in range(many):
                _tell(flights[i], course, i, k)
                begun[i] = flights[i]
            for trial in range(trials):
                for i in range(many):
                    push = pushes[i % len(pushes), min(k, pushes.shape[1] - 1)]
                    if trial > 0:
                        target = _state_of(course.targets[i % len(course.targets), k])
                        ended, began = fetch(flights[i], "state"), fetch(begun[i], "state")
                        correct(push, ended, began, target, room.bodies[0], i, clock.period)
                        flights[i] = begun[i]
                        write_flight(flights[i], room, i)
                    give_push(flights[i], push)
                fly_period(flights, room, times, clock, observer)
                for i in range(many):
                    flights[i].lost_at = -1.0  # a prediction may be as wrong as it is

    return unique(fly, controller.key)


def make_listen(controller: Controller) -> Callable[..., Any]:
    """Return a function that runs a controller's law along a log."""
    update = make_update(controller)

    def listen(flights, clock, measured, references, voltages, told, places, found):
        """Write what the law remembers after each of K updates on logged states.

        Args:
            flights: the record of one that begins (1).
            clock: see `period.Clock`.
            measured: see `Functions`, and so the next four.
            references: (K, 8).
            voltages: (K).
            told: (K, r).
            places: (r, 4).
            found: (K, k).
        """
        flight = flights[0]
        for k in range(len(measured)):
            flight.known[:] = measured[k]
            flight.reference[:] = references[k]
            flight.voltage = voltages[k]
            flight.count = float(k)
            update(flight, clock)
            for row in range(len(places)):
                value = told[k, row]
                if not math.isnan(value):
                    number, integral = int(places[row, 0]), int(places[row, 1])
                    if integral >= 0:
                        share = places[row, 3] / places[row, 2]
                        flight.memory[integral] += share * (value - flight.memory[number])
                    flight.memory[number] = value
            found[k] = flight.memory

    return unique(listen, controller.key)


class Functions(NamedTuple):
    """Flights with a controller.

    Attributes:
        fly: returns each `keep`-th state (N, K/keep + 1, 13) of flights, of `Craft`, `Start`,
            `Course`, `Observer`, `keep`, and trials of each control period, see `make_fly`.
        listen: returns what the law remembers after each of K updates on logged states (K, k), of
            these (K, 13); references (K, 8); voltages (K); what the log says of the memory (K, r),
            NaN where it says nothing; places of each of these (r, 4): the number in the memory, the
            integral behind it, -1 for none, its gain, and the share of the difference that the
            integral takes; the memory to begin with (k); and `Craft`.
    """

    fly: Callable[..., np.ndarray]
    listen: Callable[..., np.ndarray]


@lru_cache(maxsize=16)
def compiled_flights(controller: Controller) -> Functions:
    """Return the functions of a controller, compiled at their first call."""
    whose = "" if controller.shipped else f" with {controller.name}"
    compiled_fly, compiled_listen = (
        compile_cached(
            function,
            SOURCES,
            f"{what}{whose}",
            parts=parts,
            text=controller.digest,
            file=str(controller.file),
            **engine.OPTIONS,
        )
        for function, what, parts in (
            (make_fly(controller), "predictions", 260),
            (make_listen(controller), "the law along a log", 80),
        )
    )

    def fly(
        craft: Craft,
        start: Start,
        course: Course,
        observer: Observer,
        keep: int = 1,
        trials: int = 1,
    ) -> np.ndarray:
        flights = begun(craft, start)
        many, updates = len(flights), course.references.shape[1]
        states = np.empty((many, updates // keep + 1, 13))
        room, places = make_room(len(start.speeds[0])), make_times()
        for first in range(0, many, LANES):
            some = slice(first, first + LANES)
            each = craft.crafts if len(craft.crafts.bodies) == 1 else craft.crafts.chosen(some)
            each.furnish(room)
            compiled_fly(
                flights[some],
                room,
                places,
                craft.clock,
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
        craft: Craft,
    ) -> np.ndarray:
        n, found = len(craft.crafts.speeds[0]), np.empty((len(measured), len(first)))
        one = np.ones(1)
        rest = Start(
            states=np.eye(1, 13),
            speeds=np.zeros((1, n)),
            memory=first[None],
            counts=0.0 * one,
            errors=np.zeros((1, ERROR)),
            voltages=one,
            shares=np.ones((1, n)),
            pushes=np.zeros((1, 1, PUSH)),
        )
        flights = begun(craft, rest)
        compiled_listen(flights, craft.clock, measured, references, voltages, told, places, found)
        return found

    return Functions(fly, listen)


def begun(craft: Craft, start: Start) -> np.ndarray:
    """Return the records of flights that begin, see `record.flight_dtype`, with `ERROR`."""
    crafts, n = craft.crafts, start.speeds.shape[1]
    sizes = sizes_of(craft.controller, n, 0, 0)
    many = max(len(start.states), len(crafts.bodies))
    flights = np.zeros(many, flight_dtype(sizes, {"error": (ERROR,)}))
    begin(flights, start.states, start.speeds, [])
    if sizes.gains:
        flights["gains"] = craft.gains
    if sizes.memory:
        flights["memory"] = start.memory
    flights["law"], flights["lag"] = crafts.law, crafts.lags
    flights["error"], flights["shares"], flights["count"] = start.errors, start.shares, start.counts
    # the law flies to where its reference is, all the time, however low
    flights["holding"], flights["mode_updates"], flights["clearance"] = 0.0, 1.0, -math.inf
    air = flights["air"]
    air["wind_x"], air["wind_y"], air["wind_z"] = np.transpose(craft.winds)
    air["air_density"], air["drag_area"] = AIR_DENSITY, craft.drag_areas
    air["push_start"], air["push_duration"] = -ALWAYS, 2.0 * ALWAYS
    return flights

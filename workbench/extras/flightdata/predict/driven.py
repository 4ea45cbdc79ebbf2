"""Compiled flights over the control periods of a log: what each is told, and what pushes it.

The disturbance: what a model cannot explain of a flight, as a force and a moment over time. Along a
log, closed loop, the law commands in each control period on what the flight computer knew. Force in
W and moment in B are those which bring the model to where the log has it at the period's end.
Velocities answer a held push linearly. So one trial without a push and one with it are enough, and
another one for what turning in the period changes:

    f = m (v_log - v) / T,   m = J (w_log - w) / T

Position and attitude are held by asking for velocities that close what is left of their difference
within `CLOSING_TIME_S`. Flown again with these pushes, the same law makes the same flight.
"""

import math
from collections.abc import Callable
from typing import TYPE_CHECKING, Any

import numpy as np

from workbench.common.jitable import give_unique_name, register_jitable
from workbench.control.controller import Controller
from workbench.control.quaternions import inverse, product
from workbench.design.rollout.fields import get_field, get_lane
from workbench.design.rollout.lane_motion import write_lane_state
from workbench.design.rollout.lane_times import DelayRings, LaneTimes, PeriodClock
from workbench.design.rollout.lanes import LANES, LaneWorkspace
from workbench.design.rollout.law_update import make_law_update
from workbench.design.rollout.period import make_fly_period
from workbench.dynamics.rigid_body import into_body, into_world, rotation
from workbench.extras.flightdata.predict.known import (
    ESTIMATE_ERROR_SIZE,
    WRONG_STATE,
    Observer,
)

if TYPE_CHECKING:
    from workbench.extras.flightdata.predict.flown import FlightCourses

DRIVEN_FIELDS = {"error": (ESTIMATE_ERROR_SIZE,), "target": (13,)}
"""What the record of a flight has besides: the estimate's error, and the state that the log has at
the end of the control period."""
FULL_COMMAND_SHARE = 0.99
"""Share of the speed at full command from which on a rotor is at its limit."""
PUSH_SIZE = 9
"""Numbers of a disturbance: force in W (3), force in B (3) [N], and moment in B (3) [N·m]."""
CLOSING_TIME_S = 0.05
"""Time in which a difference of position or attitude is closed [s]."""


@register_jitable
def _write_course(flight: np.record, course: "FlightCourses", i: int, k: int) -> None:
    """Write what a flight is told in a control period."""
    voltages = course.voltages[i % len(course.voltages)]
    flight.voltage = voltages[min(k, len(voltages) - 1)]
    flight.reference[:] = course.references[i % len(course.references), k]
    if course.errors.shape[1] > 0:
        flight.error[:] = course.errors[i % len(course.errors), k]
    if course.targets.shape[1] > 0:
        flight.target[:] = course.targets[i % len(course.targets), k]


@register_jitable
def _count_saturated(flight: np.record, course: "FlightCourses", i: int, k: int) -> None:
    """Count a control period in which a rotor is at its limit."""
    if course.limits.shape[1] == 0:
        return
    commands, fastest = get_field(flight, "commands"), 0.0
    for command in commands:
        fastest = max(fastest, command)
    if fastest > FULL_COMMAND_SHARE * course.limits[i % len(course.limits), k]:
        course.saturated[i % len(course.saturated)] += 1.0


@register_jitable
def set_next_push(flight: np.record, push: np.ndarray) -> None:
    """Let a push act in the next control period, see `PUSH_SIZE`."""
    R_WB, air = rotation(get_field(flight, "state")[0:4]), flight.air
    x, y, z = into_world(R_WB, (push[3], push[4], push[5]))
    air.push_x, air.push_y, air.push_z = push[0] + x, push[1] + y, push[2] + z
    air.push_torque_x, air.push_torque_y, air.push_torque_z = push[6], push[7], push[8]


@register_jitable
def correct_push(
    push: np.ndarray, flight: np.record, began: np.record, body: np.record, i: int, period: float
) -> None:
    """Add to a push, in place, what a period's end lacks of the velocities that are wanted.

    Args:
        push: see `PUSH_SIZE`.
        flight: the record at the end.
        began: at the begin.
        body: see `lanes.LANE_BODIES_DTYPE`.
        i: the flight's lane.
        period: its length [s].
    """
    state, begun = get_field(flight, "state"), get_field(began, "state")
    target = get_field(flight, "target")
    between = product(target[0:4], inverse(begun[0:4]))
    sign, half, mass = 2.0 if between[0] >= 0.0 else -2.0, 0.5 * period, get_lane(body, "mass", i)
    lacks = np.empty(3)
    for axis in range(3):
        turned = half * (begun[7 + axis] + target[7 + axis])
        moved = half * (begun[10 + axis] + target[10 + axis])
        w = target[7 + axis] + (sign * between[1 + axis] - turned) / CLOSING_TIME_S
        v = target[10 + axis] + (target[4 + axis] - begun[4 + axis] - moved) / CLOSING_TIME_S
        lacks[axis] = (w - state[7 + axis]) / period
        push[axis] += mass * (v - state[10 + axis]) / period
    x, y, z = into_body(rotation(state[0:4]), (lacks[0], lacks[1], lacks[2]))
    xx, xy, xz, yy, yz, zz = get_lane(body, "inertia", i)
    push[6] += xx * x + xy * y + xz * z
    push[7] += xy * x + yy * y + yz * z
    push[8] += xz * x + yz * y + zz * z


def make_fly_driven(controller: Controller) -> Callable[..., Any]:
    """Return the flights of up to 16 vehicles with a controller."""
    key = f"{controller.key}_{WRONG_STATE.key}"
    fly_period = make_fly_period(make_law_update(controller), WRONG_STATE, key)

    def fly(
        flights: np.ndarray,
        rings: DelayRings,
        room: LaneWorkspace,
        times: LaneTimes,
        clock: PeriodClock,
        observer: Observer,
        course: "FlightCourses",
        trials: int,
        keep: int,
        states: np.ndarray,
    ) -> None:
        """Write each `keep`-th state (N, K/keep + 1, 13); this is what gets compiled.

        Args:
            flights: their records, see `record.flight_dtype`, with `DRIVEN_FIELDS`.
            rings: see `DelayRings`; nothing has a delay.
            room: of their motion, furnished, see `VehicleBatch.furnish`.
            times: see `LaneTimes`.
            clock: see `PeriodClock`.
            observer: see `Observer`.
            course: see `FlightCourses`.
            trials: of each control period. The last one counts; after each one before, the push is
                corrected for what its end lacked. With 1 the pushes stay.
            keep: updates between two states.
            states: places.
        """
        many, updates, pushes = len(flights), course.references.shape[1], course.pushes
        begun = flights.copy()
        for i in range(LANES):
            write_lane_state(flights[min(i, many - 1)], room, i)
        for k in range(updates + 1):
            if k % keep == 0:
                for i in range(many):
                    states[i, k // keep] = flights[i].state
            if k == updates:
                break
            for i in range(many):
                _write_course(flights[i], course, i, k)
                begun[i] = flights[i]
            for trial in range(trials):
                for i in range(many):
                    push = pushes[i % len(pushes), min(k, pushes.shape[1] - 1)]
                    if trial > 0:
                        correct_push(push, flights[i], begun[i], room.bodies[0], i, clock.period)
                        flights[i] = begun[i]
                        write_lane_state(flights[i], room, i)
                    set_next_push(flights[i], push)
                fly_period(flights, rings, room, times, clock, observer)
                for i in range(many):
                    flights[i].lost_at = -1.0  # a prediction may be as wrong as it is
            for i in range(many):
                _count_saturated(flights[i], course, i, k)

    return give_unique_name(fly, controller.key)


def make_run_law(controller: Controller) -> Callable[..., Any]:
    """Return a function that runs a controller's law along a log."""
    update = make_law_update(controller)

    def listen(
        flights: np.ndarray,
        clock: PeriodClock,
        measured: np.ndarray,
        references: np.ndarray,
        voltages: np.ndarray,
        told: np.ndarray,
        places: np.ndarray,
        found: np.ndarray,
    ) -> None:
        """Write what the law remembers after each of K updates on logged states.

        Args:
            flights: the record of one that begins (1).
            clock: see `PeriodClock`.
            measured: see `flown.DrivenFunctions`, and so the next four.
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

    return give_unique_name(listen, controller.key)

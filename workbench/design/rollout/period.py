"""A control period of up to sixteen flights: what happens in it, in the diagram's order.

All that is due at one time reads the state before it, as updates of Drake's systems do. At a
control update the law sees the state of that time. Its commands, wind and push hold until the next
one. Between two updates the motion goes from event to event: samples, delays, battery, flight mode.

No flight knows who flies beside it: each gives the same numbers in any company.
"""

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np

from workbench.common.jitable import give_unique_name, register_jitable
from workbench.common.vectors import Numbers
from workbench.control.flight_mode import flying
from workbench.design.rollout.fields import get_field, set_field
from workbench.design.rollout.lane_motion import read_lane_motion, write_lane_air, write_lane_drive
from workbench.design.rollout.lane_times import (
    SAME_TIME_S,
    DelayRings,
    LaneTimes,
    PeriodClock,
    next_event,
)
from workbench.design.rollout.lanes import LaneWorkspace
from workbench.design.rollout.motion import advance_lanes
from workbench.design.rollout.sensor_set import EstimatorInputs
from workbench.design.tumbling import TUMBLING_RATE, TUMBLING_SPEED
from workbench.dynamics.air.normals import NORMALS_PER_SAMPLE as NORMALS
from workbench.dynamics.air.normals import draw_normals
from workbench.dynamics.air.update import push_share, steady_wind, turbulent_wind
from workbench.dynamics.rotors import loaded_voltage, power_share, turning_share
from workbench.session.integration import FAST_TURN_RAD_S


class StateSource(NamedTuple):
    """Where a law gets the state of its vehicle from: functions that compile.

    Attributes:
        sense: `(flight, clock, sensors)` writes `flight.known` at a control update.
        sense_between: `(flight, clock, sensors, passed)` returns the state (13) as it is sensed
            some time after the last update [s].
        mode_state: `(flight)` returns the state (13) that the flight mode sees.
        next_sample: `(sensors, now)` returns the time of the next sample of any sensor [s].
        take_samples: `(flight, sensors, now)` takes the samples that are due now.
        key: see `give_unique_name`.
    """

    sense: Callable[..., None]
    sense_between: Callable[..., Any]
    mode_state: Callable[..., Any]
    next_sample: Callable[..., float]
    take_samples: Callable[..., None]
    key: str


def make_fly_period(
    update: Callable[..., None], source: StateSource, key: str
) -> Callable[..., None]:
    """Return a function that flies up to 16 flights for one control period.

    Args:
        update: runs the law and writes `flight.commands`, see `make_law_update`.
        source: of the state that the law gets.
        key: see `give_unique_name`.
    """
    sense, sense_between, mode_state, next_sample, take_samples, _ = source

    @register_jitable(allocates=False)
    def fly_period(
        flights: np.ndarray,
        rings: DelayRings,
        room: LaneWorkspace,
        times: LaneTimes,
        clock: PeriodClock,
        sensors: EstimatorInputs | None,
    ) -> None:
        """Fly on for a control period.

        Flight i moves in lane i of `room`. The record has the state as it was at the last event,
        the lane as it is: `read_lane_motion` copies it back before anything looks at it.

        Args:
            flights: up to 16 records, see `record.flight_dtype`.
            rings: of these flights, see `DelayRings`.
            room: see `LaneWorkspace`.
            times: places for the times of the lanes, see `LaneTimes`.
            clock: see `PeriodClock`.
            sensors: what the sensors of all flights have in common; None on the truth.
        """
        pushed = False
        # control update: what each flight does reads its state at the beginning of the period
        for i in range(len(flights)):
            flight = flights[i]
            times.end[i] = (flight.count + 1.0) * clock.period
            if flight.lost_at >= 0.0:  # it does not move any more
                times.now[i] = times.end[i]
                continue
            times.now[i] = flight.count * clock.period
            sense(flight, clock, sensors)
            _delay_state(flight, rings.states, i)
            if clock.sags:
                flight.voltage = _loaded_voltage(flight)
            update(flight, clock)
            _actuate_at_once(flight, rings.commands, i)
            pushed = _set_air(flight, clock.period) or pushed
            _update_mode(flight, clock, times.now[i], mode_state(flight))
            _update_battery(flight, clock, times.now[i])
            take_samples(flight, sensors, times.now[i])
            write_lane_air(flight, room, i)
            write_lane_drive(flight, room, i)
            fast = _turns_fast(get_field(flight, "state"))
            times.sizes[i] = flight.fast_step if fast else flight.step
            times.third[i] = (flight.fast_third if fast else flight.third) > 0.0
        # from event to event of each flight, until all have come to the end of the period
        going = True
        while going:
            for i in range(len(flights)):
                now, end, until = times.now[i], times.end[i], times.end[i]
                if now < end:
                    until = min(next_event(flights[i], clock, now), next_sample(sensors, now))
                    until = until if until < end - SAME_TIME_S else end
                times.spans[i] = until - now
                times.now[i] = until
            advance_lanes(room, times.sizes, times.third, times.spans, clock.sags, pushed)
            going = False
            for i in range(len(flights)):
                flight, now = flights[i], times.now[i]
                if now == times.end[i]:
                    continue
                going = True
                read_lane_motion(flight, room, i)
                passed = now - flight.count * clock.period
                if _is_due(flight.sensing_offset, passed):
                    state = sense_between(flight, clock, sensors, passed)
                    _store_state(flight, rings.states, i, state)
                if _is_due(flight.command_offset, passed):
                    _actuate_delayed(flight, rings.commands, i)
                _update_mode(flight, clock, now, mode_state(flight))
                _update_battery(flight, clock, now)
                take_samples(flight, sensors, now)
                write_lane_drive(flight, room, i)
        # the state at the end, and who is lost
        for i in range(len(flights)):
            flight = flights[i]
            flight.count += 1.0
            if flight.lost_at < 0.0:
                read_lane_motion(flight, room, i)
                if _is_lost(get_field(flight, "state"), flight.clearance):
                    flight.lost_at = flight.count

    return give_unique_name(fly_period, key)


@register_jitable(forceinline=True, allocates=False)
def _is_due(offset: float, passed: float) -> bool:
    """Return whether what happens at an offset within each period, if not at 0, happens now [s]."""
    return offset > 0.0 and abs(passed - offset) < SAME_TIME_S


@register_jitable(allocates=False)
def _delay_state(flight: np.record, states: np.ndarray, i: int) -> None:
    """Replace the state that the law gets by an earlier one, where sensing has a delay."""
    if flight.sensing_delay == 0.0:
        return
    if flight.sensing_offset == 0.0:
        _store_state(flight, states, i, get_field(flight, "known"))
    place = _ring_index(flight.count - flight.sensing_delay, states.shape[1])
    for k in range(13):
        flight.known[k] = states[i, place, k]


@register_jitable(allocates=False)
def _store_state(flight: np.record, states: np.ndarray, i: int, state: Numbers) -> None:
    """Store the state that was sensed in this control period."""
    place = _ring_index(flight.count, states.shape[1])
    for k in range(13):
        states[i, place, k] = state[k]


@register_jitable(allocates=False)
def _actuate_at_once(flight: np.record, commands: np.ndarray, i: int) -> None:
    """Let the rotors follow new commands, or store these where they have a delay."""
    if flight.command_delay == 0.0 and flight.command_offset == 0.0:
        for k in range(len(flight.acting)):
            flight.acting[k] = flight.commands[k]
        return
    place = _ring_index(flight.count, commands.shape[1])
    for k in range(len(flight.acting)):
        commands[i, place, k] = flight.commands[k]
    if flight.command_offset == 0.0:
        _actuate_delayed(flight, commands, i)


@register_jitable(allocates=False)
def _actuate_delayed(flight: np.record, commands: np.ndarray, i: int) -> None:
    """Let the rotors follow the stored commands that are due."""
    place = _ring_index(flight.count - flight.command_delay, commands.shape[1])
    for k in range(len(flight.acting)):
        flight.acting[k] = commands[i, place, k]


@register_jitable(forceinline=True, allocates=False)
def _ring_index(number: int, size: int) -> int:
    """Return the place of a number, which may be negative, in a ring."""
    return int(number) % size


@register_jitable
def _set_air(flight: np.record, period: float) -> bool:
    """Write wind and push of a control period, as `systems.wind` and `systems.push` do.

    Return whether there is a push.
    """
    air, begin = flight.air, flight.count * period
    wind = steady_wind(air, begin + 0.5 * period)
    eddies = flight.eddies
    if air.turbulence > 0.0:
        noise, after = np.empty(NORMALS), np.empty(len(eddies))
        draw_normals(flight.air_seed, int(flight.count), noise)
        state = get_field(flight, "state")
        u_x, u_y, u_z = turbulent_wind(air, state, noise, eddies, period, after)
        wind = (wind[0] + u_x, wind[1] + u_y, wind[2] + u_z)
        for k in range(len(eddies)):
            eddies[k] = after[k]
    else:  # turbulence that starts later draws stationary states
        eddies[len(eddies) - 1] = 0.0
    set_field(flight, "wind", wind)
    share = push_share(begin, period, air.push_start, air.push_duration)
    push = (
        share * air.push_x,
        share * air.push_y,
        share * air.push_z,
        air.push_at_x,
        air.push_at_y,
        air.push_at_z,
        share * air.push_torque_x,
        share * air.push_torque_y,
        share * air.push_torque_z,
    )
    set_field(flight, "push", push)
    return share > 0.0


@register_jitable(allocates=False)
def _update_mode(flight: np.record, clock: PeriodClock, now: float, state: Numbers) -> None:
    """Update the flight mode on the state (13) that it sees, if that is due."""
    if now < flight.mode_updates * clock.mode_period - SAME_TIME_S:
        return
    flight.mode_updates += 1.0
    mode, holding, x, y, z = flying(
        flight.holding,
        get_field(flight, "hold"),
        state[4:7],
        state[10:13],
        get_field(flight, "reference"),
    )
    flight.mode = mode
    flight.holding = holding
    set_field(flight, "hold", (x, y, z))


@register_jitable(allocates=False)
def _update_battery(flight: np.record, clock: PeriodClock, now: float) -> None:
    """Update the battery, if that is due; a step of the integrator ends there without one, too."""
    if now < flight.battery_updates * clock.battery_period - SAME_TIME_S:
        return
    flight.battery_updates += 1.0
    flight.charge = max(0.0, flight.charge - clock.used * _rotor_power(flight))
    if clock.sags:
        flight.open_circuit = _interpolated(flight.charge, clock.charges, clock.voltages)


@register_jitable(allocates=False)
def _interpolated(x: float, xs: np.ndarray, ys: np.ndarray) -> float:
    """Return what `np.interp` does; numba's own has scipy loaded together with the machine code."""
    value = ys[0]
    for k in range(len(xs) - 1):
        if x > xs[k]:
            share = min(1.0, (x - xs[k]) / (xs[k + 1] - xs[k]))
            value = ys[k] + share * (ys[k + 1] - ys[k])
    return value


@register_jitable(allocates=False)
def _rotor_power(flight: np.record) -> float:
    """Return the power of the rotors [N^3/2], see `dynamics.rotors.power_share`."""
    law, power = flight.law, 0.0
    for k in range(len(flight.speeds)):
        speed, share = flight.speeds[k], turning_share(flight.shares[k])
        linear_speed = 2.0 * law.half_linear_speeds[k]
        power += power_share(share * law.motor_constants[k] * speed * (speed + linear_speed))
    return power


@register_jitable(allocates=False)
def _loaded_voltage(flight: np.record) -> float:
    """Return the voltage of the battery under load, see `dynamics.rotors.loaded_voltage`."""
    return loaded_voltage(flight.open_circuit, flight.drop, _rotor_power(flight))


@register_jitable(forceinline=True, allocates=False)
def _turns_fast(state: Numbers) -> bool:
    """Return whether a body turns so fast that the integrator takes shorter steps."""
    return (
        state[7] * state[7] + state[8] * state[8] + state[9] * state[9]
        > FAST_TURN_RAD_S * FAST_TURN_RAD_S
    )


@register_jitable(allocates=False)
def _is_lost(state: Numbers, clearance: float) -> bool:
    """Return whether a flight is lost, see `Rollouts.diverged_at`."""
    w, x, y, z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    size = abs(w) + abs(x) + abs(y) + abs(z) + abs(p_x) + abs(p_y) + abs(p_z)
    size += abs(w_x) + abs(w_y) + abs(w_z) + abs(v_x) + abs(v_y) + abs(v_z)
    turns = w_x * w_x + w_y * w_y + w_z * w_z > TUMBLING_RATE**2
    flees = v_x * v_x + v_y * v_y + v_z * v_z > TUMBLING_SPEED**2
    upright = w * w + z * z > x * x + y * y
    return not size < math.inf or p_z < clearance or (not upright and (turns or flees))


@register_jitable(allocates=False)
def note_peaks(flight: np.record, room: LaneWorkspace, i: int) -> None:
    """Note the largest share of its speed limit at which a rotor of a flight has run."""
    for number in range(len(flight.speeds)):
        speed, limit = flight.speeds[number], room.rotors[number].max_rot_velocity[i]
        if speed > flight.peak_use * limit:
            flight.peak_use = speed / limit

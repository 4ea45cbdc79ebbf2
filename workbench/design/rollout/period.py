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

from workbench.common.jitable import register_jitable, unique
from workbench.control.controller import Controller
from workbench.control.flight_law import allocate, flight_law, full_speed, resolved
from workbench.control.flight_mode import flying
from workbench.control.guidance import Setpoint
from workbench.design.rollout.fields import fetch, put, store
from workbench.design.rollout.motion import LANES, advance
from workbench.design.tumbling import TUMBLING_RATE, TUMBLING_SPEED
from workbench.dynamics.air.normals import COUNT as NORMALS
from workbench.dynamics.air.normals import draw_normals
from workbench.dynamics.air.update import push_share, steady_wind, turbulent_wind
from workbench.dynamics.rotors import loaded_voltage, power_share, turning_share
from workbench.session.integration import FAST

NO_ACCELERATION = (0.0, 0.0, 0.0)
"""Of a path: there is none."""
NO_BRAKE = (0.0,) * 13
"""There are no obstacles here: the numbers of `Guidance` after the point to hold."""
ON_TIME = 1e-9
"""Events this near to each other are at the same time [s]."""


class Clock(NamedTuple):
    """When things happen in every flight, and what they have in common.

    Attributes:
        step: of physics, of which periods are multiples [s].
        period: of control [s].
        mode_period: between updates of the flight mode [s].
        estimate: see `acceleration_estimate.sampled_estimate`.
        sags: whether a battery weakens the rotors.
        battery_period: between its updates [s].
        used: charge that an update takes, over power [N^-3/2].
        charges: of the curve of the voltage without load, upwards.
        voltages: of that curve.
    """

    step: float
    period: float
    mode_period: float
    estimate: tuple[float, float]
    sags: bool
    battery_period: float
    used: float
    charges: np.ndarray
    voltages: np.ndarray


class Times(NamedTuple):
    """Of 16 lanes in a control period, all (16).

    Attributes:
        now: of each flight [s].
        end: of its control period [s].
        spans: how far each goes to its next event [s].
        sizes: of the integrator's steps [s].
        third: whether they are of third order.
    """

    now: np.ndarray
    end: np.ndarray
    spans: np.ndarray
    sizes: np.ndarray
    third: np.ndarray


def make_times() -> Times:
    """Return places for the times of 16 lanes."""
    now, end, spans, sizes = np.zeros((4, LANES))
    return Times(now, end, spans, sizes, np.zeros(LANES, dtype=bool))


class Rings(NamedTuple):
    """What is on its way in m flights where sensing or commands come late.

    Attributes:
        seen: (m, periods, 13) states on their way to the law, a ring of control periods.
        asked: (m, periods, n) commands on their way to the rotors.
    """

    seen: np.ndarray
    asked: np.ndarray


class Knowing(NamedTuple):
    """How laws come to know the motion: functions that compile.

    Attributes:
        know: writes `known`, of a flight at a control update, its clock, and what the sensors have
            in common.
        look: returns the state (13) as a sensor tells it now, of the same and the time since the
            last update [s].
        mode_state: returns the state (13) that the flight mode sees, of a flight.
        due: returns when a sensor next takes a sample after a time, of the sensors and that [s].
        sample: takes those samples, of flight, sensors and the time [s].
        key: see `jitable.unique`.
    """

    know: Callable[..., None]
    look: Callable[..., Any]
    mode_state: Callable[..., Any]
    due: Callable[..., float]
    sample: Callable[..., None]
    key: str


def make_fly_period(update: Callable[..., None], knowing: Knowing, key: str) -> Callable[..., None]:
    """Return a function that flies up to 16 flights for one control period.

    Args:
        update: commands the rotors, see `make_update`.
        knowing: how the law knows the motion.
        key: see `jitable.unique`.
    """
    know, look, mode_state, due, sample, _ = knowing

    @register_jitable
    def fly_period(flights, rings, room, times, clock, sensors):
        """Fly on for a control period.

        Args:
            flights: up to 16 records, see `record.flight_dtype`.
            rings: of these flights, see `Rings`.
            room: of their motion, see `motion.Room`; it has the state, too.
            times: see `Times`.
            clock: see `Clock`.
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
            know(flight, clock, sensors)
            _see(flight, rings.seen, i)
            if clock.sags:
                flight.voltage = _voltage(flight)
            update(flight, clock)
            _act(flight, rings.asked, i)
            pushed = _blow(flight, clock) or pushed
            _update_mode(flight, clock, times.now[i], mode_state(flight))
            _update_battery(flight, clock, times.now[i])
            sample(flight, sensors, times.now[i])
            write_air(flight, room, i)
            write_drive(flight, room, i)
            fast = _turns_fast(fetch(flight, "state"))
            times.sizes[i] = flight.fast_step if fast else flight.step
            times.third[i] = (flight.fast_third if fast else flight.third) > 0.0
        # from event to event of each flight, until all have come to the end of the period
        going = True
        while going:
            for i in range(len(flights)):
                now, end, until = times.now[i], times.end[i], times.end[i]
                if now < end:
                    until = min(_next_event(flights[i], clock, now), due(sensors, now))
                    until = until if until < end - ON_TIME else end
                times.spans[i] = until - now
                times.now[i] = until
            advance(room, times.sizes, times.third, times.spans, clock.sags, pushed)
            going = False
            for i in range(len(flights)):
                flight, now = flights[i], times.now[i]
                if now == times.end[i]:
                    continue
                going = True
                read_motion(flight, room, i)
                since = now - flight.count * clock.period
                if flight.look > 0.0 and abs(since - flight.look) < ON_TIME:
                    _remember(flight, rings.seen, i, look(flight, clock, sensors, since))
                if flight.since > 0.0 and abs(since - flight.since) < ON_TIME:
                    _follow(flight, rings.asked, i)
                _update_mode(flight, clock, now, mode_state(flight))
                _update_battery(flight, clock, now)
                sample(flight, sensors, now)
                write_drive(flight, room, i)
        # the state at the end, and who is lost
        for i in range(len(flights)):
            flight = flights[i]
            flight.count += 1.0
            if flight.lost_at < 0.0:
                read_motion(flight, room, i)
                if _is_lost(fetch(flight, "state"), flight.clearance):
                    flight.lost_at = flight.count

    return unique(fly_period, key)


def make_update(controller: Controller) -> Callable[..., None]:
    """Return a function that runs one update of a controller, and writes `commands` [rad/s]."""
    law_update = flight_law(controller).update
    remember, memory_of = (_remember_law, _memory_of) if controller.memory else (_pass, _no_memory)

    @register_jitable
    def update(flight, clock):
        """Run the law on what it knows; see `flight_law.update` for the order of the arguments."""
        holding = flight.holding
        # motors, lift and authority are on; the mode itself does not climb
        guidance = (1.0, 1.0, 1.0, 0.0, holding, holding) + fetch(flight, "hold") + NO_BRAKE
        setpoint = Setpoint(fetch(flight, "reference"), guidance, NO_ACCELERATION)
        filtered, memory = law_update(
            fetch(flight, "known"),
            flight.voltage,
            setpoint,
            fetch(flight, "gains"),
            flight.shares,
            flight.law,
            None,  # no loop is cut or measured
            clock.estimate,
            flight.computer,
            fetch(flight, "filtered"),
            memory_of(flight),
            flight.commands,
            flight.count,
        )
        store(flight, "filtered", filtered)
        remember(flight, memory)
        _quantise(flight)

    return unique(update, controller.key)


@register_jitable
def give_wrench(flight, clock):
    """Command the rotors to make the wrench that is asked for."""
    allocate(fetch(flight, "wrench"), 1.0, 1.0, flight.shares, flight.law, flight.commands)
    _quantise(flight)


@register_jitable
def give_speeds(flight, clock):
    """Do nothing: the commands are what is asked for."""


@register_jitable(forceinline=True)
def _memory_of(flight):
    return fetch(flight, "memory")


@register_jitable(forceinline=True)
def _no_memory(flight):
    return ()


@register_jitable(forceinline=True)
def _remember_law(flight, memory):
    store(flight, "memory", memory)


@register_jitable(forceinline=True)
def _pass(flight, memory):
    """Do nothing: the law remembers nothing."""


@register_jitable
def _quantise(flight):
    """Round the commands to their resolution."""
    steps = flight.computer[2]
    if steps > 0.0:
        for k in range(len(flight.commands)):
            flight.commands[k] = resolved(flight.commands[k], full_speed(flight.law, k), steps)


@register_jitable
def read_motion(flight, room, i):
    """Read the state of a flight from its lane."""
    state, speeds = room.bodies[0].state, flight.speeds
    for k in range(13):
        flight.state[k] = state[k * LANES + i]
    for number in range(len(speeds)):
        speeds[number] = room.rotors[number].speed[i]


@register_jitable
def write_flight(flight, room, i):
    """Write the state of a flight, and what seldom changes, to its lane."""
    body = room.bodies[0]
    state, speeds = body.state, flight.speeds
    for k in range(13):
        state[k * LANES + i] = flight.state[k]
    put(body, "half_drag", i, 0.5 * flight.air.air_density * flight.air.drag_area)
    put(body, "drop", i, flight.drop)
    put(body, "compensation", i, flight.sag_compensation)
    for number in range(len(speeds)):
        rotor, share = room.rotors[number], flight.shares[number]
        put(rotor, "speed", i, speeds[number])
        put(rotor, "share", i, turning_share(share))
        put(rotor, "runs", i, 1.0 if share > 0.0 else 0.0)


@register_jitable
def write_air(flight, room, i):
    """Write wind and push of a flight to its lane."""
    body, push = room.bodies[0], fetch(flight, "push")
    put(body, "wind", i, fetch(flight, "wind"))
    put(body, "push", i, push[0:3])
    put(body, "push_point", i, push[3:6])
    put(body, "push_torque", i, push[6:9])


@register_jitable
def write_drive(flight, room, i):
    """Write commands and voltage of a flight to its lane."""
    put(room.bodies[0], "open_circuit", i, flight.open_circuit)
    put(room.bodies[0], "known", i, flight.open_circuit)
    for number in range(len(flight.acting)):
        put(room.rotors[number], "command", i, flight.acting[number])


@register_jitable
def _see(flight, seen, i):
    """Let the law see what is known, or what was known earlier where sensing is late."""
    if flight.late == 0.0:
        return
    if flight.look == 0.0:
        _remember(flight, seen, i, fetch(flight, "known"))
    place = _place(flight.count - flight.late, seen.shape[1])
    for k in range(13):
        flight.known[k] = seen[i, place, k]


@register_jitable
def _remember(flight, seen, i, state):
    """Remember what is known in a control period."""
    place = _place(flight.count, seen.shape[1])
    for k in range(13):
        seen[i, place, k] = state[k]


@register_jitable
def _act(flight, asked, i):
    """Let the rotors follow the commands, where these do not come late."""
    if flight.age == 0.0 and flight.since == 0.0:
        for k in range(len(flight.acting)):
            flight.acting[k] = flight.commands[k]
        return
    place = _place(flight.count, asked.shape[1])
    for k in range(len(flight.acting)):
        asked[i, place, k] = flight.commands[k]
    if flight.since == 0.0:
        _follow(flight, asked, i)


@register_jitable
def _follow(flight, asked, i):
    """Let the rotors follow the commands of the update that is due."""
    place = _place(flight.count - flight.age, asked.shape[1])
    for k in range(len(flight.acting)):
        flight.acting[k] = asked[i, place, k]


@register_jitable(forceinline=True)
def _place(number, size):
    """Return the place of a number, which may be negative, in a ring."""
    return int(number) % size


@register_jitable
def _blow(flight, clock):
    """Write wind and push of a control period, as `systems.wind` and `systems.push` do.

    Return whether there is a push.
    """
    air, begin, period = flight.air, flight.count * clock.period, clock.period
    wind = steady_wind(air, begin + 0.5 * period)
    eddies = flight.eddies
    if air.turbulence > 0.0:
        noise, after = np.empty(NORMALS), np.empty(len(eddies))
        draw_normals(flight.air_seed, int(flight.count), noise)
        state = fetch(flight, "state")
        u_x, u_y, u_z = turbulent_wind(air, state, noise, eddies, period, after)
        wind = (wind[0] + u_x, wind[1] + u_y, wind[2] + u_z)
        for k in range(len(eddies)):
            eddies[k] = after[k]
    else:  # turbulence that starts later draws stationary states
        eddies[len(eddies) - 1] = 0.0
    store(flight, "wind", wind)
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
    store(flight, "push", push)
    return share > 0.0


@register_jitable
def _update_mode(flight, clock, now, state):
    """Update the flight mode on the state (13) that it sees, if that is due."""
    if now < flight.mode_updates * clock.mode_period - ON_TIME:
        return
    flight.mode_updates += 1.0
    mode, holding, x, y, z = flying(
        flight.holding, fetch(flight, "hold"), state[4:7], state[10:13], fetch(flight, "reference")
    )
    flight.mode = mode
    flight.holding = holding
    store(flight, "hold", (x, y, z))


@register_jitable
def _update_battery(flight, clock, now):
    """Update the battery, if that is due; a step of the integrator ends there without one, too."""
    if now < flight.battery_updates * clock.battery_period - ON_TIME:
        return
    flight.battery_updates += 1.0
    flight.charge = max(0.0, flight.charge - clock.used * _power(flight))
    if clock.sags:
        flight.open_circuit = np.interp(flight.charge, clock.charges, clock.voltages)


@register_jitable(forceinline=True)
def is_multiple(now, period):
    """Return whether a time is a multiple of a period."""
    return abs(now - period * math.floor(now / period + 0.5)) < ON_TIME


@register_jitable(forceinline=True)
def next_multiple(now, period):
    """Return the next multiple of a period after a time."""
    return period * (math.floor((now + ON_TIME) / period) + 1.0)


@register_jitable
def _next_event(flight, clock, now):
    """Return when something next happens to a flight, besides its sensors' samples [s]."""
    begin, found = flight.count * clock.period, flight.mode_updates * clock.mode_period
    found = min(found, flight.battery_updates * clock.battery_period)
    if begin + flight.look > now + ON_TIME:
        found = min(found, begin + flight.look)
    if begin + flight.since > now + ON_TIME:
        found = min(found, begin + flight.since)
    return found


@register_jitable
def _power(flight):
    """Return the power of the rotors [N^3/2], see `dynamics.rotors.power_share`."""
    law, power = flight.law, 0.0
    for k in range(len(flight.speeds)):
        speed, share = flight.speeds[k], turning_share(flight.shares[k])
        linear_speed = 2.0 * law.half_linear_speeds[k]
        power += power_share(share * law.motor_constants[k] * speed * (speed + linear_speed))
    return power


@register_jitable
def _voltage(flight):
    """Return the voltage of the battery under load, see `dynamics.rotors.loaded_voltage`."""
    return loaded_voltage(flight.open_circuit, flight.drop, _power(flight))


@register_jitable(forceinline=True)
def _turns_fast(state):
    """Return whether a body turns so fast that the integrator takes shorter steps."""
    return state[7] * state[7] + state[8] * state[8] + state[9] * state[9] > FAST * FAST


@register_jitable
def _is_lost(state, clearance):
    """Return whether a flight is lost, see `Rollouts.diverged_at`."""
    w, x, y, z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
    size = abs(w) + abs(x) + abs(y) + abs(z) + abs(p_x) + abs(p_y) + abs(p_z)
    size += abs(w_x) + abs(w_y) + abs(w_z) + abs(v_x) + abs(v_y) + abs(v_z)
    turns = w_x * w_x + w_y * w_y + w_z * w_z > TUMBLING_RATE**2
    flees = v_x * v_x + v_y * v_y + v_z * v_z > TUMBLING_SPEED**2
    upright = w * w + z * z > x * x + y * y
    return not size < math.inf or p_z < clearance or (not upright and (turns or flees))


@register_jitable
def note_peaks(flight, room, i):
    """Note the largest share of its speed limit at which a rotor of a flight has run."""
    for number in range(len(flight.speeds)):
        speed, limit = flight.speeds[number], room.rotors[number].max_rot_velocity[i]
        if speed > flight.peak_use * limit:
            flight.peak_use = speed / limit

"""The motion of sixteen vehicles side by side: Drake's equations and integrators, compiled.

A record has one number of each of 16 vehicles, its lanes, next to each other. A loop over the lanes
that calls the functions of `dynamics` becomes vector instructions, so 16 vehicles fly in the time
of three. The integrators are Drake's `runge_kutta5` (Dormand and Prince, "A family of embedded
Runge-Kutta formulae", 1980) and `runge_kutta3` (Kutta's), at fixed steps. The rate of a quaternion
follows from the quaternion as it is, as in Drake's plant: so both give the same flight to rounding.
"""

from typing import NamedTuple

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.fields import packed_dtype, put, take
from workbench.dynamics.air.drag import drag_force
from workbench.dynamics.rigid_body import (
    body_acceleration,
    cross,
    into_body,
    quaternion_rate,
    rotation,
)
from workbench.dynamics.rotors import (
    RotorConstants,
    compensated_share,
    loaded_voltage,
    power_share,
    rotor_load,
    speed_slope,
    static_thrust,
    within,
)

LANES = 16
"""Vehicles side by side: four vectors of four, so that one's wait is another's work."""
LANE = (LANES,)
THREE, FOUR, SIX, NINE = ((rows, LANES) for rows in (3, 4, 6, 9))

BODIES = packed_dtype(
    {
        "q_WB": FOUR,
        "p_WB": THREE,
        "w_WB": THREE,
        "v_WB": THREE,
        "q_rate": FOUR,
        "p_rate": THREE,
        "w_rate": THREE,
        "v_rate": THREE,
        "R_WB": NINE,
        "w_B": THREE,
        "v_B": THREE,
        "force": THREE,
        "moment": THREE,
        "momentum": THREE,
        "wind": THREE,
        "push": THREE,
        "push_point": THREE,
        "push_torque": THREE,
        "mass": LANE,
        "inertia": SIX,
        "inverse": SIX,
        "p_BoBcm_B": THREE,
        "half_drag": LANE,
        "open_circuit": LANE,
        "drop": LANE,
        "compensation": LANE,
        "known": LANE,
        "power": LANE,
        "voltage": LANE,
        "divisor": LANE,
        "step": LANE,
    },
    whole={
        "state": ("q_WB", "p_WB", "w_WB", "v_WB"),
        "rate": ("q_rate", "p_rate", "w_rate", "v_rate"),
    },
)
"""The bodies of 16 vehicles:

    q_WB .. v_WB    state, in W [m, rad/s, m/s]; together they are `state` (13 x 16, row by row)
    q_rate .. v_rate    its derivative, likewise `rate`
    R_WB            attitude, row by row
    w_B, v_B        angular velocity, and velocity relative to the air, in B [rad/s, m/s]
    force, moment   without gravity, the moment about the origin, in B [N, N·m]
    momentum        angular momentum of the rotors in B [N·m·s]
    wind            velocity of the air in W [m/s]
    push            force of a push in W [N], push_point and push_torque in B [m, N·m]
    mass .. p_BoBcm_B    see `RigidBody`
    half_drag       half the air's density times the drag area [kg/m]
    open_circuit, drop, compensation, known    supply of the battery, see `dynamics.rotors`
    power, voltage, divisor    load of the battery, and by what commands are divided
    step            of the integrator [s]
"""
ROTORS = packed_dtype(
    {
        "speed": LANE,
        "speed_rate": LANE,
        "static": LANE,
        "command": LANE,
        "runs": LANE,
        "share": LANE,
        **{name: THREE if name in ("p_BR", "axis_B") else LANE for name in RotorConstants._fields},
    }
)
"""A rotor of each of 16 vehicles: speed, derivative, static thrust, command, whether it follows its
command (0, 1), share of its thrust, and constants."""
# Dormand and Prince: weights of the slopes before in each stage, then in the step
WEIGHTS_5 = (
    (1 / 5, 0.0, 0.0, 0.0, 0.0, 0.0),
    (3 / 40, 9 / 40, 0.0, 0.0, 0.0, 0.0),
    (44 / 45, -56 / 15, 32 / 9, 0.0, 0.0, 0.0),
    (19372 / 6561, -25360 / 2187, 64448 / 6561, -212 / 729, 0.0, 0.0),
    (9017 / 3168, -355 / 33, 46732 / 5247, 49 / 176, -5103 / 18656, 0.0),
    (35 / 384, 0.0, 500 / 1113, 125 / 192, -2187 / 6784, 11 / 84),
)
# Kutta: likewise
WEIGHTS_3 = ((1 / 2, 0.0, 0.0), (-1.0, 2.0, 0.0), (1 / 6, 2 / 3, 1 / 6))
TABLEAU_5, TABLEAU_3 = np.array(WEIGHTS_5), np.array(WEIGHTS_3)
STAGES = len(WEIGHTS_5)
STATES = 13
STRETCH = 1.01
"""Factor by which Drake may lengthen the last step before an event."""


class Room(NamedTuple):
    """What flies, and places that the integrator works in; S is 16 times the size of the state.

    Attributes:
        bodies: one record, see `BODIES`.
        rotors: (n) see `ROTORS`.
        begun: (S) state at the beginning of a step: of the bodies, then of the rotors.
        moved: (S) the state in a stage, or at the end.
        slopes: (stages, S).
        sizes: (S) of the step of each lane [s].
    """

    bodies: np.ndarray
    rotors: np.ndarray
    begun: np.ndarray
    moved: np.ndarray
    slopes: np.ndarray
    sizes: np.ndarray


def make_room(rotors: int) -> Room:
    """Return a room for vehicles with as many rotors."""
    size = (STATES + rotors) * LANES
    return Room(
        np.zeros(1, BODIES),
        np.zeros(rotors, ROTORS),
        np.zeros(size),
        np.zeros(size),
        np.zeros((STAGES, size)),
        np.zeros(size),
    )


@register_jitable
def derive(bodies, rotors, sags, pushed):
    """Write the time derivatives of 16 vehicles: of the bodies' state in W, and of rotor speeds.

    Args:
        bodies: a record of all of them, see `BODIES`.
        rotors: of the vehicles, see `ROTORS` (n).
        sags: whether a battery weakens the rotors.
        pushed: whether anything pushes.
    """
    _calc_air_velocity(bodies)
    _calc_speed_rates(bodies, rotors, sags)
    for i in range(LANES):
        force, moment = _drag(bodies, i)
        put(bodies, "force", i, force)
        put(bodies, "moment", i, moment)
        put(bodies, "momentum", i, (0.0, 0.0, 0.0))
    if pushed:
        _push(bodies)
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            force, moment, momentum = _load(bodies, rotor, i)
            put(bodies, "force", i, _sum(take(bodies, "force", i), force))
            put(bodies, "moment", i, _sum(take(bodies, "moment", i), moment))
            put(bodies, "momentum", i, _sum(take(bodies, "momentum", i), momentum))
    for i in range(LANES):
        w_B, (m_x, m_y, m_z) = take(bodies, "w_B", i), take(bodies, "moment", i)
        g_x, g_y, g_z = cross(w_B, take(bodies, "momentum", i))  # gyroscopic moment
        found = body_acceleration(
            take(bodies, "R_WB", i),
            w_B,
            take(bodies, "force", i),
            (m_x - g_x, m_y - g_y, m_z - g_z),
            take(bodies, "mass", i),
            take(bodies, "inertia", i),
            take(bodies, "inverse", i),
            take(bodies, "p_BoBcm_B", i),
        )
        put(bodies, "w_rate", i, found[0:3])
        put(bodies, "v_rate", i, found[3:6])
    for i in range(LANES):
        put(bodies, "q_rate", i, quaternion_rate(take(bodies, "q_WB", i), take(bodies, "w_WB", i)))
        put(bodies, "p_rate", i, take(bodies, "v_WB", i))


@register_jitable(forceinline=True)
def _calc_air_velocity(bodies):
    """Write attitude, and angular velocity and velocity in the air in B."""
    for i in range(LANES):
        R_WB = rotation(take(bodies, "q_WB", i))
        (v_x, v_y, v_z), (u_x, u_y, u_z) = take(bodies, "v_WB", i), take(bodies, "wind", i)
        put(bodies, "R_WB", i, R_WB)
        put(bodies, "w_B", i, into_body(R_WB, take(bodies, "w_WB", i)))
        put(bodies, "v_B", i, into_body(R_WB, (v_x - u_x, v_y - u_y, v_z - u_z)))


@register_jitable(forceinline=True)
def _calc_speed_rates(bodies, rotors, sags):
    """Write static thrusts, and the derivatives of the rotors' speeds."""
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            share, speed = take(rotor, "share", i), take(rotor, "speed", i)
            put(rotor, "static", i, static_thrust(constants(rotor, i), share, speed))
    if sags:
        load_battery(bodies, rotors)
    for number in range(len(rotors)):
        rotor = rotors[number]
        if sags:
            for i in range(LANES):
                command = take(rotor, "command", i) / take(bodies, "divisor", i)
                command = take(bodies, "voltage", i) * within(command, constants(rotor, i))
                _follow(rotor, i, command)
        else:
            for i in range(LANES):
                _follow(rotor, i, within(take(rotor, "command", i), constants(rotor, i)))


@register_jitable(forceinline=True)
def load_battery(bodies, rotors):
    """Write the voltage under load, and by what commands are divided, at the static thrusts."""
    for i in range(LANES):
        put(bodies, "power", i, 0.0)
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            power = take(bodies, "power", i) + power_share(take(rotor, "static", i))
            put(bodies, "power", i, power)
    for i in range(LANES):
        rest, drop = take(bodies, "open_circuit", i), take(bodies, "drop", i)
        voltage = loaded_voltage(rest, drop, take(bodies, "power", i))
        compensation, known = take(bodies, "compensation", i), take(bodies, "known", i)
        put(bodies, "voltage", i, voltage)
        put(bodies, "divisor", i, compensated_share(voltage, rest, compensation, known))


@register_jitable(forceinline=True)
def _follow(rotor, i, command):
    """Write the derivative of a rotor's speed; a stopped rotor runs down."""
    command = command if take(rotor, "runs", i) > 0.0 else 0.0
    put(rotor, "speed_rate", i, speed_slope(constants(rotor, i), command, take(rotor, "speed", i)))


@register_jitable(forceinline=True)
def _drag(bodies, i):
    """Return force and moment of the body's drag, in B."""
    center, (v_x, v_y, v_z) = take(bodies, "p_BoBcm_B", i), take(bodies, "v_B", i)
    s_x, s_y, s_z = cross(take(bodies, "w_B", i), center)
    force = drag_force(take(bodies, "half_drag", i), (v_x + s_x, v_y + s_y, v_z + s_z))
    return force, cross(center, force)


@register_jitable(forceinline=True)
def _push(bodies):
    """Add the push."""
    for i in range(LANES):
        force = into_body(take(bodies, "R_WB", i), take(bodies, "push", i))
        moment = _sum(cross(take(bodies, "push_point", i), force), take(bodies, "push_torque", i))
        put(bodies, "force", i, _sum(take(bodies, "force", i), force))
        put(bodies, "moment", i, _sum(take(bodies, "moment", i), moment))


@register_jitable(forceinline=True)
def _load(bodies, rotor, i):
    """Return force, moment and angular momentum of a rotor, in B."""
    return rotor_load(
        constants(rotor, i),
        take(rotor, "speed", i),
        take(rotor, "speed_rate", i),
        take(rotor, "share", i),
        take(rotor, "static", i),
        take(bodies, "w_B", i),
        take(bodies, "v_B", i),
        take(bodies, "R_WB", i),
        take(bodies, "p_WB", i)[2],
    )


@register_jitable(forceinline=True)
def constants(rotor, i):
    """Return the constants of a rotor."""
    return RotorConstants(
        take(rotor, "p_BR", i),
        take(rotor, "axis_B", i),
        take(rotor, "direction", i),
        take(rotor, "max_rot_velocity", i),
        take(rotor, "motor_constant", i),
        take(rotor, "linear_speed", i),
        take(rotor, "moment_constant", i),
        take(rotor, "inertia", i),
        take(rotor, "time_constant_up", i),
        take(rotor, "time_constant_down", i),
        take(rotor, "rotor_drag_coefficient", i),
        take(rotor, "rolling_moment_coefficient", i),
        take(rotor, "inflow_coefficient", i),
        take(rotor, "ground_effect_coefficient", i),
        take(rotor, "propeller_radius", i),
    )


@register_jitable(forceinline=True)
def acceleration(bodies, i):
    """Return the angular acceleration of a lane, and that of its origin, as `derive` wrote them."""
    return take(bodies, "w_rate", i) + take(bodies, "v_rate", i)


@register_jitable(forceinline=True)
def _sum(a, b):
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@register_jitable
def step(room, tableau, sags, pushed):
    """Advance each lane by its `step` with a Runge-Kutta method; one with a step of 0 stays.

    Args:
        room: see `Room`.
        tableau: of Butcher (stages, stages): row k has the weights of the slopes 0 .. k in the next
            stage, the last row those in the result.
        sags: see `derive`.
        pushed: see `derive`.
    """
    body, size = room.bodies[0], len(room.begun)
    for place in range(size):  # the lane is the fastest index
        room.sizes[place] = body.step[place % LANES]
    _gather(body.state, room.rotors, room.begun)
    for stage in range(len(tableau)):
        derive(body, room.rotors, sags, pushed)
        _gather_rates(body.rate, room.rotors, room.slopes[stage])
        weight, slope = tableau[stage, 0], room.slopes[0]
        for place in range(size):
            room.moved[place] = weight * slope[place]
        for k in range(1, stage + 1):
            weight, slope = tableau[stage, k], room.slopes[k]
            for place in range(size):
                room.moved[place] += weight * slope[place]
        for place in range(size):
            room.moved[place] = room.begun[place] + room.sizes[place] * room.moved[place]
        _scatter(room.moved, body.state, room.rotors)


@register_jitable
def _gather(state, rotors, places):
    """Write the state of the bodies, then that of the rotors."""
    for place in range(len(state)):
        places[place] = state[place]
    for number in range(len(rotors)):
        for i in range(LANES):
            places[len(state) + number * LANES + i] = rotors[number].speed[i]


@register_jitable
def _gather_rates(rate, rotors, places):
    """Write the derivative of the state, as `_gather` does the state."""
    for place in range(len(rate)):
        places[place] = rate[place]
    for number in range(len(rotors)):
        for i in range(LANES):
            places[len(rate) + number * LANES + i] = rotors[number].speed_rate[i]


@register_jitable
def _scatter(places, state, rotors):
    """Read the state from where `_gather` has written it."""
    for place in range(len(state)):
        state[place] = places[place]
    for number in range(len(rotors)):
        for i in range(LANES):
            rotors[number].speed[i] = places[len(state) + number * LANES + i]


@register_jitable
def advance(room, sizes, third, spans, sags, pushed):
    """Advance each lane by a time, at steps of its own size.

    Args:
        room: see `Room`.
        sizes: steps of the lanes (16) [s].
        third: whether they are of third order, else of fifth (16).
        spans: time that each lane is to go (16) [s]; 0 on return.
        sags: see `derive`.
        pushed: see `derive`.
    """
    size = room.bodies[0].step
    while True:
        fifths, thirds = False, False
        for i in range(LANES):
            if spans[i] > 0.0:
                fifths, thirds = fifths or not third[i], thirds or third[i]
        if not (fifths or thirds):
            break
        for method in range(2):
            if not (thirds if method == 0 else fifths):
                continue
            for i in range(LANES):
                size[i] = 0.0
                if spans[i] > 0.0 and third[i] == (method == 0):
                    size[i] = spans[i] if spans[i] <= STRETCH * sizes[i] else sizes[i]
            step(room, TABLEAU_3 if method == 0 else TABLEAU_5, sags, pushed)
            for i in range(LANES):
                spans[i] -= size[i]

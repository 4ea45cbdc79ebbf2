"""The motion of sixteen vehicles side by side: Drake's equations and integrators, compiled.

A record has one number of each of 16 vehicles, its lanes, next to each other. A loop over the lanes
that calls the functions of `dynamics` becomes vector instructions, so 16 vehicles fly in the time
of three. The integrators are Drake's `runge_kutta5` (Dormand and Prince, "A family of embedded
Runge-Kutta formulae", 1980) and `runge_kutta3` (Kutta's), at fixed steps. The rate of a quaternion
follows from the quaternion as it is, as in Drake's plant: so both give the same flight to rounding.
"""

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.common.vectors import Vector3
from workbench.design.rollout.fields import get_lane, set_lane
from workbench.design.rollout.lanes import (
    DORMAND_PRINCE_TABLEAU,
    KUTTA_TABLEAU,
    LANES,
    LaneWorkspace,
)
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
    within_speed_limits,
)

LAST_STEP_STRETCH = 1.01
"""Factor by which Drake may lengthen the last step before an event."""


@register_jitable(allocates=False)
def derive_lanes(bodies: np.record, rotors: np.ndarray, sags: bool, pushed: bool) -> None:
    """Write the time derivatives of 16 vehicles: of the bodies' state in W, and of rotor speeds.

    Args:
        bodies: a record of all of them, see `LANE_BODIES_DTYPE`.
        rotors: of the vehicles, see `LANE_ROTORS_DTYPE` (n).
        sags: whether a battery weakens the rotors.
        pushed: whether anything pushes.
    """
    _calc_air_velocity(bodies)
    _calc_speed_rates(bodies, rotors, sags)
    for i in range(LANES):
        force, moment = _body_drag(bodies, i)
        set_lane(bodies, "force", i, force)
        set_lane(bodies, "moment", i, moment)
        set_lane(bodies, "momentum", i, (0.0, 0.0, 0.0))
    if pushed:
        _add_push(bodies)
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            force, moment, momentum = _rotor_load_on_body(bodies, rotor, i)
            set_lane(bodies, "force", i, _sum(get_lane(bodies, "force", i), force))
            set_lane(bodies, "moment", i, _sum(get_lane(bodies, "moment", i), moment))
            set_lane(bodies, "momentum", i, _sum(get_lane(bodies, "momentum", i), momentum))
    for i in range(LANES):
        w_B, (m_x, m_y, m_z) = get_lane(bodies, "w_B", i), get_lane(bodies, "moment", i)
        g_x, g_y, g_z = cross(w_B, get_lane(bodies, "momentum", i))  # gyroscopic moment
        found = body_acceleration(
            get_lane(bodies, "R_WB", i),
            w_B,
            get_lane(bodies, "force", i),
            (m_x - g_x, m_y - g_y, m_z - g_z),
            get_lane(bodies, "mass", i),
            get_lane(bodies, "inertia", i),
            get_lane(bodies, "inverse", i),
            get_lane(bodies, "p_BoBcm_B", i),
        )
        set_lane(bodies, "w_rate", i, found[0:3])
        set_lane(bodies, "v_rate", i, found[3:6])
    for i in range(LANES):
        set_lane(
            bodies,
            "q_rate",
            i,
            quaternion_rate(get_lane(bodies, "q_WB", i), get_lane(bodies, "w_WB", i)),
        )
        set_lane(bodies, "p_rate", i, get_lane(bodies, "v_WB", i))


@register_jitable(forceinline=True, allocates=False)
def _calc_air_velocity(bodies: np.record) -> None:
    """Write attitude, and angular velocity and velocity in the air in B."""
    for i in range(LANES):
        R_WB = rotation(get_lane(bodies, "q_WB", i))
        (v_x, v_y, v_z), (u_x, u_y, u_z) = get_lane(bodies, "v_WB", i), get_lane(bodies, "wind", i)
        set_lane(bodies, "R_WB", i, R_WB)
        set_lane(bodies, "w_B", i, into_body(R_WB, get_lane(bodies, "w_WB", i)))
        set_lane(bodies, "v_B", i, into_body(R_WB, (v_x - u_x, v_y - u_y, v_z - u_z)))


@register_jitable(forceinline=True, allocates=False)
def _calc_speed_rates(bodies: np.record, rotors: np.ndarray, sags: bool) -> None:
    """Write static thrusts, and the derivatives of the rotors' speeds."""
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            share, speed = get_lane(rotor, "share", i), get_lane(rotor, "speed", i)
            set_lane(rotor, "static", i, static_thrust(rotor_constants_of(rotor, i), share, speed))
    if sags:
        load_battery(bodies, rotors)
    for number in range(len(rotors)):
        rotor = rotors[number]
        if sags:
            for i in range(LANES):
                command = get_lane(rotor, "command", i) / get_lane(bodies, "divisor", i)
                command = get_lane(bodies, "voltage", i) * within_speed_limits(
                    command, rotor_constants_of(rotor, i)
                )
                _calc_speed_rate(rotor, i, command)
        else:
            for i in range(LANES):
                _calc_speed_rate(
                    rotor,
                    i,
                    within_speed_limits(
                        get_lane(rotor, "command", i), rotor_constants_of(rotor, i)
                    ),
                )


@register_jitable(forceinline=True, allocates=False)
def load_battery(bodies: np.record, rotors: np.ndarray) -> None:
    """Write the voltage under load, and by what commands are divided, at the static thrusts."""
    for i in range(LANES):
        set_lane(bodies, "power", i, 0.0)
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            power = get_lane(bodies, "power", i) + power_share(get_lane(rotor, "static", i))
            set_lane(bodies, "power", i, power)
    for i in range(LANES):
        rest, drop = get_lane(bodies, "open_circuit", i), get_lane(bodies, "drop", i)
        voltage = loaded_voltage(rest, drop, get_lane(bodies, "power", i))
        compensation = get_lane(bodies, "compensation", i)
        known = get_lane(bodies, "known_open_circuit", i)
        set_lane(bodies, "voltage", i, voltage)
        set_lane(bodies, "divisor", i, compensated_share(voltage, rest, compensation, known))


@register_jitable(forceinline=True, allocates=False)
def _calc_speed_rate(rotor: np.record, i: int, command: float) -> None:
    """Write the derivative of a rotor's speed; a stopped rotor runs down."""
    command = command if get_lane(rotor, "runs", i) > 0.0 else 0.0
    set_lane(
        rotor,
        "speed_rate",
        i,
        speed_slope(rotor_constants_of(rotor, i), command, get_lane(rotor, "speed", i)),
    )


@register_jitable(forceinline=True, allocates=False)
def _body_drag(bodies: np.record, i: int) -> tuple[Vector3, Vector3]:
    """Return force and moment of the body's drag, in B."""
    center, (v_x, v_y, v_z) = get_lane(bodies, "p_BoBcm_B", i), get_lane(bodies, "v_B", i)
    s_x, s_y, s_z = cross(get_lane(bodies, "w_B", i), center)
    force = drag_force(get_lane(bodies, "half_drag", i), (v_x + s_x, v_y + s_y, v_z + s_z))
    return force, cross(center, force)


@register_jitable(forceinline=True, allocates=False)
def _add_push(bodies: np.record) -> None:
    """Add the push."""
    for i in range(LANES):
        force = into_body(get_lane(bodies, "R_WB", i), get_lane(bodies, "push", i))
        moment = _sum(
            cross(get_lane(bodies, "push_point", i), force), get_lane(bodies, "push_torque", i)
        )
        set_lane(bodies, "force", i, _sum(get_lane(bodies, "force", i), force))
        set_lane(bodies, "moment", i, _sum(get_lane(bodies, "moment", i), moment))


@register_jitable(forceinline=True, allocates=False)
def _rotor_load_on_body(
    bodies: np.record, rotor: np.record, i: int
) -> tuple[Vector3, Vector3, Vector3]:
    """Return force, moment and angular momentum of a rotor, in B."""
    return rotor_load(
        rotor_constants_of(rotor, i),
        get_lane(rotor, "speed", i),
        get_lane(rotor, "speed_rate", i),
        get_lane(rotor, "share", i),
        get_lane(rotor, "static", i),
        get_lane(bodies, "w_B", i),
        get_lane(bodies, "v_B", i),
        get_lane(bodies, "R_WB", i),
        get_lane(bodies, "p_WB", i)[2],
    )


@register_jitable(forceinline=True, allocates=False)
def rotor_constants_of(rotor: np.record, i: int) -> RotorConstants:
    """Return the constants of a rotor."""
    return RotorConstants(
        get_lane(rotor, "p_BR", i),
        get_lane(rotor, "axis_B", i),
        get_lane(rotor, "direction", i),
        get_lane(rotor, "max_rot_velocity", i),
        get_lane(rotor, "motor_constant", i),
        get_lane(rotor, "linear_speed", i),
        get_lane(rotor, "moment_constant", i),
        get_lane(rotor, "inertia", i),
        get_lane(rotor, "time_constant_up", i),
        get_lane(rotor, "time_constant_down", i),
        get_lane(rotor, "rotor_drag_coefficient", i),
        get_lane(rotor, "rolling_moment_coefficient", i),
        get_lane(rotor, "inflow_coefficient", i),
        get_lane(rotor, "ground_effect_coefficient", i),
        get_lane(rotor, "propeller_radius", i),
    )


@register_jitable(forceinline=True, allocates=False)
def lane_acceleration(bodies: np.record, i: int) -> tuple[float, ...]:
    """Return the angular acceleration of a lane, and that of its origin, as `derive_lanes` wrote
    them.
    """
    return get_lane(bodies, "w_rate", i) + get_lane(bodies, "v_rate", i)


@register_jitable(forceinline=True, allocates=False)
def _sum(a: Vector3, b: Vector3) -> Vector3:
    return a[0] + b[0], a[1] + b[1], a[2] + b[2]


@register_jitable(allocates=False)
def runge_kutta_step(room: LaneWorkspace, tableau: np.ndarray, sags: bool, pushed: bool) -> None:
    """Advance each lane by its `step` with a Runge-Kutta method; one with a step of 0 stays.

    Args:
        room: see `LaneWorkspace`.
        tableau: of Butcher (stages, stages): row k has the weights of the slopes 0 .. k in the next
            stage, the last row those in the result.
        sags: see `derive_lanes`.
        pushed: see `derive_lanes`.
    """
    body, size = room.bodies[0], len(room.begun)
    for place in range(size):  # the lane is the fastest index
        room.sizes[place] = body.step[place % LANES]
    _gather(body.state, room.rotors, room.begun)
    for stage in range(len(tableau)):
        derive_lanes(body, room.rotors, sags, pushed)
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


@register_jitable(allocates=False)
def _gather(state: np.ndarray, rotors: np.ndarray, places: np.ndarray) -> None:
    """Write the state of the bodies, then that of the rotors."""
    for place in range(len(state)):
        places[place] = state[place]
    for number in range(len(rotors)):
        for i in range(LANES):
            places[len(state) + number * LANES + i] = rotors[number].speed[i]


@register_jitable(allocates=False)
def _gather_rates(rate: np.ndarray, rotors: np.ndarray, places: np.ndarray) -> None:
    """Write the derivative of the state, as `_gather` does the state."""
    for place in range(len(rate)):
        places[place] = rate[place]
    for number in range(len(rotors)):
        for i in range(LANES):
            places[len(rate) + number * LANES + i] = rotors[number].speed_rate[i]


@register_jitable(allocates=False)
def _scatter(places: np.ndarray, state: np.ndarray, rotors: np.ndarray) -> None:
    """Read the state from where `_gather` has written it."""
    for place in range(len(state)):
        state[place] = places[place]
    for number in range(len(rotors)):
        for i in range(LANES):
            rotors[number].speed[i] = places[len(state) + number * LANES + i]


@register_jitable(allocates=False)
def advance_lanes(
    room: LaneWorkspace,
    sizes: np.ndarray,
    third: np.ndarray,
    spans: np.ndarray,
    sags: bool,
    pushed: bool,
) -> None:
    """Advance each lane by a time, at steps of its own size.

    Args:
        room: see `LaneWorkspace`.
        sizes: steps of the lanes (16) [s].
        third: whether they are of third order, else of fifth (16).
        spans: time that each lane is to go (16) [s]; 0 on return.
        sags: see `derive_lanes`.
        pushed: see `derive_lanes`.
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
                    size[i] = spans[i] if spans[i] <= LAST_STEP_STRETCH * sizes[i] else sizes[i]
            runge_kutta_step(
                room, KUTTA_TABLEAU if method == 0 else DORMAND_PRINCE_TABLEAU, sags, pushed
            )
            for i in range(LANES):
                spans[i] -= size[i]

"""What moves in a block: loops over its candidates around the vehicle's own functions.

In several loops a step: one would be a chain of hundreds of operations that wait for each other,
longer than what a processor looks ahead to fill the time with the next candidates'.
"""

import math

import numpy as np

from workbench.common.jitable import register_jitable
from workbench.design.rollout.rows import (
    CHARGE,
    CLEARANCE,
    COUNT,
    HELD,
    LANES,
    LAST,
    LOAD,
    LOST,
    MIDDLE,
    OPEN_CIRCUIT,
    POWER,
    PRESSURE,
    PUSH,
    R_WB,
    RIGID,
    SHARE,
    SLOPE,
    SPEED,
    STATE,
    TURN,
    VOLTAGE,
    WAY,
    WIND,
    put,
    put3,
    put6,
    put9,
    put13,
    take,
    take3,
    take6,
    take7,
    take9,
    take13,
    take16,
    take19,
)
from workbench.design.tumbling import TUMBLING_RATE, TUMBLING_SPEED
from workbench.dynamics.air.drag import body_drag, with_rotor_drag
from workbench.dynamics.air.normals import COUNT as NORMALS
from workbench.dynamics.air.normals import draw_normals
from workbench.dynamics.air.update import push_at, wind_at
from workbench.dynamics.rigid_body import accelerations, into_body, middle, moved
from workbench.dynamics.rotor_response import step_rotor, within
from workbench.dynamics.vehicle_step import (
    LAG,
    loaded,
    middle_height,
    power_share,
    static_thrust,
    supplied,
    thrust_change,
    whole_wrench,
    with_thrust,
    with_thrust_change,
)


@register_jitable
def move(block, rotors, blades, changes, sags, compensation, pushed, step):
    """Do a step of physics.

    Args:
        block: of the candidates.
        rotors: blocks of the rotors.
        blades: whether any drag.
        changes: whether inflow or ground change any thrust.
        sags: whether there is a battery, see `weaken`.
        compensation: share of its sag that is made up for.
        pushed: whether any candidate is pushed.
        step: [s].
    """
    for i in range(LANES):
        R, w_W, v_W = middle(take13(block, STATE, i), take6(block, LAST, i), step)
        _meet_air(block, i, R, w_W, v_W)
    _drag(block)
    for number in range(len(rotors)):
        rotor = rotors[number]
        if sags:
            for i in range(LANES):
                held, most = take(rotor, HELD, i), take(rotor, TURN + LAG, i)
                voltage = take(block, VOLTAGE, i)
                speed = supplied(held, most, voltage, voltage, compensation)
                _step_speed(rotor, i, speed)
        else:
            for i in range(LANES):
                _step_speed(rotor, i, take(rotor, HELD, i))
    _turn(block, rotors, blades)
    if changes:
        _change_thrusts(block, rotors, step)
    if pushed:
        for i in range(LANES):
            R, push = take9(block, R_WB, i), take6(block, PUSH, i)
            f_x, f_y, f_z, m_x, m_y, m_z = take6(block, LOAD, i)
            p_x, p_y, p_z = into_body(R, push[0:3])
            t_x, t_y, t_z = into_body(R, push[3:6])
            load = (f_x + p_x, f_y + p_y, f_z + p_z, m_x + t_x, m_y + t_y, m_z + t_z)
            put6(block, LOAD, i, load)
    _accelerate(block, step)
    for i in range(LANES):
        put13(block, STATE, i, moved(take13(block, STATE, i), take6(block, LAST, i), step))


@register_jitable
def weaken(block, rotors, supply):
    """Write power and voltage of the batteries at the present speeds, see `engine.Supply`."""
    for i in range(LANES):
        put(block, POWER, i, 0.0)
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            speed, share = take(rotor, SPEED, i), take(rotor, SHARE, i)
            thrust = static_thrust(speed, share, take19(rotor, TURN, i))
            put(block, POWER, i, take(block, POWER, i) + power_share(thrust))
    for i in range(LANES):
        now = (take(block, OPEN_CIRCUIT, i), supply.drop)
        put(block, VOLTAGE, i, loaded(now, take(block, POWER, i)))


@register_jitable
def discharge(block, supply, steps, step):
    """Update charges, and the voltages without load that follow, as `battery.Battery` does.

    Args:
        block: of the candidates.
        supply: see `engine.Supply`.
        steps: of physics in a control period.
        step: of physics, in the period that this one began.
    """
    charges, voltages = supply.curve[:, 0].copy(), supply.curve[:, 1].copy()
    for i in range(LANES):
        if (int(take(block, COUNT, i)) * steps + step) % supply.every != 0:
            continue
        charge = take(block, CHARGE, i) - supply.used * take(block, POWER, i)
        charge = max(0.0, charge)
        put(block, CHARGE, i, charge)
        put(block, OPEN_CIRCUIT, i, np.interp(charge, charges, voltages))


@register_jitable
def hold_commands(rotors, asked, acting, updates, step):
    """Let the rotors of those for whom it is time follow the commands that then act.

    Args:
        rotors: blocks of the rotors.
        asked: commands of the last updates, a ring.
        acting: see `engine.Crafts`.
        updates: how many there were before the last one.
        step: of physics, in the period that this one began.
    """
    for i in range(LANES):
        age, since = acting[min(i, len(acting) - 1)]
        if since == step:
            commands = asked[(updates - age) % len(asked)]
            for number in range(len(rotors)):
                limit = take(rotors[number], TURN + LAG, i)
                put(rotors[number], HELD, i, within(commands[number, i], limit))


@register_jitable
def blow(block, lively, air, seeds, steps, since, step, eddies):
    """Write wind and push in a step of those in air that is not steady, one by one.

    Args:
        block: of the candidates.
        lively: for whom it is not (m).
        air: see `Candidates`.
        seeds: likewise.
        steps: of physics in a control period.
        since: the step of physics, in the period that this one began.
        step: of physics [s].
        eddies: what the turbulence remembers (m, 6).
    """
    noise = np.empty(NORMALS)
    for i in range(len(air)):
        if not lively[i]:
            continue
        number = int(take(block, COUNT, i)) * steps + since
        draw_normals(seeds[i], number, noise)
        state = take13(block, STATE, i)
        put3(
            block,
            WIND,
            i,
            wind_at(number * step, state, noise, air[i], step, eddies[i], eddies[i]),
        )
        put6(block, PUSH, i, push_at(number * step, state, air[i], step))


@register_jitable
def note_lost(block):
    """Note who is lost, see `Rollouts.diverged_at`; return how many are."""
    for i in range(LANES):
        state = take13(block, STATE, i)
        w, x, y, z, p_x, p_y, p_z, w_x, w_y, w_z, v_x, v_y, v_z = state
        size = abs(w) + abs(x) + abs(y) + abs(z) + abs(p_x) + abs(p_y) + abs(p_z)
        size += abs(w_x) + abs(w_y) + abs(w_z) + abs(v_x) + abs(v_y) + abs(v_z)
        turns = w_x * w_x + w_y * w_y + w_z * w_z > TUMBLING_RATE**2
        flees = v_x * v_x + v_y * v_y + v_z * v_z > TUMBLING_SPEED**2
        upright = w * w + z * z > x * x + y * y
        lost = take(block, LOST, i)
        now = not size < math.inf or p_z < take(block, CLEARANCE, i)
        now = now or (not upright and (turns or flees))
        if now and lost < 0.0:
            lost = take(block, COUNT, i)
        put(block, LOST, i, lost)
    many = 0
    for i in range(LANES):
        many += take(block, LOST, i) >= 0.0
    return many


@register_jitable(forceinline=True)
def _step_speed(rotor, i, command):
    """Write the speed after a step, and that in its middle with its slope."""
    speed, slope, after = step_rotor(command, take(rotor, SPEED, i), take7(rotor, TURN + LAG, i))
    put(rotor, MIDDLE, i, speed)
    put(rotor, SLOPE, i, slope)
    put(rotor, SPEED, i, after)


@register_jitable(forceinline=True)
def _meet_air(block, i, R, w_W, v_W):
    """Write orientation, and velocity relative to the air and angular velocity in B."""
    a_x, a_y, a_z = take3(block, WIND, i)
    v_x, v_y, v_z = v_W
    put9(block, R_WB, i, R)
    put3(block, WAY, i, into_body(R, (v_x - a_x, v_y - a_y, v_z - a_z)))
    put3(block, WAY + 3, i, into_body(R, w_W))


@register_jitable
def _drag(block):
    """Begin what acts on the body with its drag."""
    for i in range(LANES):
        v_B, w_B = take3(block, WAY, i), take3(block, WAY + 3, i)
        p_BoBcm_B = take3(block, RIGID + 13, i)
        drag = body_drag(v_B, w_B, take(block, PRESSURE, i), p_BoBcm_B)
        put9(block, LOAD, i, drag + (0.0, 0.0, 0.0))


@register_jitable
def _turn(block, rotors, blades):
    """Add what the rotors do, with the drag of their blades if any drag.

    Four rotors in a loop: what acts on the body is read and written once for them.
    """
    fours = len(rotors) // 4 * 4
    for number in range(0, fours, 4):
        a, b, c, d = rotors[number], rotors[number + 1], rotors[number + 2], rotors[number + 3]
        if blades:
            for i in range(LANES):
                v_B, w_B = take3(block, WAY, i), take3(block, WAY + 3, i)
                load = _dragged(_dragged(take9(block, LOAD, i), a, i, v_B, w_B), b, i, v_B, w_B)
                load = _dragged(_dragged(load, c, i, v_B, w_B), d, i, v_B, w_B)
                put9(block, LOAD, i, load)
        else:
            for i in range(LANES):
                load = _pushed(_pushed(take9(block, LOAD, i), a, i), b, i)
                put9(block, LOAD, i, _pushed(_pushed(load, c, i), d, i))
    for number in range(fours, len(rotors)):
        rotor = rotors[number]
        if blades:
            for i in range(LANES):
                v_B, w_B = take3(block, WAY, i), take3(block, WAY + 3, i)
                put9(block, LOAD, i, _dragged(take9(block, LOAD, i), rotor, i, v_B, w_B))
        else:
            for i in range(LANES):
                put9(block, LOAD, i, _pushed(take9(block, LOAD, i), rotor, i))


@register_jitable(forceinline=True)
def _pushed(load, rotor, i):
    """Return a load with what a rotor does, but for the drag of its blades."""
    row, speed = take16(rotor, TURN, i), take(rotor, MIDDLE, i)
    return with_thrust(load, speed, take(rotor, SLOPE, i), take(rotor, SHARE, i), row)


@register_jitable(forceinline=True)
def _dragged(load, rotor, i, v_B, w_B):
    """Return a load with what a rotor does."""
    load, speed = _pushed(load, rotor, i), take(rotor, MIDDLE, i)
    return with_rotor_drag(load[0:6], v_B, w_B, speed, take16(rotor, TURN, i)) + load[6:9]


@register_jitable
def _change_thrusts(block, rotors, step):
    """Add what inflow and ground change of the rotors' thrusts."""
    for number in range(len(rotors)):
        rotor = rotors[number]
        for i in range(LANES):
            row, v_B, w_B = take19(rotor, TURN, i), take3(block, WAY, i), take3(block, WAY + 3, i)
            height, climb = take(block, STATE + 6, i), take(block, STATE + 12, i)
            height = middle_height(height, climb, take(block, LAST + 5, i), step)
            speed, share = take(rotor, MIDDLE, i), take(rotor, SHARE, i)
            up_B = take3(block, R_WB + 6, i)
            change = thrust_change(v_B, w_B, up_B, height, speed, share, row)
            put6(block, LOAD, i, with_thrust_change(take6(block, LOAD, i), change, row))


@register_jitable
def _accelerate(block, step):
    """Write the acceleration that follows from what acts on the body."""
    for i in range(LANES):
        w_B = take3(block, WAY + 3, i)
        acceleration = accelerations(
            take9(block, R_WB, i),
            w_B,
            take6(block, LAST, i),
            step,
            whole_wrench(take9(block, LOAD, i), w_B),
            take(block, RIGID, i),
            take6(block, RIGID + 1, i),
            take6(block, RIGID + 7, i),
            take3(block, RIGID + 13, i),
        )
        put6(block, LAST, i, acceleration)

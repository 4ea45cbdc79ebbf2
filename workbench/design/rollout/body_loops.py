"""What moves in a block: loops over its candidates around the rigid body and the air."""

import math

import numpy as np
from numba.extending import register_jitable

from workbench.design.rollout.rigid_body import held_load, moved, rotation, velocity_changes
from workbench.design.rollout.rows import (
    BLADE,
    CHANGES,
    CLEARANCE,
    LANES,
    LOAD,
    LOST,
    PRESSURE,
    R_WB,
    RIGID,
    SPEED,
    STATE,
    TURNING,
    WAY,
    WIND,
    WRENCH,
    put,
    put6,
    put9,
    put13,
    take,
    take3,
    take4,
    take6,
    take8,
    take9,
    take13,
)
from workbench.design.tumbling import TUMBLING_RATE, TUMBLING_SPEED
from workbench.systems.air.drag import body_drag, motion_in_air, with_rotor_drag
from workbench.systems.air.normals import COUNT, draw_normals
from workbench.systems.air.update import air_update


@register_jitable
def pull(block, rotors, blades):  # type: ignore[no-untyped-def]
    """Begin what will act on the body with the drag in a steady wind; the blades' if they have."""
    for i in range(LANES):
        v_B, w_B = motion_in_air(take13(block, STATE, i), take3(block, WIND, i))
        put6(block, WAY, i, v_B + w_B)
        p_BoBcm_B = take3(block, RIGID + 13, i)
        put6(block, WRENCH, i, body_drag(v_B, w_B, take(block, PRESSURE, i), p_BoBcm_B))
    for number in range(len(rotors) if blades else 0):
        rotor = rotors[number]
        for i in range(LANES):
            v_B, w_B = take3(block, WAY, i), take3(block, WAY + 3, i)
            wrench, speed = take6(block, WRENCH, i), take(rotor, SPEED, i)
            wrench = with_rotor_drag(wrench, v_B, w_B, speed, take8(rotor, BLADE, i))
            put6(block, WRENCH, i, wrench)


@register_jitable
def blow(block, rotors, lively, air, seeds, crafts, instant, period, eddies, next_eddies):  # type: ignore[no-untyped-def]
    """Do the same for those in air that is not steady, one by one."""
    n = len(rotors)
    drag, wind, noise, speeds = np.zeros(6), np.zeros(3), np.empty(COUNT), np.empty(n)
    for i in range(len(air)):
        if not lively[i]:
            continue
        draw_normals(seeds[i], instant, noise)
        for number in range(n):
            speeds[number] = take(rotors[number], SPEED, i)
        air_update(
            instant * period,
            take13(block, STATE, i),
            speeds,
            noise,
            air[i],
            take3(block, RIGID + 13, i),
            crafts.blades[i],
            period,
            eddies[i],
            drag,
            wind,
            next_eddies[i],
        )
        eddies[i] = next_eddies[i]
        for k in range(6):
            put(block, WRENCH + k, i, drag[k])


@register_jitable
def hold_load(block, step):  # type: ignore[no-untyped-def]
    """Let what was gathered act from now on."""
    for i in range(LANES):
        wrench, p_BoBcm_B = take6(block, WRENCH, i), take3(block, RIGID + 13, i)
        put6(block, LOAD, i, held_load(wrench, take(block, RIGID, i), p_BoBcm_B, step))


@register_jitable
def move(block, step, steps):  # type: ignore[no-untyped-def]
    """Do some steps of physics.

    In three loops: one would be a chain of a hundred operations that wait for each other, and
    longer than what a processor looks ahead to fill the time with the next candidates'.
    """
    for _ in range(steps):
        for i in range(LANES):
            put9(block, R_WB, i, rotation(take4(block, STATE, i)))
        for i in range(LANES):
            changes = velocity_changes(
                take9(block, R_WB, i),
                take3(block, STATE + 7, i),
                take6(block, LOAD, i),
                take6(block, RIGID + 1, i),
                take6(block, TURNING, i),
                take3(block, RIGID + 13, i),
                step,
            )
            put6(block, CHANGES, i, changes)
        for i in range(LANES):
            state, changes = take13(block, STATE, i), take6(block, CHANGES, i)
            put13(block, STATE, i, moved(state, take9(block, R_WB, i), changes, step))


@register_jitable
def note_lost(block, instant):  # type: ignore[no-untyped-def]
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
            lost = 1.0 * instant
        put(block, LOST, i, lost)
    many = 0
    for i in range(LANES):
        many += take(block, LOST, i) >= 0.0
    return many
